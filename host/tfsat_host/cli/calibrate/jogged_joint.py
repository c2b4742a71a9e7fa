"""A joint that its servo moves from stop to stop while the logger's samples come in: both boards at once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from tfsat_host.calibration.steps.step import Step
from tfsat_host.calibration.steps.step import servo as servo_step
from tfsat_host.cli.calibrate.bench import Bench
from tfsat_host.cli.calibrate.person import drawn_or_lines, warn_of_losses
from tfsat_host.cli.stopping import stop_wish, suspend_now
from tfsat_host.devices.jog_path import JogInterrupted, JogTour, from_the_start
from tfsat_host.errors import RefusedError
from tfsat_host.present.output import NotConfirmed, Output
from tfsat_host.servo_settings import ServoSettings
from tfsat_host.units import CDEG_PER_DEG

if TYPE_CHECKING:
    from tfsat_host.calibration.sensors.joint_sensors import JointSensors
    from tfsat_host.calibration.steps.counts import Counts
    from tfsat_host.calibration.steps.evidence import Evidence
    from tfsat_host.robot import RobotModel


def sweep(step: Step, bench: Bench, out: Output) -> Evidence:
    """Sweep a joint by its servo instead of by hand. Raises as `drive` does."""
    from tfsat_host.calibration.servos.tour import SWEEP_HOLD_S, sweep_stops_cdeg

    stops_cdeg = sweep_stops_cdeg(bench.jog.settings().settings.of(step.moving_joint))
    return drive(JogTour(step.moving_joint, stops_cdeg, SWEEP_HOLD_S), step, bench, out)


def measure_servo(
    joint: int,
    settings: ServoSettings,
    sensors: JointSensors,
    bench: Bench,
    model: RobotModel,
    out: Output,
) -> Evidence:
    """Has the servo visit each place of the plan; let go at the first stop at which it does not follow.

    `settings` are those in force on the sequencer, `sensors` the joint's, with a measured zero point.

    Raises:
        RefusedError: it was not confirmed, or the joint is not where it should begin.
        CalibrationError: the servo does not follow.
        BoardRefusal, JogError, TfsatError: see `drive`.
    """
    from tfsat_host.calibration.servos.servo_map import HOLD_S, servo_plan
    from tfsat_host.calibration.servos.tour import Visits

    servo, plan = settings.of(joint), servo_plan(settings.of(joint))
    tour = JogTour(joint, (plan[0], *plan), HOLD_S)  # at first the servo only takes hold of the joint
    visits = Visits(tour.stops_cdeg, servo, sensors, model)
    evidence = drive(tour, servo_step(joint), bench, out, visits.check_start, visits.add_rest)
    setting = (servo.zero_us, servo.ns_per_deg, servo.reversed)
    return replace(evidence, visits=visits.known, servo_setting=setting)


def drive(
    tour: JogTour,
    step: Step,
    bench: Bench,
    out: Output,
    begun: Callable[[Counts], None] = lambda _: None,
    rested: Callable[[Counts], None] = lambda _: None,
) -> Evidence:
    """Asks, has the servo move the joint through the tour, and keeps the logger's samples; the joint ends limp.

    `step` tells which bodies are held meanwhile. `begun` is given `LOOK_S` of the limp joint before it moves;
    what it raises is all that happens. `rested`: see `LoggedTour`.

    Raises:
        RefusedError, UsageError: it was not confirmed.
        BoardRefusal, JogError: see `JogClient.tour`.
        JogInterrupted: Ctrl-C or Ctrl-Z; the joint was let go.
        TfsatError: the logger fell silent; the joint was let go.
    """
    from tfsat_host.calibration.servos.tour import LOOK_S, LoggedTour, latest
    from tfsat_host.calibration.steps.counts import Counts
    from tfsat_host.calibration.steps.evidence import Evidence

    _ask_to_move(step, tour, bench, out)
    recorded_at, last = datetime.now(UTC), -1

    def line(at: tuple[int, int]) -> str:
        angle = f"{at[1] / CDEG_PER_DEG:6.2f} deg, to {tour.stops_cdeg[at[0]] / CDEG_PER_DEG:g} deg"
        return f"joint {tour.joint}: {angle}, stop {at[0] + 1} of {len(tour.stops_cdeg)}"

    def due(at: tuple[int, int]) -> bool:
        nonlocal last
        before, last = last, at[0]
        return before < last

    bench.mover.begin(step)
    with bench.logger.live() as scales:
        bench.logger.samples_of(bench.mover.lead_s)
        begun(latest([*bench.logger.live_samples(), *bench.logger.samples_of(LOOK_S)], scales))
        with stop_wish(before_suspension=True) as stopped, drawn_or_lines(out, line, line, due) as show:
            watch = LoggedTour(bench.logger.samples_of, scales, lambda *at: show(at), rested)
            end = bench.jog.tour(tour, stopped, watch)
    if end.held:
        evidence = Evidence(step, Counts.from_live(watch.samples, scales), recorded_at, bench.origin)
        warn_of_losses(evidence, out)
        return evidence
    what = "Interrupted."
    if stopped.suspend:
        out.note(f"Ctrl-Z: joint {tour.joint} limp, last commanded {end.angle_cdeg / CDEG_PER_DEG:g} deg.")
        suspend_now()
        what = "Ctrl-Z let the joint go before the program stopped."
    again = from_the_start(tour.stops_cdeg[0])
    raise JogInterrupted(tour.joint, end, what, again, " Nothing of this step was kept.")


def _ask_to_move(step: Step, tour: JogTour, bench: Bench, out: Output) -> None:
    """Says what will move, and waits for JOG; with `--yes` for nothing.

    Raises:
        BoardRefusal, JogRefused: the sequencer would not move it.
        RefusedError: another word was typed.
        UsageError: there is no terminal to ask on, and no `--yes`.
    """
    from tfsat_host.calibration.servos.tour import tour_task

    bench.jog.check_tour(tour)
    if not (out.json_mode and out.yes):
        out.note("\n" + "\n  ".join(tour_task(step, tour.stops_cdeg, tour.hold_s, tour.duration_s)))
    if out.yes:
        return
    try:
        out.ask("Type JOG to move it: ", meaning="Nothing was moved.", accept=("jog",))
    except NotConfirmed as error:  # an interlock, not the end of a series of steps
        raise RefusedError(what=error.what, meaning=error.meaning, next_step=error.next_step) from None
