# sha256 of protocol/tfsat_log.ksy: 7285da3d389b9929234b99dcb04fe7cb78b6bcc0be14571956b410b9a604d8c0
# ruff: noqa
# fmt: off
# mypy: ignore-errors
# This is a generated file! Please edit source .ksy file and use kaitai-struct-compiler to rebuild

import kaitaistruct
from kaitaistruct import KaitaiStruct, KaitaiStream, BytesIO
from enum import IntEnum


if getattr(kaitaistruct, 'API_VERSION', (0, 9)) < (0, 11):
    raise Exception("Incompatible Kaitai Struct Python API: 0.11 or later is required, but you have %s" % (kaitaistruct.__version__))

class TfsatLog(KaitaiStruct):
    """A row of 512-byte blocks. Kaitai does not check the CRC: see `crc` of each block
    (CRC-32/ISO-HDLC over the bytes before it). A block that was never written is all zero.
    """

    class BlockKind(IntEnum):
        header = 1
        data = 2
        footer = 3

    class EventCode(IntEnum):
        switch_edge = 1
        stroke = 2
        sensor_fault = 3
        sensor_recovered = 4
        card_stall = 5
        samples_dropped = 6
        release = 7
        landing = 8
        ring_high_water = 9
        card_lost = 10
        card_back = 11
        rewritten = 12
        sampling_late = 13
        sensor_missed = 15

    class StopReason(IntEnum):
        host = 1
        landing = 2
        file_full = 3
        card_gone = 4
    def __init__(self, _io, _parent=None, _root=None):
        super(TfsatLog, self).__init__(_io)
        self._parent = _parent
        self._root = _root or self
        self._read()

    def _read(self):
        self._raw_blocks = []
        self.blocks = []
        i = 0
        while not self._io.is_eof():
            self._raw_blocks.append(self._io.read_bytes(512))
            _io__raw_blocks = KaitaiStream(BytesIO(self._raw_blocks[-1]))
            self.blocks.append(TfsatLog.Block(_io__raw_blocks, self, self._root))
            i += 1



    def _fetch_instances(self):
        pass
        for i in range(len(self.blocks)):
            pass
            self.blocks[i]._fetch_instances()


    class Block(KaitaiStruct):
        def __init__(self, _io, _parent=None, _root=None):
            super(TfsatLog.Block, self).__init__(_io)
            self._parent = _parent
            self._root = _root
            self._read()

        def _read(self):
            self.head = TfsatLog.BlockHeader(self._io, self, self._root)
            _on = self.head.kind
            if _on == TfsatLog.BlockKind.data:
                pass
                self._raw_body = self._io.read_bytes(476)
                _io__raw_body = KaitaiStream(BytesIO(self._raw_body))
                self.body = TfsatLog.Data(_io__raw_body, self, self._root)
            elif _on == TfsatLog.BlockKind.footer:
                pass
                self._raw_body = self._io.read_bytes(476)
                _io__raw_body = KaitaiStream(BytesIO(self._raw_body))
                self.body = TfsatLog.LogFooter(_io__raw_body, self, self._root)
            elif _on == TfsatLog.BlockKind.header:
                pass
                self._raw_body = self._io.read_bytes(476)
                _io__raw_body = KaitaiStream(BytesIO(self._raw_body))
                self.body = TfsatLog.LogHeader(_io__raw_body, self, self._root)
            else:
                pass
                self.body = self._io.read_bytes(476)
            self.crc = self._io.read_u4le()


        def _fetch_instances(self):
            pass
            self.head._fetch_instances()
            _on = self.head.kind
            if _on == TfsatLog.BlockKind.data:
                pass
                self.body._fetch_instances()
            elif _on == TfsatLog.BlockKind.footer:
                pass
                self.body._fetch_instances()
            elif _on == TfsatLog.BlockKind.header:
                pass
                self.body._fetch_instances()
            else:
                pass


    class BlockHeader(KaitaiStruct):
        """The first 32 bytes of every block."""
        def __init__(self, _io, _parent=None, _root=None):
            super(TfsatLog.BlockHeader, self).__init__(_io)
            self._parent = _parent
            self._root = _root
            self._read()

        def _read(self):
            self.magic = self._io.read_u4le()
            self.version = self._io.read_u1()
            self.kind = KaitaiStream.resolve_enum(TfsatLog.BlockKind, self._io.read_u1())
            self.sample_count = self._io.read_u1()
            self.event_count = self._io.read_u1()
            self.session = self._io.read_u4le()
            self.block_number = self._io.read_u4le()
            self.first_sample = self._io.read_u4le()
            self.samples_dropped = self._io.read_u4le()
            self.time_us = self._io.read_u8le()


        def _fetch_instances(self):
            pass


    class Data(KaitaiStruct):
        def __init__(self, _io, _parent=None, _root=None):
            super(TfsatLog.Data, self).__init__(_io)
            self._parent = _parent
            self._root = _root
            self._read()

        def _read(self):
            self.sample_slots = []
            for i in range(6):
                self.sample_slots.append(TfsatLog.Sample(self._io, self, self._root))

            self.event_slots = []
            for i in range(2):
                self.event_slots.append(TfsatLog.Event(self._io, self, self._root))



        def _fetch_instances(self):
            pass
            for i in range(len(self.sample_slots)):
                pass
                self.sample_slots[i]._fetch_instances()

            for i in range(len(self.event_slots)):
                pass
                self.event_slots[i]._fetch_instances()



    class Event(KaitaiStruct):
        """Something that happened, with its own time."""
        def __init__(self, _io, _parent=None, _root=None):
            super(TfsatLog.Event, self).__init__(_io)
            self._parent = _parent
            self._root = _root
            self._read()

        def _read(self):
            self.time_us = self._io.read_u8le()
            self.code = KaitaiStream.resolve_enum(TfsatLog.EventCode, self._io.read_u1())
            self.index = self._io.read_u1()
            self.arg = self._io.read_u2le()
            self.value = self._io.read_s4le()


        def _fetch_instances(self):
            pass


    class ImuReading(KaitaiStruct):
        """One 14-byte burst of an MPU-6050, registers 0x3B to 0x48 (RM-MPU-6000A rev. 4.2, p. 29-32), raw counts."""
        def __init__(self, _io, _parent=None, _root=None):
            super(TfsatLog.ImuReading, self).__init__(_io)
            self._parent = _parent
            self._root = _root
            self._read()

        def _read(self):
            self.accel = []
            for i in range(3):
                self.accel.append(self._io.read_s2le())

            self.temperature = self._io.read_s2le()
            self.gyro = []
            for i in range(3):
                self.gyro.append(self._io.read_s2le())



        def _fetch_instances(self):
            pass
            for i in range(len(self.accel)):
                pass

            for i in range(len(self.gyro)):
                pass



    class LogEntry(KaitaiStruct):
        """A recording that the logger can hand over."""
        def __init__(self, _io, _parent=None, _root=None):
            super(TfsatLog.LogEntry, self).__init__(_io)
            self._parent = _parent
            self._root = _root
            self._read()

        def _read(self):
            self.number = self._io.read_u2le()
            self.session = self._io.read_u4le()
            self.blocks = self._io.read_u4le()
            self.wall_clock_us = self._io.read_u8le()
            self.closed = self._io.read_u1()


        def _fetch_instances(self):
            pass


    class LogFooter(KaitaiStruct):
        """Summary written when a recording is closed cleanly. Payload of a footer block."""
        def __init__(self, _io, _parent=None, _root=None):
            super(TfsatLog.LogFooter, self).__init__(_io)
            self._parent = _parent
            self._root = _root
            self._read()

        def _read(self):
            self.samples = self._io.read_u4le()
            self.samples_dropped = self._io.read_u4le()
            self.blocks = self._io.read_u4le()
            self.ring_peak_blocks = self._io.read_u4le()
            self.interval_min_us = self._io.read_u4le()
            self.interval_max_us = self._io.read_u4le()
            self.jitter_rms_us = self._io.read_f4le()
            self.late_ticks = self._io.read_u4le()
            self.ring_blocks = self._io.read_u4le()
            self.card_stall_max_ms = self._io.read_u4le()
            self.blocks_rewritten = self._io.read_u4le()
            self.stop_reason = KaitaiStream.resolve_enum(TfsatLog.StopReason, self._io.read_u1())


        def _fetch_instances(self):
            pass


    class LogHeader(KaitaiStruct):
        """What was recorded, with which scales. Payload of a header block."""
        def __init__(self, _io, _parent=None, _root=None):
            super(TfsatLog.LogHeader, self).__init__(_io)
            self._parent = _parent
            self._root = _root
            self._read()

        def _read(self):
            self.protocol_hash = []
            for i in range(8):
                self.protocol_hash.append(self._io.read_u1())

            self.firmware_version = []
            for i in range(3):
                self.firmware_version.append(self._io.read_u1())

            self.imu_present = self._io.read_u1()
            self.board_serial = []
            for i in range(8):
                self.board_serial.append(self._io.read_u1())

            self.image_crc = self._io.read_u4le()
            self.rate_hz = self._io.read_f4le()
            self.gyro_lsb_per_deg_s = self._io.read_f4le()
            self.accel_lsb_per_g = self._io.read_f4le()
            self.temperature_lsb_per_c = self._io.read_f4le()
            self.temperature_offset_c = self._io.read_f4le()
            self.angle_counts_per_turn = self._io.read_u4le()
            self.gyro_range_deg_s = self._io.read_u2le()
            self.accel_range_g = self._io.read_u1()
            self.dlpf_cfg = self._io.read_u1()
            self.who_am_i = []
            for i in range(4):
                self.who_am_i.append(self._io.read_u1())

            self.bus_khz = self._io.read_u2le()
            self.after_landing_s = self._io.read_u2le()
            self.schema = []
            for i in range(384):
                self.schema.append(self._io.read_u1())

            self.wall_clock_us = self._io.read_u8le()
            self.imu_offset_us = []
            for i in range(4):
                self.imu_offset_us.append(self._io.read_u2le())

            self.angle_offset_us = []
            for i in range(6):
                self.angle_offset_us.append(self._io.read_u2le())

            self.maneuver_known = self._io.read_u1()
            self.maneuver_crc = self._io.read_u2le()


        def _fetch_instances(self):
            pass
            for i in range(len(self.protocol_hash)):
                pass

            for i in range(len(self.firmware_version)):
                pass

            for i in range(len(self.board_serial)):
                pass

            for i in range(len(self.who_am_i)):
                pass

            for i in range(len(self.schema)):
                pass

            for i in range(len(self.imu_offset_us)):
                pass

            for i in range(len(self.angle_offset_us)):
                pass



    class LoggerSettings(KaitaiStruct):
        """How the logger samples and records."""
        def __init__(self, _io, _parent=None, _root=None):
            super(TfsatLog.LoggerSettings, self).__init__(_io)
            self._parent = _parent
            self._root = _root
            self._read()

        def _read(self):
            self.rate_hz = self._io.read_u2le()
            self.gyro_range_deg_s = self._io.read_u2le()
            self.accel_range_g = self._io.read_u1()
            self.dlpf_cfg = self._io.read_u1()
            self.bus_khz = self._io.read_u2le()
            self.after_landing_s = self._io.read_u2le()
            self.file_mib = self._io.read_u2le()


        def _fetch_instances(self):
            pass


    class Sample(KaitaiStruct):
        """All sensors, each read at the sample's time and its offset in LogHeader."""
        def __init__(self, _io, _parent=None, _root=None):
            super(TfsatLog.Sample, self).__init__(_io)
            self._parent = _parent
            self._root = _root
            self._read()

        def _read(self):
            self.time_offset_us = self._io.read_u4le()
            self.flags = self._io.read_u2le()
            self.imu = []
            for i in range(4):
                self.imu.append(TfsatLog.ImuReading(self._io, self, self._root))

            self.angle = []
            for i in range(6):
                self.angle.append(self._io.read_u2le())



        def _fetch_instances(self):
            pass
            for i in range(len(self.imu)):
                pass
                self.imu[i]._fetch_instances()

            for i in range(len(self.angle)):
                pass



    class ServoSetting(KaitaiStruct):
        """How a joint's servo turns pulses into angles, and how far it may go."""
        def __init__(self, _io, _parent=None, _root=None):
            super(TfsatLog.ServoSetting, self).__init__(_io)
            self._parent = _parent
            self._root = _root
            self._read()

        def _read(self):
            self.zero_us = self._io.read_u2le()
            self.ns_per_deg = self._io.read_u2le()
            self.reversed = self._io.read_u1()
            self.min_cdeg = self._io.read_s2le()
            self.max_cdeg = self._io.read_s2le()


        def _fetch_instances(self):
            pass
