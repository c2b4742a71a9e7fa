"""What can be wrong with a maneuver: one class, one stable name per defect."""

from __future__ import annotations

from enum import StrEnum

from tfsat_host.errors import TfsatError

_SHOWN_CHARACTERS = 40
NO_MANEUVER = "There is no maneuver that could be flown."


class Defect(StrEnum):
    """Stable names of the defects; tests, scripts and the documentation rely on them."""

    ANGLE_NOT_FINITE = "angle-not-finite"
    ZERO_STROKE = "zero-stroke"
    UNKNOWN_JOINT = "unknown-joint"
    JOINT_RANGE = "joint-range"
    NO_STROKES = "no-strokes"
    TOO_MANY_STROKES = "too-many-strokes"
    SPEED_RANGE = "speed-range"
    TIME_NOT_FINITE = "time-not-finite"
    TIMES_INCOMPLETE = "times-incomplete"
    BEFORE_PAUSE = "before-pause"
    OVERLAP = "overlap"
    OUTLASTS_FALL = "outlasts-fall"
    FILE_UNREADABLE = "file-unreadable"
    FILE_SYNTAX = "file-syntax"
    FILE_SCHEMA = "file-schema"
    FILE_UNKNOWN_KEY = "file-unknown-key"
    FILE_MISSING_KEY = "file-missing-key"
    FILE_WRONG_TYPE = "file-wrong-type"


class ManeuverError(TfsatError):
    """The maneuver cannot be flown, or its file cannot be understood.

    Its words are those of whoever plans a maneuver; what was not done about it the command adds to `meaning`.

    Attributes:
        code: Which defect; stable.
        stroke: Number of the stroke at fault, counted from 1, or None when it is the whole maneuver.
    """

    def __init__(
        self,
        code: StrEnum,
        *,
        what: str,
        next_step: str,
        meaning: str = NO_MANEUVER,
        stroke: int | None = None,
    ) -> None:
        super().__init__(what=what, meaning=meaning, next_step=next_step)
        self.code = Defect(code)
        self.stroke = stroke

    def in_file(self, name: str) -> ManeuverError:
        """The same error, naming the file that the maneuver came from."""
        return ManeuverError(
            self.code,
            what=f"{name}: {self.what}",
            meaning=self.meaning,
            next_step=self.next_step,
            stroke=self.stroke,
        )


def shortened(text: str) -> str:
    """What somebody wrote, for a message: its beginning, if it is long."""
    return text if len(text) <= _SHOWN_CHARACTERS else text[:_SHOWN_CHARACTERS] + "…"
