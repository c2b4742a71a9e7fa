"""The batch flies as the one robot of `tfsat_host.dynamics` does, each sample with parameters of its own."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.plan.sensitivity.studies import RATE_RAD_S, STROKES, parameters_of, stated_by, study_of
from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import (
    Multibody,
    TimedMove,
    history_from_moves,
    path_rotation,
    propagate,
    quaternion,
    rotation_angle_rad,
)
from tfsat_host.dynamics.propagate_within import final_attitudes
from tfsat_host.plan.parameters import Parameters, Plan, PlannedStroke
from tfsat_host.robot import RobotModel


def _apart_deg(first: FloatArray, other: FloatArray) -> float:
    return float(np.degrees(quaternion.angle(quaternion.product(quaternion.inverse(first), other))))


def _final(parameters: Parameters, vectors: FloatArray) -> FloatArray:
    history = parameters.history(vectors)
    return final_attitudes(parameters.robots(vectors), history).quaternion[:, 0]


@pytest.mark.parametrize("rate_deg_s", [None, (0.5, -2.0, 3.0), (40.0, 20.0, -30.0)])
def test_each_sample_flies_as_propagate_flies_it_alone(
    robot: RobotModel, rate_deg_s: tuple[float, float, float] | None
) -> None:
    study = study_of(robot, replace(stated_by(robot), servo_speed_relative=0.15), samples=3, seed=3)
    rate = None if rate_deg_s is None else np.radians(rate_deg_s)
    vectors = study.vectors(study.deviates(0))
    bodies, moves = study.parameters.robots(vectors), study.parameters.motion(vectors)
    together, error_rad = final_attitudes(bodies, study.parameters.history(vectors), initial_rate_rad_s=rate)
    assert np.degrees(error_rad) < 1e-4
    # A drawn servo may be faster than the file's greatest rate, which binds `moved`.
    servos = tuple(replace(servo, max_rate_rad_s=math.inf) for servo in robot.servos)
    unbound, late = replace(robot, servos=servos), 0
    for i in range(len(vectors)):
        alone = Multibody.of(robot).replace(
            mass_kg=bodies.mass_kg[i],
            com_m=bodies.com_m[i],
            inertia_kg_m2=bodies.inertia_kg_m2[i],
            joint_axis=bodies.joint_axis[i],
            joint_point_m=bodies.joint_point_m[i],
        )
        angle, timed = np.zeros(robot.n_joints), []
        for k, stroke in enumerate(STROKES):
            reached = np.radians(vectors[i, study.parameters.part["stroke_end"]][k])
            size = reached - angle[stroke.joint]
            timed.append(TimedMove(stroke.joint, size, moves.start_s[k, i], moves.end_s[k, i]))
            angle[stroke.joint] = reached
        late += bool((moves.end_s[:-1, i] > moves.start_s[1:, i]).any())
        history = history_from_moves(unbound, timed, end_s=max(2.5, float(moves.end_s[:, i].max())))
        flight = propagate(alone, history, initial_rate_rad_s=rate, step_s=5e-3, order=6)
        assert _apart_deg(flight.quaternion_xyzw[-1], together[:, i]) < 1e-4
    assert late, "no sample has two joints in motion at once"


def test_a_robot_without_errors_ends_where_the_path_of_its_strokes_leads(robot: RobotModel) -> None:
    parameters = parameters_of(robot)
    nominal = parameters.nominal[None]
    attitude = _final(parameters, nominal)
    path = path_rotation(
        Multibody.of(robot), [s.joint for s in STROKES], np.array([s.delta_rad for s in STROKES])
    )
    assert _apart_deg(attitude, path) < 2e-5
    assert np.degrees(rotation_angle_rad(attitude)) == pytest.approx(26.1058, abs=1e-4)


def test_a_joint_still_on_its_way_begins_its_next_stroke_when_it_has_arrived(robot: RobotModel) -> None:
    strokes = [PlannedStroke(0, 1.0, 0.7), PlannedStroke(0, -1.0, 0.8)]
    parameters = type(parameters_of(robot)).of(robot, Plan.of(robot, strokes, RATE_RAD_S))
    moves = parameters.motion(parameters.nominal[None])
    assert moves.start_s[1, 0] == moves.end_s[0, 0] == pytest.approx(0.7 + 1.0 / RATE_RAD_S)


def test_a_stroke_of_no_angle_takes_no_time_and_moves_nothing(robot: RobotModel) -> None:
    parameters = parameters_of(robot)
    vector = parameters.nominal.copy()
    vector[parameters.part["stroke_end"]] = 0.0
    moves = parameters.motion(vector[None])
    assert (moves.end_s - moves.start_s).sum() == pytest.approx(0.0, abs=1e-8)
    assert np.array_equal(_final(parameters, vector[None]), [0.0, 0.0, 0.0, 1.0])


def test_where_the_bound_of_steps_is_hit_the_error_says_so(robot: RobotModel) -> None:
    parameters, fast = parameters_of(robot), np.radians([80.0, 60.0, 100.0])
    nominal = parameters.nominal[None]
    bodies, history = parameters.robots(nominal), parameters.history(nominal)
    exact = final_attitudes(bodies, history, initial_rate_rad_s=fast, tolerance_rad=1e-9).quaternion[:, 0]
    rough, error_rad = final_attitudes(bodies, history, initial_rate_rad_s=fast, steps_max=1)
    assert 1e-5 < _apart_deg(rough[:, 0], exact) < np.degrees(error_rad)
