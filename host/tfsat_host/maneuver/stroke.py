"""A stroke: one joint moves once."""

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
