"""A step while it is read: a bar for each body, the joints' angles, and what comes next."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from tfsat_host.calibration.steps.instructions import title
from tfsat_host.calibration.steps.step import Step, StepKind, bodies
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderResult

    from tfsat_host.calibration.certificate.certificate import Calibration
    from tfsat_host.calibration.progress import BodyLevel, StepProgress
    from tfsat_host.calibration.solution import Solution
    from tfsat_host.calibration.steps.evidence import Evidence
    from tfsat_host.cli.calibrate.bench import Bench
    from tfsat_host.robot import RobotModel

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
        """Each line with its style."""
        progress = self.progress
        bar = max(10, min(_WIDEST, width - _AROUND_BAR))
        left = f"{'at most ' if progress.stops_deg else ''}{progress.left_s:.0f} s left"
        angles = (f"{joint}: {angle:+6.1f} deg" for joint, angle in enumerate(progress.joint_deg, 1))
        return [
            (f"{title(self.step)}: {left}", _NAME),
            *((_body_line(self.step, one, bar), _MET if one.met else _NOT_MET) for one in progress.levels),
            (f"joint  {'  '.join(angles)}", ""),
            *([(_rest_words(progress), _NAME)] if progress.stops_deg else []),
        ]


def line_of(step: Step, progress: StepProgress) -> str:
    """In one line, where there is no terminal."""
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
    """Which rest comes next, and how many there are."""
    total = len(progress.stops_deg)
    if progress.next_stop_deg is None:
        return f"all {total} rests are there"
    return f"rest at {progress.next_stop_deg:g} deg: {progress.rests + 1} of {total}"


def _right(step: Step) -> str:
    if step.kind in (StepKind.REST, StepKind.ZERO):
        return "all bodies are still"
    held = f", {bodies(step.held)} held" if step.held else ""
    return f"{bodies(step.moved)} moved{held}"


def _body_line(step: Step, level: BodyLevel, width: int) -> str:
    """With a bar that is full at twice the limit, which is marked in the middle."""
    role = _role(step, level.body)
    if level.limit_deg_s is None:
        return f"body {level.body} {role:<5}  {'':{width}}  {level.rate_deg_s:6.1f} deg/s"
    full = "#" * round(width * min(1.0, level.rate_deg_s / level.limit_deg_s / 2.0))
    bar = f"{full:<{width}}"
    bar = f"{bar[: width // 2]}|{bar[width // 2 + 1 :]}"
    return f"body {level.body} {role:<5} [{bar}] {level.rate_deg_s:6.1f} deg/s, {_limit_words(level)}"


def _role(step: Step, body: int) -> str:
    if body in step.moved:
        return "moved"
    if not step.moved:
        return "still"
    return "held" if body in step.held else "along"


def _limit_words(level: BodyLevel) -> str:
    return f"{'at least' if level.at_least else 'at most'} {level.limit_deg_s:.1f}"


def record(
    step: Step, bench: Bench, known: Solution | Calibration, model: RobotModel, out: Output
) -> Evidence:
    """Has the step done and reads it, until it is done or its time is over."""
    from tfsat_host.calibration.progress import Watch
    from tfsat_host.calibration.steps.evidence import LiveSource, pass_over, read_step

    bench.mover.begin(step)
    with bench.logger.live() as scales:
        live = LiveSource(bench.logger.live_samples, scales, bench.origin, lambda: datetime.now(UTC))
        pass_over(live, bench.mover.lead_s)
        with _shown(step, out) as show:
            evidence = read_step(step, live, Watch(step, scales, known, model, show))
    warn_of_losses(evidence, out)
    return evidence


def warn_of_losses(evidence: Evidence, out: Output) -> None:
    """Says how many samples never arrived."""
    lost = evidence.counts.samples_lost
    if lost:
        total = len(evidence.counts.t_us) + lost
        out.warn(f"{lost} of {total} samples never arrived ({title(evidence.step)}).")


@contextmanager
def _shown(step: Step, out: Output) -> Iterator[Callable[[StepProgress], None]]:
    """A picture in place on a terminal; else a line at the start and one each `LINE_S`; nothing with `--json`."""
    if out.json_mode:
        yield lambda _progress: None
        return
    with out.live(diagnostic=True) as draw:
        if draw is not None:
            yield lambda progress: draw(Picture(step, progress))
            return
        out.note("  Reading …")
        due_s = LINE_S

        def say(progress: StepProgress) -> None:
            nonlocal due_s
            if progress.elapsed_s >= due_s or progress.done:
                out.note(f"  {line_of(step, progress)}")
                due_s = progress.elapsed_s + LINE_S

        yield say
