"""A person at the bench who does with each attempt what a test says, and a terminal where lines are typed."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

from tfsat_host.calibration.steps.step import Step, swings
from tfsat_host.emulated.emulated_operator import EmulatedOperator
from tfsat_host.emulated.emulated_robot import EmulatedRobot

FILE = Path("calibration-emulated.toml")
COMMAND = ("calibrate", "misalignment", "--joint", "2", "--port", "x")
FIRST, SECOND = swings(2)

Doing = Callable[[Step, Callable[[Step], None]], None]
"""What somebody does when asked for a step; the function does a step as it should be done."""


class Scripted:
    """Does with each attempt what the test says, and else what is asked."""

    lead_s = 0.0

    def __init__(self, robot: EmulatedRobot, doing: dict[int, Doing]) -> None:
        self._operator = EmulatedOperator(robot)
        self._doing = doing
        self.requested_steps: list[Step] = []

    def begin(self, step: Step) -> None:
        self.requested_steps.append(step)
        self._doing.get(len(self.requested_steps), as_asked)(step, self._operator.begin)


class Terminal(io.StringIO):
    """What a person types."""

    def isatty(self) -> bool:
        return True


def as_asked(step: Step, do: Callable[[Step], None]) -> None:
    do(step)


def wrong_side(step: Step, do: Callable[[Step], None]) -> None:
    # The held side moves, and the moving side is held.
    do(Step(step.kind, step.joint, moved=step.held, held=step.moved))


def do_nothing(_step: Step, _do: Callable[[Step], None]) -> None:
    pass


def interrupt_step(_step: Step, _do: Callable[[Step], None]) -> None:
    raise KeyboardInterrupt


Run = Callable[..., tuple[int, list[Step]]]
"""Runs a command with such a person; gives its exit code and the steps that were asked for."""
