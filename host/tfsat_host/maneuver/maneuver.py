"""A maneuver: strokes in order, with the speed and the pause that fix their times."""

from __future__ import annotations

from dataclasses import dataclass

from tfsat_host.units import cdeg_from_deg


@dataclass(frozen=True, slots=True)
class Stroke:
    """One joint moves once, by a relative angle.

    Attributes:
        joint: 1 to 3; joint i joins body i and body i+1.
        angle_deg: Change of the joint angle; positive opens the joint.
        t_s: Start after release, when somebody fixed it; None leaves it to the schedule rule.
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
