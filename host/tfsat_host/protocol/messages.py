"""Payloads of the link's frames and records of the log.

Generated from protocol/tfsat.toml by tools/generate_protocol.py. Do not edit.
"""

from __future__ import annotations

from typing import ClassVar

from .enums import BlockKind, Board, CardState, DropPhase, ErrorCode, EventCode, LoggerState, Origin, ResetCause, SequencerState, StopReason
from .record import Layout, Payload, Record


class ImuReading(Record):
    """One 14-byte burst of an MPU-6050, registers 0x3B to 0x48 (RM-MPU-6000A rev. 4.2, p. 29-32), raw counts.

    Attributes:
        accel: Specific force x, y, z.
        temperature: Die temperature: counts / temperature_lsb_per_c + temperature_offset_c.
        gyro: Angular rate x, y, z.
    """

    SIZE: ClassVar[int] = 14
    __slots__ = ("accel", "temperature", "gyro",)
    LAYOUT: ClassVar[Layout] = (
        ("accel", "h", 3),
        ("temperature", "h", None),
        ("gyro", "h", 3),
    )

    accel: tuple[int, ...]
    temperature: int
    gyro: tuple[int, ...]


class Sample(Record):
    """All sensors, each read at the sample's time and its offset in LogHeader.

    Attributes:
        time_offset_us: Time after the block's time_us.
        flags: Bits 0-3: IMU 1-4 valid; 4-9: angle sensor 1-6 valid; 10, 11: release switch 1, 2 open; 12-15: IMU 1-4 clipped.
        imu: Bodies 1 to 4.
        angle: Absolute angle sensors, ADC counts: joint 1 (two sensors), joint 2, joint 3.
    """

    SIZE: ClassVar[int] = 74
    __slots__ = ("time_offset_us", "flags", "imu", "angle",)
    LAYOUT: ClassVar[Layout] = (
        ("time_offset_us", "I", None),
        ("flags", "H", None),
        ("imu", ImuReading, 4),
        ("angle", "H", 6),
    )

    time_offset_us: int
    flags: int
    imu: tuple[ImuReading, ...]
    angle: tuple[int, ...]


class Event(Record):
    """Something that happened, with its own time.

    Attributes:
        time_us: The logger's clock, since power-up.
        code: What happened.
        index: Which one; see EventCode.
        arg: See EventCode.
        value: See EventCode.
    """

    SIZE: ClassVar[int] = 16
    __slots__ = ("time_us", "code", "index", "arg", "value",)
    LAYOUT: ClassVar[Layout] = (
        ("time_us", "Q", None),
        ("code", EventCode, None),
        ("index", "B", None),
        ("arg", "H", None),
        ("value", "i", None),
    )

    time_us: int
    code: EventCode
    index: int
    arg: int
    value: int


class ServoSetting(Record):
    """How a joint's servo turns pulses into angles, and how far it may go.

    Attributes:
        zero_us: Pulse width that holds 0 deg.
        ns_per_deg: Change of pulse width for each degree.
        reversed: 1: shorter pulses open the joint.
        min_cdeg: Least angle that may be commanded.
        max_cdeg: Greatest angle that may be commanded.
    """

    SIZE: ClassVar[int] = 9
    __slots__ = ("zero_us", "ns_per_deg", "reversed", "min_cdeg", "max_cdeg",)
    LAYOUT: ClassVar[Layout] = (
        ("zero_us", "H", None),
        ("ns_per_deg", "H", None),
        ("reversed", "B", None),
        ("min_cdeg", "h", None),
        ("max_cdeg", "h", None),
    )

    zero_us: int
    ns_per_deg: int
    reversed: int
    min_cdeg: int
    max_cdeg: int


class BlockHeader(Record):
    """The first 32 bytes of every block.

    Attributes:
        magic: block_magic.
        version: block_version.
        kind: What the block holds.
        sample_count: Sample slots in use.
        event_count: Event slots in use.
        session: Random id of the recording.
        block_number: From 0, without gaps in a recording.
        first_sample: Index of the block's first sample in the recording, counting dropped ones too.
        samples_dropped: Samples lost so far because the ring was full.
        time_us: The logger's clock at the block's first sample, since power-up.
    """

    SIZE: ClassVar[int] = 32
    __slots__ = ("magic", "version", "kind", "sample_count", "event_count", "session", "block_number", "first_sample", "samples_dropped", "time_us",)
    LAYOUT: ClassVar[Layout] = (
        ("magic", "I", None),
        ("version", "B", None),
        ("kind", BlockKind, None),
        ("sample_count", "B", None),
        ("event_count", "B", None),
        ("session", "I", None),
        ("block_number", "I", None),
        ("first_sample", "I", None),
        ("samples_dropped", "I", None),
        ("time_us", "Q", None),
    )

    magic: int
    version: int
    kind: BlockKind
    sample_count: int
    event_count: int
    session: int
    block_number: int
    first_sample: int
    samples_dropped: int
    time_us: int


class LogHeader(Record):
    """What was recorded, with which scales. Payload of a header block.

    Attributes:
        protocol_hash: Of the specification that the firmware was built with.
        firmware_version: Major, minor, patch.
        imu_present: Bits 0-3: IMU 1-4 answered at the start.
        board_serial: The logger's serial number.
        image_crc: CRC-32/ISO-HDLC of the flashed image.
        rate_hz: Commanded sampling rate.
        gyro_lsb_per_deg_s: Gyro scale.
        accel_lsb_per_g: Accelerometer scale.
        temperature_lsb_per_c: Temperature scale of an MPU-6050; of the other parts see IMUs.
        temperature_offset_c: Temperature of an MPU-6050 at zero counts.
        angle_counts_per_turn: ADC counts of a full turn of an angle sensor.
        gyro_range_deg_s: Full scale, +-.
        accel_range_g: Full scale, +-.
        dlpf_cfg: Low-pass of the IMUs, CONFIG.DLPF_CFG; see IMUs.
        who_am_i: Register 0x75 of each IMU; 0 where none answered.
        bus_khz: Clock of the I2C buses.
        after_landing_s: The recording closes by itself this long after the landing.
        schema: This layout in words, ASCII, padded with zeros: a file found in ten years explains itself.
        wall_clock_us: Unix time at time_us, if the host set the clock; else 0.
        imu_offset_us: From a sample's time to the moment of each IMU's reading. 0 in logs of block_version 2, which do not tell it.
        angle_offset_us: The same of each angle sensor.
    """

    SIZE: ClassVar[int] = 472
    __slots__ = ("protocol_hash", "firmware_version", "imu_present", "board_serial", "image_crc", "rate_hz", "gyro_lsb_per_deg_s", "accel_lsb_per_g", "temperature_lsb_per_c", "temperature_offset_c", "angle_counts_per_turn", "gyro_range_deg_s", "accel_range_g", "dlpf_cfg", "who_am_i", "bus_khz", "after_landing_s", "schema", "wall_clock_us", "imu_offset_us", "angle_offset_us",)
    LAYOUT: ClassVar[Layout] = (
        ("protocol_hash", "B", 8),
        ("firmware_version", "B", 3),
        ("imu_present", "B", None),
        ("board_serial", "B", 8),
        ("image_crc", "I", None),
        ("rate_hz", "f", None),
        ("gyro_lsb_per_deg_s", "f", None),
        ("accel_lsb_per_g", "f", None),
        ("temperature_lsb_per_c", "f", None),
        ("temperature_offset_c", "f", None),
        ("angle_counts_per_turn", "I", None),
        ("gyro_range_deg_s", "H", None),
        ("accel_range_g", "B", None),
        ("dlpf_cfg", "B", None),
        ("who_am_i", "B", 4),
        ("bus_khz", "H", None),
        ("after_landing_s", "H", None),
        ("schema", "B", 384),
        ("wall_clock_us", "Q", None),
        ("imu_offset_us", "H", 4),
        ("angle_offset_us", "H", 6),
    )

    protocol_hash: bytes
    firmware_version: bytes
    imu_present: int
    board_serial: bytes
    image_crc: int
    rate_hz: float
    gyro_lsb_per_deg_s: float
    accel_lsb_per_g: float
    temperature_lsb_per_c: float
    temperature_offset_c: float
    angle_counts_per_turn: int
    gyro_range_deg_s: int
    accel_range_g: int
    dlpf_cfg: int
    who_am_i: bytes
    bus_khz: int
    after_landing_s: int
    schema: bytes
    wall_clock_us: int
    imu_offset_us: tuple[int, ...]
    angle_offset_us: tuple[int, ...]


class LogFooter(Record):
    """Summary written when a recording is closed cleanly. Payload of a footer block.

    Attributes:
        samples: Samples taken, dropped ones included.
        samples_dropped: Samples lost because the ring was full.
        blocks: Blocks of the recording, this one included.
        ring_peak_blocks: Most blocks that ever waited for the card.
        interval_min_us: Shortest time between two samples.
        interval_max_us: Longest time between two samples.
        jitter_rms_us: Root mean square of how far the times between samples were from the nominal one.
        late_ticks: Times between samples over one and a half nominal ones: ticks without a sample.
        ring_blocks: Blocks that the ring can hold.
        card_stall_max_ms: Longest time that the card took nothing.
        blocks_rewritten: Blocks that were written a second time after the landing.
        stop_reason: Why the recording ended.
    """

    SIZE: ClassVar[int] = 45
    __slots__ = ("samples", "samples_dropped", "blocks", "ring_peak_blocks", "interval_min_us", "interval_max_us", "jitter_rms_us", "late_ticks", "ring_blocks", "card_stall_max_ms", "blocks_rewritten", "stop_reason",)
    LAYOUT: ClassVar[Layout] = (
        ("samples", "I", None),
        ("samples_dropped", "I", None),
        ("blocks", "I", None),
        ("ring_peak_blocks", "I", None),
        ("interval_min_us", "I", None),
        ("interval_max_us", "I", None),
        ("jitter_rms_us", "f", None),
        ("late_ticks", "I", None),
        ("ring_blocks", "I", None),
        ("card_stall_max_ms", "I", None),
        ("blocks_rewritten", "I", None),
        ("stop_reason", StopReason, None),
    )

    samples: int
    samples_dropped: int
    blocks: int
    ring_peak_blocks: int
    interval_min_us: int
    interval_max_us: int
    jitter_rms_us: float
    late_ticks: int
    ring_blocks: int
    card_stall_max_ms: int
    blocks_rewritten: int
    stop_reason: StopReason


class LoggerSettings(Record):
    """How the logger samples and records.

    Attributes:
        rate_hz: Sampling rate.
        gyro_range_deg_s: Full scale, +-: 250, 500, 1000 or 2000.
        accel_range_g: Full scale, +-: 2, 4, 8 or 16.
        dlpf_cfg: Low-pass of the IMUs, CONFIG.DLPF_CFG, 0 to 6: 256, 188, 98, 42, 20, 10, 5 Hz.
        bus_khz: Clock of the I2C buses: 100 or 400.
        after_landing_s: A recording closes by itself this long after the landing.
        file_mib: Room that a recording takes on the card.
    """

    SIZE: ClassVar[int] = 12
    __slots__ = ("rate_hz", "gyro_range_deg_s", "accel_range_g", "dlpf_cfg", "bus_khz", "after_landing_s", "file_mib",)
    LAYOUT: ClassVar[Layout] = (
        ("rate_hz", "H", None),
        ("gyro_range_deg_s", "H", None),
        ("accel_range_g", "B", None),
        ("dlpf_cfg", "B", None),
        ("bus_khz", "H", None),
        ("after_landing_s", "H", None),
        ("file_mib", "H", None),
    )

    rate_hz: int
    gyro_range_deg_s: int
    accel_range_g: int
    dlpf_cfg: int
    bus_khz: int
    after_landing_s: int
    file_mib: int


class LogEntry(Record):
    """A recording that the logger can hand over.

    Attributes:
        number: Of its file, DROP0001.BIN and up; 0 is what RAM holds.
        session: Random id of the recording; 0: its first block says nothing.
        blocks: Blocks of the file; unused room included where it was not closed.
        wall_clock_us: Unix time of its start, or 0.
        closed: 1: its last block is its footer.
    """

    SIZE: ClassVar[int] = 19
    __slots__ = ("number", "session", "blocks", "wall_clock_us", "closed",)
    LAYOUT: ClassVar[Layout] = (
        ("number", "H", None),
        ("session", "I", None),
        ("blocks", "I", None),
        ("wall_clock_us", "Q", None),
        ("closed", "B", None),
    )

    number: int
    session: int
    blocks: int
    wall_clock_us: int
    closed: int


class HelloRequest(Payload):
    """Who are you? Its number and layout never change, so that any two revisions understand it."""

    TYPE: ClassVar[int] = 0x01
    SIZE: ClassVar[int] = 0
    __slots__ = ()
    LAYOUT: ClassVar[Layout] = ()


class HelloReply(Payload):
    """Who are you? Its number and layout never change, so that any two revisions understand it.

    Attributes:
        board: Kind of board.
        firmware_version: Major, minor, patch.
        board_serial: Serial number of the chip; zeros where it has none.
        image_crc: CRC-32/ISO-HDLC of the flashed image, computed by the board.
        protocol_hash: Hash of this specification.
    """

    TYPE: ClassVar[int] = 0x81
    SIZE: ClassVar[int] = 24
    __slots__ = ("board", "firmware_version", "board_serial", "image_crc", "protocol_hash",)
    LAYOUT: ClassVar[Layout] = (
        ("board", Board, None),
        ("firmware_version", "B", 3),
        ("board_serial", "B", 8),
        ("image_crc", "I", None),
        ("protocol_hash", "B", 8),
    )

    board: Board
    firmware_version: bytes
    board_serial: bytes
    image_crc: int
    protocol_hash: bytes


class SequencerStatusRequest(Payload):
    """What the sequencer is doing."""

    TYPE: ClassVar[int] = 0x02
    SIZE: ClassVar[int] = 0
    __slots__ = ()
    LAYOUT: ClassVar[Layout] = ()


class SequencerStatusReply(Payload):
    """What the sequencer is doing.

    Attributes:
        state: State machine.
        fault: The latched fault, or none.
        last_refusal: Why ARM was last refused, or none.
        switches_open: Bit 0, 1: release switch 1, 2 is open.
        arm_token: To be given to ARM; changes at each change of state.
        reset_cause: Why the board last started.
        resets_while_armed: Restarts that this arming has survived; 255 stands for more.
        strokes_started: Strokes of the last run that have begun: a whole pulse of the new width was on the servo's pin.
        knocks: Knocks since arming; see release. They survive a reset.
        joint_angle_cdeg: Angle that each servo is told to hold; 0 where it gets no pulses.
        uptime_ms: Since the board started.
        image_crc: CRC-32/ISO-HDLC of the flashed image.
        ram_never_used_bytes: Low-water mark of free RAM since the board started.
        frames_rejected: Frames that arrived damaged, since the board started.
        stores_damaged: Why ARM is refused for what is stored; even bits for the maneuver, odd ones for the servo settings. Bit 0, 1: store_damaged; 2, 3: upload_interrupted; 4, 5: store_old_layout.
        false_releases: False releases since arming; see release. They survive a reset.
        servos_driven: Bit 0, 1, 2: the servo of joint 1, 2, 3 gets pulses; else it is limp.
        brown_out_level: The fuse BODLEVEL: the supply below which the processor is held in reset (ATmega32U4 datasheet 7766J, table 8-1). 0: 4.3 V; 1: 3.5; 2: 3.4; 3: 2.6; 4: 2.4; 5: 2.2; 6: 2.0; 7: it never is.
    """

    TYPE: ClassVar[int] = 0x82
    SIZE: ClassVar[int] = 34
    __slots__ = ("state", "fault", "last_refusal", "switches_open", "arm_token", "reset_cause", "resets_while_armed", "strokes_started", "knocks", "joint_angle_cdeg", "uptime_ms", "image_crc", "ram_never_used_bytes", "frames_rejected", "stores_damaged", "false_releases", "servos_driven", "brown_out_level",)
    LAYOUT: ClassVar[Layout] = (
        ("state", SequencerState, None),
        ("fault", ErrorCode, None),
        ("last_refusal", ErrorCode, None),
        ("switches_open", "B", None),
        ("arm_token", "H", None),
        ("reset_cause", ResetCause, None),
        ("resets_while_armed", "B", None),
        ("strokes_started", "B", None),
        ("knocks", "H", None),
        ("joint_angle_cdeg", "h", 3),
        ("uptime_ms", "I", None),
        ("image_crc", "I", None),
        ("ram_never_used_bytes", "H", None),
        ("frames_rejected", "H", None),
        ("stores_damaged", "B", None),
        ("false_releases", "H", None),
        ("servos_driven", "B", None),
        ("brown_out_level", "B", None),
    )

    state: SequencerState
    fault: ErrorCode
    last_refusal: ErrorCode
    switches_open: int
    arm_token: int
    reset_cause: ResetCause
    resets_while_armed: int
    strokes_started: int
    knocks: int
    joint_angle_cdeg: tuple[int, ...]
    uptime_ms: int
    image_crc: int
    ram_never_used_bytes: int
    frames_rejected: int
    stores_damaged: int
    false_releases: int
    servos_driven: int
    brown_out_level: int


class RunReportRequest(Payload):
    """The last run, as measured by the sequencer's own timer."""

    TYPE: ClassVar[int] = 0x04
    SIZE: ClassVar[int] = 0
    __slots__ = ()
    LAYOUT: ClassVar[Layout] = ()


class RunReportReply(Payload):
    """The last run, as measured by the sequencer's own timer.

    Attributes:
        released: 1: there was a run since power was switched on. 0: the rest is zero.
        bounces: Edges of both switches from the release's first edge to its confirmation.
        release_ms: The release edge on the clock of uptime_ms: whole milliseconds. After a reset: of the uptime before it.
        release_us: And microseconds beyond those, 0 to 999.
        stroke_count: Strokes of the maneuver that flew.
        start_us: Of each stroke, the rise of the first whole pulse of its width that was on the pin, after the release edge, 0.5 us rounded down; or stroke_not_begun_us, stroke_time_unknown_us. Late where the pin was held and let go.
        earlier_us: The robot may have left so long before the release edge; 0 unless the edges fit two releases.
        later_us: And so long after it.
    """

    TYPE: ClassVar[int] = 0x84
    SIZE: ClassVar[int] = 82
    __slots__ = ("released", "bounces", "release_ms", "release_us", "stroke_count", "start_us", "earlier_us", "later_us",)
    LAYOUT: ClassVar[Layout] = (
        ("released", "B", None),
        ("bounces", "H", None),
        ("release_ms", "I", None),
        ("release_us", "H", None),
        ("stroke_count", "B", None),
        ("start_us", "I", 16),
        ("earlier_us", "I", None),
        ("later_us", "I", None),
    )

    released: int
    bounces: int
    release_ms: int
    release_us: int
    stroke_count: int
    start_us: tuple[int, ...]
    earlier_us: int
    later_us: int


class LoggerStatusRequest(Payload):
    """What the logger is doing."""

    TYPE: ClassVar[int] = 0x03
    SIZE: ClassVar[int] = 0
    __slots__ = ()
    LAYOUT: ClassVar[Layout] = ()


class LoggerStatusReply(Payload):
    """What the logger is doing.

    Attributes:
        state: State.
        error: Why the last recording failed, or none.
        imu_present: Bits 0-3: IMU 1-4 answers now.
        switches_open: Bit 0, 1: release switch 1, 2 is open.
        session: Of the present or last recording; 0 before the first.
        samples: Samples of that recording.
        samples_dropped: Of those, lost because the ring was full.
        blocks_written: Blocks handed to the card.
        ring_blocks: Blocks that wait for the card.
        ring_peak_blocks: Most that ever waited.
        rate_hz: Sampling rate.
        who_am_i: Register 0x75 of each IMU.
        uptime_ms: Since the board started.
        card: The card, looked at every two seconds while nothing is recorded.
        card_free_mib: Free room on it, counted when the logger met it and after each recording.
        phase: Of the present or last recording.
        ram_holds_drop: 1: RAM holds a drop that no card has. Keep the power on and fetch it.
        late_ticks: Ticks of the sampling timer without a sample, since the board started.
        settings_origin: Of the settings in force.
        unix_us: Time of day, or 0 when no host has set it.
    """

    TYPE: ClassVar[int] = 0x83
    SIZE: ClassVar[int] = 54
    __slots__ = ("state", "error", "imu_present", "switches_open", "session", "samples", "samples_dropped", "blocks_written", "ring_blocks", "ring_peak_blocks", "rate_hz", "who_am_i", "uptime_ms", "card", "card_free_mib", "phase", "ram_holds_drop", "late_ticks", "settings_origin", "unix_us",)
    LAYOUT: ClassVar[Layout] = (
        ("state", LoggerState, None),
        ("error", ErrorCode, None),
        ("imu_present", "B", None),
        ("switches_open", "B", None),
        ("session", "I", None),
        ("samples", "I", None),
        ("samples_dropped", "I", None),
        ("blocks_written", "I", None),
        ("ring_blocks", "H", None),
        ("ring_peak_blocks", "H", None),
        ("rate_hz", "H", None),
        ("who_am_i", "B", 4),
        ("uptime_ms", "I", None),
        ("card", CardState, None),
        ("card_free_mib", "I", None),
        ("phase", DropPhase, None),
        ("ram_holds_drop", "B", None),
        ("late_ticks", "I", None),
        ("settings_origin", Origin, None),
        ("unix_us", "Q", None),
    )

    state: LoggerState
    error: ErrorCode
    imu_present: int
    switches_open: int
    session: int
    samples: int
    samples_dropped: int
    blocks_written: int
    ring_blocks: int
    ring_peak_blocks: int
    rate_hz: int
    who_am_i: bytes
    uptime_ms: int
    card: CardState
    card_free_mib: int
    phase: DropPhase
    ram_holds_drop: int
    late_ticks: int
    settings_origin: Origin
    unix_us: int


class ManeuverBeginRequest(Payload):
    """Starts an upload. The stored maneuver stays until commit, but ARM is refused (upload_interrupted) from here on, power cuts included.

    Attributes:
        stroke_count: Strokes that follow.
        speed_cdeg_s: Average joint speed that the schedule assumes, 0.01 deg/s.
    """

    TYPE: ClassVar[int] = 0x10
    SIZE: ClassVar[int] = 3
    __slots__ = ("stroke_count", "speed_cdeg_s",)
    LAYOUT: ClassVar[Layout] = (
        ("stroke_count", "B", None),
        ("speed_cdeg_s", "H", None),
    )

    stroke_count: int
    speed_cdeg_s: int


class ManeuverBeginReply(Payload):
    """Starts an upload. The stored maneuver stays until commit, but ARM is refused (upload_interrupted) from here on, power cuts included.

    Attributes:
        stroke_count: As understood.
    """

    TYPE: ClassVar[int] = 0x90
    SIZE: ClassVar[int] = 1
    __slots__ = ("stroke_count",)
    LAYOUT: ClassVar[Layout] = (
        ("stroke_count", "B", None),
    )

    stroke_count: int


class ManeuverStrokeRequest(Payload):
    """One stroke of the upload.

    Attributes:
        index: From 0.
        joint: 1 to 3.
        angle_cdeg: Displacement, 0.01 deg.
        start_us: Start after release.
    """

    TYPE: ClassVar[int] = 0x11
    SIZE: ClassVar[int] = 8
    __slots__ = ("index", "joint", "angle_cdeg", "start_us",)
    LAYOUT: ClassVar[Layout] = (
        ("index", "B", None),
        ("joint", "B", None),
        ("angle_cdeg", "h", None),
        ("start_us", "I", None),
    )

    index: int
    joint: int
    angle_cdeg: int
    start_us: int


class ManeuverStrokeReply(Payload):
    """One stroke of the upload.

    Attributes:
        index: As understood.
    """

    TYPE: ClassVar[int] = 0x91
    SIZE: ClassVar[int] = 1
    __slots__ = ("index",)
    LAYOUT: ClassVar[Layout] = (
        ("index", "B", None),
    )

    index: int


class ManeuverCommitRequest(Payload):
    """Checks the whole maneuver and stores it. EEPROM is slow: the host repeats the commit until `stored` is 1.

    Attributes:
        crc: CRC-16/IBM-3740 over stroke_count, speed_cdeg_s and each stroke's joint, angle_cdeg, start_us.
    """

    TYPE: ClassVar[int] = 0x12
    SIZE: ClassVar[int] = 2
    __slots__ = ("crc",)
    LAYOUT: ClassVar[Layout] = (
        ("crc", "H", None),
    )

    crc: int


class ManeuverCommitReply(Payload):
    """Checks the whole maneuver and stores it. EEPROM is slow: the host repeats the commit until `stored` is 1.

    Attributes:
        stored: 0: still writing. 1: stored, checked by reading back.
        written: 1: this upload changed the store. 0: it held the same maneuver already.
    """

    TYPE: ClassVar[int] = 0x92
    SIZE: ClassVar[int] = 2
    __slots__ = ("stored", "written",)
    LAYOUT: ClassVar[Layout] = (
        ("stored", "B", None),
        ("written", "B", None),
    )

    stored: int
    written: int


class ManeuverInfoRequest(Payload):
    """Which maneuver would fly."""

    TYPE: ClassVar[int] = 0x13
    SIZE: ClassVar[int] = 0
    __slots__ = ()
    LAYOUT: ClassVar[Layout] = ()


class ManeuverInfoReply(Payload):
    """Which maneuver would fly.

    Attributes:
        origin: Factory or uploaded.
        stroke_count: Strokes.
        speed_cdeg_s: Average joint speed, 0.01 deg/s.
        crc: As in maneuver_commit, computed from what would fly.
        end_us: When the last stroke ends.
        generation: Uploads that this board has stored.
    """

    TYPE: ClassVar[int] = 0x93
    SIZE: ClassVar[int] = 14
    __slots__ = ("origin", "stroke_count", "speed_cdeg_s", "crc", "end_us", "generation",)
    LAYOUT: ClassVar[Layout] = (
        ("origin", Origin, None),
        ("stroke_count", "B", None),
        ("speed_cdeg_s", "H", None),
        ("crc", "H", None),
        ("end_us", "I", None),
        ("generation", "I", None),
    )

    origin: Origin
    stroke_count: int
    speed_cdeg_s: int
    crc: int
    end_us: int
    generation: int


class ManeuverReadRequest(Payload):
    """Reads one stroke back from what would fly.

    Attributes:
        index: From 0.
    """

    TYPE: ClassVar[int] = 0x14
    SIZE: ClassVar[int] = 1
    __slots__ = ("index",)
    LAYOUT: ClassVar[Layout] = (
        ("index", "B", None),
    )

    index: int


class ManeuverReadReply(Payload):
    """Reads one stroke back from what would fly.

    Attributes:
        index: As asked.
        joint: 1 to 3.
        angle_cdeg: Displacement, 0.01 deg.
        start_us: Start after release.
    """

    TYPE: ClassVar[int] = 0x94
    SIZE: ClassVar[int] = 8
    __slots__ = ("index", "joint", "angle_cdeg", "start_us",)
    LAYOUT: ClassVar[Layout] = (
        ("index", "B", None),
        ("joint", "B", None),
        ("angle_cdeg", "h", None),
        ("start_us", "I", None),
    )

    index: int
    joint: int
    angle_cdeg: int
    start_us: int


class ArmRequest(Payload):
    """From now on the release starts the maneuver.

    Attributes:
        arm_token: From sequencer_status.
    """

    TYPE: ClassVar[int] = 0x20
    SIZE: ClassVar[int] = 2
    __slots__ = ("arm_token",)
    LAYOUT: ClassVar[Layout] = (
        ("arm_token", "H", None),
    )

    arm_token: int


class ArmReply(Payload):
    """From now on the release starts the maneuver.

    Attributes:
        state: Afterwards.
    """

    TYPE: ClassVar[int] = 0xA0
    SIZE: ClassVar[int] = 1
    __slots__ = ("state",)
    LAYOUT: ClassVar[Layout] = (
        ("state", SequencerState, None),
    )

    state: SequencerState


class DisarmRequest(Payload):
    """Back to safe, from any state; stops the servo pulses and clears a latched fault."""

    TYPE: ClassVar[int] = 0x21
    SIZE: ClassVar[int] = 0
    __slots__ = ()
    LAYOUT: ClassVar[Layout] = ()


class DisarmReply(Payload):
    """Back to safe, from any state; stops the servo pulses and clears a latched fault.

    Attributes:
        state: Afterwards.
    """

    TYPE: ClassVar[int] = 0xA1
    SIZE: ClassVar[int] = 1
    __slots__ = ("state",)
    LAYOUT: ClassVar[Layout] = (
        ("state", SequencerState, None),
    )

    state: SequencerState


class RecordStartRequest(Payload):
    """Starts a recording, and sets the time of day. Refused by the card, it still goes on in RAM (state failed).

    Attributes:
        number: Chosen at random by the host.
        unix_us: Time of day; 0 leaves the clock as it is.
    """

    TYPE: ClassVar[int] = 0x40
    SIZE: ClassVar[int] = 12
    __slots__ = ("number", "unix_us",)
    LAYOUT: ClassVar[Layout] = (
        ("number", "I", None),
        ("unix_us", "Q", None),
    )

    number: int
    unix_us: int


class RecordStartReply(Payload):
    """Starts a recording, and sets the time of day. Refused by the card, it still goes on in RAM (state failed).

    Attributes:
        state: Afterwards.
        session: Random id of the recording.
    """

    TYPE: ClassVar[int] = 0xC0
    SIZE: ClassVar[int] = 5
    __slots__ = ("state", "session",)
    LAYOUT: ClassVar[Layout] = (
        ("state", LoggerState, None),
        ("session", "I", None),
    )

    state: LoggerState
    session: int


class RecordStopRequest(Payload):
    """Ends the recording with a footer. The host repeats it until the state is stopped."""

    TYPE: ClassVar[int] = 0x41
    SIZE: ClassVar[int] = 0
    __slots__ = ()
    LAYOUT: ClassVar[Layout] = ()


class RecordStopReply(Payload):
    """Ends the recording with a footer. The host repeats it until the state is stopped.

    Attributes:
        state: stopping, then stopped.
        session: Of the recording.
        samples: Samples taken.
        samples_dropped: Of those, lost.
    """

    TYPE: ClassVar[int] = 0xC1
    SIZE: ClassVar[int] = 13
    __slots__ = ("state", "session", "samples", "samples_dropped",)
    LAYOUT: ClassVar[Layout] = (
        ("state", LoggerState, None),
        ("session", "I", None),
        ("samples", "I", None),
        ("samples_dropped", "I", None),
    )

    state: LoggerState
    session: int
    samples: int
    samples_dropped: int


class LiveRequest(Payload):
    """Switches live sampling on or off. It also ends when the cable is pulled.

    Attributes:
        enabled: 1 on, 0 off.
    """

    TYPE: ClassVar[int] = 0x42
    SIZE: ClassVar[int] = 1
    __slots__ = ("enabled",)
    LAYOUT: ClassVar[Layout] = (
        ("enabled", "B", None),
    )

    enabled: int


class LiveReply(Payload):
    """Switches live sampling on or off. It also ends when the cable is pulled.

    Attributes:
        enabled: As understood.
        rate_hz: Sampling rate.
        gyro_lsb_per_deg_s: Gyro scale.
        accel_lsb_per_g: Accelerometer scale.
        angle_counts_per_turn: Angle sensor scale.
        dlpf_cfg: Low-pass of the IMUs, CONFIG.DLPF_CFG.
        who_am_i: Register 0x75 of each IMU; 0 where none answered.
        imu_offset_us: From a sample's time to the moment of each IMU's reading.
        angle_offset_us: The same of each angle sensor.
    """

    TYPE: ClassVar[int] = 0xC2
    SIZE: ClassVar[int] = 40
    __slots__ = ("enabled", "rate_hz", "gyro_lsb_per_deg_s", "accel_lsb_per_g", "angle_counts_per_turn", "dlpf_cfg", "who_am_i", "imu_offset_us", "angle_offset_us",)
    LAYOUT: ClassVar[Layout] = (
        ("enabled", "B", None),
        ("rate_hz", "H", None),
        ("gyro_lsb_per_deg_s", "f", None),
        ("accel_lsb_per_g", "f", None),
        ("angle_counts_per_turn", "I", None),
        ("dlpf_cfg", "B", None),
        ("who_am_i", "B", 4),
        ("imu_offset_us", "H", 4),
        ("angle_offset_us", "H", 6),
    )

    enabled: int
    rate_hz: int
    gyro_lsb_per_deg_s: float
    accel_lsb_per_g: float
    angle_counts_per_turn: int
    dlpf_cfg: int
    who_am_i: bytes
    imu_offset_us: tuple[int, ...]
    angle_offset_us: tuple[int, ...]


class LoggerSettingsWriteRequest(Payload):
    """Checks, stores and uses new settings; not while recording. rate_too_high: detail = the highest rate in Hz that the buses carry.

    Attributes:
        settings: All of them.
    """

    TYPE: ClassVar[int] = 0x45
    SIZE: ClassVar[int] = 12
    __slots__ = ("settings",)
    LAYOUT: ClassVar[Layout] = (
        ("settings", LoggerSettings, None),
    )

    settings: LoggerSettings


class LoggerSettingsWriteReply(Payload):
    """Checks, stores and uses new settings; not while recording. rate_too_high: detail = the highest rate in Hz that the buses carry.

    Attributes:
        stored: 1: stored, checked by reading back.
    """

    TYPE: ClassVar[int] = 0xC5
    SIZE: ClassVar[int] = 1
    __slots__ = ("stored",)
    LAYOUT: ClassVar[Layout] = (
        ("stored", "B", None),
    )

    stored: int


class LoggerSettingsReadRequest(Payload):
    """The settings in force."""

    TYPE: ClassVar[int] = 0x46
    SIZE: ClassVar[int] = 0
    __slots__ = ()
    LAYOUT: ClassVar[Layout] = ()


class LoggerSettingsReadReply(Payload):
    """The settings in force.

    Attributes:
        origin: Factory or uploaded.
        settings: All of them.
        rate_max_hz: What the buses carry at this clock.
    """

    TYPE: ClassVar[int] = 0xC6
    SIZE: ClassVar[int] = 15
    __slots__ = ("origin", "settings", "rate_max_hz",)
    LAYOUT: ClassVar[Layout] = (
        ("origin", Origin, None),
        ("settings", LoggerSettings, None),
        ("rate_max_hz", "H", None),
    )

    origin: Origin
    settings: LoggerSettings
    rate_max_hz: int


class ClockSetRequest(Payload):
    """Sets the time of day.

    Attributes:
        unix_us: Unix time now.
    """

    TYPE: ClassVar[int] = 0x47
    SIZE: ClassVar[int] = 8
    __slots__ = ("unix_us",)
    LAYOUT: ClassVar[Layout] = (
        ("unix_us", "Q", None),
    )

    unix_us: int


class ClockSetReply(Payload):
    """Sets the time of day.

    Attributes:
        uptime_us: The logger's clock at that moment.
    """

    TYPE: ClassVar[int] = 0xC7
    SIZE: ClassVar[int] = 8
    __slots__ = ("uptime_us",)
    LAYOUT: ClassVar[Layout] = (
        ("uptime_us", "Q", None),
    )

    uptime_us: int


class LogListRequest(Payload):
    """The first recording whose number is `from_number` or greater; not while recording.

    Attributes:
        from_number: 0 to begin with what RAM holds.
    """

    TYPE: ClassVar[int] = 0x48
    SIZE: ClassVar[int] = 2
    __slots__ = ("from_number",)
    LAYOUT: ClassVar[Layout] = (
        ("from_number", "H", None),
    )

    from_number: int


class LogListReply(Payload):
    """The first recording whose number is `from_number` or greater; not while recording.

    Attributes:
        found: 0: there is none, the rest is zero.
        entry: The recording.
    """

    TYPE: ClassVar[int] = 0xC8
    SIZE: ClassVar[int] = 20
    __slots__ = ("found", "entry",)
    LAYOUT: ClassVar[Layout] = (
        ("found", "B", None),
        ("entry", LogEntry, None),
    )

    found: int
    entry: LogEntry


class LogReadRequest(Payload):
    """Sends blocks of a recording as log_part and log_zeros; not while recording. A new log_read, or a closed port, ends the one before.

    Attributes:
        number: As in LogEntry.
        session: As in LogEntry.
        first_block: From 0.
        count: At most log_read_blocks.
    """

    TYPE: ClassVar[int] = 0x49
    SIZE: ClassVar[int] = 12
    __slots__ = ("number", "session", "first_block", "count",)
    LAYOUT: ClassVar[Layout] = (
        ("number", "H", None),
        ("session", "I", None),
        ("first_block", "I", None),
        ("count", "H", None),
    )

    number: int
    session: int
    first_block: int
    count: int


class LogReadReply(Payload):
    """Sends blocks of a recording as log_part and log_zeros; not while recording. A new log_read, or a closed port, ends the one before.

    Attributes:
        count: Blocks that will be sent: fewer at the end of the file.
    """

    TYPE: ClassVar[int] = 0xC9
    SIZE: ClassVar[int] = 2
    __slots__ = ("count",)
    LAYOUT: ClassVar[Layout] = (
        ("count", "H", None),
    )

    count: int


class LogEraseRequest(Payload):
    """Removes a recording from the card; number 0: gives up what RAM holds. Not while recording.

    Attributes:
        number: As in LogEntry.
        session: As in LogEntry.
    """

    TYPE: ClassVar[int] = 0x4A
    SIZE: ClassVar[int] = 6
    __slots__ = ("number", "session",)
    LAYOUT: ClassVar[Layout] = (
        ("number", "H", None),
        ("session", "I", None),
    )

    number: int
    session: int


class LogEraseReply(Payload):
    """Removes a recording from the card; number 0: gives up what RAM holds. Not while recording.

    Attributes:
        erased: 1.
    """

    TYPE: ClassVar[int] = 0xCA
    SIZE: ClassVar[int] = 1
    __slots__ = ("erased",)
    LAYOUT: ClassVar[Layout] = (
        ("erased", "B", None),
    )

    erased: int


class LogPartStream(Payload):
    """A piece of a block, as asked for by log_read. A lost one is asked for again.

    Attributes:
        block: Of the recording.
        part: From 0.
        data: log_part_bytes of the block.
    """

    TYPE: ClassVar[int] = 0x61
    SIZE: ClassVar[int] = 69
    __slots__ = ("block", "part", "data",)
    LAYOUT: ClassVar[Layout] = (
        ("block", "I", None),
        ("part", "B", None),
        ("data", "B", 64),
    )

    block: int
    part: int
    data: bytes


class LogZerosStream(Payload):
    """Blocks that hold only zeros, as asked for by log_read.

    Attributes:
        first_block: Of the recording.
        count: Blocks.
    """

    TYPE: ClassVar[int] = 0x62
    SIZE: ClassVar[int] = 6
    __slots__ = ("first_block", "count",)
    LAYOUT: ClassVar[Layout] = (
        ("first_block", "I", None),
        ("count", "H", None),
    )

    first_block: int
    count: int


class LiveSampleStream(Payload):
    """One sample as it is taken; sent unasked while live sampling is on. What the host does not read in time is skipped and shows as a gap in the index.

    Attributes:
        index: Of the sample since the board started.
        time_us: The logger's clock, since power-up.
        sample: time_offset_us is 0.
    """

    TYPE: ClassVar[int] = 0x60
    SIZE: ClassVar[int] = 86
    __slots__ = ("index", "time_us", "sample",)
    LAYOUT: ClassVar[Layout] = (
        ("index", "I", None),
        ("time_us", "Q", None),
        ("sample", Sample, None),
    )

    index: int
    time_us: int
    sample: Sample


class ErrorReply(Payload):
    """Answer to a request that was not served.

    Attributes:
        request: Type of the request.
        code: Why.
        detail: What the code refers to, such as the index of the stroke; -1 where nothing.
    """

    TYPE: ClassVar[int] = 0xFF
    SIZE: ClassVar[int] = 6
    __slots__ = ("request", "code", "detail",)
    LAYOUT: ClassVar[Layout] = (
        ("request", "B", None),
        ("code", ErrorCode, None),
        ("detail", "i", None),
    )

    request: int
    code: ErrorCode
    detail: int


class SettingsWriteRequest(Payload):
    """Checks and stores the servo settings. The host repeats it until `stored` is 1, then reads back.

    Attributes:
        frame_us: From pulse to pulse.
        servo: Joints 1 to 3.
    """

    TYPE: ClassVar[int] = 0x15
    SIZE: ClassVar[int] = 29
    __slots__ = ("frame_us", "servo",)
    LAYOUT: ClassVar[Layout] = (
        ("frame_us", "H", None),
        ("servo", ServoSetting, 3),
    )

    frame_us: int
    servo: tuple[ServoSetting, ...]


class SettingsWriteReply(Payload):
    """Checks and stores the servo settings. The host repeats it until `stored` is 1, then reads back.

    Attributes:
        stored: 0: still writing. 1: stored, checked by reading back.
        written: 1: storing these settings changed the store. 0: it held them already before they were sent.
    """

    TYPE: ClassVar[int] = 0x95
    SIZE: ClassVar[int] = 2
    __slots__ = ("stored", "written",)
    LAYOUT: ClassVar[Layout] = (
        ("stored", "B", None),
        ("written", "B", None),
    )

    stored: int
    written: int


class SettingsReadRequest(Payload):
    """The servo settings in force."""

    TYPE: ClassVar[int] = 0x16
    SIZE: ClassVar[int] = 0
    __slots__ = ()
    LAYOUT: ClassVar[Layout] = ()


class SettingsReadReply(Payload):
    """The servo settings in force.

    Attributes:
        origin: Factory or uploaded.
        generation: Settings that this board has stored.
        frame_us: From pulse to pulse.
        servo: Joints 1 to 3.
    """

    TYPE: ClassVar[int] = 0x96
    SIZE: ClassVar[int] = 34
    __slots__ = ("origin", "generation", "frame_us", "servo",)
    LAYOUT: ClassVar[Layout] = (
        ("origin", Origin, None),
        ("generation", "I", None),
        ("frame_us", "H", None),
        ("servo", ServoSetting, 3),
    )

    origin: Origin
    generation: int
    frame_us: int
    servo: tuple[ServoSetting, ...]


class JointReportRequest(Payload):
    """What the joint angles are, as the host has them from the logger. ARM heeds it while it is fresh.

    Attributes:
        angle_cdeg: Joints 1 to 3, 0.01 deg.
    """

    TYPE: ClassVar[int] = 0x22
    SIZE: ClassVar[int] = 6
    __slots__ = ("angle_cdeg",)
    LAYOUT: ClassVar[Layout] = (
        ("angle_cdeg", "h", 3),
    )

    angle_cdeg: tuple[int, ...]


class JointReportReply(Payload):
    """What the joint angles are, as the host has them from the logger. ARM heeds it while it is fresh.

    Attributes:
        at_start_pose: 1: all within the tolerance.
    """

    TYPE: ClassVar[int] = 0xA2
    SIZE: ClassVar[int] = 1
    __slots__ = ("at_start_pose",)
    LAYOUT: ClassVar[Layout] = (
        ("at_start_pose", "B", None),
    )

    at_start_pose: int


class JogRequest(Payload):
    """Moves one joint slowly; from SAFE or an earlier jog only. A limp joint has no known angle: the host says where it is, so that the first pulse does not jerk it. DISARM, a closed port, or a while without orders ends it.

    Attributes:
        joint: 1 to 3.
        from_cdeg: Where the joint is; ignored while it is already being jogged.
        to_cdeg: Where it is to go; within its limits.
        confirm: jog_confirm.
    """

    TYPE: ClassVar[int] = 0x23
    SIZE: ClassVar[int] = 9
    __slots__ = ("joint", "from_cdeg", "to_cdeg", "confirm",)
    LAYOUT: ClassVar[Layout] = (
        ("joint", "B", None),
        ("from_cdeg", "h", None),
        ("to_cdeg", "h", None),
        ("confirm", "I", None),
    )

    joint: int
    from_cdeg: int
    to_cdeg: int
    confirm: int


class JogReply(Payload):
    """Moves one joint slowly; from SAFE or an earlier jog only. A limp joint has no known angle: the host says where it is, so that the first pulse does not jerk it. DISARM, a closed port, or a while without orders ends it.

    Attributes:
        angle_cdeg: What the servo is told now.
        arrived: 1: it is told the target.
    """

    TYPE: ClassVar[int] = 0xA3
    SIZE: ClassVar[int] = 3
    __slots__ = ("angle_cdeg", "arrived",)
    LAYOUT: ClassVar[Layout] = (
        ("angle_cdeg", "h", None),
        ("arrived", "B", None),
    )

    angle_cdeg: int
    arrived: int
