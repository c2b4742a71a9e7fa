"""The chain in free fall against the paper's numbers and an independent reference."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.dynamics.chain_driver import Robot, Script, Shown
from tests.dynamics.histories import SineHistory
from tests.dynamics.random_robots import random_tree
from tests.dynamics.reference import free_attitude
from tfsat_host.arrays import FloatArray

G = 9.80665


def fly_strokes(probe: Path, robot: Robot, strokes_deg: Sequence[tuple[int, float]]) -> list[Rotation]:
    """Net rotation of every body after strokes (joint index, angle) from zero angles, at rest at first."""
    script = Script(robot)
    script.release()
    n = len(robot.inner)
    angle = np.zeros(n)
    for joint, stroke_deg in strokes_deg:
        start = angle.copy()
        for phase in np.linspace(0.0, np.pi, 101)[1:]:  # from rest to rest in 0.4 s
            rate = np.zeros(n)
            angle[joint] = start[joint] + np.radians(stroke_deg) * 0.5 * (1 - np.cos(phase))
            # From rest to rest along half a cosine.
            rate[joint] = np.radians(stroke_deg) * 0.5 * np.sin(phase) * np.pi / 0.4
            script.step(0.004, angle, rate, np.zeros(n))
    for body in range(len(robot.mass)):
        script.show(body)
    return [Rotation.from_quat(state.quaternion) for state in script.run(probe)]


def test_the_paper_maneuver_reorients_every_body_by_26_11_degrees(probe: Path, drop_tower: Robot) -> None:
    strokes = [(0, 58.75), (1, 70.29), (0, -58.75), (1, -70.29)]
    rotations = fly_strokes(probe, drop_tower, strokes)
    for rotation in rotations:
        assert np.degrees(rotation.magnitude()) == pytest.approx(26.11, abs=0.005)
        # All bodies turn together: the maneuver is closed.
        assert np.degrees((rotation * rotations[0].inv()).magnitude()) < 1e-6
    vector = np.degrees(rotations[2].as_rotvec())
    assert vector == pytest.approx([-0.549, 0.373, -26.104], abs=0.002)  # almost about z, as in the paper


def test_the_reversed_maneuver_gives_the_inverse_rotation(probe: Path, drop_tower: Robot) -> None:
    there = fly_strokes(probe, drop_tower, [(0, 59), (1, 70), (0, -59), (1, -70)])[2]
    back = fly_strokes(probe, drop_tower, [(1, 70), (0, 59), (1, -70), (0, -59)])[2]
    assert np.degrees((there * back).magnitude()) < 1e-6


def test_a_path_that_is_retraced_cancels(probe: Path, drop_tower: Robot) -> None:
    for rotation in fly_strokes(probe, drop_tower, [(0, 59), (1, 70), (1, -70), (0, -59)]):
        assert np.degrees(rotation.magnitude()) < 1e-9


def fly(
    probe: Path, robot: Robot, history: SineHistory, base_rate: FloatArray, steps: int, show: Sequence[int]
) -> list[Shown]:
    """Simulate one second of free fall in equal steps.

    Shows body 0 at (10, 20, 30) mm after each step in `show`.
    """
    script = Script(robot)
    script.step(1e-3, *history.all(0.0))  # still held: brings the joints to where they start
    script.say("place", [0, 0, 0, 1], [0, 0, 0])
    script.hold(robot.base)
    script.step(1e-3, *history.all(0.0))
    script.release(base_rate, (0.007, 0.0, -0.04))
    for k in range(1, steps + 1):
        script.step(1.0 / steps, *history.all(k / steps))
        if k in show:
            script.show(robot.base)
            script.show(0, (0.01, 0.02, 0.03))
    return script.run(probe)


@pytest.mark.parametrize("seed", range(4))
def test_random_trees_turn_as_the_reference_says(probe: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    robot = random_tree(rng, 2 + seed)
    history = SineHistory(rng, 1 + seed)
    # Seed 0 has no momentum at all.
    base_rate = rng.normal(size=3) * (0.0 if seed == 0 else 0.5)
    base, _ = fly(probe, robot, history, base_rate, 1000, [1000])
    expected = free_attitude(robot, history, 1.0, base_rate)
    error = (Rotation.from_quat(base.quaternion) * expected.inv()).magnitude()
    assert np.degrees(error) < 1e-6


def test_the_integration_is_of_fourth_order(probe: Path) -> None:
    rng = np.random.default_rng(7)
    robot, history, base_rate = random_tree(rng, 4), SineHistory(rng, 3), np.array([0.4, -0.3, 0.5])
    expected = free_attitude(robot, history, 1.0, base_rate)
    errors = []
    for steps in (20, 40, 80):
        base, _ = fly(probe, robot, history, base_rate, steps, [steps])
        errors.append((Rotation.from_quat(base.quaternion) * expected.inv()).magnitude())
    # Halving the step divides the error by sixteen.
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > 3.6).all()
    assert (orders < 5.0).all()


def test_momentum_is_kept_and_accelerations_are_derivatives(probe: Path) -> None:
    rng = np.random.default_rng(11)
    robot, history = random_tree(rng, 5), SineHistory(rng, 4)
    around = [499, 500, 501]
    states = fly(probe, robot, history, np.array([0.2, 0.1, -0.3]), 1000, [1, *around, 1000])
    momenta = np.array([s.momentum for s in states])
    # Momentum to rounding, over a thousand steps.
    assert np.abs(momenta - momenta[0]).max() < 1e-12 * max(1.0, np.abs(momenta[0]).max())
    before, now, after = states[3], states[5], states[7]
    derivative = (after.rate - before.rate) / 2e-3
    assert now.angular_acceleration == pytest.approx(derivative, rel=1e-3, abs=1e-3)
    assert now.velocity == pytest.approx((after.position - before.position) / 2e-3, rel=1e-4, abs=1e-4)
    derivative = (after.velocity - before.velocity) / 2e-3
    assert now.acceleration == pytest.approx(derivative, rel=1e-3, abs=1e-3)
    # An accelerometer does not feel gravity: what it reads is the rest, in its body's frame.
    felt = Rotation.from_quat(now.quaternion).inv().apply(now.acceleration + np.array([0, 0, G]))
    assert now.specific_force == pytest.approx(felt, abs=1e-9)


def test_a_robot_at_rest_feels_nothing_in_free_fall(probe: Path, drop_tower: Robot) -> None:
    script = Script(drop_tower)
    script.release((0, 0, 0), (0.0, 0.0, -0.04))
    for _ in range(50):
        script.step(0.01, np.zeros(3), np.zeros(3), np.zeros(3))
    script.show(0, (0.05, 0.05, 0.05))
    # Not even rounding: nothing acts on the robot.
    (state,) = script.run(probe)
    assert np.abs(state.specific_force).max() < 1e-12
    assert state.velocity == pytest.approx([0, 0, -0.04 - 9.80665 * 0.5])
    assert state.position[2] == pytest.approx(0.298 - 0.04 * 0.5 - 9.80665 * 0.125)
