"""The operator at the bench of an emulated robot, who holds and moves what a calibration asks for."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.steps.step import (
    AXES,
    DURATION_S,
    SWEEP_ROUNDS,
    SWEEP_STOPS_DEG,
    TURN_ROUNDS,
    Axis,
    Step,
    StepKind,
    turn_leg_s,
)
from tfsat_host.emulated.emulated_robot import EmulatedRobot
from tfsat_host.emulated.manual_motion import LEAD_S, Leg, Motion, Operator

SWING_DEG = 60.0
SWING_PERIOD_S = 2.0
SWING_CYCLES = 5
SWEEP_LEG_S = 1.5
SWEEP_REST_S = 1.0
TURN_REST_S = 1.2
TAIL_S = 1.0
"""Each motion ends with so much rest more."""


def swing_motion(
    start_rad: float, range_rad: FloatArray, operator: Operator, random: np.random.Generator
) -> Motion:
    """Out and back, `SWING_CYCLES` times; comes back to within `operator.stopping_deg`, at last to where it began.

    The joint is at `start_rad` now; `range_rad` (2,) has its least and greatest angle.
    """
    # Each swing's own amplitude: a person does not repeat a motion exactly.
    amplitude = np.deg2rad(SWING_DEG) * (1 + operator.variation * random.standard_normal(SWING_CYCLES))
    short = _stops(np.full(SWING_CYCLES, start_rad), range_rad, operator, random)
    short[-1] = start_rad
    # Columns out and back, read row by row: out, back, out, back.
    targets = np.column_stack([np.clip(start_rad + amplitude, *range_rad), short]).ravel()
    return _motion(targets, SWING_PERIOD_S / 2, 0.0, operator, random)


def sweep_motion(range_rad: FloatArray, operator: Operator, random: np.random.Generator) -> Motion:
    """Build a sweep of a joint through `SWEEP_STOPS_DEG`, repeated `SWEEP_ROUNDS` times.

    The joint's present position stands in for the first stop. Stops outside its least and greatest angle,
    `range_rad` (2,), are clipped to these.
    """
    # Where the joint is stands in for the first stop, so each round leaves it out.
    rounds = np.tile(np.deg2rad(SWEEP_STOPS_DEG[1:]), SWEEP_ROUNDS)
    return _motion(_stops(rounds, range_rad, operator, random), SWEEP_LEG_S, SWEEP_REST_S, operator, random)


def turn_motion(angle_deg: float, rounds: int, operator: Operator, random: np.random.Generator) -> Motion:
    """There and back `rounds` times. Where it lies before is as badly placed as where it comes to lie."""
    nominal = np.deg2rad(np.tile([angle_deg, 0.0], rounds))
    # One placing error for each rest, the one before the motion included; angles count from that one.
    placing = np.deg2rad(operator.placing_deg) * random.standard_normal(2 * rounds + 1)
    return _motion(nominal + placing[1:] - placing[0], turn_leg_s(angle_deg), TURN_REST_S, operator, random)


def turn_axis(axis: Axis, operator: Operator, random: np.random.Generator) -> FloatArray:
    """(3,) the body axis as it was meant, tilted by a hand: unit vector in body axes."""
    meant = np.eye(3)[AXES.index(axis)]
    # Two components across the axis, each 1/sqrt(2) of the RMS tilt; one along it would tilt nothing.
    tilt = np.deg2rad(operator.tilt_deg) / np.sqrt(2) * random.standard_normal(3)
    tilted = meant + np.where(meant == 0.0, tilt, 0.0)
    return np.asarray(tilted / np.linalg.norm(tilted))


def servo_motion(operator: Operator, random: np.random.Generator) -> Motion:
    """Build the motion of a servo step: an empty one, because the servo moves and the operator only holds."""
    return Motion((), operator, _seed(random))


def _stops(
    nominal_rad: FloatArray, range_rad: FloatArray, operator: Operator, random: np.random.Generator
) -> FloatArray:
    off = np.deg2rad(operator.stopping_deg) * random.uniform(-1, 1, len(nominal_rad))
    least, most = range_rad
    stops = np.clip(nominal_rad, least, most) + off
    # What would be beyond a mechanical stop lies as far before it: people do not lean on it each time.
    inside: FloatArray = np.clip(most - np.abs(most - (least + np.abs(stops - least))), least, most)
    return inside


def _motion(
    targets_rad: FloatArray, leg_s: float, rest_s: float, operator: Operator, random: np.random.Generator
) -> Motion:
    """Legs that vary in duration and together take as long as nominal ones at this pace, and `TAIL_S`."""
    n_legs = len(targets_rad)
    # Normalise by the sum: single legs vary, and the whole takes its nominal time at this pace.
    share = np.clip(1 + operator.variation * random.standard_normal(n_legs), 0.5, 1.5)
    durations_s = leg_s * operator.pace * n_legs * share / share.sum()
    rests_s = np.full(n_legs, rest_s * operator.pace)
    rests_s[-1] += TAIL_S
    columns = (targets_rad.tolist(), durations_s.tolist(), rests_s.tolist())
    return Motion(tuple(Leg(*row) for row in zip(*columns, strict=True)), operator, _seed(random))


def _seed(random: np.random.Generator) -> int:
    return int(random.integers(2**63))


LIMP_AFTER_US = 120_000
"""A little more than limp_after_us of tools/emulator/src/physics/servo.h."""
_ALL_BODIES = (1, 2, 3, 4)
_ALL_JOINTS = (1, 2, 3)


class EmulatedOperator:
    """Does by hand what the prompts ask.

    Args:
        robot: At the bench.
        operator: Steady by default; the seed decides everything that the operator varies.
    """

    def __init__(self, robot: EmulatedRobot, operator: Operator | None = None) -> None:
        self._robot = robot
        self._operator = operator or Operator.steady()
        self._random = np.random.default_rng(self._operator.seed)

    def begin(self, step: Step) -> None:
        """Sets the robot up for a step and starts the motion, which goes on while samples are taken.

        A joint that is to be zero, or that begins to move, is closed first, which takes no time.

        Raises:
            EmulationError: a servo holds a joint that the operator should move.
            ValueError: the step does not say what its kind needs.
        """
        match step.kind:
            case StepKind.REST:
                self._robot.hold(_ALL_BODIES)
            case StepKind.ZERO:
                self._close(_ALL_JOINTS if step.joint is None else (step.joint,))
            case StepKind.SWING | StepKind.SWEEP:
                self._move(step, step.moving_joint)
            case StepKind.TURN:
                self._turn(step)
            case StepKind.SERVO:
                # The servo does the moving; the hands that hold the robot only sway and give way.
                self._robot.hold(step.held)
                self._robot.operator.hold_against(
                    step.moving_joint, servo_motion(self._operator, self._random)
                )

    def duration_s(self, step: Step) -> float:
        """Return the duration of the step's motion with this operator, rests at both ends included.

        For a servo step, return only the time the robot lies still before the operator begins to sway.
        """
        ends_s = LEAD_S + TAIL_S
        moving_s = {
            StepKind.REST: DURATION_S[StepKind.REST] - ends_s,
            StepKind.ZERO: DURATION_S[StepKind.ZERO] - ends_s,
            StepKind.SWING: SWING_CYCLES * SWING_PERIOD_S * self._operator.pace,
            StepKind.SWEEP: SWEEP_ROUNDS
            * (len(SWEEP_STOPS_DEG) - 1)
            * (SWEEP_LEG_S + SWEEP_REST_S)
            * self._operator.pace,
            StepKind.TURN: TURN_ROUNDS * 2 * (turn_leg_s(step.angle_deg) + TURN_REST_S) * self._operator.pace,
            StepKind.SERVO: -TAIL_S,
        }
        return ends_s + moving_s[step.kind]

    def wait_until_limp(self) -> None:
        """Lets the time pass that a servo still holds a joint after its last pulse."""
        self._robot.advance(LIMP_AFTER_US)

    def _close(self, joints: Iterable[int]) -> None:
        """Close the joints while holding the robot by one body only, then lay the whole robot down."""
        self._robot.hold(_ALL_BODIES[-1:])
        for joint in joints:
            self._robot.operator.put_joint(joint)
        self._robot.hold(_ALL_BODIES)

    def _move(self, step: Step, joint: int) -> None:
        self._close((joint,))
        self._robot.hold(step.held)
        start_rad = np.deg2rad(self._robot.joint_angles_deg()[joint - 1])
        range_rad = self._robot.model.joint_limits_rad[joint - 1]
        if step.kind is StepKind.SWING:
            motion = swing_motion(start_rad, range_rad, self._operator, self._random)
        else:
            motion = sweep_motion(range_rad, self._operator, self._random)
        self._robot.operator.move_joint(joint, motion)

    def _turn(self, step: Step) -> None:
        if step.axis is None:
            raise ValueError("a turn needs an axis")
        # Closed joints make the robot one rigid body: all gyros turn by the same angle.
        self._close(_ALL_JOINTS)
        axis = turn_axis(step.axis, self._operator, self._random)
        motion = turn_motion(step.angle_deg, TURN_ROUNDS, self._operator, self._random)
        self._robot.operator.turn(axis, motion)
