"""What trades against what: how much of an offset's uncertainty comes from other numbers that are uncertain, too.

Masses and inertias are free in the fit if `com_offsets` was asked for them; the errors of gyros and joint angles always
are, as far as their calibration allows. All of them have priors. The covariance at the end of the fit says what
an offset's standard deviation would be if a group of them were known exactly.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.model_fit.fit import ModelFit
from tfsat_host.evaluation.model_fit.unexplained import Flown

FloatArray = NDArray[np.float64]

PARTNERS = 3
_GYRO_GROUPS = ("gyro bias", "gyro mounting", "gyro scale")
_KINDS = {"com": "centers of mass", "mass": "masses", "inertia": "inertias"}
_DELAY = "gyro delay"
_JOINTS = "joint angles"


@dataclass(frozen=True, eq=False)
class Trade:
    """One center of mass's offset.

    Attributes:
        name: Of the offset.
        unit: Of its standard deviations.
        std: With everything uncertain that the fit holds.
        std_alone: If all that is no center of mass were known exactly.
        growth: By group, the standard deviation with only that group uncertain, over `std_alone`.
        partners: The numbers, of whatever group, that it correlates with most, and the correlation; the most first.
    """

    name: str
    unit: str
    std: float
    std_alone: float
    growth: Mapping[str, float]
    partners: tuple[tuple[str, float], ...]

    def sentence(self) -> str:
        """In words."""
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

    def std_if_known(self, wanted: NDArray[np.intp], known: NDArray[np.intp]) -> FloatArray:
        """Of the wanted, if the others were given."""
        own = self.covariance[np.ix_(wanted, wanted)]
        if not len(known):
            return np.sqrt(np.diag(own))
        unit = np.sqrt(np.diag(self.covariance)[known])
        unit = np.where(unit > 0.0, unit, 1.0)
        cross = self.covariance[np.ix_(wanted, known)] / unit
        given = self.covariance[np.ix_(known, known)] / np.outer(unit, unit)
        left = own - cross @ np.linalg.pinv(given, rcond=1e-13, hermitian=True) @ cross.T
        return np.sqrt(np.maximum(np.diag(left), 0.0))


def trades(fit: ModelFit, flown: Flown) -> tuple[Trade, ...]:
    """Of each center of mass's offset in a fit, in the fit's order.

    Args:
        fit: Of one drop.
        flown: The same drop.
    """
    numbers = _numbers(fit, flown)
    wanted = numbers.of([_KINDS["com"]])
    others = [group for group in dict.fromkeys(numbers.groups) if group not in (_KINDS["com"], "momentum")]
    std = np.sqrt(np.diag(numbers.covariance))
    alone = numbers.std_if_known(wanted, numbers.of(others))
    growth = {
        group: numbers.std_if_known(wanted, numbers.of([other for other in others if other != group])) / alone
        for group in others
    }
    nameable = np.flatnonzero([bool(name) and s > 0.0 for name, s in zip(numbers.names, std, strict=True)])
    found = []
    for row, index in enumerate(wanted):
        with_others = nameable[nameable != index]
        correlation = numbers.covariance[index, with_others] / (std[index] * std[with_others])
        order = np.argsort(-np.abs(correlation))[:PARTNERS]
        found.append(
            Trade(
                numbers.names[index],
                fit.offsets.units[index],
                float(std[index]),
                float(alone[row]),
                {group: float(values[row]) for group, values in growth.items()},
                tuple((numbers.names[with_others[k]], float(correlation[k])) for k in order),
            )
        )
    return tuple(found)


def _numbers(fit: ModelFit, flown: Flown) -> _Numbers:
    """The sensors' errors turned back from independent ones into their own units."""
    offsets = fit.offsets
    first = len(offsets) + 3
    back = np.eye(len(fit.covariance))
    back[first:, first:] = flown.sensor_errors
    names = [*offsets.names, *[f"momentum {axis}" for axis in "xyz"]]
    groups = [*[_KINDS[kind] for kind in offsets.kinds], *["momentum"] * 3]
    for body in range(offsets.body.n_bodies):
        for group in _GYRO_GROUPS:
            names += [f"gyro {body + 1} {group.removeprefix('gyro ')} {axis}" for axis in "xyz"]
            groups += [group] * 3
    names += ["gyro delay", "gyro delay's second moment"]
    groups += [_DELAY] * 2
    # The joint angles' own errors have no names: starts and wander.
    rest = len(back) - len(names)
    return _Numbers((*names, *[""] * rest), (*groups, *[_JOINTS] * rest), back @ fit.covariance @ back.T)
