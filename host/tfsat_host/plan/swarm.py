"""Particle swarm optimization as the paper has it: coefficients that change linearly from search to agreement.

    v <- w v + c1 r1 (own best - x) + c2 r2 (best of all - x),    x <- x + v

with w = 0.9 - k/2n, c1 = 3.5 - k/n and c2 = 0.5 + 3k/n (section "Design of optimal reorientation maneuver"). The paper
leaves open: r1 and r2 are drawn for every component, start velocities reach over the whole range, and a
particle that would leave the box stops at its wall.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tfsat_host.arrays import FloatArray

Coefficient = tuple[float, float]
"""A coefficient at the first iteration and at the last; between them it changes linearly."""


def at(coefficient: Coefficient, progress: float) -> float:
    """Interpolate the coefficient at `progress`, the completed share of the iterations, 0 to 1."""
    first, last = coefficient
    return first + progress * (last - first)


@dataclass(frozen=True, slots=True)
class SwarmSettings:
    """How the swarm searches; the paper's figures."""

    particles: int = 48
    iterations: int = 50
    inertia: Coefficient = (0.9, 0.4)
    own_best: Coefficient = (3.5, 2.5)
    best_of_all: Coefficient = (0.5, 3.5)


@dataclass(frozen=True, eq=False)
class SwarmOptimum:
    """What the swarm found.

    Attributes:
        position: (d,).
        value: The objective there.
        best_values: (n + 1,) the best value at the start and after each iteration.
        evaluations: How many positions were evaluated.
    """

    position: FloatArray
    value: float
    best_values: FloatArray
    evaluations: int


def minimize(
    objective: Callable[[FloatArray], FloatArray],
    low: FloatArray,
    high: FloatArray,
    settings: SwarmSettings,
    rng: np.random.Generator,
    progress: Callable[[float], None] = lambda _done: None,
) -> SwarmOptimum:
    """Minimize `objective` between the bounds `low` and `high` (d,) by a particle swarm.

    It gives values (N,) of positions (d, N), one column per particle. The same numbers of `rng` find the same
    minimum. `progress` is called after each iteration with its share of all iterations.
    """
    shape = (len(low), settings.particles)
    floor, ceiling = low[:, None], high[:, None]
    # Uniform in the box; start velocities reach over its whole range, to both sides.
    position = rng.uniform(floor, ceiling, shape)
    velocity = rng.uniform(floor - ceiling, ceiling - floor, shape)
    own, own_value = position, objective(position)
    leader = int(np.argmin(own_value))
    best_values = [own_value[leader]]
    for k in range(settings.iterations):
        fraction = k / settings.iterations
        # Drawn for every component: a particle is not bound to the lines towards the two best.
        r1, r2 = rng.uniform(size=(2, *shape))
        velocity = at(settings.inertia, fraction) * velocity
        velocity += at(settings.own_best, fraction) * r1 * (own - position)
        velocity += at(settings.best_of_all, fraction) * r2 * (own[:, leader, None] - position)
        # A wall stops a particle: the component that was clipped loses its velocity.
        free = position + velocity
        position = np.clip(free, floor, ceiling)
        velocity = np.where(free == position, velocity, 0.0)
        value = objective(position)
        # Each particle keeps its own best; the leader is the best of these.
        better = value < own_value
        own, own_value = np.where(better, position, own), np.where(better, value, own_value)
        leader = int(np.argmin(own_value))
        best_values.append(own_value[leader])
        progress(1.0 / settings.iterations)
    return SwarmOptimum(
        own[:, leader].copy(),
        float(own_value[leader]),
        np.array(best_values),
        settings.particles * (settings.iterations + 1),
    )
