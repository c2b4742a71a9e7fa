"""Numbers that host and boards agree on.

Generated from protocol/tfsat.toml by tools/generate_protocol.py. Do not edit.
"""

from __future__ import annotations

PROTOCOL_HASH = bytes.fromhex("0c225f038fe37be9")
FIRMWARE_VERSION = (0, 2, 0)
MAX_PAYLOAD_BYTES = 96
REPLY_BIT = 0x80
JOINT_COUNT = 3
"""Joints that can stroke."""
IMU_COUNT = 4
"""MPU-6050, one a body."""
ANGLE_SENSOR_COUNT = 6
"""Absolute angle sensors, two a joint: index 2 (joint - 1) and the next."""
SWITCH_COUNT = 2
"""Release switches."""
MAX_STROKES = 16
"""Strokes that a maneuver can have."""
JOINT_ANGLE_MIN_CDEG = 0
"""Least joint angle, 0.01 deg (paper, eq. optdef)."""
JOINT_ANGLE_MAX_CDEG = 9000
"""Greatest joint angle, 0.01 deg (paper, eq. optdef)."""
SPEED_MIN_CDEG_S = 1000
"""Least average joint speed that a maneuver may assume, 0.01 deg/s."""
SPEED_MAX_CDEG_S = 40000
"""Greatest average joint speed that a maneuver may assume, 0.01 deg/s."""
PAUSE_MIN_US = 700000
"""Earliest stroke after the release: in 0.7 s the robot is clear of the releaser at 30 mm/s (paper, sec. seq)."""
FALL_US = 2500000
"""Time of free fall (paper, tab. cosmotorre). A maneuver must end before."""
SCHEDULE_GRID_US = 10000
"""Stroke times are rounded up to this grid by the host."""
SERVO_PULSE_MIN_US = 500
"""No pulse is shorter."""
SERVO_PULSE_MAX_US = 2500
"""No pulse is longer."""
SERVO_FACTORY_ZERO_US = 1000
"""Factory setting: pulse width that holds a joint at 0 deg."""
SERVO_FACTORY_NS_PER_DEG = 11111
"""Factory setting: pulse width for each further degree."""
SERVO_NS_PER_DEG_MIN = 2000
"""Least slope of a servo that a setting may claim."""
SERVO_NS_PER_DEG_MAX = 30000
"""Greatest slope of a servo that a setting may claim."""
SERVO_FRAME_US = 20000
"""Factory setting: from pulse to pulse."""
MOVING_AT_ONCE = 1
"""Factory setting: joints that move at the same time."""
SERVO_FRAME_MIN_US = 5000
"""Fastest frame that a digital servo may be given."""
SERVO_FRAME_MAX_US = 20000
"""Slowest frame that holds a servo."""
START_POSE_TOLERANCE_CDEG = 1000
"""A joint counts as at its start pose this near to it: gravity bends the hanging robot by some 6 deg (paper, sec. Result)."""
JOINT_REPORT_AGE_MS = 30000
"""A joint-angle report older than this says nothing any more."""
JOG_SPEED_CDEG_S = 1500
"""Speed of a jog: slow enough to watch, and to let go of."""
JOG_CONFIRM = 4869959
"""The flag that a jog must carry: 'JOG'."""
JOG_IDLE_MS = 1000
"""A jogged joint that gets no further order goes limp after this: a host that froze must not let it go on."""
STROKE_LINE_US = 1000
"""The sequencer's stroke line stays high this long from each stroke's first pulse."""
STROKE_NOT_BEGUN_US = 4294967295
"""In RUN_REPORT, in place of an onset: the stroke has not begun; when the run is over, it was missed."""
STROKE_TIME_UNKNOWN_US = 4294967294
"""In RUN_REPORT, in place of an onset: the stroke began, but a reset came before its time was noted."""
RELEASE_DEBOUNCE_US = 5000
"""Both switches open for this long confirm a release; the schedule counts from the first edge."""
RELEASE_BOUNCE_US = 10000
"""Longest bounce of sound contacts when they open."""
RELEASE_CHATTER_US = 60000
"""Longest bounce of worn contacts when they open; with both switches open for longer the robot has left."""
RELEASE_HUNG_US = 1000
"""Both switches closed for this long between two openings: no bounce of sound contacts, the robot may still have hung."""
RELEASE_SEATED_US = 200000
"""Both switches closed again for this long: a false release, the robot still hangs."""
SAMPLE_RATE_HZ = 280
"""Factory setting: sampling rate (paper, sec. robot)."""
SAMPLE_RATE_MIN_HZ = 10
"""Slowest sampling rate that a setting may ask for."""
SAMPLE_RATE_MAX_HZ = 1000
"""Fastest sampling rate: the MPU-6050's accelerometer makes no more values (RM-MPU-6000A rev. 4.2, p. 11)."""
IMU_BURST_BITS = 156
"""Bits on the bus for one 14-byte burst: 17 bytes of 9 bits, 3 for start, restart and stop."""
IMUS_PER_BUS = 2
"""An MPU-6050 has two addresses, so a bus carries two."""
IMU_PROOF_BITS = 39
"""On the bus, for an IMU to show one of its settings."""
IMU_PROOF_SLACK_US = 20
"""That such a transfer may take beyond its bits."""
SAMPLING_MARGIN_US = 200
"""Of each sampling period, kept for a sensor that fails and for the processor."""
GYRO_RANGE_FACTORY_DEG_S = 500
"""Factory setting: the paper's range."""
ACCEL_RANGE_FACTORY_G = 16
"""Factory setting: the widest, for the landing."""
DLPF_FACTORY = 3
"""Factory setting: 42 Hz, 4.8 ms."""
BUS_FACTORY_KHZ = 400
"""Factory setting: I2C fast mode."""
AFTER_LANDING_FACTORY_S = 30
"""Factory setting: a recording goes on this long after the landing, then closes by itself."""
AFTER_LANDING_MIN_S = 5
"""Least time that a recording goes on after the landing: longer than a fall, should a shock in it be taken for the landing."""
AFTER_LANDING_MAX_S = 600
"""Most."""
FILE_FACTORY_MIB = 32
"""Factory setting: room that a recording takes on the card; 23 minutes at 280 Hz."""
FILE_MIN_MIB = 1
"""Least room."""
FILE_MAX_MIB = 1024
"""Most."""
RING_BLOCKS = 896
"""Blocks that the logger's RAM holds: 5.3 s at 1 kHz, 19 s at 280 Hz."""
LANDING_SHOCK_G = 6
"""A specific force of this much on one axis, after the release, is the landing. Strokes stay under 2 g."""
LANDING_EARLIEST_US = 300000
"""Earliest landing after the release."""
LANDING_LATEST_US = 5000000
"""Latest landing after the release, whatever the sensors read."""
REWRITE_AFTER_LANDING_US = 1000000
"""This long after the landing, the blow is over, and what RAM holds of the fall is written a second time."""
REWRITE_AFTER_RELEASE_US = 4000000
"""And not before this time after the release, should a shock in the fall be taken for the landing."""
REWRITE_BEFORE_RELEASE_US = 1000000
"""The second copy begins this long before the release, or where RAM does."""
FROZEN_US = 100000
"""An IMU whose output does not change by one bit for this long has stopped measuring: its noise alone is some counts."""
LOG_PART_BYTES = 64
"""A block crosses the cable in parts of this size."""
LOG_READ_BLOCKS = 128
"""Most blocks that one log_read sends."""
BLOCK_BYTES = 512
"""A block on the card."""
BLOCK_MAGIC = 827541076
"""The bytes 'TFS1' that every block begins with."""
BLOCK_VERSION = 3
"""Version of the block layout. 2 is read as well: it has no imu_offset_us and angle_offset_us."""
SAMPLES_PER_BLOCK = 6
"""Sample slots in a data block."""
EVENTS_PER_BLOCK = 2
"""Event slots in a data block."""
HEADER_REPEAT_BLOCKS = 256
"""The header block is written again each time this many blocks have passed."""
PARTIAL_BLOCK_MS = 100
"""A data block that has waited this long is written as far as it is filled."""
CARD_SYNC_MS = 250
"""The card is told to flush its own buffers at this interval."""
