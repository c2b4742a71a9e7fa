"""The vector holds the model, each parameter changes what it is named after, and units are those that people read."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.dynamics.random_robots import random_robot
from tests.plan.sensitivity.studies import RATE_RAD_S, parameters_of
from tfsat_host.dynamics import JointHistory, Multibody
from tfsat_host.plan.parameters import Parameters, Plan, PlannedStroke
from tfsat_host.robot import RobotModel

_ARRAYS = ("mass_kg", "com_m", "inertia_kg_m2", "joint_axis", "joint_point_m")


def _change_parameter(parameters: Parameters, name: str, by: float) -> tuple[Multibody, list[str]]:
    """Return the robot with one parameter changed, and the names of its arrays that differ."""
    vector = parameters.nominal.copy()
    vector[parameters.names.index(name)] += by
    multibody = parameters.robots(vector[None])
    return multibody, [
        key
        for key in _ARRAYS
        if not np.allclose(getattr(multibody, key)[0], getattr(parameters.body, key), rtol=1e-12, atol=1e-15)
    ]


def test_the_nominal_vector_is_the_model(robot: RobotModel) -> None:
    parameters = parameters_of(robot)
    multibody, reference = parameters.robots(parameters.nominal[None]), Multibody.of(robot)
    for key in _ARRAYS:
        np.testing.assert_allclose(
            getattr(multibody, key)[0], getattr(reference, key), rtol=1e-14, atol=1e-18
        )


def test_so_it_is_for_any_tree(tmp_path: Path) -> None:
    robot = random_robot(tmp_path, 7, 5)
    parameters = Parameters.of(robot, Plan.of(robot, [PlannedStroke(2, 0.3, 0.1)], RATE_RAD_S))
    multibody = parameters.robots(parameters.nominal[None])
    np.testing.assert_allclose(multibody.joint_axis[0], robot.joint_axis, atol=1e-15)
    np.testing.assert_allclose(multibody.inertia_kg_m2[0], robot.inertia_kg_m2, atol=1e-18)
    assert len(set(parameters.names)) == len(parameters.names) == 10 * 5 + 5 * 4 + 1 + 3


@pytest.mark.parametrize(
    ("name", "array", "index", "by", "change"),
    [
        ("body 2 mass", "mass_kg", (1,), 0.1, 0.1),
        ("body 3 CoM y", "com_m", (2, 1), 2.0, 2e-3),
        ("body 1 inertia zz", "inertia_kg_m2", (0, 2, 2), 0.5, 0.5e-3),
        ("body 4 inertia yz", "inertia_kg_m2", (3, 1, 2), 0.01, 1e-5),
        ("joint 1 point z", "joint_point_m", (0, 2), 3.0, 3e-3),
        ("joint 2 point x", "joint_point_m", (1, 0), 3.0, 3e-3),
    ],
)
def test_a_parameter_changes_what_it_is_named_after(
    robot: RobotModel, name: str, array: str, index: tuple[int, ...], by: float, change: float
) -> None:
    parameters = parameters_of(robot)
    multibody, differ = _change_parameter(parameters, name, by)
    assert differ == [array]
    difference = getattr(multibody, array)[0] - getattr(parameters.body, array)
    assert difference[index] == pytest.approx(change)
    twin = difference[(index[0], *index[:0:-1])] if array == "inertia_kg_m2" else difference[index]
    assert twin == difference[index]
    assert np.count_nonzero(np.abs(difference) > 1e-15) == (2 if name.endswith("yz") else 1)


def test_a_tilt_turns_the_axis_about_the_direction_that_it_names(robot: RobotModel) -> None:
    multibody, differ = _change_parameter(parameters_of(robot), "joint 1 tilt about y", 2.0)
    assert differ == ["joint_axis"]
    turn = np.radians(2.0)
    np.testing.assert_allclose(multibody.joint_axis[0, 0], [np.cos(turn), 0.0, -np.sin(turn)], atol=1e-15)


def test_directions_across_any_axis_are_perpendicular_to_it_and_to_each_other(tmp_path: Path) -> None:
    robot = random_robot(tmp_path, 11, 5)
    parameters = Parameters.of(robot, Plan.of(robot, [PlannedStroke(0, 0.3, 0.1)], RATE_RAD_S))
    frames = np.concatenate([robot.joint_axis[:, None], parameters.across], axis=1)
    np.testing.assert_allclose(frames @ frames.swapaxes(1, 2), np.tile(np.eye(3), (4, 1, 1)), atol=1e-14)


def test_ends_of_strokes_and_speeds_are_in_degrees(robot: RobotModel) -> None:
    parameters = parameters_of(robot)
    vector = parameters.nominal.copy()
    vector[parameters.names.index("stroke 1 end (joint 1)")] = 54.8
    vector[parameters.names.index("joint 1 speed")] = 137.0
    moves = parameters.motion(vector[None])
    batch = parameters.history(vector[None])
    history = JointHistory(batch.breaks_s[:, 0] + 1e-12 * np.arange(18), batch.coefficients[..., 0])
    np.testing.assert_allclose(
        np.degrees(history.angles_rad(np.array([1.3, 2.5]))),
        [[54.8, 70.0 * _completed_share(1.3), 0.0], [0.0, 0.0, 0.0]],
        atol=1e-8,
    )
    assert moves.end_s[0, 0] - moves.start_s[0, 0] == pytest.approx(54.8 / 137.0)


def _completed_share(t_s: float) -> float:
    """Return the completed share of the second stroke, from its constant rate and symmetry in time."""
    duration, acceleration = 70.0 / 170.0, 4000.0
    ramp = 0.5 * duration * (1.0 - np.sqrt(1.0 - 4.0 * 70.0 / (acceleration * duration**2)))
    return float(acceleration * ramp * (t_s - 1.05 - 0.5 * ramp) / 70.0)
