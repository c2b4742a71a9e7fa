"""The table `[uncertainty]`: how far the file's figures may be off."""

from __future__ import annotations

import math

from tfsat_host.robot.entries import Entry
from tfsat_host.robot.model import Uncertainty

# Five standard deviations below the figure, something must be left of a mass, an inertia or a rate.
_GREATEST_SHARE = 0.2


def uncertainty(top: Entry) -> Uncertainty | None:
    """The table's figures, 0 for one that is left out; None without the table.

    Raises:
        RobotFileError: a figure is no standard deviation, or a share too large to draw from.
    """
    if not top.has("uncertainty"):
        return None
    entry = top.table("uncertainty")
    found = Uncertainty(
        mass_relative=entry.deviation("mass_relative", _GREATEST_SHARE),
        com_m=1e-3 * entry.deviation("com_mm"),
        inertia_relative=entry.deviation("inertia_relative", _GREATEST_SHARE),
        joint_point_m=1e-3 * entry.deviation("joint_point_mm"),
        joint_axis_rad=math.radians(entry.deviation("joint_axis_deg")),
        stroke_rad=math.radians(entry.deviation("stroke_deg")),
        stroke_relative=entry.deviation("stroke_relative", _GREATEST_SHARE),
        servo_speed_relative=entry.deviation("servo_speed_relative", _GREATEST_SHARE),
    )
    entry.done()
    return found
