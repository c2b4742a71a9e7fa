"""The integration is of the order that it states, and converges to what an independent integrator finds."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.dynamics.chain_driver import Robot
from tests.dynamics.histories import PolynomialHistory
from tests.dynamics.random_robots import random_robot
from tests.dynamics.reference import free_attitude, rate_without_momentum
from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import Multibody, TimedMove, history_from_moves, propagate, stroke_rotation
from tfsat_host.robot import RobotModel, load_robot

Order = Literal[4, 6]
STEPS = (64, 128, 256)
ROUNDING_DEG = 1e-12


def angle_deg(a: FloatArray, b: FloatArray) -> float:
    return float(np.degrees((Rotation.from_quat(a) * Rotation.from_quat(b).inv()).magnitude()))


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> RobotModel:
    return random_robot(tmp_path_factory.mktemp("robot"), 41, 5)


@pytest.fixture(scope="module")
def history() -> PolynomialHistory:
    return PolynomialHistory(np.random.default_rng(42), 4, duration_s=1.0)


def end(
    robot: RobotModel, history: PolynomialHistory, rate: FloatArray | None, n: int, order: Order
) -> FloatArray:
    flight = propagate(
        Multibody.of(robot),
        history.joint_history(),
        initial_rate_rad_s=rate,
        step_s=history.duration_s / n,
        order=order,
    )
    assert len(flight.t_s) == n + 1
    return np.asarray(flight.quaternion_xyzw[-1])


@pytest.mark.parametrize("rate", [None, np.array([0.9, -1.4, 1.1])], ids=["no momentum", "turning"])
@pytest.mark.parametrize("order", [4, 6])
def test_halving_the_step_divides_the_error_by_two_to_the_order(
    robot: RobotModel, history: PolynomialHistory, order: Order, rate: FloatArray | None
) -> None:
    limit = end(robot, history, rate, 512, 6)
    errors = np.array([angle_deg(end(robot, history, rate, n, order), limit) for n in STEPS])
    # Above the rounding error, or the order would be noise.
    assert errors[-1] > 5 * ROUNDING_DEG
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx([order, order], abs=0.2)


@pytest.mark.parametrize("rate", [None, np.array([0.9, -1.4, 1.1])], ids=["no momentum", "turning"])
def test_the_limit_is_the_independent_references(
    robot: RobotModel, history: PolynomialHistory, rate: FloatArray | None
) -> None:
    arrays = Robot.of(robot)
    released = rate_without_momentum(arrays, *history(0.0)) if rate is None else rate
    expected = free_attitude(arrays, history, 1.0, released)
    # The independent reference integrates to 1e-11.
    assert angle_deg(end(robot, history, rate, 512, 6), expected.as_quat()) < 1e-8


def test_jumping_rates_cost_no_order() -> None:
    robot = load_robot()
    moves = [TimedMove(0, 1.0, 0.013, 0.351), TimedMove(1, 1.2, 0.29, 0.77), TimedMove(0, -1.0, 0.6, 0.95)]
    history, body = history_from_moves(robot, moves, end_s=1.0), Multibody.of(robot)
    ends = [
        propagate(
            body, history, initial_rate_rad_s=np.array([0.2, 0.5, -0.3]), step_s=step_s
        ).quaternion_xyzw[-1]
        for step_s in (0.04, 0.02, 0.01, 0.00125)
    ]
    errors = [angle_deg(e, ends[-1]) for e in ends[:-1]]
    # Jumping rates end steps: the integration sees none of them.
    assert np.log2(errors[0] / errors[2]) / 2 == pytest.approx(4.0, abs=0.6)


def test_a_strokes_rotation_is_of_order_six(robot: RobotModel) -> None:
    body, start = Multibody.of(robot), np.array([0.3, -0.7, 0.5, 1.0])
    rotations = [stroke_rotation(body, 1, start, np.array(1.5), steps=steps) for steps in (2, 4, 8, 64)]
    errors = [angle_deg(q, rotations[-1]) for q in rotations[:-1]]
    assert errors[-1] > 5 * ROUNDING_DEG
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx([6.0, 6.0], abs=0.7)
