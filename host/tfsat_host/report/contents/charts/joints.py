"""The joints' angles: as they were, and as they were commanded."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.report.contents.chart import Chart, Line
from tfsat_host.units import s_from_us

FloatArray = NDArray[np.float64]


def joint_chart(found: Evaluation) -> Chart:
    """Of all joints over the drop's times."""
    lines = [
        Line(
            f"joint {joint.joint}",
            np.rad2deg(joint.angle_rad),
            joint.joint - 1,
            "measured",
            np.rad2deg(joint.std_rad()),
        )
        for joint in found.motion.joints
    ]
    commanded = commanded_rad(found)
    if commanded is not None:
        lines += [
            Line(f"joint {index + 1} commanded", np.rad2deg(angle), index, "commanded")
            for index, angle in enumerate(commanded.T)
        ]
    return Chart(
        "joints",
        "Joint angles",
        "angle (deg)",
        tuple(lines),
        "From the angle sensors and the gyros on either side of each joint. Commanded: at the average speed that the "
        "schedule counts with. Band: one standard deviation.",
    )


def commanded_rad(found: Evaluation) -> FloatArray | None:
    """(n, joints) at the samples' times; None if nobody said what was commanded."""
    if found.schedule is None:
        return None
    t_s = found.motion.t_s
    angles = np.tile([servo.start_rad for servo in found.model.servos], (len(t_s), 1))
    for timed, flown in zip(found.schedule.strokes, found.strokes, strict=True):
        begin = flown.logged_s if np.isfinite(flown.logged_s) else timed.t_s
        took = max(s_from_us(timed.end_us - timed.t_us), 1e-6)
        share = np.clip((t_s - begin) / took, 0.0, 1.0)
        angles[:, timed.joint - 1] += np.deg2rad(timed.angle_deg) * share
    return np.asarray(angles)
