"""The operator of a calibration at a terminal, and a command's result."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.calibration.steps.step import title
from tfsat_host.cli.calibrate.next_commands import as_typed_here
from tfsat_host.cli.calibrate.step_display import LINE_S, Picture, drawn_or_lines, line_of
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.calibration.certificate.campaign import Campaign
    from tfsat_host.calibration.certificate.certificate import Calibration
    from tfsat_host.calibration.progress import StepProgress
    from tfsat_host.calibration.solution import Known
    from tfsat_host.calibration.steps.evidence import Evidence
    from tfsat_host.calibration.steps.step import Step
    from tfsat_host.cli.calibrate.bench import Bench
    from tfsat_host.robot import RobotModel

    Reader = Callable[[Step, Known], Evidence]

OF_EMULATED = "These are the errors of an emulated robot: of no use for a real one."


def record(step: Step, bench: Bench, known: Known, model: RobotModel, out: Output) -> Evidence:
    """Has the step done and reads it, until it is done or its time is over."""
    from tfsat_host.calibration.progress import Watch
    from tfsat_host.calibration.steps.evidence import LiveSource, pass_over, read_step

    due_s = LINE_S

    def due(progress: StepProgress) -> bool:
        nonlocal due_s
        now = progress.elapsed_s >= due_s or progress.done
        due_s = progress.elapsed_s + LINE_S if now else due_s
        return now

    bench.mover.begin(step)
    with bench.logger.live() as scales:
        live = LiveSource(bench.logger.live_samples, scales, bench.origin, lambda: datetime.now(UTC))
        pass_over(live, bench.mover.lead_s)
        with drawn_or_lines(
            out, lambda now: Picture(step, now), lambda now: line_of(step, now), due, first="  Reading …"
        ) as show:
            evidence = read_step(step, live, Watch(step, scales, known, model, show))
    warn_of_losses(evidence, out)
    return evidence


def warn_of_losses(evidence: Evidence, out: Output) -> None:
    """Says how many samples never arrived."""
    if lost := evidence.counts.samples_lost:
        total = len(evidence.counts.t_us) + lost
        out.warn(f"{lost} of {total} samples never arrived ({title(evidence.step)}).")


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
