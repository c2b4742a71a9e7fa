"""The strokes of a recorded run, joint by joint: evidence for each servo's speed, acceleration and delay."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.servos.dynamics_fit import LEAD_S
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.evidence import CommandedStroke, Evidence
from tfsat_host.calibration.steps.step import Step, StepKind
from tfsat_host.evaluation.clocks import align_clocks
from tfsat_host.evaluation.motion.samples import LANDING_GUARD_S, end_of_fall_s
from tfsat_host.maneuver import Schedule
from tfsat_host.run.certificate_check import origin_of_log
from tfsat_host.run.recorded_landing import time_of_day
from tfsat_host.sdlog import DropLog

SETTLED_S = 0.1
"""A stroke counts if its joint has rested so long before the landing."""


def recorded_strokes(log: DropLog, schedule: Schedule, file: Path) -> list[Evidence]:
    """Cut the strokes of each joint out of a recorded run: a drop, or a run on the bench.

    `schedule` is what the sequencer flew; `file` the recording's name in errors.

    Raises:
        CalibrationError: the recording has no release, no time of day, or no stroke line.
    """
    until_s = end_of_fall_s(log) - LANDING_GUARD_S
    strokes: dict[int, list[CommandedStroke]] = {}
    for stroke, line_s in zip(schedule.strokes, align_clocks(log, schedule).stroke_s, strict=True):
        # A line that was not seen is NaN, which compares as False: that stroke tells no delay.
        if line_s + 1e-6 * (stroke.end_us - stroke.t_us) + SETTLED_S < until_s:
            commanded = CommandedStroke(round(log.origin_us + 1e6 * line_s), stroke.angle_cdeg)
            strokes.setdefault(stroke.joint, []).append(commanded)
    first, last = np.searchsorted(log.t_s, [-LEAD_S, until_s])
    counts = Counts.from_log(log).part(slice(int(first), int(last)))
    recorded_at = time_of_day(log, int(counts.t_us[0])) if len(counts.t_us) else None
    if log.release is None or recorded_at is None or not strokes:
        problem = "shows no stroke line that fits the maneuver: when strokes were commanded is not known."
        if log.release is None:
            problem = "holds no release: the maneuver did not begin."
        elif recorded_at is None:
            problem = "does not say at what time of day it was recorded."
        raise CalibrationError(
            what=f"{file} {problem}",
            meaning="No servo's speed, acceleration and delay can be told; nothing was kept.",
            next_step="Name the maneuver that was flown with --maneuver, or take the recording of another run.",
        )
    origin = origin_of_log(log.header)
    return [
        Evidence(Step(StepKind.STROKES, joint), counts, recorded_at, origin, strokes=tuple(of_joint))
        for joint, of_joint in sorted(strokes.items())
    ]
