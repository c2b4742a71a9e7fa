"""The paper's search for the centers of mass, for comparison: a particle swarm on its objective.

The paper minimizes J (`momentum_average`) over nine offsets within 10 mm either way (section Result). It leaves the
swarm open; here it is the one with which it designs its maneuver. With masses and rates given, the momentum is a
quadratic polynomial in the offsets, exactly: the center of mass is linear in them, and moments of inertia are sums
of products of two distances. Averages and rotations into inertial axes keep that, so that the momenta of 55 robots
give J of any other without going through the samples' dynamics again.

J has no weights: it takes what a wrong scale factor of a gyro does for a wrong offset, states no uncertainty, and is
flat where the offsets are hard to determine. How far searches from other random starts lie apart shows how flat.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize as descend

from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.com_fit.com_fit import ModelFit
from tfsat_host.evaluation.com_fit.momentum_average import averaged_momentum
from tfsat_host.evaluation.com_fit.momentum_residual import FallSamples
from tfsat_host.evaluation.com_fit.offsets import Offsets
from tfsat_host.plan.swarm import SwarmSettings, minimize

SEEDS = tuple(range(10))
ARRIVED_SHARE = 0.01
"""A swarm that is above the bottom of its own valley by more than this share of J has not arrived."""


@dataclass(frozen=True, eq=False)
class MomentumPolynomial:
    """What the averaged momentum strays by, as a polynomial in p offsets.

    Attributes:
        coefficients: (1 + p + p (p + 1) / 2, 3, k) of `powers`, kg m^2/s.
    """

    coefficients: FloatArray

    def momentum_change(self, vectors: FloatArray) -> FloatArray:
        """(N, 3, k) hbar(t_j) - hbar(t_0) with offsets (N, p), in their units."""
        flat = self.coefficients.reshape(len(self.coefficients), -1)
        return np.asarray((powers(vectors) @ flat).reshape(len(vectors), *self.coefficients.shape[1:]))

    def objective(self, vectors: FloatArray) -> FloatArray:
        """(N,) J with offsets (N, p), kg m^2/s."""
        x, y, z = np.moveaxis(self.momentum_change(vectors), 1, 0)
        return np.asarray(np.sqrt(x**2 + y**2 + z**2).sum(axis=-1))


@dataclass(frozen=True, eq=False)
class SwarmFit:
    """What swarms found, and Gauss and Newton's offsets.

    Attributes:
        values: (p,) the best of all, in the offsets' units.
        objective: J there, kg m^2/s.
        objective_before: J of the model without offsets.
        objective_gauss_newton: J of Gauss and Newton's offsets, which do not minimize it.
        objective_below: J at the bottom of the valley in which the best lies: what a descent from there reaches.
        each: (s, p) what each swarm found.
        particles: Of each swarm.
        iterations: Of each swarm.
    """

    values: FloatArray
    objective: float
    objective_before: float
    objective_gauss_newton: float
    objective_below: float
    each: FloatArray
    particles: int
    iterations: int

    @property
    def converged(self) -> bool:
        """The best lies at the bottom of its valley, and no lower place is known."""
        lowest = min(self.objective_below, self.objective_before, self.objective_gauss_newton)
        return bool(self.objective <= (1.0 + ARRIVED_SHARE) * lowest)

    def sentences(self) -> tuple[str, ...]:
        """Format for a person how the swarms searched and whether to believe the result."""
        sentences = [
            f"{len(self.each)} swarm{'' if len(self.each) == 1 else 's'} of {self.particles} particles, "
            f"{self.iterations} iterations each."
        ]
        if self.objective > self.objective_before:
            sentences.append(
                f"What they found is worse than no correction: J is {self.objective:.3g} kg m^2/s, and "
                f"{self.objective_before:.3g} kg m^2/s as the model is."
            )
        if not self.converged:
            lowest = min(self.objective_below, self.objective_before, self.objective_gauss_newton)
            sentences.append(
                f"They did not converge: the best stopped at J = {self.objective:.3g} kg m^2/s, "
                f"{lowest:.3g} kg m^2/s is possible. Its offsets are for comparison only."
            )
        return tuple(sentences)

    @property
    def spread(self) -> FloatArray:
        """(p,) standard deviation over the swarms."""
        if len(self.each) < 2:
            return np.full(len(self.values), np.nan)
        return np.asarray(self.each.std(axis=0, ddof=1))


def powers(vectors: FloatArray) -> FloatArray:
    """(N, 1 + p + p (p + 1) / 2): one, each of p numbers, and each product of two."""
    # The upper triangle with its diagonal: each square and each product of two once.
    rows, columns = np.triu_indices(vectors.shape[1])
    return np.concatenate(
        [np.ones((len(vectors), 1)), vectors, vectors[:, rows] * vectors[:, columns]], axis=1
    )


def momentum_polynomial(offsets: Offsets, kinematics: FallSamples) -> MomentumPolynomial:
    """Fit one drop's momentum polynomial, by centers of mass alone, to as many robots as it has coefficients."""
    p = len(offsets)
    # As far out as the bounds, where rounding matters least.
    unit = offsets.bounds * np.eye(p)
    rows, columns = np.triu_indices(p, 1)
    # The origin, both ways along each axis, and each pair: as many robots as coefficients.
    places = np.concatenate([np.zeros((1, p)), unit, -unit, unit[rows] + unit[columns]])
    averages = averaged_momentum(offsets.apply(places), kinematics).values
    # From the first window, as J counts it; components before samples: (places, 3, k).
    strayed = (averages - averages[:, :1]).swapaxes(1, 2)
    coefficients = np.linalg.solve(powers(places), strayed.reshape(len(places), -1))
    return MomentumPolynomial(np.asarray(coefficients, dtype=np.float64).reshape(strayed.shape))


def swarm_fit(
    fit: ModelFit,
    kinematics: FallSamples,
    *,
    settings: SwarmSettings | None = None,
    seeds: Sequence[int] = SEEDS,
) -> SwarmFit:
    """Search with the paper's particle swarm over the offsets of the Gauss-Newton fit.

    The fit has all that it held uncertain; the paper took all but the centers of mass for exact. `settings`
    are the paper's by default; each of `seeds` is a swarm.
    """
    offsets, settings = fit.offsets.alone, settings or SwarmSettings()
    # One polynomial for all swarms: J then costs a matrix product a particle, and no dynamics.
    polynomial = momentum_polynomial(offsets, kinematics)
    minima = [
        minimize(
            lambda columns: polynomial.objective(columns.T),
            -offsets.bounds,
            offsets.bounds,
            settings,
            np.random.default_rng(seed),
        )
        for seed in seeds
    ]
    best = min(minima, key=lambda minimum: minimum.value)
    before = polynomial.objective(np.zeros((1, len(offsets))))[0]
    return SwarmFit(
        best.position,
        best.value,
        float(before),
        float(averaged_momentum(fit.offsets.correct(fit.values), kinematics).objective),
        _bottom(polynomial, best.position, offsets.bounds),
        np.stack([minimum.position for minimum in minima]),
        settings.particles,
        settings.iterations,
    )


def _bottom(polynomial: MomentumPolynomial, start: FloatArray, bounds: FloatArray) -> float:
    """J where a descent from `start` ends, within the bounds."""

    def at(vector: FloatArray) -> float:
        return float(polynomial.objective(vector[None])[0])

    # Descend from the swarm's best: if J falls much the swarm had not arrived.
    descent = descend(
        at, start.tolist(), method="L-BFGS-B", bounds=[(-float(bound), float(bound)) for bound in bounds]
    )
    return min(float(descent.fun), at(start))
