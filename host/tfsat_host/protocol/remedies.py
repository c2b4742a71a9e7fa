"""What each error code of a board means for the drop, and what to do.

Generated from protocol/tfsat.toml by tools/generate_protocol.py. Do not edit.
"""

from __future__ import annotations

from tfsat_host.next_step import Advice, NextStep

from .enums import ErrorCode

REMEDIES: dict[ErrorCode, tuple[str, str, Advice]] = {
    ErrorCode.NONE: (
        "No error.",
        "",
        Advice(),
    ),
    ErrorCode.UNKNOWN_MESSAGE: (
        "The board does not know this request.",
        "Host and board speak different protocols.",
        Advice("Flash the board and install the host package from the same release."),
    ),
    ErrorCode.BAD_LENGTH: (
        "The request has the wrong length.",
        "Host and board speak different protocols.",
        Advice("Flash the board and install the host package from the same release."),
    ),
    ErrorCode.WRONG_STATE: (
        "The request is not allowed in the board's present state.",
        "Nothing was changed.",
        Advice(NextStep("disarm"), ", then the same command again."),
    ),
    ErrorCode.NO_STAGED_MANEUVER: (
        "A step or a commit came without a begin.",
        "The upload was interrupted; nothing was stored, and the board does not arm until an upload is complete.",
        Advice("Run ", NextStep("upload-sequence"), " again."),
    ),
    ErrorCode.STEP_MISSING: (
        "The maneuver was committed before all its steps had arrived.",
        "The upload was interrupted; nothing was stored, and the board does not arm until an upload is complete.",
        Advice("Run ", NextStep("upload-sequence"), " again."),
    ),
    ErrorCode.CRC_MISMATCH: (
        "The maneuver's CRC does not match its steps.",
        "The upload was damaged; nothing was stored, and the board does not arm until an upload is complete.",
        Advice("Run ", NextStep("upload-sequence"), " again; if it recurs, change the cable."),
    ),
    ErrorCode.TOO_MANY_STROKES: (
        "The maneuver has no stroke, or more than the board can hold.",
        "The stored maneuver is unchanged.",
        Advice("Give 1 to 16 strokes."),
    ),
    ErrorCode.JOINT_UNKNOWN: (
        "A stroke names a joint that does not exist.",
        "Nothing was stored, and the board does not arm until an upload is complete.",
        Advice("Use joints 1, 2 and 3."),
    ),
    ErrorCode.ANGLE_OUT_OF_RANGE: (
        "A stroke would take a joint outside 0 to 90 deg, or moves nothing.",
        "Nothing was stored, and the board does not arm until an upload is complete; the frame would have been hit.",
        Advice("Choose smaller strokes."),
    ),
    ErrorCode.STROKES_OVERLAP: (
        "A stroke starts before its joint has ended the one before.",
        "Nothing was stored, and the board does not arm until an upload is complete; a joint cannot do two strokes at once.",
        Advice("Move that joint's strokes apart, or leave the times to the schedule rule."),
    ),
    ErrorCode.TOO_EARLY: (
        "A stroke starts before the pause is over.",
        "Nothing was stored, and the board does not arm until an upload is complete; the robot would still touch the releaser.",
        Advice("Start at 0.70 s or later."),
    ),
    ErrorCode.TOO_LONG: (
        "The maneuver would outlast the fall.",
        "Nothing was stored, and the board does not arm until an upload is complete; the robot would land while moving.",
        Advice("Shorten the strokes: the last must end before 2.50 s."),
    ),
    ErrorCode.SPEED_OUT_OF_RANGE: (
        "The joint speed is outside 10 to 400 deg/s.",
        "Nothing was stored, and the board does not arm until an upload is complete.",
        Advice("Give the average speed that the servos reach, about 170 deg/s."),
    ),
    ErrorCode.STORE_FAILED: (
        "The EEPROM did not keep what was written.",
        "The board may be worn out; do not fly it.",
        Advice("Upload once more; if it recurs, replace the Arduino Micro."),
    ),
    ErrorCode.SWITCH_OPEN: (
        "A release switch is open.",
        "The robot is not seated: armed like this, it could not tell its release.",
        Advice("Seat the robot in the releaser until both switches are closed, then arm again."),
    ),
    ErrorCode.NO_MANEUVER: (
        "No valid maneuver was uploaded.",
        "There is nothing to fly.",
        Advice(NextStep("upload-sequence", ("59", "70",))),
    ),
    ErrorCode.STALE_TOKEN: (
        "The request belongs to an earlier state of the board.",
        "A repeated frame arrived late and was ignored.",
        Advice("Run the command again."),
    ),
    ErrorCode.FAULT_LATCHED: (
        "A fault is latched.",
        "The board will not arm.",
        Advice(NextStep("status"), " tells which; ", NextStep("disarm"), " clears it."),
    ),
    ErrorCode.INDEX_OUT_OF_RANGE: (
        "A step index is beyond the maneuver's end.",
        "Nothing was stored, and the board does not arm until an upload is complete.",
        Advice("Run ", NextStep("upload-sequence"), " again."),
    ),
    ErrorCode.STROKE_MISSED: (
        "A stroke was scheduled, but no pulse of it came out on the servo's pin.",
        "The maneuver was not flown as uploaded; the joint stayed where it was.",
        Advice("Read which stroke was missed: ", NextStep("status"), ". Look for a short or a wrong wire at that servo's pin (D9, D10, D11 for joint 1, 2, 3); without one, do not fly this board."),
    ),
    ErrorCode.NOT_AT_START_POSE: (
        "A joint is not at its start pose.",
        "Armed now, its servo would jerk it there, and the maneuver would start from another pose than designed.",
        Advice("Bring the joint to 0 deg by hand or with ", NextStep("jog"), ", then arm again."),
    ),
    ErrorCode.RESET_WHILE_ARMED: (
        "The board restarted while it was armed, and a switch was open.",
        "The moment of the release is lost: no joint moves.",
        Advice("Correct the cause of the restart, then ", NextStep("disarm"), ", seat the robot and arm again."),
    ),
    ErrorCode.RESET_WHILE_RUNNING: (
        "The board restarted while the maneuver ran.",
        "The rest of the maneuver was not flown.",
        Advice("Correct the cause of the restart, then ", NextStep("disarm"), "."),
    ),
    ErrorCode.JOG_NOT_CONFIRMED: (
        "The jog did not carry its flag.",
        "Nothing was moved.",
        Advice(NextStep("jog"), " asks before it moves a joint."),
    ),
    ErrorCode.SETTING_OUT_OF_RANGE: (
        "A servo setting makes no sense.",
        "The stored settings are unchanged.",
        Advice("Pulses must lie within 500 to 2500 us over the joint's whole range; frames within 5 to 20 ms. Correct the file, then ", NextStep("upload-servos"), " again."),
    ),
    ErrorCode.SETTINGS_DO_NOT_FIT: (
        "The stored maneuver leaves a joint's limits in the servo settings.",
        "Armed now, a servo would be driven against its stop.",
        Advice("Upload a smaller maneuver, or correct the joint's limits with ", NextStep("upload-servos"), "."),
    ),
    ErrorCode.STORE_DAMAGED: (
        "The stored maneuver or the servo settings are damaged in the EEPROM.",
        "What is left may be older than what you uploaded last.",
        Advice("Upload both again: ", NextStep("upload-sequence"), ", and ", NextStep("upload-servos"), ". If it recurs, replace the Arduino Micro."),
    ),
    ErrorCode.CLOSED_WHILE_RUNNING: (
        "Both release switches closed again after the maneuver had begun.",
        "The robot hung, or was caught: the strokes left were not flown, and the servos hold where they were told last.",
        Advice("Keep clear of the joints, then ", NextStep("disarm"), ": the servos go limp. Bring the joints to 0 deg, seat the robot and arm again."),
    ),
    ErrorCode.UPLOAD_INTERRUPTED: (
        "An upload of the maneuver or of the servo settings was begun and never completed.",
        "The board still holds what it had before, which is not what you wanted last: it does not arm with that.",
        Advice("Upload again what was interrupted: ", NextStep("upload-sequence"), ", or ", NextStep("upload-servos"), ". ", NextStep("status"), " tells which."),
    ),
    ErrorCode.STORE_OLD_LAYOUT: (
        "The stored maneuver or the servo settings were stored by an earlier firmware, in another layout.",
        "This firmware does not read them: nothing of them is in force.",
        Advice("Upload both again: ", NextStep("upload-sequence"), ", and ", NextStep("upload-servos"), " (or ", NextStep("upload-servos", ("--factory",)), ")."),
    ),
    ErrorCode.STARTS_TOO_CLOSE: (
        "A stroke starts before the one before it, or less than 10 ms after it.",
        "Nothing was stored, and the board does not arm until an upload is complete.",
        Advice("Give the strokes in the order of their times; let two begin at the same time or at least 10 ms apart."),
    ),
    ErrorCode.TOO_MANY_MOVING: (
        "The stored maneuver moves more joints at once than the servo settings allow.",
        "The supply may dip, and a servo or the board with it.",
        Advice("If the supply carries it, raise moving_at_once with ", NextStep("upload-servos"), "; else upload a maneuver that moves fewer joints at once."),
    ),
    ErrorCode.NO_CARD: (
        "No SD card answers.",
        "Only the newest seconds stay, in the logger's RAM, until its power goes.",
        Advice("Push the card in until it clicks, then start the recording again. After a drop: keep the power on and run ", NextStep("log fetch", ("ram",)), "."),
    ),
    ErrorCode.CARD_FULL: (
        "The card has no room for a recording, or holds DROP9999.BIN, the last number.",
        "Only the newest seconds stay, in the logger's RAM, until its power goes.",
        Advice(NextStep("log fetch"), ", then ", NextStep("log erase"), "; or put in another card."),
    ),
    ErrorCode.CARD_WRITE_FAILED: (
        "The card refused a write.",
        "The recording has a gap or has ended; RAM keeps the newest seconds until the power goes.",
        Advice("Keep the power on and run ", NextStep("log fetch", ("ram",)), ". Replace the card before the next drop."),
    ),
    ErrorCode.SENSOR_MISSING: (
        "An IMU does not answer.",
        "That body's rates are not recorded.",
        Advice("Check the wiring and the address jumper of that IMU."),
    ),
    ErrorCode.BUS_STUCK: (
        "An I2C bus is held low.",
        "Two IMUs are not recorded.",
        Advice("Unplug the IMUs of that bus one by one; replace the one that holds it."),
    ),
    ErrorCode.NOT_RECORDING: (
        "There is no recording to stop.",
        "Nothing was changed.",
        Advice(NextStep("status"), " shows what the logger does."),
    ),
    ErrorCode.SENSOR_FROZEN: (
        "An IMU repeats the same reading.",
        "It answers and does not measure: that body's rates are not recorded.",
        Advice("Switch the robot's power off and on; if it recurs, replace that IMU."),
    ),
    ErrorCode.SENSOR_FOREIGN: (
        "What answers at an IMU's address is no part that the logger knows (WHO_AM_I), or does not keep its settings.",
        "Its scales are unknown, so that body's rates are not recorded.",
        Advice(NextStep("status"), " shows what it answers; replace it by an MPU-6050, MPU-6500, MPU-9250, MPU-9255 or ICM-20689."),
    ),
    ErrorCode.CARD_WRITE_PROTECTED: (
        "The card forbids writing.",
        "Only the newest seconds stay, in the logger's RAM, until its power goes.",
        Advice("Put in another card: the write protection is set in the card's registers, no switch changes it."),
    ),
    ErrorCode.CARD_UNREADABLE: (
        "The card has no file system that the logger knows.",
        "Only the newest seconds stay, in the logger's RAM, until its power goes.",
        Advice("Format the card as FAT32 or exFAT with the SD Association's formatter, then start again."),
    ),
    ErrorCode.RATE_TOO_HIGH: (
        "The I2C buses cannot carry this sampling rate.",
        "The stored settings are unchanged.",
        Advice("Lower the rate, or raise the bus clock to 400 kHz."),
    ),
    ErrorCode.LOGGER_SETTING_OUT_OF_RANGE: (
        "A setting of the logger makes no sense.",
        "The stored settings are unchanged.",
        Advice(NextStep("logger-settings", ("--help",)), " lists what there is."),
    ),
    ErrorCode.NO_SUCH_LOG: (
        "There is no such recording.",
        "Nothing was changed.",
        Advice(NextStep("log list")),
    ),
    ErrorCode.LOG_CHANGED: (
        "The recording under this number is another than the one asked for.",
        "Nothing was read or erased.",
        Advice(NextStep("log list"), ", then the same command again."),
    ),
    ErrorCode.RAM_HOLDS_DROP: (
        "The logger's RAM holds a drop that no card has.",
        "A new recording would overwrite it.",
        Advice(NextStep("log fetch", ("ram",)), ", then start again. To give it up: ", NextStep("log erase", ("ram",)), "."),
    ),
    ErrorCode.BUSY: (
        "The logger is counting the free room of a card that it has just met.",
        "Nothing was changed; sampling goes on.",
        Advice("Wait some seconds, then the same command again: the host repeats it by itself for a minute."),
    ),
    ErrorCode.SENSOR_RESET: (
        "An IMU has lost its settings.",
        "Its supply was gone for a moment: that body's rates are missing until it is started anew, about 0.1 s.",
        Advice("Check its plug and the 3.3 V line under shaking before the next drop."),
    ),
}
"""Error code: (what happened, what it means, what to do)."""
