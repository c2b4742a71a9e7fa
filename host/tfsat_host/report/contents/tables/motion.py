"""Strokes and joints."""

from __future__ import annotations

import numpy as np

from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.motion.joints import SensorDisagreement
from tfsat_host.report.contents.tables.cells import number, with_std
from tfsat_host.report.document import Table

_deg = np.rad2deg


def stroke_table(found: Evaluation) -> Table | None:
    """Commanded and flown; None if nobody said what was commanded."""
    if found.schedule is None:
        return None
    rows = [
        [
            f"{stroke.number}: joint {stroke.joint}",
            number(_deg(stroke.commanded_rad), 2, signed=True),
            with_std(_deg(stroke.size_rad), _deg(stroke.size_std_rad), signed=True),
            with_std(stroke.start_s, stroke.start_std_s),
            number(1e3 * stroke.dead_time_s, 1),
            number(stroke.end_s, 3),
            number(_deg(stroke.peak_rate_rad_s), 0, signed=True),
            number(_deg(stroke.overshoot_rad), 2),
        ]
        for stroke in found.strokes
    ]
    remarks = [f"Stroke {stroke.number}: {stroke.remark}" for stroke in found.strokes if stroke.remark]
    return Table(
        title="Strokes",
        columns=[
            "stroke",
            "commanded (deg)",
            "flown (deg)",
            "start (s)",
            "dead time (ms)",
            "end (s)",
            "peak rate (deg/s)",
            "overshoot (deg)",
        ],
        rows=rows,
        caption=" ".join(
            ["Dead time: from the rise of the stroke line to the start of the joint.", *remarks]
        ),
    )


def standing_table(found: Evaluation) -> Table | None:
    """Joints that nothing commanded; None if nobody said what was commanded."""
    rows = [
        [
            f"joint {one.joint}",
            f"{number(one.from_s, 2)} to {number(one.until_s, 2)}",
            with_std(_deg(one.drift_rad), _deg(one.drift_std_rad), signed=True),
            f"{number(_deg(one.greatest_rad), 3, signed=True)} at {number(one.greatest_at_s, 2)} s",
            "moved" if one.unexpected else "crept" if one.crept else "stood",
        ]
        for one in found.standing
    ]
    if not rows:
        return None
    return Table(
        title="Joints between their strokes",
        columns=["joint", "time (s)", "drift (deg)", "farthest (deg)", "it"],
        rows=rows,
        caption="Drift: from the first samples to the last. Farthest: from the first samples, noise included.",
    )


def joint_table(found: Evaluation) -> Table:
    """Where the joints were at the release and at the end, and whether their sensors agree."""
    motion = found.motion
    release = int(np.searchsorted(motion.t_s, 0.0))
    rows = []
    for joint in motion.joints:
        std = _deg(joint.std_rad())
        rows.append(
            [
                f"joint {joint.joint}",
                with_std(_deg(joint.angle_rad[release]), std[release], signed=True),
                with_std(_deg(joint.angle_rad[-1]), std[-1], signed=True),
                *(_beside(one) for one in joint.sensors),
            ]
        )
    return Table(
        title="Joints",
        columns=["joint", "at the release (deg)", "at the end (deg)", "sensor 1 (deg)", "sensor 2 (deg)"],
        rows=rows,
        caption="Sensors: mean difference from the fused angle ± what their calibration allows, and the rms of all "
        "differences, noise included.",
    )


def _beside(sensor: SensorDisagreement) -> str:
    """An angle sensor beside the fused angle."""
    if not np.isfinite(sensor.mean_rad):
        return "never answered"
    mean = with_std(_deg(sensor.mean_rad), _deg(sensor.expected_rad), signed=True)
    return f"{mean}, rms {number(_deg(sensor.rms_rad), 2)}"
