"""Which combinations of the offsets a drop's data can tell, and which they cannot.

The data's information on the offsets, all that the sensors' errors could explain taken off, is diagonal in directions
of its own: along each of them the data alone leave a standard deviation of 1 / (singular value). Offsets of one
unit are taken as they are; of several units, each in multiples of what its prior allows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.model_fit.fit import ModelFit

FloatArray = NDArray[np.float64]

UNTOLD_SHARE = 0.5
"""A direction is told if the fit leaves less than this share of what the prior allowed."""
_RANK = 1e-8
"""A singular value that is so much smaller than the greatest is rounding."""
_NAMED_SHARE = 0.05
_MOST_NAMED = 3
_MOST_UNTOLD = 3


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
    def told(self) -> bool:
        """The data say more of it than was allowed for before."""
        return self.std <= UNTOLD_SHARE * self.prior_std

    @property
    def composition(self) -> str:
        """Such as `97 % body 2 CoM z`: the greatest shares."""
        shares = self.components**2
        order = np.argsort(-shares)[:_MOST_NAMED]
        named = [k for k in order if shares[k] >= _NAMED_SHARE] or [int(order[0])]
        return ", ".join(f"{100.0 * shares[k]:.0f} % {self.names[k]}" for k in named)


@dataclass(frozen=True, eq=False)
class Identifiability:
    """What one drop can tell of the offsets.

    Attributes:
        unit: Of all stds here: the offsets' own, or `prior std`.
        directions: p, the weakest first.
        rank: How many of them the data say anything of.
    """

    unit: str
    directions: tuple[Direction, ...]
    rank: int

    @property
    def singular_values(self) -> FloatArray:
        """(p,) descending, 1 / unit."""
        return np.array([direction.singular_value for direction in reversed(self.directions)])

    @property
    def condition(self) -> float:
        """Greatest singular value over the least; infinite if the data say nothing of a direction."""
        values = self.singular_values
        return float(values[0] / values[-1]) if self.rank == len(values) else float("inf")

    @property
    def untold(self) -> tuple[Direction, ...]:
        """Directions that the data cannot tell."""
        return tuple(direction for direction in self.directions if not direction.told)

    def sentences(self) -> tuple[str, ...]:
        """For a person who has to decide what to believe."""
        weakest, p = self.directions[0], len(self.directions)
        found = [
            f"The data tell {p - len(self.untold)} of {p} directions of the offsets; condition number "
            f"{self.condition:.0f}.",
            f"The weakest is {weakest.composition}: ± {weakest.std:.2g} {self.unit} after the fit, where "
            f"± {weakest.prior_std:.2g} {self.unit} was allowed.",
        ]
        found += [
            f"Not told: {direction.composition} (± {direction.std:.2g} {self.unit}); its value is the prior's, "
            "correct nothing by it."
            for direction in self.untold[:_MOST_UNTOLD]
        ]
        if len(self.untold) > _MOST_UNTOLD:
            found.append(f"{len(self.untold) - _MOST_UNTOLD} more directions are not told either.")
        return tuple(found)


def identifiability(fit: ModelFit) -> Identifiability:
    """Of the offsets of a fit, by the data and the covariance at its end."""
    offsets = fit.offsets
    p = len(offsets)
    single = len(set(offsets.units)) == 1
    scale = np.ones(p) if single else offsets.prior_std
    information = fit.information * np.outer(scale, scale)
    covariance = fit.covariance[:p, :p] / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(0.5 * (information + information.T))
    singular = np.sqrt(np.maximum(values, 0.0))
    prior = (offsets.prior_std / scale) ** 2
    known = singular > _RANK * singular[-1]
    directions = tuple(
        Direction(
            offsets.names,
            vector,
            float(value),
            float(1.0 / value) if is_known else float("inf"),
            float(np.sqrt(vector @ covariance @ vector)),
            float(np.sqrt(vector**2 @ prior)),
        )
        for value, vector, is_known in zip(singular, vectors.T, known, strict=True)
    )
    return Identifiability(offsets.units[0] if single else "prior std", directions, int(known.sum()))
