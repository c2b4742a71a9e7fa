"""What the sensors say of each other and of free fall, without any model of masses."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.apply import apply_calibration
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.report.contents.chart import Chart, Line
from tfsat_host.sdlog.droplog import rows_of
from tfsat_host.units import STANDARD_GRAVITY_M_S2

FloatArray = NDArray[np.float64]

AVERAGED = 9
"""Samples: neighbours' noise hides what a wrong mounting does."""


def gyro_residual_chart(found: Evaluation) -> Chart:
    """What each gyro shows beside the motion that all of them tell."""
    left = np.rad2deg(found.motion.fused.left_over_rad_s)
    left = np.where(found.motion.samples.fall[:, None, None], left, np.nan)
    lines = [
        Line(f"body {body + 1}", np.linalg.norm(_averaged(left[:, body]), axis=1), body, "measured")
        for body in range(left.shape[1])
    ]
    return Chart(
        "gyro_residuals",
        "What adjacent gyros disagree about",
        "rate, norm (deg/s)",
        tuple(lines),
        f"Of each gyro, beside the one motion that fits all of them best; averaged over {AVERAGED} samples. A wrong "
        "mounting or scale shows while joints move, a wrong bias always.",
    )


def force_chart(found: Evaluation) -> Chart:
    """What the accelerometers feel beyond their zero-g output."""
    forces = specific_force_g(found)
    lines = [
        Line(f"body {body + 1}", np.linalg.norm(forces[:, body], axis=1), body, "measured")
        for body in range(forces.shape[1])
    ]
    return Chart(
        "forces",
        "Micro-gravity",
        "specific force, norm (g)",
        tuple(lines),
        "Less what each accelerometer shows between release and first stroke, which is its zero-g output. 1 g before "
        "the release; strokes shake the sensors, which sit off the center of mass.",
        log_y=True,
    )


def specific_force_g(found: Evaluation) -> FloatArray:
    """(n, 4, 3) at the motion's samples, body axes, less the zero-g output; NaN where that or the sample is missing."""
    log, t_s = found.log, found.motion.t_s
    first, last = np.searchsorted(log.t_s, [t_s[0], t_s[-1]])
    part = rows_of(log, slice(int(first), int(last) + 1))
    calibrated = apply_calibration(Counts.from_log(part), found.calibration, found.model)
    rows = np.searchsorted(part.t_s, t_s)
    forces = calibrated.specific_force_m_s2[rows] / STANDARD_GRAVITY_M_S2
    zero = np.full(forces.shape[1:], np.nan)
    quiet = found.micro_gravity.windows[0]
    for body in quiet.bodies:
        zero[body.body - 1] = body.residual_g
    return np.asarray(forces - zero)


def _averaged(values: FloatArray) -> FloatArray:
    """(n, 3) moving average; NaN where a sample of it is missing, as at both ends."""
    weights, half = np.full(AVERAGED, 1.0 / AVERAGED), AVERAGED // 2
    averaged = np.full(values.shape, np.nan)
    if len(values) >= AVERAGED:
        inner = [np.convolve(column, weights, mode="valid") for column in values.T]
        averaged[half : len(values) - half] = np.column_stack(inner)
    return averaged
