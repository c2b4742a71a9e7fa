"""The whole design against the paper, and the optimum against brute force."""

from __future__ import annotations

import functools
import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import Multibody, path_rotation, rotation_angle_rad, rotation_vector_rad
from tfsat_host.dynamics.history import TimedMove, servo_moves
from tfsat_host.dynamics.simulation import arrivals_s
from tfsat_host.maneuver import schedule_maneuver
from tfsat_host.plan.loops import Sequence, best_sequence, classes
from tfsat_host.plan.maneuver_design import Design, candidate, search
from tfsat_host.plan.maneuver_design import design as designed
from tfsat_host.plan.optimum import Summit, climb, find_optimum, value_and_gradient
from tfsat_host.plan.problem import DesignError, DesignSettings, Problem
from tfsat_host.plan.swarm import SwarmOptimum, minimize
from tfsat_host.robot import RobotModel

DEFAULT = DesignSettings()


@functools.cache
def design(robot: RobotModel, settings: DesignSettings = DEFAULT) -> Design:
    """Return a design, computed once for all tests that use it."""
    return designed(robot, settings)


# The paper's displacements take 1.518 s at 170 deg/s, not its 1.50 s.
PAPERS_TIME_S = 2 * (58.75 + 70.29) / 170.0


def test_the_papers_maneuver_is_nearly_the_best_in_its_time(drop_tower: RobotModel) -> None:
    solution = design(drop_tower, DesignSettings(time_limit_s=PAPERS_TIME_S))
    best = solution.optimum
    assert best.sequence == (1, 2, -1, -2)
    # What the design finds in the paper's time, and how near the paper's own displacements are to it.
    assert best.alpha_deg == pytest.approx([60.06, 68.98, 0.0], abs=0.01)
    assert best.reorientation_deg == pytest.approx(26.126, abs=0.001)
    assert best.rotation_vector_deg[2] == pytest.approx(-26.12, abs=0.01)
    assert best.duration_s == pytest.approx(PAPERS_TIME_S, abs=1e-9)
    assert best.efficiency == pytest.approx(0.1012, abs=0.0001)
    # A residual of zero: the climb ended on the summit.
    assert solution.summit.residual < 1e-6
    papers = candidate(solution.problem, np.radians([58.75, 70.29, 0.0]), (1, 2, 3, -1, -2, -3))
    assert papers.reorientation_deg == pytest.approx(26.112, abs=0.001)
    # The paper's point lies below the summit by less than its digits show.
    assert 0.0 < best.reorientation_deg - papers.reorientation_deg < 0.015


@pytest.mark.parametrize("time_limit_s", [0.05, 0.2, 1.0])
def test_a_short_time_has_an_optimum_too(drop_tower: RobotModel, time_limit_s: float) -> None:
    """Share a short time nearly evenly between two joints, and leave no joint to move alone."""
    solution = design(drop_tower, DesignSettings(time_limit_s=time_limit_s))
    # Even the shortest time has an optimum to climb to.
    assert solution.gap_deg is not None
    assert solution.gap_deg >= -1e-9
    even = solution.problem.farthest_rad(0.25 * time_limit_s) * [1, 1, 0]
    assert solution.optimum.alpha_deg[:2] == pytest.approx(np.degrees(even[:2]), rel=0.1)
    shared = candidate(solution.problem, even, (1, 2, 3, -1, -2, -3))
    assert solution.optimum.reorientation_deg >= shared.reorientation_deg > 0.0


@settings(max_examples=60)
@given(time_limit_s=st.floats(0.05, 3.0), share=st.lists(st.floats(0.0, 1.0), min_size=3, max_size=3))
def test_strokes_take_what_the_servos_need(
    drop_tower: RobotModel, time_limit_s: float, share: list[float]
) -> None:
    """Strokes take the time that `simulate` needs with the robot file's own acceleration."""
    problem = Problem.of(drop_tower, DesignSettings(time_limit_s=time_limit_s))
    # Displacements up to the joints' limits.
    size = np.array(share) * np.radians(90.0)
    taken_s = problem.stroke_s(size)
    moves = [
        # Strokes ten seconds apart, so that none waits for another.
        TimedMove(j, size[j], 10.0 * j, 10.0 * j + max(size[j] / np.radians(170.0), 1e-9))
        for j in range(3)
    ]
    flown_s = [move.end_s - move.start_s for move in servo_moves(drop_tower, moves)]
    assert taken_s == pytest.approx(flown_s, abs=2e-9)
    # The inverse of the time: as far as a servo gets in it.
    back = np.array([problem.farthest_rad(s)[j] for j, s in enumerate(taken_s)])
    assert back == pytest.approx(size, abs=1e-9)
    limited_size = problem.within_time(size)
    assert problem.keeps_time(limited_size) and (limited_size <= size).all()
    if not problem.keeps_time(size):
        assert problem.duration_s(limited_size) == pytest.approx(time_limit_s, rel=1e-9)
        # A little more would not fit: nothing is given away.
        assert not problem.keeps_time(1.0001 * limited_size)
    step = 1e-7
    slope = (problem.stroke_s(size + step) - problem.stroke_s(size)) / step
    assert (
        problem.stroke_s_per_rad(size) == pytest.approx(np.where(size > 1e-3, slope, 0.0), rel=1e-2)
        or (size < 1e-3).any()
    )


@pytest.mark.parametrize("time_limit_s", [0.4, 0.6, 1.0, 1.5, 1.518, 1.532, 1.7])
def test_every_stroke_has_ended_when_the_next_begins(drop_tower: RobotModel, time_limit_s: float) -> None:
    solution = design(drop_tower, DesignSettings(time_limit_s=time_limit_s))
    schedule = schedule_maneuver(solution.maneuver(solution.optimum))
    ends_s = arrivals_s(drop_tower, schedule)
    starts_s = [stroke.t_s for stroke in schedule.strokes]
    assert all(end_s <= start_s + 1e-9 for end_s, start_s in zip(ends_s, starts_s[1:], strict=False))
    # With starts on the grid of 10 ms and the servos' acceleration: 1.5 s once ended 11 ms late.
    span_s = ends_s[-1] - starts_s[0]
    assert time_limit_s - 0.05 < span_s <= time_limit_s + 1e-6
    assert span_s == pytest.approx(solution.round_candidate(solution.optimum).duration_s, abs=1e-6)


def test_the_swarms_point_is_climbed_from_as_well(five_bodies: RobotModel) -> None:
    """Whatever a coarse grid misses, the optimum is never below the swarm."""
    solution = design(five_bodies, DesignSettings(joints=(0, 1, 3)))
    assert solution.gap_deg is not None
    # Not below the swarm, which must not find what the climb misses.
    assert solution.gap_deg >= -1e-6
    assert solution.optimum.reorientation_deg > 0.0


@pytest.mark.parametrize("alternating", [False, True])
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.prove)])
def test_the_swarm_comes_near_and_never_beats_the_optimum(
    drop_tower: RobotModel, seed: int, alternating: bool
) -> None:
    solution = design(drop_tower, DesignSettings(seed=seed, alternating=alternating))
    assert solution.gap_deg is not None
    assert 0.0 <= solution.gap_deg < 1.0
    assert solution.swarm.alpha_deg[2] == pytest.approx(0.0, abs=1.0)
    # The penalty lets the swarm stay within the time.
    assert solution.swarm.duration_s < 1.5 + 1e-4
    # Flat: the swarm ends some degrees beside the optimum and loses little.
    assert solution.swarm.alpha_deg[:2] == pytest.approx([59.4, 68.1], abs=6.0)


def test_no_point_of_a_fine_grid_beats_the_optimum(drop_tower: RobotModel) -> None:
    """Points of a 3 deg grid that use up all the time, in every sequence and corner, do not beat the optimum."""
    problem = Problem.of(drop_tower, DesignSettings())
    summit, _ = find_optimum(problem)
    pairs = np.array(list(itertools.product(np.arange(0.0, 91.0, 3.0), repeat=2)))
    # Every third displacement that uses up the time, whichever joint it belongs to: all servos are alike.
    spent_s = problem.stroke_s(np.radians(np.column_stack([pairs, np.zeros(len(pairs))]).T)).sum(axis=0)
    rest = np.degrees([problem.farthest_rad(max(0.75 - s, 0.0))[2] for s in spent_s])
    triples = np.column_stack([pairs, rest])[(spent_s <= 0.75) & (rest <= 90.0)]
    points = np.radians(np.concatenate([triples, np.roll(triples, 1, axis=1), np.roll(triples, 2, axis=1)]).T)
    best, _ = best_sequence(problem.loops().angles_rad(points))
    # No point of the grid is above the summit.
    assert best.max() <= summit.reorientation_rad + 1e-9
    assert np.degrees(summit.reorientation_rad - best.max()) < 0.05  # and the grid comes near it


def test_another_grid_finds_the_same_optimum(drop_tower: RobotModel) -> None:
    problem = Problem.of(drop_tower, DesignSettings(time_limit_s=1.8))
    coarse, _ = find_optimum(problem, grid_points=350)
    fine, _ = find_optimum(problem, grid_points=1500)
    assert coarse.reorientation_rad == pytest.approx(fine.reorientation_rad, abs=1e-9)


def test_every_climb_starts_within_the_time(drop_tower: RobotModel, monkeypatch: pytest.MonkeyPatch) -> None:
    in_time: list[bool] = []

    def watch_climb(problem: Problem, sequence: Sequence, start_rad: FloatArray) -> Summit:
        in_time.append(bool(problem.keeps_time(start_rad)))
        return climb(problem, sequence, start_rad)

    monkeypatch.setattr("tfsat_host.plan.optimum.climb", watch_climb)
    problem = Problem.of(drop_tower, DesignSettings())
    find_optimum(problem, grid_points=700)  # some points of this grid are less than 1 % too far
    assert in_time and all(in_time)


def test_the_highest_summit_is_not_the_one_below_the_best_grid_point(drop_tower: RobotModel) -> None:
    """Find the highest maximum at 2.2 s, where it is not the one nearest to the best grid point.

    With 2.2 s a third joint begins to help, in a sequence whose grid points are not the best ones. The
    expected value is the best of all 860 local maxima of the grid, each climbed.
    """
    best, ranked = find_optimum(Problem.of(drop_tower, DesignSettings(time_limit_s=2.2)))
    assert np.degrees(best.reorientation_rad) == pytest.approx(39.425896, abs=1e-5)
    # In the 41 ms that are left a servo with 4000 deg/s^2 turns by 1.7 deg, not by the 7 of 170 deg/s.
    assert np.degrees(best.displacements_rad) == pytest.approx([90.0, 90.0, 1.695], abs=1e-3)
    assert [s.reorientation_rad for s in ranked] == sorted(
        (s.reorientation_rad for s in ranked), reverse=True
    )


def test_without_a_time_limit_joints_1_and_2_open_all_the_way(drop_tower: RobotModel) -> None:
    solution = design(drop_tower, DesignSettings(joints=(0, 1), time_limit_s=10.0))
    assert solution.optimum.alpha_deg == pytest.approx([90.0, 90.0])
    assert solution.optimum.reorientation_deg == pytest.approx(39.4, abs=0.05)
    assert solution.summit.gain_rad_s == 0.0


def test_more_time_gives_what_the_optimum_says_it_gives(drop_tower: RobotModel) -> None:
    problems = [Problem.of(drop_tower, DesignSettings(time_limit_s=time_s)) for time_s in (1.49, 1.5, 1.51)]
    start = np.radians([59.0, 68.0, 0.0])
    shorter, middle, longer = (climb(problem, (1, 2, 3, -1, -2, -3), start) for problem in problems)
    # The time's worth is the slope between two designs.
    gain = (longer.reorientation_rad - shorter.reorientation_rad) / 0.02
    assert middle.gain_rad_s == pytest.approx(gain, rel=1e-3)


def test_the_gradient_is_that_of_the_angle(drop_tower: RobotModel) -> None:
    loops = Problem.of(drop_tower, DesignSettings()).loops((classes(3)[1],))
    x = np.array([0.9, 1.1, 0.3])
    value, gradient = value_and_gradient(loops, x)
    for i, h in itertools.product(range(3), (1e-4,)):
        step = h * np.eye(3)[i]
        ahead, behind = (value_and_gradient(loops, x + s * step)[0] for s in (1, -1))
        # Central differences of the angle itself.
        assert gradient[i] == pytest.approx((ahead - behind) / (2 * h), abs=1e-7)
    assert value == pytest.approx(float(loops.angles_rad(x[:, None])[0, 0]))


def test_a_climb_ends_where_nothing_rises(drop_tower: RobotModel) -> None:
    problem = Problem.of(drop_tower, DesignSettings())
    summit = climb(problem, classes(3)[1], np.radians([40.0, 40.0, 20.0]))
    assert summit.residual < 1e-6
    assert problem.keeps_time(summit.displacements_rad)


def test_the_maneuver_can_be_scheduled_and_stays_within_the_time(drop_tower: RobotModel) -> None:
    solution = design(drop_tower)
    maneuver = solution.maneuver(solution.optimum, "designed")
    assert sum(abs(stroke.angle_deg) for stroke in maneuver.strokes) / maneuver.speed_deg_s <= 1.5
    for stroke, exact in zip(maneuver.strokes, solution.optimum.alpha_deg[[0, 1, 0, 1]], strict=True):
        # A step of the sequencer's grid is 1.7 deg.
        assert abs(exact - abs(stroke.angle_deg)) < 1.7
    schedule = schedule_maneuver(maneuver)
    assert [s.joint for s in schedule.strokes] == [1, 2, 1, 2]
    assert not schedule.notices


def test_the_reported_rotation_is_that_of_the_reported_sequence(drop_tower: RobotModel) -> None:
    solution = design(drop_tower, DesignSettings(joints=(0, 1, 2), limit_deg=(30.0, 30.0, 90.0)))
    best = solution.optimum
    joints = [abs(s) - 1 for s in best.sequence]
    deltas = np.radians([np.copysign(best.alpha_deg[abs(s) - 1], s) for s in best.sequence])
    vector = np.degrees(rotation_vector_rad(path_rotation(solution.problem.body, joints, deltas)))
    assert vector == pytest.approx(best.rotation_vector_deg, abs=1e-6)
    assert (best.alpha_deg <= np.array([30.0, 30.0, 90.0]) + 1e-9).all()


def test_a_robot_with_other_ranges_is_designed_for(five_bodies: RobotModel) -> None:
    """Five bodies in a tree: a joint that only closes from its start pose moves out by negative angles."""
    solution = design(five_bodies, DesignSettings(joints=(0, 1, 2), time_limit_s=3.0))
    best = solution.optimum
    low, high = np.degrees(five_bodies.joint_limits_rad).T
    start = np.degrees([servo.start_rad for servo in five_bodies.servos])
    pose, strokes = start.copy(), solution.maneuver(best).strokes
    for stroke in strokes:
        pose[stroke.joint - 1] += stroke.angle_deg
        assert (pose >= low - 1e-9).all()
        assert (pose <= high + 1e-9).all()
    # Back where it began: the path is closed.
    assert pose == pytest.approx(start)
    joints, deltas = [s.joint - 1 for s in strokes], np.radians([s.angle_deg for s in strokes])
    rotation = path_rotation(Multibody.of(five_bodies), joints, deltas, start_rad=np.radians(start), steps=16)
    reorientation_deg = float(np.degrees(rotation_angle_rad(rotation)))
    assert reorientation_deg == pytest.approx(
        best.reorientation_deg, abs=0.01
    )  # displacements were rounded down
    assert best.reorientation_deg == pytest.approx(np.degrees(solution.summit.reorientation_rad), abs=1e-3)
    assert solution.problem.steps > 2  # its strokes need more than the drop tower robot's


def test_joints_that_may_turn_to_both_sides_are_searched_on_both(drop_tower: RobotModel) -> None:
    """Joint 3 outwards by a negative angle gives 42.78 deg where positive angles alone give 40.13 deg."""
    both = replace(drop_tower, joint_limits_rad=np.radians([[-90.0, 90.0]] * 3))
    best = design(both, DesignSettings(time_limit_s=3.0))
    assert best.optimum.reorientation_deg == pytest.approx(42.78, abs=0.005)
    assert best.optimum.alpha_deg == pytest.approx([90.0, 90.0, -75.0], abs=0.01)
    strokes = best.maneuver(best.optimum).strokes
    # 75 deg take 0.441 s; 74.8 deg take the 0.44 s that the grid has left.
    assert {s.angle_deg for s in strokes if s.joint == 3} == {-74.8, 74.8}
    assert strokes[[s.joint for s in strokes].index(3)].angle_deg == -74.8


def test_what_is_written_is_judged_as_it_is_written(drop_tower: RobotModel) -> None:
    solution = design(drop_tower)
    candidate, maneuver = solution.round_candidate(solution.optimum), solution.maneuver(solution.optimum)
    joints, deltas = (
        [s.joint - 1 for s in maneuver.strokes],
        np.radians([s.angle_deg for s in maneuver.strokes]),
    )
    rotation = path_rotation(solution.problem.body, joints, deltas, steps=16)
    # The written angles, not the exact ones, are judged.
    assert candidate.reorientation_deg == pytest.approx(
        float(np.degrees(rotation_angle_rad(rotation))), abs=1e-9
    )
    # 59.5 and 68 deg at 170 deg/s are 0.35 and 0.40 s: whole steps of the sequencer's grid.
    assert candidate.alpha_deg == pytest.approx([59.5, 68.0, 0.0])
    assert candidate.duration_s == pytest.approx(1.5)
    assert candidate.sequence == solution.optimum.sequence
    assert 0.0 <= solution.optimum.reorientation_deg - candidate.reorientation_deg < 1e-3


@settings(max_examples=40)
@given(
    time_limit_s=st.floats(0.1, 3.0),
    shares=st.lists(st.floats(0.01, 1.0), min_size=3, max_size=3),
)
def test_what_is_commanded_is_near_and_keeps_time_and_limits(
    drop_tower: RobotModel, time_limit_s: float, shares: list[float]
) -> None:
    problem = Problem.of(drop_tower, DesignSettings(time_limit_s=time_limit_s))
    desired_deg = np.degrees(problem.within_time(np.radians(90.0) * np.array(shares)))
    commanded = problem.commanded_deg(desired_deg)
    assert commanded * 100 == pytest.approx(np.rint(commanded * 100), abs=1e-6)
    # Rounded to hundredths: off by one and a half of them at the most.
    assert np.abs(commanded - desired_deg).max() <= 0.0151
    assert problem.duration_s(np.radians(commanded)) <= time_limit_s + 1e-8
    assert (commanded >= 0.0).all()
    assert (commanded <= 90.0).all()


@settings(max_examples=60)
@given(
    # Shorter, the slowest servo turns nothing by 0.01 deg, which is refused.
    time_limit_s=st.floats(0.3, 3.0),
    shares=st.lists(st.floats(0.0, 1.0), min_size=3, max_size=3),
    acceleration_deg_s2=st.floats(100.0, 1e5),
)
def test_some_displacements_near_any_keep_the_time_on_the_grid(
    drop_tower: RobotModel, time_limit_s: float, shares: list[float], acceleration_deg_s2: float
) -> None:
    problem = Problem.of(drop_tower, DesignSettings(time_limit_s=time_limit_s))
    problem = replace(problem, acceleration_rad_s2=np.full(3, np.radians(acceleration_deg_s2)))
    desired_deg = np.degrees(problem.within_time(np.radians(90.0) * np.array(shares)))
    sequence = (1, 2, 3, -1, -2, -3)
    schedulable = list(problem.schedulable_deg(desired_deg, sequence))
    assert schedulable
    for displacements_deg in schedulable:
        assert problem.scheduled_s(np.radians(displacements_deg), sequence) <= time_limit_s + 1e-6
        assert ((displacements_deg >= 0.0) & (displacements_deg <= 90.0)).all()


def test_turns_end_with_the_best_of_their_rounds(
    drop_tower: RobotModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Keep the best result of all rounds, even if a swarm's second round finds less than its first."""
    rounds: list[float] = []

    def worsen_optimum(*args: Any) -> SwarmOptimum:
        swarm_optimum = minimize(*args)
        # Worse in every round: the first one must be kept.
        rounds.append(swarm_optimum.value + 0.01 * len(rounds))
        return replace(swarm_optimum, value=rounds[-1])

    monkeypatch.setattr("tfsat_host.plan.maneuver_design.minimize", worsen_optimum)
    settings = DesignSettings(alternating=True, time_limit_s=2.2, seed=3)
    optimum, _ = search(Problem.of(drop_tower, settings), settings)
    assert len(rounds) > 1
    assert optimum.value == min(rounds)


def test_the_penalty_is_the_papers(drop_tower: RobotModel) -> None:
    problem = Problem.of(drop_tower, DesignSettings())
    loops = problem.loops()
    inside, outside = np.radians([[59.0], [68.0], [0.0]]), np.radians([[59.0], [68.5 + 0.17], [0.0]])
    assert problem.objective(loops, inside)[0] == -loops.angles_rad(inside).max()
    # The overtime of 68.67 instead of 68.5 deg, as the paper's objective charges it.
    overtime = 2 * (59.0 + 68.67) / 170.0 - 1.5
    paid = np.degrees(problem.objective(loops, outside)[0] + loops.angles_rad(outside).max())
    assert paid == pytest.approx(1e11 * overtime**2, rel=1e-9)


def test_five_joints_are_too_many(drop_tower: RobotModel) -> None:
    many = replace(
        drop_tower,
        joint_names=("a", "b", "c", "d", "e"),
        servos=drop_tower.servos[:1] * 5,
        joint_limits_rad=np.tile(drop_tower.joint_limits_rad[:1], (5, 1)),
    )
    with pytest.raises(DesignError, match="5 joints are too many") as caught:
        design(many)
    assert caught.value.setting == "joints"


@pytest.mark.parametrize(
    ("wrong", "setting"),
    [
        ({"joints": (0,)}, "joints"),
        ({"joints": (0, 0)}, "joints"),
        ({"joints": (0, 3)}, "joints"),
        ({"limit_deg": (90.0,)}, "limit"),
        ({"limit_deg": (90.0, 90.0, 91.0)}, "limit"),
        ({"limit_deg": (0.0, 90.0, 90.0)}, "limit"),
        ({"speed_deg_s": 0.0}, "speed"),
        ({"time_limit_s": float("nan")}, "time limit"),
        ({"penalty": -1.0}, "penalty"),
        ({"time_limit_s": 1e-4}, "time limit"),
        ({"limit_deg": (90.0, 90.0, 0.005)}, "limit"),
    ],
)
def test_settings_that_do_not_fit_are_named(
    drop_tower: RobotModel, wrong: dict[str, object], setting: str
) -> None:
    with pytest.raises(DesignError) as caught:
        design(drop_tower, replace(DesignSettings(), **wrong))  # type: ignore[arg-type]
    assert caught.value.setting == setting
    assert caught.value.next_step
