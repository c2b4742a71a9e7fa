"""A step while it is read: a bar for each body, the joints' angles, and what comes next."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from tfsat_host.calibration.steps.step import Step, StepKind
from tfsat_host.cli.calibrate.prompts import bodies, title

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderResult

    from tfsat_host.calibration.progress import BodyLevel, StepProgress

_MET, _NOT_MET, _NAME = "green", "bold yellow", "bold"
_WIDEST = 40
_AROUND_BAR = 46
"""Columns of a body's line that are not its bar."""


@dataclass(frozen=True, slots=True)
class Picture:
    """For a terminal, drawn anew in its place; no line is wider than it."""

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
        heading = f"{title(self.step)}: {_time_words(progress)}"
        levels = [
            (_body_line(self.step, level, bar), _MET if level.met else _NOT_MET) for level in progress.levels
        ]
        lines = [(heading, _NAME), *levels, (_joint_words(progress), "")]
        if progress.stops_deg:
            lines.append((f"{rest_words(progress)}", _NAME))
        return lines


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
        parts.append(rest_words(progress))
    return ", ".join(parts)


def rest_words(progress: StepProgress) -> str:
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


def _time_words(progress: StepProgress) -> str:
    return f"at most {progress.left_s:.0f} s left" if progress.stops_deg else f"{progress.left_s:.0f} s left"


def _joint_words(progress: StepProgress) -> str:
    return "joint  " + "  ".join(
        f"{joint}: {angle:+6.1f} deg" for joint, angle in enumerate(progress.joint_deg, 1)
    )


def _body_line(step: Step, level: BodyLevel, width: int) -> str:
    role = _role(step, level.body)
    if level.limit_deg_s is None:
        return f"body {level.body} {role:<5}  {'':{width}}  {level.rate_deg_s:6.1f} deg/s"
    bar = _bar(level.rate_deg_s / level.limit_deg_s, width)
    return f"body {level.body} {role:<5} [{bar}] {level.rate_deg_s:6.1f} deg/s, {_limit_words(level)}"


def _role(step: Step, body: int) -> str:
    if body in step.moved:
        return "moved"
    if not step.moved:
        return "still"
    return "held" if body in step.held else "along"


def _limit_words(level: BodyLevel) -> str:
    return f"{'at least' if level.at_least else 'at most'} {level.limit_deg_s:.1f}"


def _bar(share: float, width: int) -> str:
    """Full at twice the limit, which is marked in the middle."""
    filled = round(width * min(1.0, share / 2.0))
    bar = list("#" * filled + " " * (width - filled))
    bar[width // 2] = "|"
    return "".join(bar)
