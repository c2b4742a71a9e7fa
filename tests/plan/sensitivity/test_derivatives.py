"""Derivatives against other steps, and against an independent model that shares no equation with ours."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from tests.dynamics.chain_driver import Robot
from tests.dynamics.reference import free_attitude
from tests.plan.sensitivity.studies import EXACT, RATE_RAD_S, parameters_of, stated_by
from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import TimedMove, history_from_moves
from tfsat_host.plan.error_sources import error_sources
from tfsat_host.plan.parameters import Parameters, Plan, PlannedStroke
from tfsat_host.plan.spread import derivatives, linear_spread
from tfsat_host.robot import RobotModel

_SPIN = np.radians([1.0, -2.0, 3.0])
_UNTIL_S = 0.9
_STROKES = (PlannedStroke(0, np.radians(59.0), 0.05), PlannedStroke(1, np.radians(70.0), 0.40))


@pytest.mark.parametrize("rate", [None, _SPIN])
def test_derivatives_do_not_depend_on_the_step(robot: RobotModel, rate: FloatArray | None) -> None:
    parameters = parameters_of(robot, rate)
    partials, halved = derivatives(parameters), derivatives(parameters, step_scale=0.5)
    scale = np.abs(partials.of_attitude).max(axis=1, keepdims=True) + 1e-3
    assert (np.abs(partials.of_attitude - halved.of_attitude) < 1e-6 * scale).all()
    assert (np.abs(partials.of_rotation_vector - halved.of_rotation_vector) < 1e-6 * scale).all()


def _reference_vector_deg(robot: RobotModel, changed: Robot, ends_deg: FloatArray) -> FloatArray:
    """Compute the rotation vector with the independent model.

    Both kinds of history are trapezoids of the same servo.
    """
    angle, moves = np.zeros(3), []
    for stroke, end_deg in zip(_STROKES, ends_deg, strict=True):
        delta = np.radians(end_deg) - angle[stroke.joint]
        moves.append(TimedMove(stroke.joint, delta, stroke.start_s, stroke.start_s + abs(delta) / RATE_RAD_S))
        angle[stroke.joint] += delta
    history = history_from_moves(robot, moves, end_s=_UNTIL_S)

    def joints(t_s: float) -> tuple[FloatArray, FloatArray]:
        return history.angles_rad(np.array(t_s)), history.rates_rad_s(np.array(t_s))

    return np.asarray(np.degrees(free_attitude(changed, joints, _UNTIL_S, _SPIN, rtol=1e-8).as_rotvec()))


def _shift_entry(array: FloatArray, index: tuple[int, ...], by: float) -> FloatArray:
    changed = array.copy()
    changed[index] += by
    return changed


def _tensor(array: FloatArray, body: int, i: int, k: int, by: float) -> FloatArray:
    changed = _shift_entry(array, (body, i, k), by)
    changed[body, k, i] = changed[body, i, k]
    return changed


_CHANGES: dict[str, tuple[float, Callable[[Robot, float], Robot]]] = {
    "body 2 mass": (0.01, lambda r, by: replace(r, mass=_shift_entry(r.mass, (1,), by))),
    "body 1 CoM z": (1.0, lambda r, by: replace(r, com=_shift_entry(r.com, (0, 2), 1e-3 * by))),
    "body 3 inertia xy": (0.1, lambda r, by: replace(r, inertia=_tensor(r.inertia, 2, 0, 1, 1e-3 * by))),
    "joint 2 point z": (1.0, lambda r, by: replace(r, point=_shift_entry(r.point, (1, 2), 1e-3 * by))),
    "joint 1 tilt about z": (
        0.5,
        lambda r, by: replace(
            r,
            axis=np.vstack([[np.cos(np.radians(by)), np.sin(np.radians(by)), 0.0], r.axis[1:]]),
        ),
    ),
    "stroke 2 end (joint 2)": (0.2, lambda r, _by: r),
}


_QUICK = ("joint 1 tilt about z", "stroke 2 end (joint 2)")


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=() if name in _QUICK else pytest.mark.prove) for name in _CHANGES],
)
def test_derivatives_agree_with_an_independent_model(robot: RobotModel, name: str) -> None:
    plan = Plan.of(robot, _STROKES, RATE_RAD_S, until_s=_UNTIL_S)
    parameters = Parameters.of(robot, plan, _SPIN)
    step, change = _CHANGES[name]
    ends = np.degrees(parameters.plan.stop_rad)
    vectors = []
    for by in (-step, step):
        moved_end = by if name.startswith("stroke 2") else 0.0
        reached = _shift_entry(ends, (1,), moved_end)
        vectors.append(_reference_vector_deg(robot, change(Robot.of(robot), by), reached))
    slope = (vectors[1] - vectors[0]) / (2.0 * step)
    partials = derivatives(parameters)
    index = parameters.names.index(name)
    np.testing.assert_allclose(
        partials.of_rotation_vector[index], slope, atol=1e-3 * float(np.abs(slope).max())
    )
    middle = (np.linalg.norm(vectors[1]) - np.linalg.norm(vectors[0])) / (2.0 * step)
    assert partials.of_reorientation[index] == pytest.approx(middle, abs=1e-3 * float(np.abs(slope).max()))


def test_a_path_there_and_back_turns_nothing_and_still_has_slopes(robot: RobotModel) -> None:
    strokes = [PlannedStroke(0, 0.8, 0.7), PlannedStroke(0, -0.8, 1.2)]
    partials = derivatives(Parameters.of(robot, Plan.of(robot, strokes, RATE_RAD_S)))
    assert partials.reorientation_deg < 1e-6
    assert np.isfinite(partials.of_rotation_vector).all()
    end = Parameters.of(robot, Plan.of(robot, strokes, RATE_RAD_S)).names.index("stroke 2 end (joint 1)")
    assert partials.of_reorientation[end] == pytest.approx(
        float(np.linalg.norm(partials.of_rotation_vector[end]))
    )
    assert partials.of_reorientation[end] > 0.1


def test_squares_of_the_sources_add_up_to_the_whole(robot: RobotModel) -> None:
    parameters = parameters_of(robot)
    spread = linear_spread(derivatives(parameters), error_sources(parameters, stated_by(robot)))
    assert np.linalg.norm(spread.of_sources_deg) == pytest.approx(spread.reorientation_deg)
    assert spread.shares.sum() == pytest.approx(1.0)
    assert spread.attitude_deg >= spread.reorientation_deg


def test_a_model_without_errors_has_no_spread(robot: RobotModel) -> None:
    parameters = parameters_of(robot)
    spread = linear_spread(derivatives(parameters), error_sources(parameters, EXACT))
    assert spread.reorientation_deg == spread.attitude_deg == 0.0
    assert not spread.shares.any()
