"""Enumerations of the protocol.

Generated from protocol/tfsat.toml by tools/generate_protocol.py. Do not edit.
"""

from __future__ import annotations

from enum import IntEnum


class Board(IntEnum):
    """Kind of board that answers HELLO."""

    SEQUENCER = 1
    """Arduino Micro: flies the maneuver."""
    LOGGER = 2
    """Teensy 4.1: records the fall."""


class SequencerState(IntEnum):
    """The sequencer's state machine."""

    SAFE = 0
    """Nothing moves. No servo pulses."""
    ARMED = 1
    """Servos hold the start pose; the release starts the schedule."""
    RUNNING = 2
    """Released: strokes run on schedule. ARMED again after a false release."""
    DONE = 3
    """All strokes were commanded; servos hold the end pose."""
    FAULT = 4
    """Something is wrong; nothing new is commanded until a person disarms. Servos that were driven are held where they were."""
    JOGGING = 5
    """One joint is moved slowly on a person's order; the others get no pulses."""


class Origin(IntEnum):
    """Where a maneuver or the settings on the board come from."""

    FACTORY = 0
    """Never uploaded: kept in the firmware (the maneuver is the paper's 59/70)."""
    UPLOADED = 1
    """Uploaded by a host and stored in EEPROM."""


class ResetCause(IntEnum):
    """Why the board last started."""

    POWER_ON = 0
    """Power was switched on."""
    EXTERNAL = 1
    """The reset pin or button, or an upload."""
    BROWN_OUT = 2
    """The supply dipped."""
    WATCHDOG = 3
    """The main loop hung."""
    UNKNOWN = 4
    """The bootloader hid the cause."""


class LoggerState(IntEnum):
    """The logger's state."""

    IDLE = 0
    """Sampling, not recording."""
    RECORDING = 1
    """Samples go to the card."""
    STOPPING = 2
    """The ring is being emptied and the footer written."""
    STOPPED = 3
    """The last recording was closed cleanly."""
    FAILED = 4
    """The card refused; see the error code. RAM keeps the newest seconds, after a landing the drop."""


class CardState(IntEnum):
    """What the logger knows of its card."""

    UNKNOWN = 0
    """Not looked at yet, or its free room is being counted."""
    READY = 1
    """A recording would find room."""
    MISSING = 2
    """No card, or one without contact."""
    UNREADABLE = 3
    """A card without a file system that the logger knows."""
    FULL = 4
    """No room for a recording."""
    WRITE_PROTECTED = 5
    """The card's own registers forbid writing."""
    FAILING = 6
    """It refused a write, or has been busy for too long."""


class DropPhase(IntEnum):
    """Where in a drop the recording is, by the release switches and the accelerometers."""

    WAITING = 0
    """Not released."""
    FALLING = 1
    """Released."""
    LANDED = 2
    """Landed; the recording closes by itself after a while."""


class StopReason(IntEnum):
    """Why a recording ended."""

    HOST = 1
    """A host asked for it."""
    LANDING = 2
    """The time after the landing was over."""
    FILE_FULL = 3
    """The file had no more room; before a release the recording goes on in the next."""
    CARD_GONE = 4
    """The card took nothing, and more samples would have cost RAM the drop."""


class BlockKind(IntEnum):
    """What a block on the card holds."""

    HEADER = 1
    """LogHeader: what was recorded, with which scales."""
    DATA = 2
    """Samples and events."""
    FOOTER = 3
    """LogFooter: the recording was closed cleanly."""


class EventCode(IntEnum):
    """Events in the log."""

    SWITCH_EDGE = 1
    """A release switch changed: index = switch, arg = 1 opened, 0 closed, value = edges before it that came too fast to keep."""
    STROKE = 2
    """The sequencer's stroke line rose: index = count since the recording began, from 0, value = edges before it that came too fast to keep."""
    SENSOR_FAULT = 3
    """A sensor gives no readings any more, or for another reason than before: index = IMU, arg = error code; sensor_foreign: value = its WHO_AM_I; else value = microseconds before the event from which its readings are in doubt, 0: none. They repeat (sensor_frozen), or may be in other scales: a part that wakes up measuring had not shown its settings since, whatever it failed of in the end."""
    SENSOR_RECOVERED = 4
    """A sensor answers again: index = IMU, value = its WHO_AM_I, 0 in logs of earlier firmware."""
    CARD_STALL = 5
    """A card write took long: value = milliseconds."""
    SAMPLES_DROPPED = 6
    """The ring was full: value = samples lost."""
    RELEASE = 7
    """The logger detected a release, see [release]; time = its t = 0, arg = 1. arg = 0: a false release, both switches closed again."""
    LANDING = 8
    """The robot has landed: arg = 1 by a shock, value = mg; arg = 0 by the time since the release."""
    RING_HIGH_WATER = 9
    """More of the ring than ever waits for the card: arg = quarters of the ring, value = blocks."""
    CARD_LOST = 10
    """The card stopped answering: arg = error code. It is tried again for as long as the ring has room."""
    CARD_BACK = 11
    """The card takes blocks again: value = milliseconds that it was gone."""
    REWRITTEN = 12
    """The last seconds were written a second time: value = blocks."""
    SAMPLING_LATE = 13
    """Ticks of the sampling timer passed without a sample: value = microseconds since the sample before."""
    SENSOR_MISSED = 15
    """A transfer from a running IMU failed; its reading is missing until it has shown that it kept its settings, most often this one only: index = IMU, arg = error code. One that stays away for 20 ms is a sensor_fault."""


class ErrorCode(IntEnum):
    """Why a request was refused, what that means and what to do."""

    NONE = 0
    """No error."""
    UNKNOWN_MESSAGE = 1
    """The board does not know this request."""
    BAD_LENGTH = 2
    """The request has the wrong length."""
    WRONG_STATE = 3
    """The request is not allowed in the board's present state."""
    NO_STAGED_MANEUVER = 4
    """A step or a commit came without a begin."""
    STEP_MISSING = 5
    """The maneuver was committed before all its steps had arrived."""
    CRC_MISMATCH = 6
    """The maneuver's CRC does not match its steps."""
    TOO_MANY_STROKES = 7
    """The maneuver has no stroke, or more than the board can hold."""
    JOINT_UNKNOWN = 8
    """A stroke names a joint that does not exist."""
    ANGLE_OUT_OF_RANGE = 9
    """A stroke would take a joint outside 0 to 90 deg, or moves nothing."""
    STROKES_OVERLAP = 10
    """A stroke starts before its joint has ended the one before."""
    TOO_EARLY = 11
    """A stroke starts before the pause is over."""
    TOO_LONG = 12
    """The maneuver would outlast the fall."""
    SPEED_OUT_OF_RANGE = 13
    """The joint speed is outside 10 to 400 deg/s."""
    STORE_FAILED = 14
    """The EEPROM did not keep what was written."""
    SWITCH_OPEN = 15
    """A release switch is open."""
    NO_MANEUVER = 16
    """No valid maneuver was uploaded."""
    STALE_TOKEN = 17
    """The request belongs to an earlier state of the board."""
    FAULT_LATCHED = 18
    """A fault is latched."""
    INDEX_OUT_OF_RANGE = 19
    """A step index is beyond the maneuver's end."""
    STROKE_MISSED = 20
    """A stroke was scheduled, but no pulse of it came out on the servo's pin."""
    NOT_AT_START_POSE = 21
    """A joint is not at its start pose."""
    RESET_WHILE_ARMED = 22
    """The board restarted while it was armed, and a switch was open."""
    RESET_WHILE_RUNNING = 23
    """The board restarted while the maneuver ran."""
    JOG_NOT_CONFIRMED = 24
    """The jog did not carry its flag."""
    SETTING_OUT_OF_RANGE = 25
    """A servo setting makes no sense."""
    SETTINGS_DO_NOT_FIT = 26
    """The stored maneuver leaves a joint's limits in the servo settings."""
    STORE_DAMAGED = 27
    """The stored maneuver or the servo settings are damaged in the EEPROM."""
    CLOSED_WHILE_RUNNING = 28
    """Both release switches closed again after the maneuver had begun."""
    UPLOAD_INTERRUPTED = 29
    """An upload of the maneuver or of the servo settings was begun and never completed."""
    STORE_OLD_LAYOUT = 30
    """The stored maneuver or the servo settings were stored by an earlier firmware, in another layout."""
    STARTS_TOO_CLOSE = 31
    """A stroke starts before the one before it, or less than 10 ms after it."""
    TOO_MANY_MOVING = 32
    """The stored maneuver moves more joints at once than the servo settings allow."""
    NO_CARD = 40
    """No SD card answers."""
    CARD_FULL = 41
    """The card has no room for a recording, or holds DROP9999.BIN, the last number."""
    CARD_WRITE_FAILED = 42
    """The card refused a write."""
    SENSOR_MISSING = 43
    """An IMU does not answer."""
    BUS_STUCK = 44
    """An I2C bus is held low."""
    NOT_RECORDING = 45
    """There is no recording to stop."""
    SENSOR_FROZEN = 46
    """An IMU repeats the same reading."""
    SENSOR_FOREIGN = 47
    """What answers at an IMU's address is no part that the logger knows (WHO_AM_I), or does not keep its settings."""
    CARD_WRITE_PROTECTED = 48
    """The card forbids writing."""
    CARD_UNREADABLE = 49
    """The card has no file system that the logger knows."""
    RATE_TOO_HIGH = 50
    """The I2C buses cannot carry this sampling rate."""
    LOGGER_SETTING_OUT_OF_RANGE = 51
    """A setting of the logger makes no sense."""
    NO_SUCH_LOG = 52
    """There is no such recording."""
    LOG_CHANGED = 53
    """The recording under this number is another than the one asked for."""
    RAM_HOLDS_DROP = 54
    """The logger's RAM holds a drop that no card has."""
    BUSY = 55
    """The logger is counting the free room of a card that it has just met."""
    SENSOR_RESET = 57
    """An IMU has lost its settings."""
