"""A step while it is read: a bar for each body, the joints' angles, and what comes next."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from tfsat_host.calibration.steps.step import Step, StepKind, bodies, title
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderResult

    from tfsat_host.calibration.progress import BodyLevel, StepProgress

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
