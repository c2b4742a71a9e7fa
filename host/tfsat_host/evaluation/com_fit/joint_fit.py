"""One fit to several drops: the robot's offsets in common, momentum and the sensors' errors each drop's own.

Each drop's own fit gives linear equations at its own values. In directions that no data tell, those of two drops differ
by the model's curvature alone, and their sum would seem to know what neither does: of six drops the standard
deviations came out a third too small. So all drops are linearized at the same values, again and again until these stay.

The robot's own uncertain numbers, such as hinge points and axes, are offsets: however many drops there are, their prior
counts once. Errors of a certificate that drops share are taken as each drop's own; a hundredth of the uncertainty comes
from them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.com_fit.com_fit import ModelFit, OffsetEquations, bounded_solution, linearize
from tfsat_host.evaluation.com_fit.offsets import Offsets

MAX_STEPS = 10
CONVERGED_STDS = 0.01
"""Of each offset, in its standard deviations after the fit."""


class JointFit(NamedTuple):
    """Offsets that explain several drops best.

    Attributes:
        values: (p,) in their units, within their bounds.
        unbounded: (p,) the same without the bounds.
        covariance: (p, p).
        drops: Each drop's equations at the values.
    """

    values: FloatArray
    unbounded: FloatArray
    covariance: FloatArray
    drops: tuple[OffsetEquations, ...]


def fit_jointly(fits: Sequence[ModelFit]) -> JointFit:
    """Fit the offsets of drops that were each fitted alone.

    Args:
        fits: Of the same offsets, one a drop.
    """
    joint = _solve([fit.equations for fit in fits], fits[0].offsets)
    if len(fits) == 1:
        return joint
    for _ in range(MAX_STEPS):
        # Linearize each drop there, at the momentum and the errors of its own that go with it.
        drops = [
            linearize(fit.offsets, fit.flown, drop.place_at(joint.values), fit.widening)
            for fit, drop in zip(fits, joint.drops, strict=True)
        ]
        before, joint = joint, _solve(drops, fits[0].offsets)
        change_stds = np.abs(joint.values - before.values) / np.sqrt(np.diag(joint.covariance))
        if change_stds.max() < CONVERGED_STDS:
            break
    return joint


def _solve(drops: Sequence[OffsetEquations], offsets: Offsets) -> JointFit:
    """Sum what the drops tell; the prior counts once."""
    normal = np.diag(offsets.prior_std**-2.0) + sum(drop.information for drop in drops)
    right = np.sum([drop.right_hand_side for drop in drops], axis=0)
    covariance = np.asarray(np.linalg.inv(normal), dtype=np.float64)
    # Offer values within bounds; whether drops agree is judged by those without.
    values = bounded_solution(normal, right, -offsets.bounds, offsets.bounds)
    return JointFit(values, covariance @ right, covariance, tuple(drops))
