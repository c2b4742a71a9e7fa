"""A joint that its servo moves from stop to stop while the logger's samples come in: both boards at once."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from itertools import groupby
from typing import TYPE_CHECKING

from tfsat_host.calibration.steps.instructions import title
from tfsat_host.calibration.steps.step import bodies
from tfsat_host.cli.stopping import stop_wish, suspend_now
from tfsat_host.errors import Interrupted, RefusedError, TfsatError
from tfsat_host.present.output import NotConfirmed, Output
from tfsat_host.protocol.limits import JOG_IDLE_MS, JOG_SPEED_CDEG_S
from tfsat_host.units import CDEG_PER_DEG

if TYPE_CHECKING:
    from tfsat_host.calibration.sensors.joint_sensors import JointSensors
    from tfsat_host.calibration.steps.counts import Counts
    from tfsat_host.calibration.steps.evidence import Evidence
    from tfsat_host.calibration.steps.step import Step
    from tfsat_host.cli.calibrate.bench import Bench
    from tfsat_host.devices.jogging import JogEnd, JogTour
    from tfsat_host.devices.logger import LoggerClient
    from tfsat_host.protocol.messages import LiveReply, LiveSampleStream
    from tfsat_host.robot import RobotModel
    from tfsat_host.servo_settings import ServoSettings

SWEEP_HOLD_S = 1.0
LAST_SAMPLES_S = 0.02
"""At the end of a rest: what the logger has sent is in by then."""
LOOK_S = 0.8
SILENCE_S = 1.0
Look = Callable[["Counts"], None]
"""Looks at samples."""


class TourInterrupted(Interrupted):
    """Ctrl-C or Ctrl-Z while the joint moved or was held; it was let go.

    Attributes:
        details: For `--json`: the joint, and the angle in deg that was commanded last.
    """

    def __init__(self, tour: JogTour, end: JogEnd, how: str) -> None:
        from tfsat_host.devices.jogging import from_the_start, jog_details, last_commanded

        super().__init__(
            what=how,
            meaning=f"{last_commanded(tour.joint, end.angle_cdeg)} and was let go on its way; the sequencer is safe. "
            "Nothing of this step was kept.",
            next_step=from_the_start(tour.stops_cdeg[0])(end.angle_cdeg).capitalize(),
        )
        self.details = jog_details(tour.joint, end.angle_cdeg)


def sweep(step: Step, bench: Bench, out: Output) -> Evidence:
    """A sweep with the joint's servo doing what a hand would: through the same stops, as far as its limits allow.

    Raises:
        BoardRefusal, JogError, TfsatError: see `drive`.
        RefusedError: the person did not type JOG.
    """
    from tfsat_host.calibration.steps.evidence import Evidence
    from tfsat_host.calibration.steps.step import SWEEP_ROUNDS, SWEEP_STOPS_DEG
    from tfsat_host.devices.jogging import JogTour

    joint = step.moving_joint
    servo = bench.jog.settings().settings.of(joint)
    every_deg = SWEEP_STOPS_DEG + SWEEP_STOPS_DEG[1:] * (SWEEP_ROUNDS - 1)
    stops = [min(max(round(deg * CDEG_PER_DEG), servo.min_cdeg), servo.max_cdeg) for deg in every_deg]
    tour = JogTour(joint, tuple(stop for stop, _ in groupby(stops)), SWEEP_HOLD_S)
    ask_to_move(step, tour, bench, out)
    taken = datetime.now(UTC)
    return Evidence(step, drive(tour, step, bench, out), taken, bench.origin)


def measure_servo(
    joint: int,
    settings: ServoSettings,
    sensors: JointSensors,
    bench: Bench,
    model: RobotModel,
    out: Output,
) -> Evidence:
    """Asks, and has the servo visit each place of the plan; the joint ends limp.

    A joint that does not follow, or goes the wrong way, is let go at the first stop that shows it.

    Args:
        joint: 1 to 3.
        settings: In force on the sequencer.
        sensors: Of the joint, with a measured zero point.
        bench: Both boards.
        model: The robot.
        out: Where questions and progress go.

    Raises:
        RefusedError: it was not confirmed, or the joint is not where it should begin.
        CalibrationError: the servo does not follow.
        BoardRefusal, JogError, TfsatError: see `drive`.
    """
    from tfsat_host.calibration.servos.servo_map import HOLD_S, servo_plan
    from tfsat_host.calibration.servos.visits import Visits
    from tfsat_host.calibration.steps.evidence import Evidence
    from tfsat_host.calibration.steps.step import servo as servo_step
    from tfsat_host.devices.jogging import JogTour

    servo = settings.of(joint)
    plan = servo_plan(servo)
    tour = JogTour(joint, (plan[0], *plan), HOLD_S)  # at first the servo only takes hold of the joint
    step = servo_step(joint)
    ask_to_move(step, tour, bench, out)
    visits = Visits(tour.stops_cdeg, servo, sensors, model)
    taken = datetime.now(UTC)
    counts = drive(tour, step, bench, out, visits.check_start, visits.rested)
    setting = (servo.zero_us, servo.ns_per_deg, servo.reversed)
    return Evidence(step, counts, taken, bench.origin, visits=visits.known, servo_setting=setting)


def ask_to_move(step: Step, tour: JogTour, bench: Bench, out: Output) -> None:
    """Says what will move, and waits for JOG; with `--yes` for nothing.

    Raises:
        BoardRefusal, JogRefused: the sequencer would not move it.
        RefusedError: another word was typed.
        UsageError: there is no terminal to ask on, and no `--yes`.
    """
    bench.jog.check_tour(tour)
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
    bench: Bench,
    out: Output,
    begun: Look = lambda _: None,
    rested: Look = lambda _: None,
) -> Counts:
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
    from tfsat_host.calibration.steps.counts import Counts

    bench.mover.begin(step)
    with bench.logger.live() as scales:
        bench.logger.samples_of(bench.mover.lead_s)
        begun(_last([*bench.logger.live_samples(), *bench.logger.samples_of(LOOK_S)], scales))
        with stop_wish(before_suspension=True) as stopped, _progress(tour, out) as show:
            watch = _LoggedTour(bench.logger, show, lambda samples: rested(_last(samples, scales)))
            end = bench.jog.tour(tour, stopped, watch)
    if end.held:
        counts = Counts.from_live(watch.samples, scales)
        if counts.samples_lost:
            out.warn(
                f"{counts.samples_lost} of {len(counts.t_us) + counts.samples_lost} samples never arrived."
            )
        return counts
    if not stopped.suspend:
        raise TourInterrupted(tour, end, "Interrupted.")
    out.note(f"Ctrl-Z: joint {tour.joint} was let go at {end.angle_cdeg / CDEG_PER_DEG:g} deg.")
    suspend_now()
    raise TourInterrupted(tour, end, "Ctrl-Z let the joint go before the program stopped.")


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
    """

    def __init__(
        self,
        logger: LoggerClient,
        show: Callable[[int, int], None],
        rested: Callable[[Sequence[LiveSampleStream]], None],
    ) -> None:
        self.samples: list[LiveSampleStream] = []
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
        """Lets the caller look, once what the logger has sent is in."""
        before = len(self.samples)
        while len(self.samples) == before:
            self.pause(LAST_SAMPLES_S)
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
    last = -1
    with out.live(diagnostic=True) as draw:

        def show(stop: int, angle_cdeg: int) -> None:
            nonlocal last
            text = (
                f"joint {tour.joint}: {angle_cdeg / CDEG_PER_DEG:6.2f} deg, to "
                f"{tour.stops_cdeg[stop] / CDEG_PER_DEG:g} deg, stop {stop + 1} of {len(tour.stops_cdeg)}"
            )
            if draw is not None:
                draw(text)
            elif not out.json_mode and stop > last:
                out.note(f"  {text}")
                last = stop

        yield show
