"""A person at the bench of an emulated robot: holds and moves what a calibration asks for."""

from __future__ import annotations

from tfsat_host.calibration.patterns import MotionPattern
from tfsat_host.emulated.robot import EmulatedRobot

SWING_DEG = 60.0
SWING_PERIOD_S = 2.0
SWING_CYCLES = 5


class EmulatedOperator:
    """Does by hand what the prompts ask."""

    def __init__(self, robot: EmulatedRobot) -> None:
        self._robot = robot

    def rest(self) -> None:
        """Lays the whole robot on the bench."""
        self._robot.hold((1, 2, 3, 4))

    def swing(self, pattern: MotionPattern) -> None:
        """Holds and swings as the pattern says; the motion goes on while samples are taken."""
        self._robot.hold(pattern.held)
        self._robot.swing(pattern.joint, SWING_DEG, SWING_PERIOD_S, SWING_CYCLES)
