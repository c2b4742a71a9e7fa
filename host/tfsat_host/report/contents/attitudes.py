"""Attitudes over the fall, measured and by either model, in common inertial axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.dynamics.euler import euler_zyx_by_turn, euler_zyx_rad
from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.model_fit.prediction import BODY_1, Sides
from tfsat_host.report.contents.chart import padded

FloatArray = NDArray[np.float64]


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


def euler_angles(found: Evaluation) -> EulerAngles:
    """Of body 1."""
    moved = found.motion.bodies[BODY_1]
    measured = moved.attitude.as_matrix()
    driven = settled(found)
    start = measured[driven][0]
    carried = found.explained.driven.rotation[:, BODY_1]

    def by_model(sides: Sides) -> FloatArray:
        base = sides.prediction.attitude @ carried
        turned = start @ (base[0].T @ base)
        return padded(driven, continuous(euler_zyx_rad(turned)))

    covariance = np.stack([moved.covariance(index) for index in range(len(moved.t_s))])
    by_turn = euler_zyx_by_turn(measured)
    spread = by_turn @ covariance @ by_turn.swapaxes(1, 2)
    std = np.sqrt(np.maximum(np.diagonal(spread, axis1=1, axis2=2), 0.0))
    angles = continuous(euler_zyx_rad(measured))
    return EulerAngles(
        moved.t_s, angles, std, by_model(found.explained.before), by_model(found.explained.after)
    )


def settled(found: Evaluation) -> NDArray[np.bool_]:
    """(k,) those samples from the release on that the models were driven with."""
    fall = found.motion.t_s[found.motion.samples.fall]
    return np.asarray(fall >= found.explained.driven.flown.t_s[0])


def continuous(angles_rad: FloatArray) -> FloatArray:
    """(k, ...) without jumps by a turn."""
    return np.asarray(np.unwrap(angles_rad, axis=0))
