"""Attitudes of body 1 over the fall, measured and by either model, in common inertial axes; and their charts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tfsat_host.angles import wrap_angle
from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.dynamics.euler import euler_zyx_by_turn, euler_zyx_rad
from tfsat_host.evaluation.com_fit.model_comparison import BODY_1, ComparedModel
from tfsat_host.evaluation.com_fit.prediction import AttitudeError
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.spectra import compare_spectra
from tfsat_host.report.contents.chart import (
    AXES,
    NORM,
    WORDS,
    Chart,
    Kind,
    Line,
    Side,
    lines_of,
    pad_rows,
    spectrum_chart,
)

ZYX = (2, 1, 0)
"""Which axis each of the z-y-x Euler angles turns about."""


@dataclass(frozen=True, eq=False)
class EulerAngles:
    """Of body 1 at k samples from the release on; its inertial axes are its own at the first of them.

    Attributes:
        t_s: (k,) after the release.
        measured_rad: (k, 3) z-y-x, continuous.
        std_rad: (k, 3).
        before_rad, after_rad: (k, 3) by the model as its file has it and corrected, both started from the measured
            attitude when the release has settled; NaN until then.
    """

    t_s: FloatArray
    measured_rad: FloatArray
    std_rad: FloatArray
    before_rad: FloatArray
    after_rad: FloatArray


def euler_angles(evaluation: Evaluation) -> EulerAngles:
    """Compute the measured and predicted Euler angles of body 1, with standard deviations."""
    moved = evaluation.motion.bodies[BODY_1]
    measured = moved.attitude.as_matrix()
    driven = driven_samples(evaluation)
    # Both models begin where the measured attitude is when the release has settled.
    start = measured[driven][0]
    carried = evaluation.explained.driven.rotation[:, BODY_1]

    def by_model(sides: ComparedModel) -> FloatArray:
        # (k, 3, 3) attitude of the base, then of body 1 on it, counted from the first of them.
        base = sides.prediction.attitude @ carried
        turned = start @ (base[0].T @ base)
        return pad_rows(driven, continuous(euler_zyx_rad(turned)))

    covariance = np.stack([moved.covariance(index) for index in range(len(moved.t_s))])
    by_turn = euler_zyx_by_turn(measured)
    # First-order propagation J P J^T, from a small rotation vector to the Euler angles.
    spread = by_turn @ covariance @ by_turn.swapaxes(1, 2)
    # Rounding may leave a variance of nearly 0 below it.
    std = np.sqrt(np.maximum(np.diagonal(spread, axis1=1, axis2=2), 0.0))
    angles = continuous(euler_zyx_rad(measured))
    return EulerAngles(
        moved.t_s, angles, std, by_model(evaluation.explained.nominal), by_model(evaluation.explained.fitted)
    )


def driven_samples(evaluation: Evaluation) -> BoolArray:
    """(k,) those samples from the release on that the models were driven with."""
    fall = evaluation.motion.t_s[evaluation.motion.samples.fall]
    return np.asarray(fall >= evaluation.explained.driven.flown.t_s[0])


def continuous(angles_rad: FloatArray) -> FloatArray:
    """(k, ...) without jumps by a turn."""
    return np.asarray(np.unwrap(angles_rad, axis=0))


def euler_chart(evaluation: Evaluation) -> Chart:
    """z-y-x Euler angles over the drop's times."""
    angles, fall = euler_angles(evaluation), evaluation.motion.samples.fall
    sides: list[Side] = [
        (
            "measured",
            np.rad2deg(pad_rows(fall, angles.measured_rad)),
            np.rad2deg(pad_rows(fall, angles.std_rad)),
        ),
        ("before", np.rad2deg(pad_rows(fall, angles.before_rad)), None),
        ("after", np.rad2deg(pad_rows(fall, angles.after_rad)), None),
    ]
    return Chart(
        "euler",
        "Attitude of body 1",
        "z-y-x Euler angle (deg)",
        tuple(lines_of([f"φ{AXES[axis]}" for axis in ZYX], sides, ZYX)),
        "Since the release. Models: driven by the measured joint angles, from the measured attitude once the release "
        "has settled. Measured − predicted differs from the attitude error below, which includes the gyro delay: up to "
        f"{_beside_error_deg(evaluation, angles):.2g} deg while joints move, "
        f"{_beside_error_deg(evaluation, angles, last=True):.2g} deg at the end. Band: ± 1 standard deviation.",
    )


def _beside_error_deg(evaluation: Evaluation, angles: EulerAngles, *, last: bool = False) -> float:
    """Compute how far the differences of Euler angles deviate from the attitude error, in deg.

    The differences are those of the measured and the predicted curves. The result is the greatest deviation, or
    with `last` the final one.
    """
    driven = np.isfinite(angles.before_rad[:, 0])
    apart = (angles.measured_rad - angles.before_rad)[
        driven
    ] - evaluation.explained.nominal.error.euler_zyx_rad
    # Both curves were unwrapped on their own: they may be whole turns apart.
    size = np.rad2deg(np.abs(wrap_angle(apart)))
    return float(size[-1].max() if last else size.max())


def attitude_error_chart(evaluation: Evaluation) -> Chart:
    """Build the chart of measured − predicted Euler angles, and of their norm."""
    rows = evaluation.motion.t_s >= evaluation.explained.driven.flown.t_s[0]
    errors: dict[Kind, AttitudeError] = {
        "before": evaluation.explained.nominal.error,
        "after": evaluation.explained.fitted.error,
    }
    sides: list[Side] = [
        (kind, pad_rows(rows, np.rad2deg(error.euler_zyx_rad)), pad_rows(rows, np.rad2deg(error.std_rad)))
        for kind, error in errors.items()
    ]
    lines = lines_of([f"δφ{AXES[axis]}" for axis in ZYX], sides, ZYX)
    lines += [
        Line(f"norm {WORDS[kind]}", np.linalg.norm(values, axis=1), NORM, kind) for kind, values, _ in sides
    ]
    return Chart(
        "attitude_error",
        "Attitude error of the model",
        "measured − predicted (deg)",
        tuple(lines),
        "z-y-x Euler angles of body 1, both with the gyro delay. Band: ± 1 standard deviation of all sensor errors.",
    )


def attitude_spectrum_chart(evaluation: Evaluation) -> Chart:
    """Build the chart with the spectrum of the attitude error: measured − predicted Euler angles."""
    sides = evaluation.explained.nominal.error, evaluation.explained.fitted.error
    before, after = (np.rad2deg(error.euler_zyx_rad) for error in sides)
    return spectrum_chart(
        "attitude_spectrum",
        "Spectrum of the attitude error",
        "deg",
        compare_spectra(sides[0].t_s, before, after, window="Hann"),
        [f"δφ{AXES[axis]}" for axis in ZYX],
        ZYX,
    )
