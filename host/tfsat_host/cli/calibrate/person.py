"""The operator of a calibration at a terminal: a step while it is read, and a command's result."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import TYPE_CHECKING, TypeVar

from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.steps.step import Step, StepKind, bodies, title
from tfsat_host.cli.calibrate.bench import Bench
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import sentences, show_facts, show_table
from tfsat_host.quantity import record

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderResult

    from tfsat_host.calibration.certificate.calibration_campaign import Campaign
    from tfsat_host.calibration.certificate.certificate import Calibration
    from tfsat_host.calibration.progress import BodyLevel, StepProgress
    from tfsat_host.calibration.solution import SensorKnowledge
    from tfsat_host.calibration.steps.evidence import Evidence
    from tfsat_host.robot import RobotModel

    Reader = Callable[[Step, SensorKnowledge], Evidence]


State = TypeVar("State")
LINE_S = 5.0
"""Where there is no terminal, a line each."""
_MET, _NOT_MET, _NAME = "green", "bold yellow", "bold"
_WIDEST = 40
_AROUND_BAR = 46
"""Columns of a body's line that are not its bar."""


@dataclass(frozen=True, slots=True)
class Picture:
    """For a terminal, drawn again in its place; no line is wider than it."""

    step: Step
    progress: StepProgress

    def __rich_console__(self, _console: Console, options: ConsoleOptions) -> RenderResult:
        """Rich asks how it looks at this width."""
        from rich.text import Text

        for line, style in self.lines(options.max_width):
            yield Text(line, style=style, no_wrap=True, overflow="ellipsis")

    def lines(self, width: int) -> list[tuple[str, str]]:
        """Return each line with its style."""
        progress = self.progress
        bar = max(10, min(_WIDEST, width - _AROUND_BAR))
        time_text = f"{'at most ' if progress.stops_deg else ''}{progress.left_s:.0f} s left"
        angles = (f"{joint}: {angle:+6.1f} deg" for joint, angle in enumerate(progress.joint_deg, 1))
        return [
            (f"{title(self.step)}: {time_text}", _NAME),
            *(
                (_body_line(self.step, level, bar), _MET if level.met else _NOT_MET)
                for level in progress.levels
            ),
            (f"joint  {'  '.join(angles)}", ""),
            *([(_rest_words(progress), _NAME)] if progress.stops_deg else []),
        ]


def line_of(step: Step, progress: StepProgress) -> str:
    """Format the progress of a step as one line, for output without a terminal."""
    wrong = [level for level in progress.levels if not level.met]
    state = "; ".join(
        f"body {level.body} {level.rate_deg_s:.1f} deg/s, {_limit_words(level)}" for level in wrong
    )
    parts = [f"{progress.elapsed_s:.0f} s", state or _right(step)]
    if step.joint is not None:
        parts.append(f"joint {step.joint} at {progress.joint_deg[step.joint - 1]:+.1f} deg")
    if progress.stops_deg:
        parts.append(_rest_words(progress))
    return ", ".join(parts)


def _rest_words(progress: StepProgress) -> str:
    """Describe the next rest and the number of rests."""
    total = len(progress.stops_deg)
    if progress.next_stop_deg is None:
        return f"all {total} rests are there"
    return f"rest at {progress.next_stop_deg:g} deg: {progress.rests + 1} of {total}"


def _right(step: Step) -> str:
    if step.kind in (StepKind.REST, StepKind.ZERO):
        return "all bodies are still"
    held_text = f", {bodies(step.held)} held" if step.held else ""
    return f"{bodies(step.moved)} moved{held_text}"


def _body_line(step: Step, level: BodyLevel, width: int) -> str:
    """Format a body's line, with a bar of its rate that is full at twice the limit.

    The limit is marked in the middle of the bar.
    """
    role = "moved" if level.body in step.moved else "held" if level.body in step.held else "along"
    name = f"body {level.body} {role if step.moved else 'still':<5}"
    rate = f"{level.rate_deg_s:6.1f} deg/s"
    if level.limit_deg_s is None:
        return f"{name}  {'':{width}}  {rate}"
    full = "#" * round(width * min(1.0, level.rate_deg_s / level.limit_deg_s / 2.0))
    bar = f"{full:<{width}}"
    return f"{name} [{bar[: width // 2]}|{bar[width // 2 + 1 :]}] {rate}, {_limit_words(level)}"


def _limit_words(level: BodyLevel) -> str:
    return f"{'at least' if level.at_least else 'at most'} {level.limit_deg_s:.1f}"


@contextmanager
def drawn_or_lines(
    out: Output,
    picture: Callable[[State], Picture | str],
    line: Callable[[State], str],
    due: Callable[[State], bool],
    *,
    first: str = "",
) -> Iterator[Callable[[State], None]]:
    """Shows a state: in place on a terminal, else a line whenever one is due; nothing with `--json`."""
    with out.live(diagnostic=True) as draw:

        def say(state: State) -> None:
            if due(state) and not out.json_mode:
                out.note(f"  {line(state)}")

        if draw is None and first and not out.json_mode:
            out.note(first)
        yield say if draw is None else lambda state: draw(picture(state))


def record_step(
    step: Step, bench: Bench, calibration: SensorKnowledge, model: RobotModel, out: Output
) -> Evidence:
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
            evidence = read_step(step, live, Watch(step, scales, calibration, model, show))
    warn_of_losses(evidence, out)
    return evidence


def warn_of_losses(evidence: Evidence, out: Output) -> None:
    """Says how many samples never arrived."""
    if lost := evidence.counts.samples_lost:
        total = len(evidence.counts.t_us) + lost
        out.warn(f"{lost} of {total} samples lost ({title(evidence.step)}).")


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

    def on_refused(self, error: CalibrationError) -> None:
        """Asks whether to repeat it; raises the error where there is no terminal."""
        if not self._out.can_ask:
            raise error
        self._out.error(error)
        self._out.ask(
            "Press Enter to repeat the step, q to quit: ", meaning="This step was not accepted.", accept=("",)
        )

    def on_accepted(self, step: Evidence, calibration: Calibration) -> None:
        """Says what was found."""
        from tfsat_host.calibration.findings import finding_lines

        for line in () if self._out.json_mode else finding_lines(step, calibration, self._model):
            self._out.note(f"  Accepted: {line}.")

    def on_resumed(self, number: int, step: Evidence) -> None:
        """Says that it was kept before."""
        time_text = f"{step.recorded_at.astimezone():%H:%M}"
        self._out.note(f"{number} of {self._steps}: {title(step.step)}: kept from {time_text}.")


def give_result(
    args: argparse.Namespace,
    campaign: Campaign,
    steps: Sequence[Evidence],
    before: Calibration | None,
    model: RobotModel,
    out: Output,
) -> None:
    """Print the command's result, from the steps kept and the calibration before it began."""
    from tfsat_host.calibration.finding_tables import StepsResult
    from tfsat_host.calibration.review import CERTIFICATE

    calibration = campaign.calibration
    if calibration is None:
        raise ValueError("nothing was accepted")
    result = StepsResult(args.quantity, steps, before, calibration, model)

    def show() -> None:
        show_table(result.table, out)
        sentences(result.bend_lines, out)
        show_facts(CERTIFICATE, campaign, out)

    joint = {} if getattr(args, "joint", None) is None else {"joint": args.joint}
    out.result({**joint, **record(result.columns, result), "file": str(campaign.certificate)}, show)
