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
    """One 14-byte burst of an MPU-6050, registers 0x3B to 0x48 (RM-MPU-6000A rev. 4.2, p. 29-32), raw counts."""

    accel: Annotated[tuple[I16, ...], 3]  # Specific force x, y, z.
    temperature: I16  # Die temperature: counts / temperature_lsb_per_c + temperature_offset_c.
    gyro: Annotated[tuple[I16, ...], 3]  # Angular rate x, y, z.


class Sample(Record):
    """All sensors, each read at the sample's time and its offset in LogHeader."""

    time_offset_us: U32  # Time after the block's time_us.
    flags: U16  # Bits 0-3: IMU 1-4 valid; 4-9: angle sensor 1-6 valid; 10, 11: release switch 1, 2 open; 12-15: IMU 1-4 clipped.
    imu: Annotated[tuple[ImuReading, ...], 4]  # Bodies 1 to 4.
    angle: Annotated[tuple[U16, ...], 6]  # Absolute angle sensors, ADC counts: joint 1 (two sensors), joint 2, joint 3.


class Event(Record):
    """Something that happened, with its own time."""

    time_us: U64  # The logger's clock, since power-up.
    code: EventCode  # What happened.
    index: U8  # Which one; see EventCode.
    arg: U16  # See EventCode.
    value: I32  # See EventCode.


class ServoSetting(Record):
    """How a joint's servo turns pulses into angles, and how far it may go."""

    zero_us: U16  # Pulse width that holds 0 deg.
    ns_per_deg: U16  # Change of pulse width for each degree.
    reversed: U8  # 1: shorter pulses open the joint.
    min_cdeg: I16  # Least angle that may be commanded.
    max_cdeg: I16  # Greatest angle that may be commanded.


class BlockHeader(Record):
    """The first 32 bytes of every block."""

    magic: U32  # block_magic.
    version: U8  # block_version.
    kind: BlockKind  # What the block holds.
    sample_count: U8  # Sample slots in use.
    event_count: U8  # Event slots in use.
    session: U32  # Random id of the recording.
    block_number: U32  # From 0, without gaps in a recording.
    first_sample: U32  # Index of the block's first sample in the recording, counting dropped ones too.
    samples_dropped: U32  # Samples lost so far because the ring was full.
    time_us: U64  # The logger's clock at the block's first sample, since power-up.


class LogHeader(Record):
    """What was recorded, with which scales. Payload of a header block."""

    protocol_hash: Annotated[bytes, 8]  # Of the specification that the firmware was built with.
    firmware_version: Annotated[bytes, 3]  # Major, minor, patch.
    imu_present: U8  # Bits 0-3: IMU 1-4 answered at the start.
    board_serial: Annotated[bytes, 8]  # The logger's serial number.
    image_crc: U32  # CRC-32/ISO-HDLC of the flashed image.
    rate_hz: F32  # Commanded sampling rate.
    gyro_lsb_per_deg_s: F32  # Gyro scale.
    accel_lsb_per_g: F32  # Accelerometer scale.
    temperature_lsb_per_c: F32  # Temperature scale of an MPU-6050; of the other parts see IMUs.
    temperature_offset_c: F32  # Temperature of an MPU-6050 at zero counts.
    angle_counts_per_turn: U32  # ADC counts of a full turn of an angle sensor.
    gyro_range_deg_s: U16  # Full scale, +-.
    accel_range_g: U8  # Full scale, +-.
    dlpf_cfg: U8  # Low-pass of the IMUs, CONFIG.DLPF_CFG; see IMUs.
    who_am_i: Annotated[bytes, 4]  # Register 0x75 of each IMU; 0 where none answered.
    bus_khz: U16  # Clock of the I2C buses.
    after_landing_s: U16  # The recording closes by itself this long after the landing.
    schema: Annotated[bytes, 384]  # This layout in words, ASCII, padded with zeros: a file found in ten years explains itself.
    wall_clock_us: U64  # Unix time at time_us, if the host set the clock; else 0.
    imu_offset_us: Annotated[tuple[U16, ...], 4]  # From a sample's time to the moment of each IMU's reading. 0 in logs of block_version 2, which do not tell it.
    angle_offset_us: Annotated[tuple[U16, ...], 6]  # The same of each angle sensor.
    maneuver_known: U8  # 1: the next field is known. 0 also in logs of firmware that does not tell it.
    maneuver_crc: U16  # Of the maneuver that the sequencer held when the recording was started, as in maneuver_info.


class LogFooter(Record):
    """Summary written when a recording is closed cleanly. Payload of a footer block."""

    samples: U32  # Samples taken, dropped ones included.
    samples_dropped: U32  # Samples lost because the ring was full.
    blocks: U32  # Blocks of the recording, this one included.
    ring_peak_blocks: U32  # Most blocks that ever waited for the card.
    interval_min_us: U32  # Shortest time between two samples.
    interval_max_us: U32  # Longest time between two samples.
    jitter_rms_us: F32  # Root mean square of how far the times between samples were from the nominal one.
    late_ticks: U32  # Times between samples over one and a half nominal ones: ticks without a sample.
    ring_blocks: U32  # Blocks that the ring can hold.
    card_stall_max_ms: U32  # Longest time that the card took nothing.
    blocks_rewritten: U32  # Blocks that were written a second time after the landing.
    stop_reason: StopReason  # Why the recording ended.


class LoggerSettings(Record):
    """How the logger samples and records."""

    rate_hz: U16  # Sampling rate.
    gyro_range_deg_s: U16  # Full scale, +-: 250, 500, 1000 or 2000.
    accel_range_g: U8  # Full scale, +-: 2, 4, 8 or 16.
    dlpf_cfg: U8  # Low-pass of the IMUs, CONFIG.DLPF_CFG, 0 to 6: 256, 188, 98, 42, 20, 10, 5 Hz.
    bus_khz: U16  # Clock of the I2C buses: 100 or 400.
    after_landing_s: U16  # A recording closes by itself this long after the landing.
    file_mib: U16  # Room that a recording takes on the card.


class LogEntry(Record):
    """A recording that the logger can hand over."""

    number: U16  # Of its file, DROP0001.BIN and up; 0 is what RAM holds.
    session: U32  # Random id of the recording; 0: its first block says nothing.
    blocks: U32  # Blocks of the file; unused room included where it was not closed.
    wall_clock_us: U64  # Unix time of its start, or 0.
    closed: U8  # 1: its last block is its footer.


class HelloRequest(Payload):
    """Who are you? Its number and layout never change, so that any two revisions understand it."""

    TYPE = 0x01


class HelloReply(Payload):
    """Who are you? Its number and layout never change, so that any two revisions understand it."""

    TYPE = 0x81
    board: Board  # Kind of board.
    firmware_version: Annotated[bytes, 3]  # Major, minor, patch.
    board_serial: Annotated[bytes, 8]  # Serial number of the chip; zeros where it has none.
    image_crc: U32  # CRC-32/ISO-HDLC of the flashed image, computed by the board.
    protocol_hash: Annotated[bytes, 8]  # Hash of this specification.


class SequencerStatusRequest(Payload):
    """What the sequencer is doing."""

    TYPE = 0x02


class SequencerStatusReply(Payload):
    """What the sequencer is doing."""

    TYPE = 0x82
    state: SequencerState  # State machine.
    fault: ErrorCode  # The latched fault, or none.
    last_refusal: ErrorCode  # Why ARM was last refused, or none.
    switches_open: U8  # Bit 0, 1: release switch 1, 2 is open.
    arm_token: U16  # To be given to ARM; changes at each change of state.
    reset_cause: ResetCause  # Why the board last started.
    resets_while_armed: U8  # Restarts that this arming has survived; 255 stands for more.
    strokes_started: U8  # Strokes of the last run that have begun: a whole pulse of the new width was on the servo's pin.
    knocks: U16  # False triggers since arming, see [release]; kept over a reset.
    joint_angle_cdeg: Annotated[tuple[I16, ...], 3]  # Angle that each servo is told to hold; 0 where it gets no pulses.
    uptime_ms: U32  # Since the board started.
    image_crc: U32  # CRC-32/ISO-HDLC of the flashed image.
    ram_never_used_bytes: U16  # Low-water mark of free RAM since the board started.
    frames_rejected: U16  # Frames that arrived damaged, since the board started.
    stores_damaged: U8  # Why ARM is refused for what is stored; even bits for the maneuver, odd ones for the servo settings. Bit 0, 1: store_damaged; 2, 3: upload_interrupted; 4, 5: store_old_layout.
    false_releases: U16  # False releases since arming, see [release]; kept over a reset.
    servos_driven: U8  # Bit 0, 1, 2: the servo of joint 1, 2, 3 gets pulses; else it is limp.
    brown_out_level: U8  # The fuse BODLEVEL: the supply below which the processor is held in reset (ATmega32U4 datasheet 7766J, table 8-1). 0: 4.3 V; 1: 3.5; 2: 3.4; 3: 2.6; 4: 2.4; 5: 2.2; 6: 2.0; 7: it never is.


class RunReportRequest(Payload):
    """The last run, as measured by the sequencer's own timer."""

    TYPE = 0x04


class RunReportReply(Payload):
    """The last run, as measured by the sequencer's own timer."""

    TYPE = 0x84
    released: U8  # 1: a run since power was switched on; 0: none, all other fields are zero.
    bounces: U16  # Edges of both switches from the release's first edge to its confirmation.
    release_ms: U32  # Time of the release edge by the clock of uptime_ms, whole milliseconds; after a reset: by the clock before it.
    release_us: U16  # Microseconds of that time beyond the whole milliseconds, 0 to 999.
    stroke_count: U8  # Strokes of the maneuver that flew.
    start_us: Annotated[tuple[U32, ...], 16]  # Of each stroke: from the release edge to the rise of the first whole pulse of its width on the pin, 0.5 us rounded down; or stroke_not_begun_us, stroke_time_unknown_us. Late if the pin was held from outside.
    earlier_us: U32  # The robot may have left up to this long before the release edge; 0 unless the edges, or those that were lost, fit two releases.
    later_us: U32  # And so long after it.


class LoggerStatusRequest(Payload):
    """What the logger is doing."""

    TYPE = 0x03


class LoggerStatusReply(Payload):
    """What the logger is doing."""

    TYPE = 0x83
    state: LoggerState  # State.
    error: ErrorCode  # Why the last recording failed, or none.
    imu_present: U8  # Bits 0-3: IMU 1-4 answers now.
    switches_open: U8  # Bit 0, 1: release switch 1, 2 is open.
    session: U32  # Of the present or last recording; 0 before the first.
    samples: U32  # Samples of that recording.
    samples_dropped: U32  # Of those, lost because the ring was full.
    blocks_written: U32  # Blocks handed to the card.
    ring_blocks: U16  # Blocks that wait for the card.
    ring_peak_blocks: U16  # Most that ever waited.
    rate_hz: U16  # Sampling rate.
    who_am_i: Annotated[bytes, 4]  # Register 0x75 of each IMU.
    uptime_ms: U32  # Since the board started.
    card: CardState  # The card, looked at every two seconds while nothing is recorded.
    card_free_mib: U32  # Free room on it, counted when the logger met it and after each recording.
    phase: DropPhase  # Of the present or last recording.
    ram_holds_drop: U8  # 1: RAM holds a drop that no card has. Keep the power on and fetch it.
    late_ticks: U32  # Ticks of the sampling timer without a sample, since the board started.
    settings_origin: Origin  # Of the settings in force.
    unix_us: U64  # Time of day, or 0 when no host has set it.
    maneuver_known: U8  # 1: the next field is known.
    maneuver_crc: U16  # Of the maneuver in the header of the present or last recording; see LogHeader.


class ManeuverBeginRequest(Payload):
    """Starts an upload. The stored maneuver stays until commit, but ARM is refused (upload_interrupted) from here on, power cuts included."""

    TYPE = 0x10
    stroke_count: U8  # Strokes that follow.
    speed_cdeg_s: U16  # Average joint speed that the schedule assumes, 0.01 deg/s.


class ManeuverBeginReply(Payload):
    """Starts an upload. The stored maneuver stays until commit, but ARM is refused (upload_interrupted) from here on, power cuts included."""

    TYPE = 0x90
    stroke_count: U8  # As understood.


class ManeuverStrokeRequest(Payload):
    """One stroke of the upload."""

    TYPE = 0x11
    index: U8  # From 0.
    joint: U8  # 1 to 3.
    angle_cdeg: I16  # Displacement, 0.01 deg.
    start_us: U32  # Start after release.


class ManeuverStrokeReply(Payload):
    """One stroke of the upload."""

    TYPE = 0x91
    index: U8  # As understood.


class ManeuverCommitRequest(Payload):
    """Checks the whole maneuver and stores it. EEPROM is slow: the host repeats the commit until `stored` is 1."""

    TYPE = 0x12
    crc: U16  # CRC-16/IBM-3740 over stroke_count, speed_cdeg_s and each stroke's joint, angle_cdeg, start_us.


class ManeuverCommitReply(Payload):
    """Checks the whole maneuver and stores it. EEPROM is slow: the host repeats the commit until `stored` is 1."""

    TYPE = 0x92
    stored: U8  # 0: still writing. 1: stored, checked by reading back.
    written: U8  # 1: this upload changed the store. 0: it held the same maneuver already.


class ManeuverInfoRequest(Payload):
    """Which maneuver would fly."""

    TYPE = 0x13


class ManeuverInfoReply(Payload):
    """Which maneuver would fly."""

    TYPE = 0x93
    origin: Origin  # Factory or uploaded.
    stroke_count: U8  # Strokes.
    speed_cdeg_s: U16  # Average joint speed, 0.01 deg/s.
    crc: U16  # As in maneuver_commit, computed from what would fly.
    end_us: U32  # When the last stroke ends.
    generation: U32  # Uploads that this board has stored.


class ManeuverReadRequest(Payload):
    """Reads one stroke back from what would fly."""

    TYPE = 0x14
    index: U8  # From 0.


class ManeuverReadReply(Payload):
    """Reads one stroke back from what would fly."""

    TYPE = 0x94
    index: U8  # As asked.
    joint: U8  # 1 to 3.
    angle_cdeg: I16  # Displacement, 0.01 deg.
    start_us: U32  # Start after release.


class ArmRequest(Payload):
    """From now on the release starts the maneuver."""

    TYPE = 0x20
    arm_token: U16  # From sequencer_status.


class ArmReply(Payload):
    """From now on the release starts the maneuver."""

    TYPE = 0xA0
    state: SequencerState  # Afterwards.


class DisarmRequest(Payload):
    """Back to safe, from any state; stops the servo pulses and clears a latched fault."""

    TYPE = 0x21


class DisarmReply(Payload):
    """Back to safe, from any state; stops the servo pulses and clears a latched fault."""

    TYPE = 0xA1
    state: SequencerState  # Afterwards.


class RecordStartRequest(Payload):
    """Starts a recording, and sets the time of day. Refused by the card, it still goes on in RAM (state failed)."""

    TYPE = 0x40
    number: U32  # Chosen at random by the host.
    unix_us: U64  # Time of day; 0 leaves the clock as it is.
    maneuver_known: U8  # 1: the next field is known.
    maneuver_crc: U16  # Of the maneuver that the sequencer holds, for the header; see LogHeader.


class RecordStartReply(Payload):
    """Starts a recording, and sets the time of day. Refused by the card, it still goes on in RAM (state failed)."""

    TYPE = 0xC0
    state: LoggerState  # Afterwards.
    session: U32  # Random id of the recording.


class RecordStopRequest(Payload):
    """Ends the recording with a footer. The host repeats it until the state is stopped."""

    TYPE = 0x41


class RecordStopReply(Payload):
    """Ends the recording with a footer. The host repeats it until the state is stopped."""

    TYPE = 0xC1
    state: LoggerState  # stopping, then stopped.
    session: U32  # Of the recording.
    samples: U32  # Samples taken.
    samples_dropped: U32  # Of those, lost.


class LiveRequest(Payload):
    """Switches live sampling on or off. It also ends when the cable is pulled."""

    TYPE = 0x42
    enabled: U8  # 1 on, 0 off.


class LiveReply(Payload):
    """Switches live sampling on or off. It also ends when the cable is pulled."""

    TYPE = 0xC2
    enabled: U8  # As understood.
    rate_hz: U16  # Sampling rate.
    gyro_lsb_per_deg_s: F32  # Gyro scale.
    accel_lsb_per_g: F32  # Accelerometer scale.
    angle_counts_per_turn: U32  # Angle sensor scale.
    dlpf_cfg: U8  # Low-pass of the IMUs, CONFIG.DLPF_CFG.
    who_am_i: Annotated[bytes, 4]  # Register 0x75 of each IMU; 0 where none answered.
    imu_offset_us: Annotated[tuple[U16, ...], 4]  # From a sample's time to the moment of each IMU's reading.
    angle_offset_us: Annotated[tuple[U16, ...], 6]  # The same of each angle sensor.


class LoggerSettingsWriteRequest(Payload):
    """Checks, stores and uses new settings; not while recording. rate_too_high: detail = the highest rate in Hz that the buses carry."""

    TYPE = 0x45
    settings: LoggerSettings  # All of them.


class LoggerSettingsWriteReply(Payload):
    """Checks, stores and uses new settings; not while recording. rate_too_high: detail = the highest rate in Hz that the buses carry."""

    TYPE = 0xC5
    stored: U8  # 1: stored, checked by reading back.


class LoggerSettingsReadRequest(Payload):
    """The settings in force."""

    TYPE = 0x46


class LoggerSettingsReadReply(Payload):
    """The settings in force."""

    TYPE = 0xC6
    origin: Origin  # Factory or uploaded.
    settings: LoggerSettings  # All of them.
    rate_max_hz: U16  # What the buses carry at this clock.


class ClockSetRequest(Payload):
    """Sets the time of day."""

    TYPE = 0x47
    unix_us: U64  # Unix time now.


class ClockSetReply(Payload):
    """Sets the time of day."""

    TYPE = 0xC7
    uptime_us: U64  # The logger's clock at that moment.


class LogListRequest(Payload):
    """The first recording whose number is `from_number` or greater; not while recording."""

    TYPE = 0x48
    from_number: U16  # 0 to begin with what RAM holds.


class LogListReply(Payload):
    """The first recording whose number is `from_number` or greater; not while recording."""

    TYPE = 0xC8
    found: U8  # 0: there is none, the rest is zero.
    entry: LogEntry  # The recording.


class LogReadRequest(Payload):
    """Sends blocks of a recording as log_part and log_zeros; not while recording. A new log_read, or a closed port, ends the one before."""

    TYPE = 0x49
    number: U16  # As in LogEntry.
    session: U32  # As in LogEntry.
    first_block: U32  # From 0.
    count: U16  # At most log_read_blocks.


class LogReadReply(Payload):
    """Sends blocks of a recording as log_part and log_zeros; not while recording. A new log_read, or a closed port, ends the one before."""

    TYPE = 0xC9
    count: U16  # Blocks that will be sent: fewer at the end of the file.


class LogEraseRequest(Payload):
    """Removes a recording from the card; number 0: gives up what RAM holds. Not while recording."""

    TYPE = 0x4A
    number: U16  # As in LogEntry.
    session: U32  # As in LogEntry.


class LogEraseReply(Payload):
    """Removes a recording from the card; number 0: gives up what RAM holds. Not while recording."""

    TYPE = 0xCA
    erased: U8  # 1.


class LogPartStream(Payload):
    """A piece of a block, as asked for by log_read. A lost one is asked for again."""

    TYPE = 0x61
    block: U32  # Of the recording.
    part: U8  # From 0.
    data: Annotated[bytes, 64]  # log_part_bytes of the block.


class LogZerosStream(Payload):
    """Blocks that hold only zeros, as asked for by log_read."""

    TYPE = 0x62
    first_block: U32  # Of the recording.
    count: U16  # Blocks.


class LiveSampleStream(Payload):
    """One sample as it is taken; sent unasked while live sampling is on. What the host does not read in time is skipped and shows as a gap in the index."""

    TYPE = 0x60
    index: U32  # Of the sample since the board started.
    time_us: U64  # The logger's clock, since power-up.
    sample: Sample  # time_offset_us is 0.


class ErrorReply(Payload):
    """Answer to a request that was not served."""

    TYPE = 0xFF
    request: U8  # Type of the request.
    code: ErrorCode  # Why.
    detail: I32  # What the code refers to, such as the index of the stroke; -1 where nothing.


class SettingsWriteRequest(Payload):
    """Checks and stores the servo settings. The host repeats it until `stored` is 1, then reads back."""

    TYPE = 0x15
    frame_us: U16  # From pulse to pulse.
    servo: Annotated[tuple[ServoSetting, ...], 3]  # Joints 1 to 3.
    moving_at_once: U8  # Joints that the supply can move at the same time, 1 to 3.


class SettingsWriteReply(Payload):
    """Checks and stores the servo settings. The host repeats it until `stored` is 1, then reads back."""

    TYPE = 0x95
    stored: U8  # 0: still writing. 1: stored, checked by reading back.
    written: U8  # 1: storing these settings changed the store. 0: it held them already before they were sent.


class SettingsReadRequest(Payload):
    """The servo settings in force."""

    TYPE = 0x16


class SettingsReadReply(Payload):
    """The servo settings in force."""

    TYPE = 0x96
    origin: Origin  # Factory or uploaded.
    generation: U32  # Settings that this board has stored.
    frame_us: U16  # From pulse to pulse.
    servo: Annotated[tuple[ServoSetting, ...], 3]  # Joints 1 to 3.
    moving_at_once: U8  # Joints that the supply can move at the same time, 1 to 3.


class JointReportRequest(Payload):
    """What the joint angles are, as the host has them from the logger. ARM heeds it while it is fresh."""

    TYPE = 0x22
    angle_cdeg: Annotated[tuple[I16, ...], 3]  # Joints 1 to 3, 0.01 deg.


class JointReportReply(Payload):
    """What the joint angles are, as the host has them from the logger. ARM heeds it while it is fresh."""

    TYPE = 0xA2
    at_start_pose: U8  # 1: all within the tolerance.


class JogRequest(Payload):
    """Moves one joint slowly; from SAFE or an earlier jog only. A limp joint has no known angle: the host says where it is, so that the first pulse does not jerk it. DISARM, a closed port, or a while without orders ends it."""

    TYPE = 0x23
    joint: U8  # 1 to 3.
    from_cdeg: I16  # Where the joint is; ignored while it is already being jogged.
    to_cdeg: I16  # Where it is to go; within its limits.
    confirm: U32  # jog_confirm.


class JogReply(Payload):
    """Moves one joint slowly; from SAFE or an earlier jog only. A limp joint has no known angle: the host says where it is, so that the first pulse does not jerk it. DISARM, a closed port, or a while without orders ends it."""

    TYPE = 0xA3
    angle_cdeg: I16  # What the servo is told now.
    arrived: U8  # 1: it is told the target.
