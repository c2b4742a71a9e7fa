"""Which combinations of the offsets a drop's data can tell, and which they cannot.

The data's information on the offsets that are sought, all taken off that the sensors' errors and the nuisance
parameters could explain within their priors, is diagonal in directions of its own: along each of them the data alone
leave a standard deviation of 1 / (singular value).

The covariance at the end of the fit states what an offset's standard deviation would be if a group of the other
numbers were known exactly, and which sums with hinge points are known better than the offset: where a hinge and a
center of mass move together, nothing moves against the hinge.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics.multibody import across
from tfsat_host.evaluation.com_fit.com_fit import ModelFit
from tfsat_host.evaluation.com_fit.momentum_residual import FallSamples

DETERMINED_SHARE = 0.5
"""A direction is determined if the fit leaves less than this share of what the prior allowed."""
_RANK = 1e-8
"""A singular value that is so much smaller than the greatest is rounding."""
_NAMED_SHARE = 0.05
_MAX_NAMED = 3
_MAX_SHOWN = 3


@dataclass(frozen=True, eq=False)
class Direction:
    """One combination of p offsets.

    Attributes:
        names: p.
        components: (p,) of length one; their squares are the offsets' shares in it.
        singular_value: Of the data's information, 1 / unit.
        std_by_data: What the data alone leave open, in the unit; infinite if they say nothing.
        std: What data and prior together leave open.
        prior_std: What the prior alone leaves open.
    """

    names: tuple[str, ...]
    components: FloatArray
    singular_value: float
    std_by_data: float
    std: float
    prior_std: float

    @property
    def determined(self) -> bool:
        """The data say more of it than was allowed for before."""
        return self.std <= DETERMINED_SHARE * self.prior_std

    @property
    def composition(self) -> str:
        """Such as `97 % body 2 CoM z`: the greatest shares."""
        shares = self.components**2
        order = np.argsort(-shares)[:_MAX_NAMED]
        named = [k for k in order if shares[k] >= _NAMED_SHARE] or [int(order[0])]
        return ", ".join(f"{100.0 * shares[k]:.0f} % {self.names[k]}" for k in named)


@dataclass(frozen=True, eq=False)
class Identifiability:
    """What one drop can tell of the offsets.

    Attributes:
        unit: Of all stds here.
        directions: p, the weakest first.
        rank: How many of them the data say anything of.
    """

    unit: str
    directions: tuple[Direction, ...]
    rank: int

    @property
    def condition(self) -> float:
        """Greatest singular value over the least; infinite if the data say nothing of a direction."""
        least, greatest = self.directions[0].singular_value, self.directions[-1].singular_value
        return greatest / least if self.rank == len(self.directions) else float("inf")

    @property
    def undetermined(self) -> tuple[Direction, ...]:
        """Directions that the data cannot tell."""
        return tuple(direction for direction in self.directions if not direction.determined)

    def sentences(self) -> tuple[str, ...]:
        """Format sentences for a person who has to decide which offsets to believe."""
        weakest, p = self.directions[0], len(self.directions)
        sentences = [
            f"{p - len(self.undetermined)} of {p} parameters observable; condition number {self.condition:.0f}.",
            f"Least observable: {weakest.composition} (σ {weakest.prior_std:.2g} {self.unit} before the fit, "
            f"{weakest.std:.2g} {self.unit} after).",
        ]
        sentences += [
            f"Not observable: {direction.composition} (± {direction.std:.2g} {self.unit}); its value is the prior's, "
            "correct nothing by it."
            for direction in self.undetermined[:_MAX_SHOWN]
        ]
        if len(self.undetermined) > _MAX_SHOWN:
            sentences.append(f"{len(self.undetermined) - _MAX_SHOWN} more directions are not observable.")
        return tuple(sentences)


def identifiability(fit: ModelFit) -> Identifiability:
    """Compute the identifiability of a fit's sought offsets from the data and the final covariance."""
    offsets, s = fit.offsets.alone, fit.offsets.sought
    information, covariance = fit.sought_information, fit.covariance[:s, :s]
    # The information is symmetric but for rounding; its eigenvalues are squares of singular values.
    values, vectors = np.linalg.eigh(0.5 * (information + information.T))
    singular = np.sqrt(np.maximum(values, 0.0))
    prior = offsets.prior_std**2
    in_rank = singular > _RANK * singular[-1]
    directions = tuple(
        Direction(
            offsets.names,
            vector,
            float(value),
            float(1.0 / value) if is_known else float("inf"),
            float(np.sqrt(vector @ covariance @ vector)),
            float(np.sqrt(vector**2 @ prior)),
        )
        for value, vector, is_known in zip(singular, vectors.T, in_rank, strict=True)
    )
    return Identifiability(offsets.units[0], directions, int(in_rank.sum()))


PARTNERS = 3
# A hinge point trades exactly if its regression coefficient is so near to plus or minus one.
ONE_TO_ONE = 0.2
BETTER_SHARE = 0.8
"""A combination is shown if its standard deviation is so much smaller than the offset's alone."""
_GYRO_GROUPS = ("gyro bias", "gyro misalignment", "gyro scale")
_KINDS = {"com": "centers of mass", "mass": "masses", "inertia": "inertias", "point": "hinge points"}
_NUISANCE_CENTER = "center of mass of body 4"
_DELAY = "gyro delay"
_AXES = "hinge axes"
_JOINTS = "joint angles"


@dataclass(frozen=True, slots=True)
class Combination:
    """Of an offset with hinge points: its name, value and standard deviation, in the offset's unit."""

    name: str
    value: float
    std: float


@dataclass(frozen=True, eq=False)
class Coupling:
    """One offset that is sought, and what it trades with.

    Attributes:
        name: Of the offset.
        unit: Of its standard deviations.
        std: With everything uncertain that the fit holds.
        std_alone: If all that is no center of mass were known exactly.
        growth: By group, the standard deviation with only that group uncertain, over `std_alone`.
        partners: The numbers, of whatever group, that it correlates with most, and the correlation; the most first.
        determined: The offset less hinge points that trade with it exactly; None if that is known no better.
    """

    name: str
    unit: str
    std: float
    std_alone: float
    growth: Mapping[str, float]
    partners: tuple[tuple[str, float], ...]
    determined: Combination | None

    def sentence(self) -> str:
        """Format the coupling as a sentence."""
        if self.determined is not None:
            return (
                f"{self.determined.name}: {self.determined.value:+.2f} ± {self.determined.std:.2g} {self.unit} "
                f"({self.name} alone: ± {self.std:.2g} {self.unit})."
            )
        cause = max(self.growth, key=lambda group: self.growth[group])
        partner, correlation = self.partners[0]
        return (
            f"{self.name}: ± {self.std:.2g} {self.unit}, {self.std / self.std_alone:.1f} times what it would be if all "
            f"else were known, most of it by {cause} ({self.growth[cause]:.1f} times); goes with {partner} "
            f"({correlation:+.2f})."
        )


@dataclass(frozen=True, eq=False)
class _Numbers:
    """Everything that is uncertain in a fit, in physical units where it has any.

    Attributes:
        names: Of each.
        groups: Of each.
        covariance: Of all.
    """

    names: tuple[str, ...]
    groups: tuple[str, ...]
    covariance: FloatArray

    def of(self, groups: Sequence[str]) -> NDArray[np.intp]:
        return np.flatnonzero(np.isin(self.groups, groups))

    def std_if_known(self, target_indices: NDArray[np.intp], known_indices: NDArray[np.intp]) -> FloatArray:
        """Compute the standard deviations of the wanted numbers, given the known ones."""
        own = self.covariance[np.ix_(target_indices, target_indices)]
        if not len(known_indices):
            return np.sqrt(np.diag(own))
        # Scale to unit variances first, as rad, mm and % differ by orders of magnitude.
        unit = np.sqrt(np.diag(self.covariance)[known_indices])
        unit = np.where(unit > 0.0, unit, 1.0)
        cross = self.covariance[np.ix_(target_indices, known_indices)] / unit
        known_covariance = self.covariance[np.ix_(known_indices, known_indices)] / np.outer(unit, unit)
        # Condition the Gaussian on the known numbers; a pseudo-inverse admits those without variance.
        conditional_covariance = (
            own - cross @ np.linalg.pinv(known_covariance, rcond=1e-13, hermitian=True) @ cross.T
        )
        return np.sqrt(np.maximum(np.diag(conditional_covariance), 0.0))


def couplings(fit: ModelFit, kinematics: FallSamples) -> tuple[Coupling, ...]:
    """Compute the coupling of each offset that a fit of one drop sought, in the fit's order."""
    numbers = _numbers(fit, kinematics)
    offset_indices = np.arange(fit.offsets.sought)
    # Centers of mass and momentum are never taken for known: every fit has to find them from the drop.
    others = [group for group in dict.fromkeys(numbers.groups) if group not in (_KINDS["com"], "momentum")]
    std = np.sqrt(np.diag(numbers.covariance))
    alone = numbers.std_if_known(offset_indices, numbers.of(others))
    # For each group, take all the other groups for known: what it alone adds.
    growth = {
        group: numbers.std_if_known(offset_indices, numbers.of([other for other in others if other != group]))
        / alone
        for group in others
    }
    nameable = np.flatnonzero([bool(name) and s > 0.0 for name, s in zip(numbers.names, std, strict=True)])
    offset_couplings = []
    for row, index in enumerate(offset_indices):
        with_others = nameable[nameable != index]
        correlation = numbers.covariance[index, with_others] / (std[index] * std[with_others])
        order = np.argsort(-np.abs(correlation))[:PARTNERS]
        offset_couplings.append(
            Coupling(
                numbers.names[index],
                fit.offsets.units[index],
                float(std[index]),
                float(alone[row]),
                {group: float(values[row]) for group, values in growth.items()},
                tuple((numbers.names[with_others[k]], float(correlation[k])) for k in order),
                _determined_combination(fit, int(index)),
            )
        )
    return tuple(offset_couplings)


def _determined_combination(fit: ModelFit, index: int) -> Combination | None:
    """Build the combination of an offset less the hinge points that move with it one to one.

    None if the combination is known no better than the offset alone.
    """
    points = np.flatnonzero([kind == "point" for kind in fit.offsets.kinds])
    if not len(points):
        return None
    factors = np.zeros(len(fit.values))
    point_covariance = fit.covariance[np.ix_(points, points)]
    # Regress the offset on the hinge points: a coefficient near plus or minus one is an exact trade.
    together = np.linalg.solve(point_covariance, fit.covariance[points, index])
    # Round to whole factors, so that the sum means a distance between two points; drop weaker trades.
    factors[points] = np.where(np.abs(np.abs(together) - 1.0) < ONE_TO_ONE, -np.sign(together), 0.0)
    factors[index] = 1.0
    p = len(factors)
    std = float(np.sqrt(factors @ fit.covariance[:p, :p] @ factors))
    if std > BETTER_SHARE * fit.std[index]:
        return None
    names = fit.offsets.names
    parts = [f" {'-' if factors[k] < 0.0 else '+'} {names[k]}" for k in points if factors[k]]
    return Combination(names[index] + "".join(parts), float(factors @ fit.values), std)


def _numbers(fit: ModelFit, kinematics: FallSamples) -> _Numbers:
    """Build the fit's numbers, the sensors' errors transformed from independent ones to their own units."""
    offsets = fit.offsets
    first = len(offsets) + 3
    # Offsets and momentum are in their units already; only the independent errors are transformed.
    back = np.eye(len(fit.covariance))
    back[first:, first:] = kinematics.sensor_errors
    names = [*offsets.names, *[f"momentum {axis}" for axis in "xyz"]]
    groups = [
        _NUISANCE_CENTER if kind == "com" and k >= offsets.sought else _KINDS[kind]
        for k, kind in enumerate(offsets.kinds)
    ]
    groups += ["momentum"] * 3
    # Names in the order of the error vector: see `Prior` in `motion/error_model.py`.
    for body in range(offsets.body.n_bodies):
        for group in _GYRO_GROUPS:
            names += [f"gyro {body + 1} {group.removeprefix('gyro ')} {axis}" for axis in "xyz"]
            groups += [group] * 3
    # Differences between gyros sum to zero: one fewer than there are gyros.
    apart = [
        f"gyro {what} apart {k}" for what in ("low-passes", "delays") for k in range(1, offsets.body.n_bodies)
    ]
    names += ["gyro delay", "gyro delay's second moment", *apart]
    groups += [_DELAY] * (2 + len(apart))
    tilts = [
        f"joint {j + 1} axis about {'xyz'[int(np.abs(side).argmax())]}"
        for j, axis in enumerate(offsets.body.joint_axis)
        for side in across(axis)
    ]
    names += tilts
    groups += [_AXES] * len(tilts)
    # The joint angles' own errors have no names: starts and wander.
    rest = len(back) - len(names)
    return _Numbers((*names, *[""] * rest), (*groups, *[_JOINTS] * rest), back @ fit.covariance @ back.T)
