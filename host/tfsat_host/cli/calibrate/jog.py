"""A joint that its servo moves from stop to stop while the logger's samples come in: both boards at once."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING

from tfsat_host.cli.advice import Interrupted
from tfsat_host.cli.calibrate.prompts import bodies, title
from tfsat_host.cli.stopping import stop_wish, suspend_now
from tfsat_host.errors import RefusedError, TfsatError
from tfsat_host.present.output import NotConfirmed, Output
from tfsat_host.protocol.limits import JOG_IDLE_MS, JOG_SPEED_CDEG_S
from tfsat_host.units import CDEG_PER_DEG

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tfsat_host.calibration.steps.counts import Counts
    from tfsat_host.calibration.steps.step import Step
    from tfsat_host.cli.calibrate.jog_bench import JogBench
    from tfsat_host.devices.jogging import JogEnd, JogTour
    from tfsat_host.devices.logger import LoggerClient
    from tfsat_host.protocol.messages import LiveReply, LiveSampleStream

SWEEP_HOLD_S = 1.0
LAST_SAMPLES_S = 0.02
"""At the end of a rest: what the logger has sent is in by then."""
LOOK_S = 0.8
SILENCE_S = 1.0
Look = Callable[["Counts"], None]
"""Looks at samples."""


@dataclass(frozen=True)
class Driven:
    """What came of a tour.

    Attributes:
        samples: All of it, in order.
        scales: Rate and scales of the samples.
        ends_us: When each stop's rest ended, on the logger's clock.
    """

    samples: Sequence[LiveSampleStream]
    scales: LiveReply
    ends_us: tuple[int, ...]


class TourInterrupted(Interrupted):
    """Ctrl-C or Ctrl-Z while the joint moved or was held; it was let go.

    Attributes:
        details: For `--json`: the joint, and the angle in deg that its servo was told last.
    """

    def __init__(self, tour: JogTour, end: JogEnd, how: str) -> None:
        from tfsat_host.devices.jogging import from_the_start, jog_details, last_told

        super().__init__(
            what=how,
            meaning=f"{last_told(tour.joint, end.angle_cdeg)} and was let go on its way; the sequencer is safe. "
            "Nothing of this step was kept.",
            next_step=from_the_start(tour.stops_cdeg[0])(end.angle_cdeg).capitalize(),
        )
        self.details = jog_details(tour.joint, end.angle_cdeg)


def _look_away(_: Counts) -> None:
    """Where nobody needs to look."""


def jogged_sweep(bench: JogBench, step: Step, out: Output) -> tuple[Sequence[LiveSampleStream], LiveReply]:
    """A sweep's samples, its servo doing what a hand would: through the same stops, as far as its limits allow.

    Raises:
        BoardRefusal, JogError, TfsatError: see `drive`.
        RefusedError: the person did not type JOG.
    """
    from tfsat_host.calibration.steps.step import SWEEP_ROUNDS, SWEEP_STOPS_DEG
    from tfsat_host.devices.jogging import JogTour

    joint = joint_of(step)
    servo = bench.sequencer.settings().settings.of(joint)
    every_deg = SWEEP_STOPS_DEG + SWEEP_STOPS_DEG[1:] * (SWEEP_ROUNDS - 1)
    stops = [min(max(round(deg * CDEG_PER_DEG), servo.min_cdeg), servo.max_cdeg) for deg in every_deg]
    tour = JogTour(joint, tuple(stop for stop, _ in groupby(stops)), SWEEP_HOLD_S)
    ask_to_move(step, tour, bench, out)
    driven = drive(tour, step, bench, out)
    return driven.samples, driven.scales


def joint_of(step: Step) -> int:
    """1 to 3. Raises ValueError for a step of no joint."""
    if step.joint is None:
        raise ValueError(f"{step.key} moves no joint")
    return step.joint


def ask_to_move(step: Step, tour: JogTour, bench: JogBench, out: Output) -> None:
    """Says what will move, and waits for JOG; with `--yes` for nothing.

    Raises:
        BoardRefusal, JogRefused: the sequencer would not move it.
        RefusedError: another word was typed.
        UsageError: there is no terminal to ask on, and no `--yes`.
    """
    bench.sequencer.check_tour(tour)
    if not (out.json_mode and out.yes):
        out.note(_explanation(step, tour))
    if out.yes:
        return
    try:
        out.ask("Type JOG to move it: ", meaning="Nothing was moved.", accept=("jog",))
    except NotConfirmed as error:  # an interlock, not the end of a series of steps
        raise RefusedError(what=error.what, meaning=error.meaning, next_step=error.next_step) from None


def drive(
    tour: JogTour,
    step: Step,
    bench: JogBench,
    out: Output,
    begun: Look = _look_away,
    rested: Look = _look_away,
) -> Driven:
    """Has the servo move the joint through the tour and keeps the logger's samples; the joint ends limp.

    Args:
        tour: The stops.
        step: Which bodies are held meanwhile.
        bench: Both boards.
        out: Where progress goes.
        begun: Given `LOOK_S` of the limp joint before it moves; what it raises is all that happens.
        rested: Given the last `LOOK_S` at the end of each rest; what it raises ends the tour.

    Raises:
        BoardRefusal, JogError: see `JogClient.tour`.
        TourInterrupted: Ctrl-C or Ctrl-Z; the joint was let go.
        TfsatError: the logger fell silent; the joint was let go.
    """
    bench.operator.begin(step)
    with bench.logger.live() as scales:
        bench.logger.samples_of(bench.operator.lead_s)
        begun(_last(_limp(bench.logger), scales))
        with stop_wish(before_suspension=True) as stopped, _progress(tour, out) as show:
            watch = _LoggedTour(bench.logger, show, lambda samples: rested(_last(samples, scales)))
            end = bench.sequencer.tour(tour, stopped, watch)
    if end.held:
        return Driven(watch.samples, scales, tuple(watch.ends_us))
    if not stopped.suspend:
        raise TourInterrupted(tour, end, "Interrupted.")
    out.note(f"Ctrl-Z: joint {tour.joint} was let go at {end.angle_cdeg / CDEG_PER_DEG:g} deg.")
    suspend_now()
    raise TourInterrupted(tour, end, "Ctrl-Z let the joint go before the program stopped.")


def _limp(logger: LoggerClient) -> Sequence[LiveSampleStream]:
    """Samples of the joint as it lies."""
    return [*logger.live_samples(), *logger.samples_of(LOOK_S)]


def _last(samples: Sequence[LiveSampleStream], scales: LiveReply) -> Counts:
    """The last `LOOK_S` of them, at least one."""
    from tfsat_host.calibration.steps.counts import Counts

    begin_us = samples[-1].time_us - round(LOOK_S * 1e6)
    first = bisect_left(samples, begin_us, key=lambda sample: sample.time_us)
    return Counts.from_live(samples[first:], scales)


class _LoggedTour:
    """Reads the logger while the sequencer moves the joint.

    Attributes:
        samples: So far.
        ends_us: When each rest ended, on the logger's clock: the time of the last sample that was in by then.
    """

    def __init__(
        self,
        logger: LoggerClient,
        show: Callable[[int, int], None],
        rested: Callable[[Sequence[LiveSampleStream]], None],
    ) -> None:
        self.samples: list[LiveSampleStream] = []
        self.ends_us: list[int] = []
        self.shown = show
        self._logger = logger
        self._rested = rested
        self._silent_s = 0.0

    def pause(self, duration_s: float) -> None:
        """Takes what the logger sends. Raises TfsatError when it has been silent for long."""
        fresh = self._logger.samples_of(duration_s)
        self.samples += fresh
        self._silent_s = 0.0 if fresh else self._silent_s + duration_s
        if self._silent_s > SILENCE_S:
            raise TfsatError(
                what=f"No live sample from the logger for {SILENCE_S:g} s.",
                meaning="It has stopped sampling, or its cable is loose. The joint was let go, nothing was kept.",
                next_step=f"Check the cable at {self._logger.port}, then the same command again.",
            )

    def rested(self, _stop: int) -> None:
        """Notes the time by the newest sample, and lets the caller look."""
        seen = len(self.samples)
        while len(self.samples) == seen:
            self.pause(LAST_SAMPLES_S)
        self.ends_us.append(self.samples[-1].time_us)
        self._rested(self.samples)


def _explanation(step: Step, tour: JogTour) -> str:
    joint, start_deg = tour.joint, tour.stops_cdeg[0] / CDEG_PER_DEG
    to_deg = max(tour.stops_cdeg) / CDEG_PER_DEG
    return "\n  ".join(
        (
            f"\n{title(step)}",
            f"Take the holding attachment off joint {joint} and leave it on the others. Lay the robot on its side, "
            f"so that gravity does not load joint {joint}.",
            f"Hold {bodies(step.held)} on the bench; {bodies(step.moved)} will move. Hands, hair and cables out of "
            "the joint's way.",
            f"The joint is limp now, and its first pulse takes it to {start_deg:g} deg at the servo's full speed: "
            f"bring it to {start_deg:g} deg by hand first.",
            f"Its servo then moves it to {to_deg:g} deg and back through {len(tour.stops_cdeg)} stops, "
            f"{tour.hold_s:g} s each, at {JOG_SPEED_CDEG_S / CDEG_PER_DEG:g} deg/s ({tour.duration_s:.0f} s in all), "
            "and lets go.",
            "Ctrl-C or Ctrl-Z lets it go at once, and so does the board "
            f"{JOG_IDLE_MS / 1000:g} s after this program's last order.",
        )
    )


@contextmanager
def _progress(tour: JogTour, out: Output) -> Iterator[Callable[[int, int], None]]:
    """Gives what shows stop and commanded angle (0.01 deg): in place on a terminal, else a line a stop."""
    told = -1
    with out.live(diagnostic=True) as draw:

        def show(stop: int, angle_cdeg: int) -> None:
            nonlocal told
            text = (
                f"joint {tour.joint}: {angle_cdeg / CDEG_PER_DEG:6.2f} deg, to "
                f"{tour.stops_cdeg[stop] / CDEG_PER_DEG:g} deg, stop {stop + 1} of {len(tour.stops_cdeg)}"
            )
            if draw is not None:
                draw(text)
            elif not out.json_mode and stop > told:
                out.note(f"  {text}")
                told = stop

        yield show
