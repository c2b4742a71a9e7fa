"""The paper's two examples of joint paths, and other strokes: what they do, and which body sees it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.dynamics.chain_driver import Robot
from tests.dynamics.random_robots import random_robot
from tests.dynamics.reference import free_attitude, rate_without_momentum
from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import (
    Flight,
    Multibody,
    TimedMove,
    history_from_moves,
    path_rotation,
    poses,
    propagate,
    stroke_rotation,
)
from tfsat_host.robot import RobotModel, load_robot

Strokes = Sequence[tuple[int, float]]

A, B = np.radians(58.75), np.radians(70.29)
REORIENTS: Strokes = [(0, A), (1, B), (0, -A), (1, -B)]
CANCELS: Strokes = [(0, A), (1, B), (1, -B), (0, -A)]
OPEN: Strokes = [(0, A), (1, B), (2, 0.4)]
BODIES = range(4)


def net(robot: RobotModel, strokes: Strokes, base: int | None = None) -> Rotation:
    joints, deltas = zip(*strokes, strict=True)
    return Rotation.from_quat(path_rotation(Multibody.of(robot, base), joints, np.array(deltas)))


def fly_strokes(robot: RobotModel, strokes: Strokes, base: int | None = None) -> Flight:
    """Half a second a stroke, from rest to rest."""
    moves = [TimedMove(joint, delta, 0.5 * k, 0.5 * k + 0.4) for k, (joint, delta) in enumerate(strokes)]
    return propagate(Multibody.of(robot, base), history_from_moves(robot, moves), order=6)


def end_of(flight: Flight, body: int) -> Rotation:
    return Rotation.from_matrix(flight.attitude(body)[-1])


def degrees(rotation: Rotation) -> float:
    return float(np.degrees(rotation.magnitude()))


def five_bodies(folder: Path, seed: int) -> RobotModel:
    return random_robot(folder, seed, 5)


def test_the_papers_first_path_reorients_every_body_by_26_11_degrees() -> None:
    robot = load_robot()
    by_strokes, flight = net(robot, REORIENTS), fly_strokes(robot, REORIENTS)
    assert degrees(by_strokes) == pytest.approx(26.11, abs=0.005)
    for body in BODIES:
        assert degrees(end_of(flight, body) * by_strokes.inv()) < 1e-4
    vector_deg = np.degrees(by_strokes.as_rotvec())
    assert vector_deg == pytest.approx([-0.549, 0.373, -26.104], abs=0.002)  # almost about z, as in the paper


def test_the_papers_second_path_cancels_exactly() -> None:
    robot = load_robot()
    assert degrees(net(robot, CANCELS)) < 1e-9
    flight = fly_strokes(robot, CANCELS)
    for body in BODIES:
        assert degrees(end_of(flight, body)) < 1e-9
    halfway = Rotation.from_quat(flight.quaternion_xyzw[np.searchsorted(flight.t_s, 0.95)])
    assert degrees(halfway) > 20.0  # what is cancelled


@pytest.mark.parametrize("seed", range(4))
def test_any_path_that_is_retraced_cancels(tmp_path: Path, seed: int) -> None:
    robot, rng = five_bodies(tmp_path, seed), np.random.default_rng(seed)
    there = [(int(rng.integers(4)), float(rng.uniform(-1.5, 1.5))) for _ in range(6)]
    back = [(joint, -delta) for joint, delta in reversed(there)]
    assert degrees(net(robot, there)) > 1.0
    assert degrees(net(robot, [*there, *back])) < 1e-9


@pytest.mark.parametrize("seed", range(4))
def test_after_a_closed_loop_every_base_body_sees_the_same_rotation(tmp_path: Path, seed: int) -> None:
    robot, rng = five_bodies(tmp_path, seed), np.random.default_rng(seed)
    first, second = (int(j) for j in rng.permutation(4)[:2])
    a, b = rng.uniform(0.5, 1.5, 2)
    loop = [(first, a), (second, b), (first, -a), (second, -b)]
    rotations = [net(robot, loop, base) for base in range(5)]
    assert degrees(rotations[0]) > 0.1
    for rotation in rotations[1:]:
        assert degrees(rotation * rotations[0].inv()) < 1e-4


@pytest.mark.parametrize("base", BODIES)
def test_after_an_open_path_the_base_bodies_differ_by_the_joint_angles(base: int) -> None:
    robot = load_robot()
    angles = np.array([A, B, 0.4])
    relative, _ = poses(Multibody.of(robot), angles)  # to the robot's own base
    rotation, by_own_base = net(robot, OPEN, base), net(robot, OPEN)
    assert degrees(rotation * (by_own_base * Rotation.from_matrix(relative[base])).inv()) < 1e-4
    assert degrees(rotation * end_of(fly_strokes(robot, OPEN), base).inv()) < 1e-4
    if base != robot.base:
        assert degrees(rotation * by_own_base.inv()) > 10.0


@pytest.mark.parametrize("base", range(5))
def test_a_flight_is_the_same_from_whichever_body_it_is_seen(tmp_path: Path, base: int) -> None:
    robot = five_bodies(tmp_path, 5)
    history = history_from_moves(
        robot, [TimedMove(0, 1.0, 0.1, 0.6), TimedMove(2, -1.2, 0.3, 0.9)], end_s=1.0
    )
    rate = np.array([0.8, -0.5, 1.1])  # of every body: the joints are at rest at first
    flight = propagate(Multibody.of(robot), history, initial_rate_rad_s=rate, order=6)
    other = propagate(Multibody.of(robot, base), history, initial_rate_rad_s=rate, order=6)
    assert other.attitude() == pytest.approx(flight.attitude(base), abs=1e-8)
    assert other.momentum() == pytest.approx(flight.momentum(), abs=1e-12)
    assert other.kinetic_energy_j() == pytest.approx(flight.kinetic_energy_j(), rel=1e-8)


@pytest.mark.parametrize("seed", range(4))
def test_single_strokes_from_any_pose_turn_the_base_as_the_reference_says(tmp_path: Path, seed: int) -> None:
    robot, rng = five_bodies(tmp_path, seed), np.random.default_rng(100 + seed)
    body, arrays = Multibody.of(robot), Robot.of(robot)
    start, delta = rng.uniform(-1.5, 1.5, 4), float(rng.uniform(-1.5, 1.5))
    for joint in range(4):
        rates = delta * np.eye(4)[joint]

        def ramp(t: float, rates: FloatArray = rates) -> tuple[FloatArray, FloatArray]:
            return start + t * rates, rates

        at_release = rate_without_momentum(arrays, start, rates)
        expected = free_attitude(arrays, ramp, 1.0, at_release)
        rotation = Rotation.from_quat(stroke_rotation(body, joint, start, np.array(delta)))
        assert degrees(rotation * expected.inv()) < 1e-3


def test_a_batch_of_robots_and_strokes_is_each_of_them(tmp_path: Path) -> None:
    robot, rng = five_bodies(tmp_path, 9), np.random.default_rng(9)
    body, joints = Multibody.of(robot), [0, 2, 3, 0, 1]
    masses, deltas = rng.uniform(0.2, 1.5, (6, 5)), rng.uniform(-1.5, 1.5, (6, 5))
    together = path_rotation(body.replace(mass_kg=masses), joints, deltas, steps=2)
    for mass, delta, rotation in zip(masses, deltas, together, strict=True):
        alone = path_rotation(body.replace(mass_kg=mass), joints, delta, steps=2)
        assert rotation == pytest.approx(alone, abs=1e-14)
