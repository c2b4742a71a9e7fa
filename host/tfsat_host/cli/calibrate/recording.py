"""A step's samples, live from the logger, and how the screen follows them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from tfsat_host.cli.calibrate.picture import Picture, line_of
from tfsat_host.cli.calibrate.prompts import title
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from tfsat_host.calibration.progress import Known, StepProgress
    from tfsat_host.calibration.steps.counts import Counts
    from tfsat_host.calibration.steps.evidence import Evidence
    from tfsat_host.calibration.steps.step import Step
    from tfsat_host.cli.calibrate.bench import Bench
    from tfsat_host.cli.calibrate.jog_bench import JogBench
    from tfsat_host.protocol.messages import LiveReply, LiveSampleStream

LOOK_S = 0.5
"""On the logger's clock, as all of these."""
LINE_S = 5.0
"""Where there is no terminal, a line each."""


def record(step: Step, bench: Bench, known: Known, out: Output) -> Evidence:
    """Has the step done and reads it, until it is done or its time is over."""
    from tfsat_host.calibration.steps.reading import LiveSource, pass_over, read_step

    bench.operator.begin(step)
    with bench.logger.live() as scales:
        live = LiveSource(bench.logger.live_samples, scales, bench.origin, lambda: datetime.now(UTC))
        pass_over(live, bench.operator.lead_s)
        with _shown(step, out) as show:
            evidence = read_step(step, live, _Looks(step, scales, known, show))
    return _told_of_losses(evidence, out)


class _Looks:
    """Looks at a step each `LOOK_S`, and says when it has come to its end."""

    def __init__(
        self, step: Step, scales: LiveReply, known: Known, show: Callable[[StepProgress], None]
    ) -> None:
        self._step = step
        self._scales = scales
        self._known = known
        self._show = show
        self._parts: list[Counts] = []
        self._due_us = 0

    def __call__(self, fresh: Sequence[LiveSampleStream]) -> bool:
        """Whether these samples were the last."""
        from tfsat_host.calibration.progress import joined, progress_of
        from tfsat_host.calibration.steps.counts import Counts

        self._parts.append(Counts.from_live(fresh, self._scales))
        if fresh[-1].time_us < self._due_us:
            return False
        so_far = joined(self._parts)
        self._parts = [so_far]
        progress = progress_of(self._step, so_far, self._known)
        self._show(progress)
        self._due_us = fresh[-1].time_us + round(min(LOOK_S, progress.left_s) * 1e6)
        return progress.done


def record_jogged(step: Step, bench: JogBench, out: Output) -> Evidence:
    """Has the joint's servo sweep it, and reads the sensors meanwhile. Raises what `jogged_sweep` does."""
    from tfsat_host.calibration.steps.counts import Counts
    from tfsat_host.calibration.steps.evidence import Evidence
    from tfsat_host.cli.calibrate.jog import jogged_sweep

    taken = datetime.now(UTC)
    samples, scales = jogged_sweep(bench, step, out)
    evidence = Evidence(step, Counts.from_live(samples, scales), taken, bench.origin)
    return _told_of_losses(evidence, out)


def _told_of_losses(evidence: Evidence, out: Output) -> Evidence:
    lost = evidence.counts.samples_lost
    if lost:
        total = len(evidence.counts.t_us) + lost
        out.warn(f"{lost} of {total} samples never arrived ({title(evidence.step)}).")
    return evidence


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
