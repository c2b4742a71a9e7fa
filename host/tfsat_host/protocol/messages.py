"""Payloads of the link's frames and records of the log.

Generated from protocol/tfsat.toml by tools/generate_protocol.py. Do not edit.
"""

from typing import Annotated

from .enums import (
    BlockKind,
    Board,
    CardState,
    DropPhase,
    ErrorCode,
    EventCode,
    LoggerState,
    Origin,
    ResetCause,
    SequencerState,
    StopReason,
)
from .record import F32, I16, I32, U16, U32, U64, U8, Payload, Record


class ImuReading(Record):
    """One 14-byte burst of an MPU-6050, registers 0x3B to 0x48 (RM-MPU-6000A rev. 4.2, p. 29-32), raw counts.

    Attributes:
        accel: Specific force x, y, z.
        temperature: Die temperature: counts / temperature_lsb_per_c + temperature_offset_c.
        gyro: Angular rate x, y, z.
    """

    accel: Annotated[tuple[I16, ...], 3]
    temperature: I16
    gyro: Annotated[tuple[I16, ...], 3]


class Sample(Record):
    """All sensors, each read at the sample's time and its offset in LogHeader.

    Attributes:
        time_offset_us: Time after the block's time_us.
        flags: Bits 0-3: IMU 1-4 valid; 4-9: angle sensor 1-6 valid; 10, 11: release switch 1, 2 open; 12-15: IMU 1-4 clipped.
        imu: Bodies 1 to 4.
        angle: Absolute angle sensors, ADC counts: joint 1 (two sensors), joint 2, joint 3.
    """

    time_offset_us: U32
    flags: U16
    imu: Annotated[tuple[ImuReading, ...], 4]
    angle: Annotated[tuple[U16, ...], 6]


class Event(Record):
    """Something that happened, with its own time.

    Attributes:
        time_us: The logger's clock, since power-up.
        code: What happened.
        index: Which one; see EventCode.
        arg: See EventCode.
        value: See EventCode.
    """

    time_us: U64
    code: EventCode
    index: U8
    arg: U16
    value: I32


class ServoSetting(Record):
    """How a joint's servo turns pulses into angles, and how far it may go.

    Attributes:
        zero_us: Pulse width that holds 0 deg.
        ns_per_deg: Change of pulse width for each degree.
        reversed: 1: shorter pulses open the joint.
        min_cdeg: Least angle that may be commanded.
        max_cdeg: Greatest angle that may be commanded.
    """

    zero_us: U16
    ns_per_deg: U16
    reversed: U8
    min_cdeg: I16
    max_cdeg: I16


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

    magic: U32
    version: U8
    kind: BlockKind
    sample_count: U8
    event_count: U8
    session: U32
    block_number: U32
    first_sample: U32
    samples_dropped: U32
    time_us: U64


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
        maneuver_known: 1: the next field is known. 0 also in logs of firmware that does not tell it.
        maneuver_crc: Of the maneuver that the sequencer held when the recording was started, as in maneuver_info.
    """

    protocol_hash: Annotated[bytes, 8]
    firmware_version: Annotated[bytes, 3]
    imu_present: U8
    board_serial: Annotated[bytes, 8]
    image_crc: U32
    rate_hz: F32
    gyro_lsb_per_deg_s: F32
    accel_lsb_per_g: F32
    temperature_lsb_per_c: F32
    temperature_offset_c: F32
    angle_counts_per_turn: U32
    gyro_range_deg_s: U16
    accel_range_g: U8
    dlpf_cfg: U8
    who_am_i: Annotated[bytes, 4]
    bus_khz: U16
    after_landing_s: U16
    schema: Annotated[bytes, 384]
    wall_clock_us: U64
    imu_offset_us: Annotated[tuple[U16, ...], 4]
    angle_offset_us: Annotated[tuple[U16, ...], 6]
    maneuver_known: U8
    maneuver_crc: U16


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

    samples: U32
    samples_dropped: U32
    blocks: U32
    ring_peak_blocks: U32
    interval_min_us: U32
    interval_max_us: U32
    jitter_rms_us: F32
    late_ticks: U32
    ring_blocks: U32
    card_stall_max_ms: U32
    blocks_rewritten: U32
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

    rate_hz: U16
    gyro_range_deg_s: U16
    accel_range_g: U8
    dlpf_cfg: U8
    bus_khz: U16
    after_landing_s: U16
    file_mib: U16


class LogEntry(Record):
    """A recording that the logger can hand over.

    Attributes:
        number: Of its file, DROP0001.BIN and up; 0 is what RAM holds.
        session: Random id of the recording; 0: its first block says nothing.
        blocks: Blocks of the file; unused room included where it was not closed.
        wall_clock_us: Unix time of its start, or 0.
        closed: 1: its last block is its footer.
    """

    number: U16
    session: U32
    blocks: U32
    wall_clock_us: U64
    closed: U8


class HelloRequest(Payload):
    """Who are you? Its number and layout never change, so that any two revisions understand it."""

    TYPE = 0x01


class HelloReply(Payload):
    """Who are you? Its number and layout never change, so that any two revisions understand it.

    Attributes:
        board: Kind of board.
        firmware_version: Major, minor, patch.
        board_serial: Serial number of the chip; zeros where it has none.
        image_crc: CRC-32/ISO-HDLC of the flashed image, computed by the board.
        protocol_hash: Hash of this specification.
    """

    TYPE = 0x81
    board: Board
    firmware_version: Annotated[bytes, 3]
    board_serial: Annotated[bytes, 8]
    image_crc: U32
    protocol_hash: Annotated[bytes, 8]


class SequencerStatusRequest(Payload):
    """What the sequencer is doing."""

    TYPE = 0x02


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
        knocks: False triggers since arming, see [release]; kept over a reset.
        joint_angle_cdeg: Angle that each servo is told to hold; 0 where it gets no pulses.
        uptime_ms: Since the board started.
        image_crc: CRC-32/ISO-HDLC of the flashed image.
        ram_never_used_bytes: Low-water mark of free RAM since the board started.
        frames_rejected: Frames that arrived damaged, since the board started.
        stores_damaged: Why ARM is refused for what is stored; even bits for the maneuver, odd ones for the servo settings. Bit 0, 1: store_damaged; 2, 3: upload_interrupted; 4, 5: store_old_layout.
        false_releases: False releases since arming, see [release]; kept over a reset.
        servos_driven: Bit 0, 1, 2: the servo of joint 1, 2, 3 gets pulses; else it is limp.
        brown_out_level: The fuse BODLEVEL: the supply below which the processor is held in reset (ATmega32U4 datasheet 7766J, table 8-1). 0: 4.3 V; 1: 3.5; 2: 3.4; 3: 2.6; 4: 2.4; 5: 2.2; 6: 2.0; 7: it never is.
    """

    TYPE = 0x82
    state: SequencerState
    fault: ErrorCode
    last_refusal: ErrorCode
    switches_open: U8
    arm_token: U16
    reset_cause: ResetCause
    resets_while_armed: U8
    strokes_started: U8
    knocks: U16
    joint_angle_cdeg: Annotated[tuple[I16, ...], 3]
    uptime_ms: U32
    image_crc: U32
    ram_never_used_bytes: U16
    frames_rejected: U16
    stores_damaged: U8
    false_releases: U16
    servos_driven: U8
    brown_out_level: U8


class RunReportRequest(Payload):
    """The last run, as measured by the sequencer's own timer."""

    TYPE = 0x04


class RunReportReply(Payload):
    """The last run, as measured by the sequencer's own timer.

    Attributes:
        released: 1: a run since power was switched on; 0: none, all other fields are zero.
        bounces: Edges of both switches from the release's first edge to its confirmation.
        release_ms: Time of the release edge by the clock of uptime_ms, whole milliseconds; after a reset: by the clock before it.
        release_us: Microseconds of that time beyond the whole milliseconds, 0 to 999.
        stroke_count: Strokes of the maneuver that flew.
        start_us: Of each stroke: from the release edge to the rise of the first whole pulse of its width on the pin, 0.5 us rounded down; or stroke_not_begun_us, stroke_time_unknown_us. Late if the pin was held from outside.
        earlier_us: The robot may have left up to this long before the release edge; 0 unless the edges, or those that were lost, fit two releases.
        later_us: And so long after it.
    """

    TYPE = 0x84
    released: U8
    bounces: U16
    release_ms: U32
    release_us: U16
    stroke_count: U8
    start_us: Annotated[tuple[U32, ...], 16]
    earlier_us: U32
    later_us: U32


class LoggerStatusRequest(Payload):
    """What the logger is doing."""

    TYPE = 0x03


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
        maneuver_known: 1: the next field is known.
        maneuver_crc: Of the maneuver in the header of the present or last recording; see LogHeader.
    """

    TYPE = 0x83
    state: LoggerState
    error: ErrorCode
    imu_present: U8
    switches_open: U8
    session: U32
    samples: U32
    samples_dropped: U32
    blocks_written: U32
    ring_blocks: U16
    ring_peak_blocks: U16
    rate_hz: U16
    who_am_i: Annotated[bytes, 4]
    uptime_ms: U32
    card: CardState
    card_free_mib: U32
    phase: DropPhase
    ram_holds_drop: U8
    late_ticks: U32
    settings_origin: Origin
    unix_us: U64
    maneuver_known: U8
    maneuver_crc: U16


class ManeuverBeginRequest(Payload):
    """Starts an upload. The stored maneuver stays until commit, but ARM is refused (upload_interrupted) from here on, power cuts included.

    Attributes:
        stroke_count: Strokes that follow.
        speed_cdeg_s: Average joint speed that the schedule assumes, 0.01 deg/s.
    """

    TYPE = 0x10
    stroke_count: U8
    speed_cdeg_s: U16


class ManeuverBeginReply(Payload):
    """Starts an upload. The stored maneuver stays until commit, but ARM is refused (upload_interrupted) from here on, power cuts included.

    Attributes:
        stroke_count: As understood.
    """

    TYPE = 0x90
    stroke_count: U8


class ManeuverStrokeRequest(Payload):
    """One stroke of the upload.

    Attributes:
        index: From 0.
        joint: 1 to 3.
        angle_cdeg: Displacement, 0.01 deg.
        start_us: Start after release.
    """

    TYPE = 0x11
    index: U8
    joint: U8
    angle_cdeg: I16
    start_us: U32


class ManeuverStrokeReply(Payload):
    """One stroke of the upload.

    Attributes:
        index: As understood.
    """

    TYPE = 0x91
    index: U8


class ManeuverCommitRequest(Payload):
    """Checks the whole maneuver and stores it. EEPROM is slow: the host repeats the commit until `stored` is 1.

    Attributes:
        crc: CRC-16/IBM-3740 over stroke_count, speed_cdeg_s and each stroke's joint, angle_cdeg, start_us.
    """

    TYPE = 0x12
    crc: U16


class ManeuverCommitReply(Payload):
    """Checks the whole maneuver and stores it. EEPROM is slow: the host repeats the commit until `stored` is 1.

    Attributes:
        stored: 0: still writing. 1: stored, checked by reading back.
        written: 1: this upload changed the store. 0: it held the same maneuver already.
    """

    TYPE = 0x92
    stored: U8
    written: U8


class ManeuverInfoRequest(Payload):
    """Which maneuver would fly."""

    TYPE = 0x13


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

    TYPE = 0x93
    origin: Origin
    stroke_count: U8
    speed_cdeg_s: U16
    crc: U16
    end_us: U32
    generation: U32


class ManeuverReadRequest(Payload):
    """Reads one stroke back from what would fly.

    Attributes:
        index: From 0.
    """

    TYPE = 0x14
    index: U8


class ManeuverReadReply(Payload):
    """Reads one stroke back from what would fly.

    Attributes:
        index: As asked.
        joint: 1 to 3.
        angle_cdeg: Displacement, 0.01 deg.
        start_us: Start after release.
    """

    TYPE = 0x94
    index: U8
    joint: U8
    angle_cdeg: I16
    start_us: U32


class ArmRequest(Payload):
    """From now on the release starts the maneuver.

    Attributes:
        arm_token: From sequencer_status.
    """

    TYPE = 0x20
    arm_token: U16


class ArmReply(Payload):
    """From now on the release starts the maneuver.

    Attributes:
        state: Afterwards.
    """

    TYPE = 0xA0
    state: SequencerState


class DisarmRequest(Payload):
    """Back to safe, from any state; stops the servo pulses and clears a latched fault."""

    TYPE = 0x21


class DisarmReply(Payload):
    """Back to safe, from any state; stops the servo pulses and clears a latched fault.

    Attributes:
        state: Afterwards.
    """

    TYPE = 0xA1
    state: SequencerState


class RecordStartRequest(Payload):
    """Starts a recording, and sets the time of day. Refused by the card, it still goes on in RAM (state failed).

    Attributes:
        number: Chosen at random by the host.
        unix_us: Time of day; 0 leaves the clock as it is.
        maneuver_known: 1: the next field is known.
        maneuver_crc: Of the maneuver that the sequencer holds, for the header; see LogHeader.
    """

    TYPE = 0x40
    number: U32
    unix_us: U64
    maneuver_known: U8
    maneuver_crc: U16


class RecordStartReply(Payload):
    """Starts a recording, and sets the time of day. Refused by the card, it still goes on in RAM (state failed).

    Attributes:
        state: Afterwards.
        session: Random id of the recording.
    """

    TYPE = 0xC0
    state: LoggerState
    session: U32


class RecordStopRequest(Payload):
    """Ends the recording with a footer. The host repeats it until the state is stopped."""

    TYPE = 0x41


class RecordStopReply(Payload):
    """Ends the recording with a footer. The host repeats it until the state is stopped.

    Attributes:
        state: stopping, then stopped.
        session: Of the recording.
        samples: Samples taken.
        samples_dropped: Of those, lost.
    """

    TYPE = 0xC1
    state: LoggerState
    session: U32
    samples: U32
    samples_dropped: U32


class LiveRequest(Payload):
    """Switches live sampling on or off. It also ends when the cable is pulled.

    Attributes:
        enabled: 1 on, 0 off.
    """

    TYPE = 0x42
    enabled: U8


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

    TYPE = 0xC2
    enabled: U8
    rate_hz: U16
    gyro_lsb_per_deg_s: F32
    accel_lsb_per_g: F32
    angle_counts_per_turn: U32
    dlpf_cfg: U8
    who_am_i: Annotated[bytes, 4]
    imu_offset_us: Annotated[tuple[U16, ...], 4]
    angle_offset_us: Annotated[tuple[U16, ...], 6]


class LoggerSettingsWriteRequest(Payload):
    """Checks, stores and uses new settings; not while recording. rate_too_high: detail = the highest rate in Hz that the buses carry.

    Attributes:
        settings: All of them.
    """

    TYPE = 0x45
    settings: LoggerSettings


class LoggerSettingsWriteReply(Payload):
    """Checks, stores and uses new settings; not while recording. rate_too_high: detail = the highest rate in Hz that the buses carry.

    Attributes:
        stored: 1: stored, checked by reading back.
    """

    TYPE = 0xC5
    stored: U8


class LoggerSettingsReadRequest(Payload):
    """The settings in force."""

    TYPE = 0x46


class LoggerSettingsReadReply(Payload):
    """The settings in force.

    Attributes:
        origin: Factory or uploaded.
        settings: All of them.
        rate_max_hz: What the buses carry at this clock.
    """

    TYPE = 0xC6
    origin: Origin
    settings: LoggerSettings
    rate_max_hz: U16


class ClockSetRequest(Payload):
    """Sets the time of day.

    Attributes:
        unix_us: Unix time now.
    """

    TYPE = 0x47
    unix_us: U64


class ClockSetReply(Payload):
    """Sets the time of day.

    Attributes:
        uptime_us: The logger's clock at that moment.
    """

    TYPE = 0xC7
    uptime_us: U64


class LogListRequest(Payload):
    """The first recording whose number is `from_number` or greater; not while recording.

    Attributes:
        from_number: 0 to begin with what RAM holds.
    """

    TYPE = 0x48
    from_number: U16


class LogListReply(Payload):
    """The first recording whose number is `from_number` or greater; not while recording.

    Attributes:
        found: 0: there is none, the rest is zero.
        entry: The recording.
    """

    TYPE = 0xC8
    found: U8
    entry: LogEntry


class LogReadRequest(Payload):
    """Sends blocks of a recording as log_part and log_zeros; not while recording. A new log_read, or a closed port, ends the one before.

    Attributes:
        number: As in LogEntry.
        session: As in LogEntry.
        first_block: From 0.
        count: At most log_read_blocks.
    """

    TYPE = 0x49
    number: U16
    session: U32
    first_block: U32
    count: U16


class LogReadReply(Payload):
    """Sends blocks of a recording as log_part and log_zeros; not while recording. A new log_read, or a closed port, ends the one before.

    Attributes:
        count: Blocks that will be sent: fewer at the end of the file.
    """

    TYPE = 0xC9
    count: U16


class LogEraseRequest(Payload):
    """Removes a recording from the card; number 0: gives up what RAM holds. Not while recording.

    Attributes:
        number: As in LogEntry.
        session: As in LogEntry.
    """

    TYPE = 0x4A
    number: U16
    session: U32


class LogEraseReply(Payload):
    """Removes a recording from the card; number 0: gives up what RAM holds. Not while recording.

    Attributes:
        erased: 1.
    """

    TYPE = 0xCA
    erased: U8


class LogPartStream(Payload):
    """A piece of a block, as asked for by log_read. A lost one is asked for again.

    Attributes:
        block: Of the recording.
        part: From 0.
        data: log_part_bytes of the block.
    """

    TYPE = 0x61
    block: U32
    part: U8
    data: Annotated[bytes, 64]


class LogZerosStream(Payload):
    """Blocks that hold only zeros, as asked for by log_read.

    Attributes:
        first_block: Of the recording.
        count: Blocks.
    """

    TYPE = 0x62
    first_block: U32
    count: U16


class LiveSampleStream(Payload):
    """One sample as it is taken; sent unasked while live sampling is on. What the host does not read in time is skipped and shows as a gap in the index.

    Attributes:
        index: Of the sample since the board started.
        time_us: The logger's clock, since power-up.
        sample: time_offset_us is 0.
    """

    TYPE = 0x60
    index: U32
    time_us: U64
    sample: Sample


class ErrorReply(Payload):
    """Answer to a request that was not served.

    Attributes:
        request: Type of the request.
        code: Why.
        detail: What the code refers to, such as the index of the stroke; -1 where nothing.
    """

    TYPE = 0xFF
    request: U8
    code: ErrorCode
    detail: I32


class SettingsWriteRequest(Payload):
    """Checks and stores the servo settings. The host repeats it until `stored` is 1, then reads back.

    Attributes:
        frame_us: From pulse to pulse.
        servo: Joints 1 to 3.
        moving_at_once: Joints that the supply can move at the same time, 1 to 3.
    """

    TYPE = 0x15
    frame_us: U16
    servo: Annotated[tuple[ServoSetting, ...], 3]
    moving_at_once: U8


class SettingsWriteReply(Payload):
    """Checks and stores the servo settings. The host repeats it until `stored` is 1, then reads back.

    Attributes:
        stored: 0: still writing. 1: stored, checked by reading back.
        written: 1: storing these settings changed the store. 0: it held them already before they were sent.
    """

    TYPE = 0x95
    stored: U8
    written: U8


class SettingsReadRequest(Payload):
    """The servo settings in force."""

    TYPE = 0x16


class SettingsReadReply(Payload):
    """The servo settings in force.

    Attributes:
        origin: Factory or uploaded.
        generation: Settings that this board has stored.
        frame_us: From pulse to pulse.
        servo: Joints 1 to 3.
        moving_at_once: Joints that the supply can move at the same time, 1 to 3.
    """

    TYPE = 0x96
    origin: Origin
    generation: U32
    frame_us: U16
    servo: Annotated[tuple[ServoSetting, ...], 3]
    moving_at_once: U8


class JointReportRequest(Payload):
    """What the joint angles are, as the host has them from the logger. ARM heeds it while it is fresh.

    Attributes:
        angle_cdeg: Joints 1 to 3, 0.01 deg.
    """

    TYPE = 0x22
    angle_cdeg: Annotated[tuple[I16, ...], 3]


class JointReportReply(Payload):
    """What the joint angles are, as the host has them from the logger. ARM heeds it while it is fresh.

    Attributes:
        at_start_pose: 1: all within the tolerance.
    """

    TYPE = 0xA2
    at_start_pose: U8


class JogRequest(Payload):
    """Moves one joint slowly; from SAFE or an earlier jog only. A limp joint has no known angle: the host says where it is, so that the first pulse does not jerk it. DISARM, a closed port, or a while without orders ends it.

    Attributes:
        joint: 1 to 3.
        from_cdeg: Where the joint is; ignored while it is already being jogged.
        to_cdeg: Where it is to go; within its limits.
        confirm: jog_confirm.
    """

    TYPE = 0x23
    joint: U8
    from_cdeg: I16
    to_cdeg: I16
    confirm: U32


class JogReply(Payload):
    """Moves one joint slowly; from SAFE or an earlier jog only. A limp joint has no known angle: the host says where it is, so that the first pulse does not jerk it. DISARM, a closed port, or a while without orders ends it.

    Attributes:
        angle_cdeg: What the servo is told now.
        arrived: 1: it is told the target.
    """

    TYPE = 0xA3
    angle_cdeg: I16
    arrived: U8
