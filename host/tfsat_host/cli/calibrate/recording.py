"""A step's samples, live from the logger, and how the screen follows them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from tfsat_host.cli.calibrate.picture import Picture, line_of
from tfsat_host.cli.calibrate.prompts import title
from tfsat_host.cli.output import Output

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from tfsat_host.calibration.steps.counts import Counts
    from tfsat_host.calibration.steps.evidence import Evidence
    from tfsat_host.calibration.steps.progress import Known, StepProgress
    from tfsat_host.calibration.steps.step import Step
    from tfsat_host.cli.calibrate.bench import Bench
    from tfsat_host.cli.calibrate.jog_bench import JogBench
    from tfsat_host.devices.logger import LoggerClient
    from tfsat_host.protocol.messages import LiveReply, LiveSampleStream

LOOK_S = 0.5
"""On the logger's clock, as all of these."""
LINE_S = 5.0
"""Where there is no terminal, a line each."""


def record(step: Step, bench: Bench, known: Known, out: Output) -> Evidence:
    """Has the step done and reads it, until it is done or its time is over."""
    from tfsat_host.calibration.steps.counts import Counts

    bench.operator.begin(step)
    with bench.logger.live() as scales:
        _pass_over(bench.logger, bench.operator.lead_s)
        taken = datetime.now(UTC)
        samples: list[LiveSampleStream] = []
        parts: list[Counts] = []
        due_us = 0
        with _shown(step, out) as show:
            while True:
                fresh = bench.logger.live_samples()
                samples += fresh
                parts.append(Counts.from_live(fresh, scales))
                if fresh[-1].time_us < due_us:
                    continue
                progress, parts = _look(step, parts, known)
                show(progress)
                if progress.done:
                    break
                due_us = fresh[-1].time_us + round(min(LOOK_S, progress.left_s) * 1e6)
    return _evidence(step, samples, scales, taken, bench, out)


def record_jogged(step: Step, bench: JogBench, out: Output) -> Evidence:
    """Has the joint's servo sweep it, and reads the sensors meanwhile. Raises what `jogged_sweep` does."""
    from tfsat_host.cli.calibrate.jog import jogged_sweep

    taken = datetime.now(UTC)
    samples, scales = jogged_sweep(bench, step, out)
    return _evidence(step, samples, scales, taken, bench, out)


def _evidence(
    step: Step,
    samples: Sequence[LiveSampleStream],
    scales: LiveReply,
    taken: datetime,
    bench: Bench,
    out: Output,
) -> Evidence:
    from tfsat_host.calibration.steps.counts import Counts
    from tfsat_host.calibration.steps.evidence import Evidence

    counts = Counts.from_live(samples, scales)
    if counts.samples_lost:
        total = len(samples) + counts.samples_lost
        out.warn(f"{counts.samples_lost} of {total} samples never arrived ({title(step)}).")
    return Evidence(step, counts, taken, bench.origin)


def _look(step: Step, parts: Sequence[Counts], known: Known) -> tuple[StepProgress, list[Counts]]:
    """Where it stands, and the same samples in one piece."""
    from tfsat_host.calibration.steps.progress import joined, progress_of

    so_far = joined(parts)
    return progress_of(step, so_far, known), [so_far]


def _pass_over(logger: LoggerClient, lead_s: float) -> None:
    """Samples of the time in which a person gets ready."""
    if lead_s <= 0:
        return
    first = logger.live_samples()[0].time_us
    while logger.live_samples()[-1].time_us < first + lead_s * 1e6:
        pass


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
