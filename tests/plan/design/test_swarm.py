"""The particle swarm: its schedules, its walls, its seeds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tfsat_host.arrays import FloatArray
from tfsat_host.plan.swarm import SwarmSettings, at, minimize

LOW, HIGH = np.array([0.0, -2.0]), np.array([1.0, 3.0])


def bowl(x: FloatArray) -> FloatArray:
    return np.asarray((x[0] - 0.3) ** 2 + 4.0 * (x[1] - 1.1) ** 2)


def test_the_coefficients_are_the_papers() -> None:
    swarm = SwarmSettings()
    assert (swarm.particles, swarm.iterations) == (48, 50)
    for k in (0, 10, 50):
        # The paper's coefficients over the fifty iterations.
        assert at(swarm.inertia, k / 50) == pytest.approx(0.9 - k / 100)
        assert at(swarm.own_best, k / 50) == pytest.approx(3.5 - k / 50)
        assert at(swarm.best_of_all, k / 50) == pytest.approx(0.5 + 3 * k / 50)


def test_it_finds_the_bottom_of_a_bowl() -> None:
    optimum = minimize(bowl, LOW, HIGH, SwarmSettings(), np.random.default_rng(3))
    assert optimum.position == pytest.approx([0.3, 1.1], abs=0.02)
    assert optimum.value == pytest.approx(float(bowl(optimum.position)))
    # Forty-eight particles, fifty iterations and the first one.
    assert optimum.evaluations == 48 * 51


@settings(deadline=None, max_examples=30)
@given(seed=st.integers(0, 2**32), particles=st.integers(1, 20), iterations=st.integers(1, 20))
def test_no_particle_leaves_the_box_and_the_best_never_gets_worse(
    seed: int, particles: int, iterations: int
) -> None:
    positions: list[FloatArray] = []

    def watch_bowl(x: FloatArray) -> FloatArray:
        positions.append(x.copy())
        return -bowl(x)  # the best places are the box's corners

    optimum = minimize(
        watch_bowl, LOW, HIGH, SwarmSettings(particles, iterations), np.random.default_rng(seed)
    )
    for x in positions:
        assert x.shape == (2, particles)
        assert (x >= LOW[:, None]).all()
        assert (x <= HIGH[:, None]).all()
    assert (np.diff(optimum.best_values) <= 0.0).all()
    assert optimum.value == optimum.best_values[-1] == min(float(np.min(-bowl(x))) for x in positions)


def test_the_coefficients_can_be_set() -> None:
    """Without memory and company a swarm only drifts: it does not settle."""
    still = (0.0, 0.0)
    lonely = SwarmSettings(inertia=still, own_best=still, best_of_all=still)
    optimum = minimize(bowl, LOW, HIGH, lonely, np.random.default_rng(3))
    assert (optimum.best_values == optimum.best_values[0]).all()


def test_particles_follow_the_leader_alone_when_only_the_leader_counts() -> None:
    positions: list[FloatArray] = []

    def watch_bowl(x: FloatArray) -> FloatArray:
        positions.append(x.copy())
        return bowl(x)

    none, half = (0.0, 0.0), (0.5, 0.5)
    led = SwarmSettings(9, 1, inertia=none, own_best=none, best_of_all=half)
    minimize(watch_bowl, LOW, HIGH, led, np.random.default_rng(8))
    start, end = positions
    leader = start[:, np.argmin(bowl(start)), None]
    # r2 is drawn between 0 and 1: they go between none and half of the way.
    assert (np.abs(end - leader) <= np.abs(start - leader)).all()
    assert (np.abs(end - leader) >= 0.5 * np.abs(start - leader) - 1e-12).all()
    assert (end != start).any(axis=0).sum() == 8  # all but the leader moved


def _watch_positions(settings: SwarmSettings, low: float, high: float) -> list[FloatArray]:
    positions: list[FloatArray] = []

    def record_position(x: FloatArray) -> FloatArray:
        positions.append(x.copy())
        return bowl(x)

    minimize(record_position, np.full(2, low), np.full(2, high), settings, np.random.default_rng(8))
    return positions


def test_a_coefficient_changes_evenly_from_the_first_iteration_to_the_last() -> None:
    """Inertia alone: each step of a free particle is the coefficient times the step before."""
    none = (0.0, 0.0)
    settings = SwarmSettings(40, 5, inertia=(1.0, 0.5), own_best=none, best_of_all=none)
    steps = np.diff(np.array(_watch_positions(settings, -1.0, 1.0)), axis=0)
    # Particles that no wall has stopped.
    free = (np.abs(np.array(_watch_positions(settings, -1.0, 1.0))) < 1.0).all(axis=0)
    assert free.any()
    for k in range(1, 5):
        assert steps[k][free] == pytest.approx((1.0 - 0.5 * k / 5) * steps[k - 1][free])


def test_a_wall_stops_a_particle() -> None:
    """It does not go on pushing outwards: the next pull of the leader moves it inwards."""
    none = (0.0, 0.0)
    settings = SwarmSettings(40, 2, inertia=(1.0, 1.0), own_best=none, best_of_all=(0.0, 2.0))
    start, first, second = _watch_positions(settings, -1.0, 1.0)
    best = np.where(bowl(first) < bowl(start), bowl(first), bowl(start))
    where = np.where(bowl(first) < bowl(start), first, start)
    leader = where[:, [int(np.argmin(best))]]
    # Stopped at a wall, with the leader inside of it.
    stopped = (np.abs(first) == 1.0) & (np.abs(leader) < 1.0)
    assert stopped.any()
    assert (np.abs(second[stopped]) < 1.0).all()


def test_progress_adds_up_to_the_whole() -> None:
    shares: list[float] = []
    minimize(bowl, LOW, HIGH, SwarmSettings(iterations=7), np.random.default_rng(1), shares.append)
    assert sum(shares) == pytest.approx(1.0)
