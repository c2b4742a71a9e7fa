"""The operator of a calibration at a terminal, and a command's result."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.calibration.steps.step import title
from tfsat_host.cli.calibrate.options import as_typed_here
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.calibration.certificate.campaign import Campaign
    from tfsat_host.calibration.certificate.certificate import Calibration
    from tfsat_host.calibration.solution import Known
    from tfsat_host.calibration.steps.evidence import Evidence
    from tfsat_host.calibration.steps.step import Step
    from tfsat_host.robot import RobotModel

    Reader = Callable[[Step, Known], Evidence]

OF_EMULATED = "These are the errors of an emulated robot: of no use for a real one."


class Terminal:
    """A session's operator at a terminal.

    Args:
        read: Has a step done and reads the sensors meanwhile, with what is known of them.
        steps: How many there are.
        model: The robot.
        args: The command's.
        out: Its voice.
    """

    def __init__(
        self, read: Reader, steps: int, model: RobotModel, args: argparse.Namespace, out: Output
    ) -> None:
        self.record = read
        self._steps, self._model, self._args, self._out = steps, model, args, out

    def refused(self, error: CalibrationError) -> None:
        """Asks whether to repeat it; raises the error where there is no terminal."""
        if not self._out.can_ask:
            raise error
        error.next_step = as_typed_here(error.next_step, self._args)
        self._out.error(error)
        self._out.ask("Enter repeats the step, q ends: ", meaning="This step was not accepted.", accept=("",))

    def accepted(self, step: Evidence, calibration: Calibration) -> None:
        """Says what was found."""
        from tfsat_host.calibration.findings import found_lines

        for line in () if self._out.json_mode else found_lines(step, calibration, self._model):
            self._out.note(f"  Accepted: {line}.")

    def resumed(self, number: int, step: Evidence) -> None:
        """Says that it was kept before."""
        taken = f"{step.taken.astimezone():%H:%M}"
        self._out.note(f"{number} of {self._steps}: {title(step.step)}: kept from {taken}.")


def give_result(
    args: argparse.Namespace,
    campaign: Campaign,
    kept: Sequence[Evidence],
    before: Calibration | None,
    model: RobotModel,
    out: Output,
) -> None:
    """The command's result, by its steps and what was known when it began."""
    from tfsat_host.calibration.certificate.certificate import commands_of, summarized
    from tfsat_host.calibration.findings import outcome
    from tfsat_host.present.terminal import show

    calibration = campaign.calibration
    if calibration is None:
        raise ValueError("nothing was accepted")
    found, parts = outcome(args.quantity, kept, before, calibration, model)
    lines = ["Nothing is missing for a drop."]
    if shortcomings := calibration.shortcomings():
        after = as_typed_here(commands_of(shortcomings)[0], args)
        lines = [f"For a drop: {summarized(shortcomings)}.", f"Next: {after}"]
    if calibration.subject.emulated:
        lines.append(OF_EMULATED)
    lines.append(f"Written to {campaign.certificate}.")
    joint = {} if getattr(args, "joint", None) is None else {"joint": args.joint}
    out.result({**joint, **found, "file": str(campaign.certificate)}, lambda: show((*parts, *lines), out))
