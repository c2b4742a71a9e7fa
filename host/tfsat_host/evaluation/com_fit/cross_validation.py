"""Whether offsets that were found in some drops improve the model in another one.

Offsets that fit the drop they were fitted to prove little. Here those of all drops but one are combined and
applied to the one left out. Each drop gives the normal equations of its own data, and the prior counts once:

    (sum of I_i + P^-1) x = sum of b_i

with I_i the data's information at x, b_i their right-hand side and P the prior's covariance: one fit to all drops at
once (`fit_jointly`). A drop whose own correction is withheld (`ModelComparison.withheld`) corrects no other drop; the
others are tried on it all the same.

Whether the drops agree shows in a chi-square of what each one's data leave over at the common offsets,

    sum of (b_i - I_i x)^T I_i^+ (b_i - I_i x)

with one degree of freedom for each direction that a drop tells anything of, less those that x took. Where chance alone
would leave more than once in a thousand times, the standard deviations are multiplied by the Birge ratio, the root of
chi-square by its degrees of freedom (R. T. Birge, The calculation of errors by the method of least squares, 1932).

Drops that share a calibration share its errors: no combination makes those smaller, and no drop left out shows them.
The standard deviations here take the drops as independent.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.special import chdtrc, chdtri

from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.com_fit.com_fit import ModelFit, OffsetEquations, bounded_solution, linearize
from tfsat_host.evaluation.com_fit.momentum_average import averaged_momentum
from tfsat_host.evaluation.com_fit.momentum_residual import FallSamples
from tfsat_host.evaluation.com_fit.offsets import Offsets

CHANCE_LEAST = 1e-3
"""Drops of one robot disagree by more in so few cases: less likely ones are not of one unchanged robot."""
_TELLS_LEAST = 0.1
"""Of the prior's information: where a drop has less, it tells nothing that another could contradict."""


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
    flown: FallSamples
    fit: ModelFit
    attitude_error: Callable[[FloatArray], float]
    against: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class CombinedOffsets:
    """Offsets of several drops together.

    Attributes:
        offsets: What was free in all drops.
        values: (p,) in the offsets' units.
        covariance: (p, p), the drops taken as independent; widened if they do not agree.
        chi_square: Of what the drops leave over at the common offsets.
        degrees_of_freedom: Of that; 0 for one drop.
    """

    offsets: Offsets
    values: FloatArray
    covariance: FloatArray
    chi_square: float
    degrees_of_freedom: float

    @property
    def chance(self) -> float:
        """How likely drops of one robot are to disagree so much or more; 1 for one drop."""
        return _chance(self.chi_square, self.degrees_of_freedom)

    @property
    def agree(self) -> bool:
        """The drops contradict each other by no more than chance makes them."""
        return self.chance >= CHANCE_LEAST

    @property
    def widened_by(self) -> float:
        """What the standard deviations were multiplied with: the Birge ratio; 1 if the drops agree."""
        return _birge_ratio(self.chi_square, self.degrees_of_freedom)

    def contradiction(self) -> str:
        """Why it is not to be trusted, a sentence or more; empty if the drops agree."""
        if self.agree:
            return ""
        return (
            f"The drops contradict each other: chi-square {self.chi_square:.0f} with {self.degrees_of_freedom:.0f} "
            f"degrees of freedom, where chance makes more than {chdtri(self.degrees_of_freedom, CHANCE_LEAST):.0f} "
            "once in a thousand times. Their common correction is DOUBTFUL; its standard deviations were multiplied by "
            f"{self.widened_by:.1f} (Birge ratio). Something of the robot changed between the drops, or one of them is "
            "wrong: look at each drop's own correction, and take none of them for the others before it is found."
        )

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
    others: CombinedOffsets
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


def combine(fits: Sequence[ModelFit]) -> CombinedOffsets:
    """Combine the offsets of one or more drops, within their bounds, and test whether the drops agree.

    Raises:
        ValueError: there is none, or the fits are not of the same offsets.
    """
    if not fits:
        raise ValueError("there is no fit to combine")
    offsets = fits[0].offsets
    for fit in fits[1:]:
        _require_same(offsets, fit.offsets)
    # One fit to all drops, relinearized at common offsets; the prior counts once.
    joint = fit_jointly(fits)
    chi_square, freedom = _disagreement(joint, offsets.prior_std)
    # The ratio is of standard deviations; it is one where chance may explain the scatter.
    covariance = joint.covariance * _birge_ratio(chi_square, freedom) ** 2
    return CombinedOffsets(offsets, joint.values, covariance, chi_square, freedom)


def _disagreement(joint: JointFit, prior_std: FloatArray) -> tuple[float, float]:
    """Chi-square of the drops about common offsets, and its degrees of freedom.

    The offsets are taken without their bounds: drops that agree on one beyond its bound agree.
    """
    if len(joint.drops) < 2:
        return 0.0, 0.0
    chi_square, direction_count = 0.0, 0
    for drop in joint.drops:
        # Along the directions that the drop tells, in standard deviations of the prior.
        tells, directions = np.linalg.eigh(prior_std[:, None] * drop.information * prior_std)
        # What this drop's data would still change at the common offsets: zero if it agrees.
        pull = drop.right_hand_side - drop.information @ joint.unbounded
        projected_pull = directions.T @ (prior_std * pull)
        # Pseudo-inverse: only directions that the drop tells add to chi-square and its degrees.
        telling = tells > _TELLS_LEAST
        chi_square += float((projected_pull[telling] ** 2 / tells[telling]).sum())
        direction_count += int(telling.sum())
    # The common fit has used up some degrees: trace of its covariance times the data's information.
    effective_parameters = float(np.trace(joint.covariance @ sum(drop.information for drop in joint.drops)))
    return chi_square, max(direction_count - effective_parameters, 0.0)


def _chance(chi_square: float, freedom: float) -> float:
    return float(chdtrc(freedom, chi_square)) if freedom > 0.0 else 1.0


def _birge_ratio(chi_square: float, freedom: float) -> float:
    """Compute the Birge ratio: at least 1, and 1 if chance may explain the disagreement."""
    if _chance(chi_square, freedom) >= CHANCE_LEAST:
        return 1.0
    return float(np.sqrt(max(chi_square / freedom, 1.0)))


def find_trusted_drops(drops: Sequence[FittedDrop]) -> tuple[FittedDrop, ...]:
    """Return the drops whose corrections may be combined."""
    return tuple(drop for drop in drops if not drop.against)


def left_aside(drops: Sequence[FittedDrop]) -> tuple[str, ...]:
    """Format a sentence for each drop whose offsets are in no combination."""
    return tuple(f"Not combined: {drop.name}. {' '.join(drop.against)}" for drop in drops if drop.against)


def cross_validate(drops: Sequence[FittedDrop]) -> tuple[LeftOut, ...]:
    """Leaves out each drop in turn, of two or more of one robot.

    Only the drops of `find_trusted_drops` correct others; a drop that has none is not judged.

    Raises:
        ValueError: there are fewer than two drops, or their fits are not of the same offsets.
    """
    if len(drops) < 2:
        raise ValueError("cross-validation needs two drops or more")
    validations = []
    for drop in drops:
        _require_same(drop.fit.offsets, drops[0].fit.offsets)
        # The drop itself takes no part, nor do doubtful drops.
        fits = [other.fit for other in find_trusted_drops(drops) if other is not drop]
        if not fits:
            continue
        others = combine(fits)
        offsets, none = drop.fit.offsets, np.zeros(len(others.values))
        # A batch of two robots: J of the model as filed, and with the others' offsets.
        objective = averaged_momentum(offsets.apply(np.stack([none, others.values])), drop.flown).objective
        validations.append(
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
    return tuple(validations)


def _off(fit: ModelFit, others: CombinedOffsets) -> float:
    p = len(fit.offsets)
    difference = fit.values - others.values
    # Own and common offsets come of different drops: their covariances add.
    covariance = fit.covariance[:p, :p] + others.covariance
    return float(np.sqrt(difference @ np.linalg.solve(covariance, difference) / p))


def _require_same(first: Offsets, second: Offsets) -> None:
    same = first.names == second.names and np.array_equal(first.prior_std, second.prior_std)
    if not same or not np.array_equal(first.body.com_m, second.body.com_m):
        raise ValueError("the fits are not of the same offsets of the same model")


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
    """Fit the robot's offsets in common, momentum and the sensors' errors each drop's own.

    Each drop's own fit gives linear equations at its own values. In directions that no data tell, those of two drops
    differ by the model's curvature alone, and their sum would seem to know what neither does: of six drops the standard
    deviations came out a third too small. So all drops are linearized at the same values, again and again until these
    stay.

    The robot's own uncertain numbers, such as hinge points and axes, are offsets: however many drops there are, their
    prior counts once. Errors of a certificate that drops share are taken as each drop's own; a hundredth of the
    uncertainty comes from them.

    All fits, one a drop, are of the same offsets.
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
