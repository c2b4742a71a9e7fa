"""What can be wrong with servo settings: one stable name for each defect."""

from __future__ import annotations

from enum import StrEnum

from tfsat_host.errors import TfsatError

NOTHING_CHANGED = "Nothing was sent to the robot; its settings are as they were."


class SettingsDefect(StrEnum):
    """Stable names, as in `error.code` of `--json`."""

    FRAME_RANGE = "frame-range"
    SLOPE_RANGE = "slope-range"
    JOINT_LIMITS = "joint-limits"
    PULSE_RANGE = "pulse-range"
    FILE_UNREADABLE = "file-unreadable"
    FILE_SYNTAX = "file-syntax"
    FILE_FORMAT = "file-format"
    FILE_UNKNOWN_KEY = "file-unknown-key"
    FILE_MISSING_KEY = "file-missing-key"
    FILE_WRONG_TYPE = "file-wrong-type"
    FILE_JOINTS = "file-joints"


class SettingsError(TfsatError):
    """The settings' file cannot be understood, or no servo can follow it.

    Attributes:
        code: Which defect; stable.
    """

    def __init__(self, code: StrEnum, *, what: str, next_step: str, meaning: str = NOTHING_CHANGED) -> None:
        super().__init__(what=what, meaning=meaning, next_step=next_step)
        self.code = SettingsDefect(code)
