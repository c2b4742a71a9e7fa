"""The attitude of body 1: measured, by the model, and what lies between them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tfsat_host.angles import wrapped
from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.model_fit.prediction import AttitudeError
from tfsat_host.report.contents.attitudes import EulerAngles, euler_angles
from tfsat_host.report.contents.chart import AXES, NORM, Chart, Kind, Line, padded
from tfsat_host.report.contents.charts.words import WORDS

FloatArray = NDArray[np.float64]

ZYX = (2, 1, 0)
"""Which axis each of the z-y-x Euler angles turns about."""


def euler_chart(found: Evaluation) -> Chart:
    """z-y-x Euler angles over the drop's times."""
    angles, fall = euler_angles(found), found.motion.samples.fall
    kinds: tuple[tuple[Kind, FloatArray], ...] = (
        ("measured", angles.measured_rad),
        ("before", angles.before_rad),
        ("after", angles.after_rad),
    )
    std = np.rad2deg(padded(fall, angles.std_rad))
    lines = [
        Line(
            f"φ{AXES[axis]} {WORDS[kind]}",
            np.rad2deg(padded(fall, values))[:, column],
            axis,
            kind,
            std[:, column] if kind == "measured" else None,
        )
        for column, axis in enumerate(ZYX)
        for kind, values in kinds
    ]
    return Chart(
        "euler",
        "Attitude of body 1",
        "z-y-x Euler angle (deg)",
        tuple(lines),
        "Since the release. The models are driven by the measured joint angles and begin where the measured attitude "
        "is when the release has settled. The error below compares what the gyros show late with a model made as late: "
        f"these curves differ from it by up to {_beside_error_deg(found, angles):.2g} deg while joints move and by "
        f"{_beside_error_deg(found, angles, last=True):.2g} deg at the end. Band: one standard deviation.",
    )


def _beside_error_deg(found: Evaluation, angles: EulerAngles, *, last: bool = False) -> float:
    """How far measured less predicted curves are from the attitude error: at most, or at the end."""
    driven = np.isfinite(angles.before_rad[:, 0])
    apart = (angles.measured_rad - angles.before_rad)[driven] - found.explained.before.error.euler_zyx_rad
    size = np.rad2deg(np.abs(wrapped(apart)))
    return float(size[-1].max() if last else size.max())


def attitude_error_chart(found: Evaluation) -> Chart:
    """Measured less predicted Euler angles, and their norm."""
    rows = found.motion.t_s >= found.explained.driven.flown.t_s[0]
    sides: tuple[tuple[Kind, AttitudeError], ...] = (
        ("before", found.explained.before.error),
        ("after", found.explained.after.error),
    )
    lines = [
        Line(
            f"δφ{AXES[axis]} {WORDS[kind]}",
            padded(rows, np.rad2deg(error.euler_zyx_rad[:, column])),
            axis,
            kind,
            padded(rows, np.rad2deg(error.std_rad[:, column])),
        )
        for column, axis in enumerate(ZYX)
        for kind, error in sides
    ]
    lines += [
        Line(
            f"norm {WORDS[kind]}",
            padded(rows, np.rad2deg(np.linalg.norm(error.euler_zyx_rad, axis=1))),
            NORM,
            kind,
        )
        for kind, error in sides
    ]
    return Chart(
        "attitude_error",
        "Attitude error of the model",
        "measured − predicted (deg)",
        tuple(lines),
        "z-y-x Euler angles of body 1, both sides as the gyros see them. Band: one standard deviation of all that the "
        "sensors may be off.",
    )
