"""Maneuvers and free rotation in Python: two ways to the same attitude, and what must be conserved."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.dynamics.random_robots import random_robot
from tests.dynamics.simulate.maneuvers import maneuver
from tfsat_host.dynamics import (
    JointHistory,
    history_from_samples,
)
from tfsat_host.dynamics.motion_files import body_attitudes, body_rates_rad_s
from tfsat_host.dynamics.simulation import Simulation, clip_history, fly, robot_limits
from tfsat_host.maneuver import Defect, ManeuverError, four_stroke, schedule_maneuver
from tfsat_host.robot import RobotModel, load_robot

THERE = ((1, 58.75), (2, 70.29), (1, -58.75), (2, -70.29))
BACK = tuple((joint, -angle_deg) for joint, angle_deg in reversed(THERE))
STRAY = ((4, 50.0), (1, -35.0), (3, 80.0), (4, -85.0), (2, 20.0))
RATE_RAD_S = np.radians([20.0, -35.0, 50.0])


def five_bodies(folder: Path) -> RobotModel:
    return random_robot(folder, 5, 5)


def fly_strokes(
    robot: RobotModel,
    *strokes: tuple[int, float],
    until_s: float = 6.0,
    base: int | None = None,
    rate_rad_s: np.ndarray[tuple[int, ...], np.dtype[np.float64]] | None = None,
    speed_deg_s: float = 170.0,
) -> Simulation:
    requested_maneuver = replace(maneuver(*strokes), speed_deg_s=speed_deg_s)
    schedule = schedule_maneuver(requested_maneuver, robot_limits(robot))
    return fly(robot, schedule, until_s=until_s, base=base, initial_rate_rad_s=rate_rad_s)


def final(simulation: Simulation) -> Rotation:
    return Rotation.from_quat(simulation.quaternion_xyzw)


def apart_deg(a: Rotation, b: Rotation) -> float:
    return float(np.degrees((a.inv() * b).magnitude()))


def test_the_papers_maneuver_turns_every_body_by_26_11_deg_about_z() -> None:
    simulation = fly_strokes(load_robot(), *THERE)
    # The axis tilts away from z by half a degree.
    assert np.degrees(final(simulation).as_rotvec()) == pytest.approx([0.0, 0.0, -26.11], abs=0.6)
    assert np.degrees(final(simulation).magnitude()) == pytest.approx(26.11, abs=0.005)
    assert simulation.is_closed
    for rotation in simulation.rotations():
        assert apart_deg(Rotation.from_matrix(rotation), final(simulation)) < 1e-6


def test_the_reversed_maneuver_gives_the_inverse_rotation() -> None:
    robot = load_robot()
    # The inverse rotation in the reversed order.
    assert apart_deg(final(fly_strokes(robot, *BACK)), final(fly_strokes(robot, *THERE)).inv()) < 1e-9
    assert np.degrees(final(fly_strokes(robot, *THERE, *BACK, until_s=9.0)).magnitude()) < 1e-9


def test_whichever_body_is_the_base_the_bodies_turn_alike_up_to_the_axes(tmp_path: Path) -> None:
    robot = five_bodies(tmp_path)
    turned = [
        np.degrees(Rotation.from_matrix(fly_strokes(robot, *STRAY, base=base).rotations()).magnitude())
        for base in range(5)
    ]
    # At the release all bodies' axes are parallel, so the inertial axes are the same for every base.
    # Angles are compared, not axes: bodies have different axes.
    assert np.ptp(turned, axis=0) == pytest.approx(np.zeros(5), abs=1e-6)
    assert np.ptp(turned[0]) > 5.0


def test_the_attitude_after_each_stroke_is_the_propagations_with_and_without_initial_rate() -> None:
    robot = load_robot()
    schedule = schedule_maneuver(four_stroke(58.75, 70.29))
    for rate in (None, RATE_RAD_S):
        simulation = fly(robot, schedule, until_s=2.5, initial_rate_rad_s=rate)
        flight = simulation.flight
        for stroke, attitude in zip(schedule.strokes, simulation.stroke_quaternions_xyzw, strict=True):
            at = int(np.flatnonzero(np.isclose(flight.t_s, stroke.end_us / 1e6, atol=1e-9))[0])
            assert (
                # The closed form and the propagation in time must agree after every stroke.
                apart_deg(Rotation.from_quat(attitude), Rotation.from_quat(flight.quaternion_xyzw[at])) < 1e-6
            )


def test_strokes_that_overlap_end_where_the_propagation_ends_and_not_where_the_path_leads(
    tmp_path: Path,
) -> None:
    robot = five_bodies(tmp_path)
    cut, parted = fly_strokes(robot, *STRAY), fly_strokes(robot, *STRAY, speed_deg_s=90.0)
    assert cut.strokes_overlap
    assert np.array_equal(cut.quaternion_xyzw, cut.flight.quaternion_xyzw[-1])
    # Overlapping strokes: no closed form can give this path.
    assert apart_deg(final(cut), final(parted)) > 1e-5


def test_body_rates_are_the_derivatives_of_the_bodies_attitudes(tmp_path: Path) -> None:
    robot = five_bodies(tmp_path)
    t_s = np.linspace(0.0, 1.0, 21)
    history = history_from_samples(t_s, np.sin(np.outer(t_s, [3.0, 4.0, 5.0, 6.0])))
    flight = fly(robot, history, until_s=1.0, initial_rate_rad_s=RATE_RAD_S, step_s=2e-3).flight
    attitudes, rates = body_attitudes(flight), body_rates_rad_s(flight)
    at = len(flight.t_s) // 2
    for body in range(5):
        turn = Rotation.from_matrix(attitudes[[at - 1, at + 1], body])
        mean = (turn[0].inv() * turn[1]).as_rotvec() / (flight.t_s[at + 1] - flight.t_s[at - 1])
        # The rate at a point against the difference quotient around it.
        assert rates[at, body] == pytest.approx(mean, abs=4e-4)


def test_a_sampled_maneuver_ends_where_its_strokes_end() -> None:
    robot = load_robot()
    strokes = fly_strokes(robot, *THERE, until_s=2.5)
    flight = strokes.flight
    again = fly(robot, history_from_samples(flight.t_s, flight.angles_rad), until_s=2.5)
    assert apart_deg(final(again), final(strokes)) < 1e-3


def test_joints_are_held_before_and_after_a_history() -> None:
    history = JointHistory(np.array([1.0, 2.0]), np.array([[[1.0]], [[0.5]]]))
    longer = clip_history(history, 0.0, 3.0)
    # A rate of one for a second, then held.
    assert longer.breaks_s.tolist() == [0.0, 1.0, 2.0, 3.0]
    t_s = np.array([0.0, 0.9, 1.5, 2.1, 3.0])
    assert longer.angles_rad(t_s)[:, 0] == pytest.approx([0.5, 0.5, 1.0, 1.5, 1.5])
    assert longer.rates_rad_s(t_s)[:, 0] == pytest.approx([0.0, 0.0, 1.0, 0.0, 0.0])
    assert clip_history(history, 1.0, 2.0).breaks_s.tolist() == [1.0, 2.0]


def test_a_robots_own_joints_bound_its_maneuvers(tmp_path: Path) -> None:
    limits = robot_limits(five_bodies(tmp_path))
    assert limits.joint_ranges_cdeg == ((-9000, 9000),) * 4
    schedule_maneuver(maneuver((4, -90.0), *[(1, 5.0)] * 18), limits)
    for strokes, defect in (
        (((5, 10.0),), Defect.UNKNOWN_JOINT),
        (((4, -60.0), (4, -31.0)), Defect.JOINT_RANGE),
    ):
        with pytest.raises(ManeuverError) as caught:
            schedule_maneuver(maneuver(*strokes), limits)
        assert caught.value.code == defect
    with pytest.raises(ManeuverError, match="the robot has joints 1 to 3"):
        schedule_maneuver(maneuver((4, 10.0)))


def test_a_maneuver_starts_in_the_start_pose_of_the_servos(tmp_path: Path) -> None:
    robot = five_bodies(tmp_path)
    servos = tuple(replace(servo, start_rad=np.radians(30.0)) for servo in robot.servos)
    robot = replace(robot, servos=servos)
    with pytest.raises(ManeuverError) as caught:
        schedule_maneuver(maneuver((2, 61.0)), robot_limits(robot))
    assert "starts with joint 2 at 30 deg" in caught.value.next_step
    closed = fly_strokes(robot, (2, 60.0), (3, -70.0), (2, -60.0), (3, 70.0))
    assert np.degrees(closed.flight.angles_rad[0]) == pytest.approx(np.full(4, 30.0))
    assert closed.is_closed
    # All bodies turn alike: the path is closed.
    turned = Rotation.from_matrix(closed.rotations())
    assert max(apart_deg(rotation, turned[0]) for rotation in turned) < 1e-5


def test_a_history_is_flown_until_any_time_in_it() -> None:
    robot = load_robot()
    t_s = np.linspace(0.0, 2.0, 41)
    history = history_from_samples(t_s, np.outer(np.sin(2.0 * t_s), [0.6, 0.9, 0.3]))
    full_simulation = fly(robot, history, until_s=2.0, initial_rate_rad_s=RATE_RAD_S)
    for until_s in (0.35, 2.0, 2.4):
        part = fly(robot, history, until_s=until_s, initial_rate_rad_s=RATE_RAD_S)
        # Cut at any time, and beyond the end of the history.
        assert part.flight.t_s[-1] == until_s
        assert part.flight.angles_rad[-1] == pytest.approx(history.angles_rad(np.array(until_s)))
    middle = fly(robot, history, until_s=1.25, initial_rate_rad_s=RATE_RAD_S)
    there = int(np.argmin(np.abs(full_simulation.flight.t_s - 1.25)))
    assert full_simulation.flight.t_s[there] == pytest.approx(1.25)
    reached = Rotation.from_quat(full_simulation.flight.quaternion_xyzw[there])
    assert apart_deg(final(middle), reached) < 2e-4
