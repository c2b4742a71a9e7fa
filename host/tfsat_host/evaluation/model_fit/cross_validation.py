"""Whether offsets that were found in some drops improve the model in another one.

Offsets that fit the drop they were fitted to prove little. Here those of all drops but one are combined and
applied to the one left out. Each drop gives the normal equations of its own data, and the prior counts once:

    (sum of I_i + P^-1) x = sum of b_i

with I_i the data's information, b_i their right-hand side and P the prior's covariance: what one fit to all drops at
once would solve. A drop whose own correction is withheld (`Explained.withheld`) corrects no other drop; the others are
tried on it all the same.

Drops that share a calibration share its errors: no combination makes those smaller, and no drop left out shows them.
The standard deviations here take the drops as independent.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.model_fit.fit import ModelFit, bounded_solution
from tfsat_host.evaluation.model_fit.momentum_average import PAPER_SIZE, averaged_momentum
from tfsat_host.evaluation.model_fit.offsets import Offsets
from tfsat_host.evaluation.model_fit.unexplained import Flown

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FittedDrop:
    """One drop, with its own fit.

    Attributes:
        name: For people.
        flown: What the model is driven by.
        fit: Of the same offsets as in the other drops.
        attitude_error: Of the model with offsets (p,), in their units, against what was measured in this drop.
        against: Why its offsets are not to be taken for the robot's, a sentence each: checks that failed, a correction
            that is withheld.
    """

    name: str
    flown: Flown
    fit: ModelFit
    attitude_error: Callable[[FloatArray], float]
    against: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Combined:
    """Offsets of several drops together.

    Attributes:
        values: (p,) in the offsets' units.
        covariance: (p, p), the drops taken as independent.
    """

    values: FloatArray
    covariance: FloatArray

    @property
    def std(self) -> FloatArray:
        """(p,)."""
        return np.sqrt(np.diag(self.covariance))


@dataclass(frozen=True, eq=False)
class LeftOut:
    """One drop, judged by the others.

    Attributes:
        name: Of the drop.
        others: The offsets of all others together.
        error_before: Attitude error here of the model without offsets, in the unit of `FittedDrop.attitude_error`.
        error_after: With the others' offsets.
        error_own: With its own: what there is to gain.
        objective_before: The paper's J here without offsets, kg m^2/s.
        objective_after: With the others'.
        own_off_std: Root mean square, over directions, of its own offsets less the others', in standard deviations of
            that difference: about 1 if the drops agree, less if they share a calibration's errors.
    """

    name: str
    others: Combined
    error_before: float
    error_after: float
    error_own: float
    objective_before: float
    objective_after: float
    own_off_std: float

    @property
    def improved(self) -> bool:
        """The others' offsets made the model's attitude better."""
        return self.error_after < self.error_before


def combine(fits: Sequence[ModelFit]) -> Combined:
    """The offsets of one or more drops, within their bounds.

    Raises:
        ValueError: there is none, or the fits are not of the same offsets.
    """
    if not fits:
        raise ValueError("there is no fit to combine")
    offsets = fits[0].offsets
    for fit in fits[1:]:
        _require_same(offsets, fit.offsets)
    prior = np.diag(offsets.prior_std**-2.0)
    information = prior + sum(fit.information for fit in fits)
    right = np.sum([fit.right_hand_side for fit in fits], axis=0)
    values = bounded_solution(information, right, -offsets.bounds, offsets.bounds)
    return Combined(values, np.asarray(np.linalg.inv(information), dtype=np.float64))


def trusted(drops: Sequence[FittedDrop]) -> tuple[FittedDrop, ...]:
    """Those that nothing stands against."""
    return tuple(drop for drop in drops if not drop.against)


def left_aside(drops: Sequence[FittedDrop]) -> tuple[str, ...]:
    """A sentence for each drop whose offsets are in no combination."""
    return tuple(
        f"The offsets of {drop.name} are in no combination: {' '.join(drop.against)}"
        for drop in drops
        if drop.against
    )


def cross_validate(drops: Sequence[FittedDrop], *, size: int = PAPER_SIZE) -> tuple[LeftOut, ...]:
    """Leaves out each drop in turn.

    Only `trusted` drops correct others; a drop that has none is not judged.

    Args:
        drops: Two or more, of one robot.
        size: N of the moving average in J.

    Raises:
        ValueError: there are fewer than two drops, or their fits are not of the same offsets.
    """
    if len(drops) < 2:
        raise ValueError("cross-validation needs two drops or more")
    found = []
    for drop in drops:
        _require_same(drop.fit.offsets, drops[0].fit.offsets)
        fits = [other.fit for other in trusted(drops) if other is not drop]
        if not fits:
            continue
        others = combine(fits)
        offsets, none = drop.fit.offsets, np.zeros(len(others.values))
        objective = averaged_momentum(
            offsets.applied(np.stack([none, others.values])), drop.flown, size
        ).objective
        found.append(
            LeftOut(
                name=drop.name,
                others=others,
                error_before=drop.attitude_error(none),
                error_after=drop.attitude_error(others.values),
                error_own=drop.attitude_error(drop.fit.values),
                objective_before=float(objective[0]),
                objective_after=float(objective[1]),
                own_off_std=_off(drop.fit, others),
            )
        )
    return tuple(found)


def _off(fit: ModelFit, others: Combined) -> float:
    p = len(fit.offsets)
    difference = fit.values - others.values
    covariance = fit.covariance[:p, :p] + others.covariance
    return float(np.sqrt(difference @ np.linalg.solve(covariance, difference) / p))


def _require_same(first: Offsets, second: Offsets) -> None:
    same = first.names == second.names and np.array_equal(first.prior_std, second.prior_std)
    if not same or not np.array_equal(first.body.com_m, second.body.com_m):
        raise ValueError("the fits are not of the same offsets of the same model")
