"""The hands at the bench of an emulated robot, for an acceptance."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tfsat_host.acceptance.bench import Task
from tfsat_host.acceptance.imu_wiring import MOVED_WITH
from tfsat_host.emulated.emulated_operator import LIMP_AFTER_US
from tfsat_host.emulated.emulated_robot import US_PER_S, EmulatedRobot
from tfsat_host.emulated.fault_injection import ServoFault
from tfsat_host.emulated.manual_motion import Leg, Motion, Operator
from tfsat_host.protocol.limits import SWITCH_COUNT
from tfsat_host.robot.absent_parts import bodies_of

MOVE_S = 2.0
REST_S = 0.5
HALF_RAD = np.deg2rad(45.0)
TILT_RAD = np.deg2rad(90.0)
_CLAMPED = 3
"""The joints of this body, or of the last one, are free to move."""


class EmulatedHands:
    """Does what the tasks say.

    Args:
        robot: At the bench.
        servo_faults: By joint; of servos that have power.
    """

    def __init__(self, robot: EmulatedRobot, servo_faults: Mapping[int, ServoFault]) -> None:
        self._robot = robot
        self._bodies = bodies_of(robot.model)
        self._joints = self._bodies[:-1]
        self._clamped = (min(_CLAMPED, len(self._bodies)),)
        self._servo_faults = servo_faults

    def do(self, task: Task, number: int = 0) -> None:
        """Do a task at once, or begin its motion. Raises EmulationError: a servo holds the joint."""
        self._robot.advance(LIMP_AFTER_US)
        match task:
            case Task.REST:
                self._close_joints()
            case Task.OPEN_AND_CLOSE:
                self._close_joints()
                self._robot.hold([body for body in self._bodies if body not in MOVED_WITH[number - 1]])
                open_rad = float(self._robot.model.joint_limits_rad[number - 1, 1])
                self._robot.operator.move_joint(number, _there_and_back(open_rad))
            case Task.TILT:
                self._close_joints()
                self._robot.operator.turn(np.array([1.0, 0.0, 0.0]), _there_and_back(TILT_RAD))
            case Task.FREE_SWITCHES | Task.LET_GO:
                self._press()
            case Task.PRESS:
                self._press(number)
            case Task.OPEN_HALF:
                self._power_servos(on=True)
                self._robot.hold(self._clamped)
                for joint in self._joints:
                    self._robot.operator.move_joint(joint, _motion(Leg(HALF_RAD, MOVE_S)))
                    self._robot.advance(round((MOVE_S + REST_S + 1.0) * US_PER_S))
            case Task.PRESS_BOTH_UNPOWERED | Task.PRESS_BOTH_POWERED:
                self._close_joints()
                self._robot.hold(self._clamped)
                self._power_servos(on=task is Task.PRESS_BOTH_POWERED)
                self._press(1, 2)

    def _close_joints(self) -> None:
        self._robot.hold(self._bodies[-1:])
        for joint in self._joints:
            self._robot.operator.put_joint(joint)
        self._robot.hold(self._bodies)

    def _press(self, *pressed: int) -> None:
        for switch in range(1, SWITCH_COUNT + 1):
            self._robot.set_switch(switch, switch in pressed)

    def _power_servos(self, *, on: bool) -> None:
        for joint in self._joints:
            self._robot.faults.servo(joint, self._servo_faults.get(joint) if on else "dead")


def _there_and_back(angle_rad: float) -> Motion:
    return _motion(Leg(angle_rad, MOVE_S, REST_S), Leg(0.0, MOVE_S, REST_S))


def _motion(*legs: Leg) -> Motion:
    return Motion(legs, Operator.steady(), seed=1)
