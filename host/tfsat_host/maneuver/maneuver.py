"""A maneuver: strokes in order, with the speed and the pause that fix their times; and what can be wrong with one."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from tfsat_host.errors import TfsatError
from tfsat_host.units import cdeg_from_deg

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

    What a command left undone because of it, the command adds to `meaning`.

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
    """A value for a message: its beginning, if it is long."""
    return text if len(text) <= _SHOWN_CHARACTERS else text[:_SHOWN_CHARACTERS] + "…"


@dataclass(frozen=True, slots=True)
class Stroke:
    """One joint moves once, by a relative angle.

    Attributes:
        joint: 1 to 3; joint i joins body i and body i+1.
        angle_deg: Change of the joint angle; positive opens the joint.
        t_s: Start after release, if it is fixed; None leaves it to the schedule rule.
    """

    joint: int
    angle_deg: float
    t_s: float | None = None

    @property
    def angle_cdeg(self) -> int:
        """Hundredths of a degree, as the board gets it; half to even.

        Raises:
            ValueError: the angle is infinite or not a number.
        """
        return cdeg_from_deg(self.angle_deg)


DEFAULT_SPEED_DEG_S = 170.0  # average joint speed of the drop experiment (paper, maneuver design)
DEFAULT_PAUSE_S = 0.70  # keeps the robot off the release mechanism even at the slowest release, 30 mm/s


@dataclass(frozen=True, slots=True)
class Maneuver:
    """Strokes in the order they are flown, from the folded pose (every joint at 0 deg).

    Attributes:
        strokes: What moves, in order.
        speed_deg_s: Average speed of a joint during a stroke.
        pause_s: From release to the first stroke.
        name: For people; not sent to the robot.
    """

    strokes: tuple[Stroke, ...]
    speed_deg_s: float = DEFAULT_SPEED_DEG_S
    pause_s: float = DEFAULT_PAUSE_S
    name: str = ""


def four_stroke(a_deg: float, b_deg: float, *, speed_deg_s: float = DEFAULT_SPEED_DEG_S) -> Maneuver:
    """The closed loop +A joint 1, +B joint 2, -A joint 1, -B joint 2 (paper, maneuver design)."""
    strokes = (Stroke(1, a_deg), Stroke(2, b_deg), Stroke(1, -a_deg), Stroke(2, -b_deg))
    return Maneuver(strokes, speed_deg_s=speed_deg_s, name=f"{a_deg:g}/{b_deg:g}")
