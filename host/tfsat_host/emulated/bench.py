"""A person at the bench of an emulated robot: holds and moves what a calibration asks for."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from tfsat_host.calibration.steps.step import (
    SWEEP_ROUNDS,
    SWEEP_STOPS_DEG,
    TURN_ROUNDS,
    Step,
    StepKind,
)
from tfsat_host.emulated.hands import (
    LEAD_S,
    SWEEP_LEG_S,
    SWEEP_REST_S,
    SWING_CYCLES,
    SWING_DEG,
    SWING_PERIOD_S,
    TAIL_S,
    TURN_REST_S,
    Hands,
    servo_motion,
    sweep_motion,
    swing_motion,
    turn_axis,
    turn_leg_s,
    turn_motion,
)
from tfsat_host.emulated.robot import EmulatedRobot

REST_S = 20.0
ZERO_S = 5.0
LIMP_AFTER_US = 120_000
"""A little more than limp_after_us of tools/emulator/src/physics/servo.h."""
_ALL_BODIES = (1, 2, 3, 4)
_ALL_JOINTS = (1, 2, 3)


class EmulatedOperator:
    """Does by hand what the prompts ask.

    Args:
        robot: At the bench.
        hands: Of the person; steady by default. Their seed decides everything that the person varies.
    """

    def __init__(self, robot: EmulatedRobot, hands: Hands | None = None) -> None:
        self._robot = robot
        self._hands = hands or Hands.steady()
        self._random = np.random.default_rng(self._hands.seed)

    def begin(self, step: Step) -> None:
        """Sets the robot up for a step and starts the motion, which goes on while samples are taken.

        A joint that is to be zero, or that begins to move, is closed first, which takes no time.

        Raises:
            EmulationError: a servo holds a joint that hands should move.
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
                self._robot.hold(step.held)
                self._robot.hands.hold_against(step.moving_joint, servo_motion(self._hands, self._random))

    def duration_s(self, step: Step) -> float:
        """How long the step's motion takes with these hands, rests at both ends included.

        Of a servo's step, only how long the robot lies still before the hands begin to sway.
        """
        ends_s = LEAD_S + TAIL_S
        moving_s = {
            StepKind.REST: REST_S - ends_s,
            StepKind.ZERO: ZERO_S - ends_s,
            StepKind.SWING: SWING_CYCLES * SWING_PERIOD_S * self._hands.pace,
            StepKind.SWEEP: SWEEP_ROUNDS
            * (len(SWEEP_STOPS_DEG) - 1)
            * (SWEEP_LEG_S + SWEEP_REST_S)
            * self._hands.pace,
            StepKind.TURN: TURN_ROUNDS * 2 * (turn_leg_s(step.angle_deg) + TURN_REST_S) * self._hands.pace,
            StepKind.SERVO: -TAIL_S,
        }
        return ends_s + moving_s[step.kind]

    def wait_until_limp(self) -> None:
        """Lets the time pass that a servo still holds a joint after its last pulse."""
        self._robot.advance(LIMP_AFTER_US)

    def rest(self) -> None:
        """Lays the whole robot on the bench."""
        self._robot.hold(_ALL_BODIES)

    def swing(self, step: Step) -> None:
        """Holds and swings as the step says; the motion goes on while samples are taken."""
        self._robot.hold(step.held)
        self._robot.swing(step.moving_joint, SWING_DEG, SWING_PERIOD_S, SWING_CYCLES)

    def _close(self, joints: Iterable[int]) -> None:
        """By one body, so that nothing keeps a joint from closing; then all lie still."""
        self._robot.hold(_ALL_BODIES[-1:])
        for joint in joints:
            self._robot.hands.close_joint(joint)
        self._robot.hold(_ALL_BODIES)

    def _move(self, step: Step, joint: int) -> None:
        self._close((joint,))
        self._robot.hold(step.held)
        start_rad = np.deg2rad(self._robot.joint_angles_deg()[joint - 1])
        range_rad = self._robot.model.joint_limits_rad[joint - 1]
        if step.kind is StepKind.SWING:
            motion = swing_motion(start_rad, range_rad, self._hands, self._random)
        else:
            motion = sweep_motion(range_rad, self._hands, self._random)
        self._robot.hands.move_joint(joint, motion)

    def _turn(self, step: Step) -> None:
        if step.axis is None:
            raise ValueError("a turn needs an axis")
        self._close(_ALL_JOINTS)
        axis = turn_axis(step.axis, self._hands, self._random)
        motion = turn_motion(step.angle_deg, TURN_ROUNDS, self._hands, self._random)
        self._robot.hands.turn(axis, motion)
