"""Armed runs on the bench: the loopback of time, in which the logger dates the sequencer's strokes, and the supply.

The maneuver and the servo settings that the board held are put back afterwards, whatever happens.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import product

import numpy as np

from tfsat_host.acceptance.angle_wiring import travel_deg
from tfsat_host.acceptance.bench import Bench, StillArmed, Task
from tfsat_host.acceptance.servo_check import joint_angles_deg
from tfsat_host.acceptance.wires import STROKE_LINE_PINS
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.sensor_samples import SensorSamples
from tfsat_host.devices.sequencer import maneuver_from_board
from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.clock_fit import ClockFit
from tfsat_host.evaluation.clocks import CRYSTAL_PPM, align_clocks
from tfsat_host.maneuver import Maneuver, Schedule, Stroke, schedule_maneuver
from tfsat_host.next_step import NextStep
from tfsat_host.preflight.logger_queries import Trace, fetch_recording, record_and_remove
from tfsat_host.preflight.preflight_check import PreflightCheck, go, judge, no_go
from tfsat_host.protocol.enums import Origin, SequencerState
from tfsat_host.protocol.limits import JOINT_COUNT
from tfsat_host.sdlog import DropLog
from tfsat_host.units import CDEG_PER_DEG

HANDS_TIMEOUT_S = 60.0
"""For two hands to let go of both switches."""
RUN_POLL_S = 0.5
"""An armed or running sequencer is asked twice a second at the most."""
AFTER_RUN_S = 2.0
MAX_STROKE_RESIDUAL_S = 100e-6
MAX_RELEASE_RESIDUAL_S = 1e-3
SMALL_DEG, SMALL_AT_S = 8.0, (0.70, 1.05, 1.47, 1.82, 2.12, 2.42)
"""Strokes of the loopback: small, should somebody have left the servos' power on."""
MAX_MOVED_DEG = 5.0
"""Of joints without servo power, while hands let go of the switches."""
STROKE_DEG, MIN_OPENED_DEG = 40.0, 20.0
MIN_UPTIME_SHARE = 0.95
"""Of the time that passed: a board whose uptime grew by less has restarted."""


def check_time(bench: Bench, closed_rad: Sequence[float] | None) -> list[PreflightCheck]:
    """Fly small strokes without servo power while the logger records, and compare the boards' dates.

    Args:
        bench: With the servos' power off.
        closed_rad: Of each angle sensor, what it shows with its joint closed; None: not known.

    Raises:
        BoardRefusal: ARM was refused, such as for a switch or joint that is open.
        TfsatError: the run was not flown, or a recording failed.
        StillArmed: see `Bench.disarm`.
    """
    trace, schedule = Trace(), _one_by_one()
    try:
        with _restoring(bench):
            bench.sequencer.upload(schedule)
            log = record_and_remove(
                bench.logger,
                bench.logger.status(),
                trace,
                lambda: _run(bench, schedule, closed_rad, Task.PRESS_BOTH_UNPOWERED),
                fetch_recording,
            )
    finally:
        if trace.left:
            bench.note(f"  {trace.left}")
    angles = np.unwrap(SensorSamples.from_counts(Counts.from_log(log)).sensor_angle_rad, axis=0)
    moved_deg = float(np.rad2deg(np.ptp(angles, axis=0).max()))
    if moved_deg > MAX_MOVED_DEG:
        return [
            no_go(
                f"Servo power was on: a joint moved by {moved_deg:.0f} deg in the loopback of time.",
                "Switch S4 off, then repeat the step.",
                moved_deg=moved_deg,
            )
        ]
    return judge_time(log, schedule)


def judge_time(log: DropLog, schedule: Schedule) -> list[PreflightCheck]:
    """Judge the stroke line, the ratio of the clocks, the strokes' times and the two dates of the release."""
    pin_out, pin_in = STROKE_LINE_PINS
    edges = sum(event.name == "stroke" for event in log.events)
    clock = align_clocks(log, schedule).sequencer
    starts = len({stroke.t_us for stroke in schedule.strokes})
    if not edges or clock is None:
        return [
            no_go(
                f"Stroke line: the logger saw {edges} edges of {starts} strokes: Micro D{pin_out} does not reach "
                f"Teensy pin {pin_in}.",
                "Check the wire and common ground, then repeat the step.",
                edges=edges,
                strokes=starts,
            )
        ]
    return [
        judge(
            []
            if edges == starts
            else [f"{edges} edges of {starts} strokes (Micro D{pin_out} to Teensy pin {pin_in})"],
            "Stroke line: {}.",
            "Check wire and ground; keep it away from the servos' cables.",
            f"Stroke line: {edges} of {starts} strokes seen.",
            edges=edges,
            strokes=starts,
        ),
        _judge_ratio(clock, schedule),
        *_judge_dates(clock),
    ]


def _judge_ratio(clock: ClockFit, schedule: Schedule) -> PreflightCheck:
    """Judge the ratio of the clocks, and say what it moves the last stroke by."""
    # A Micro that runs fast strokes early.
    shift_us = 1e6 * schedule.strokes[-1].t_s * (clock.slope - 1.0)
    rate = f"{clock.rate_ppm:+.1f} ± {clock.rate_ppm_std:.1f} ppm"
    return judge(
        [rate] if abs(clock.rate_ppm) > CRYSTAL_PPM else [],
        f"Clock ratio: {{}} (limit {CRYSTAL_PPM:g}).",
        "Change the board whose crystal is off.",
        f"Clock ratio: Micro against Teensy {rate}, {shift_us:+.0f} µs at the last stroke.",
        rate_ppm=clock.rate_ppm,
        rate_ppm_std=clock.rate_ppm_std,
        at_last_stroke_us=shift_us,
    )


def _judge_dates(clock: ClockFit) -> list[PreflightCheck]:
    """Judge the dates of the strokes and of the release, the ratio of the clocks removed."""
    strokes = [residual for residual in clock.residuals if residual.pair.event != "release"]
    worst_s = max((abs(residual.residual_s) for residual in strokes), default=0.0)
    late = worst_s > MAX_STROKE_RESIDUAL_S or not all(residual.used for residual in strokes)
    releases = [residual.residual_s for residual in clock.residuals if residual.pair.event == "release"]
    return [
        judge(
            [f"{1e6 * worst_s:.0f} µs"] if late else [],
            f"Stroke times: residual {{}} (limit {1e6 * MAX_STROKE_RESIDUAL_S:.0f} µs).",
            "Repeat the step; if it stays, flash the sequencer again.",
            f"Stroke times: within {max(1.0, 1e6 * worst_s):.0f} µs of the schedule, clock ratio removed.",
            scheduled_s=[residual.pair.clock_s for residual in strokes],
            residual_us=[1e6 * residual.residual_s for residual in strokes],
        ),
        *(
            judge(
                [f"{1e3 * abs(apart_s):.1f} ms"] if abs(apart_s) > MAX_RELEASE_RESIDUAL_S else [],
                "Release: both boards' dates differ by {}.",
                "Check the switches' wires to both boards; repeat the step.",
                f"Release: both boards' dates agree within {max(1.0, 1e6 * abs(apart_s)):.0f} µs.",
                apart_us=1e6 * apart_s,
            )
            for apart_s in releases
        ),
    ]


def check_supply(bench: Bench, closed_rad: Sequence[float]) -> PreflightCheck:
    """Start one, two and three servos at once; a restart of the sequencer shows in its uptime.

    Stops at the first number that the supply does not carry. Raises as `check_time`.
    """
    carried, restarts = 0, ""
    with _restoring(bench):
        settings = bench.sequencer.settings().settings
        for at_once in bench.joints:
            bench.sequencer.write_settings(replace(settings, moving_at_once=at_once))
            schedule = _together(at_once)
            bench.sequencer.upload(schedule)
            if restarts := _find_restart(bench, schedule, closed_rad, at_once):
                break
            carried = at_once
    several = "servo" if carried == 1 else "servos"
    if carried < settings.moving_at_once:
        return no_go(
            f"Supply: the sequencer restarted when {carried + 1} started at once ({restarts}); "
            f"its settings allow {settings.moving_at_once}.",
            "Check battery, S3, S4 and the common ground: the pulses of a stroke are lost in a restart.",
            moving_at_once=carried,
        )
    at_more = f"; it restarted at {carried + 1}: keep moving_at_once at {carried}" if restarts else ""
    return go(
        f"Supply: {carried} {several} at once without a restart, the USB cable plugged{at_more}.",
        moving_at_once=carried,
    )


def _find_restart(bench: Bench, schedule: Schedule, closed_rad: Sequence[float], at_once: int) -> str:
    """Fly once and describe the restart that it caused; empty: none, and the joints moved."""
    before = bench.sequencer.status()
    began_s = bench.logger.now_s()
    samples, failure = None, None
    try:
        samples = _run(bench, schedule, closed_rad, Task.PRESS_BOTH_POWERED, at_once)
    except StillArmed:
        raise
    except TfsatError as error:
        # A restart takes the USB link with it, or leaves strokes unflown: then `_run` has found the board again.
        failure = error
    after = bench.sequencer.status()
    passed_ms = 1000 * (bench.logger.now_s() - began_s)
    if after.uptime_ms - before.uptime_ms < MIN_UPTIME_SHARE * passed_ms:
        return f"up for {after.uptime_ms / 1000:.0f} s, {after.reset_cause.name.lower().replace('_', ' ')}"
    if failure is not None:
        raise failure
    # A supply that carried nothing has shown nothing.
    moved_deg = (
        np.abs(travel_deg(samples)).reshape(JOINT_COUNT, -1).max(axis=1)[:at_once] if samples else [0.0]
    )
    if min(moved_deg) < MIN_OPENED_DEG:
        raise TfsatError(
            what=f"A joint moved by {min(moved_deg):.0f} deg only, told {STROKE_DEG:g}.",
            meaning="The supply was not tried.",
            next_step="Switch S4 on, see that the joints are free, then repeat the step.",
        )
    return ""


def _run(
    bench: Bench, schedule: Schedule, closed_rad: Sequence[float] | None, task: Task, number: int = 0
) -> SensorSamples:
    """Arm with both switches pressed, have them let go, read the sensors to the end of the run, disarm.

    Raises:
        BoardRefusal: ARM was refused.
        NoAnswer, PortError: the link broke; the sequencer was found again and disarmed.
        TfsatError: it was not flown to its end.
        StillArmed: it could not be disarmed.
    """
    bench.hands.do(task, number)
    # Armed, the servos hold 0 deg: a joint that is open would snap shut. The board refuses what is reported open.
    if closed_rad is not None:
        angles = joint_angles_deg(bench.read(0.5), np.array(closed_rad), bench.robot)
        bench.sequencer.report_joints([round(angle * CDEG_PER_DEG) for angle in angles.tolist()])
    try:
        bench.sequencer.arm()
        bench.hands.do(Task.LET_GO)
        deadline_s = bench.sequencer.now_s() + HANDS_TIMEOUT_S
        while bench.sequencer.status().state == SequencerState.ARMED:
            if bench.sequencer.now_s() > deadline_s:
                raise _not_flown(f"Both switches were not let go within {HANDS_TIMEOUT_S:g} s")
            bench.sequencer.wait(RUN_POLL_S)
        samples = bench.read(schedule.end_s + AFTER_RUN_S)
        status = bench.sequencer.status()
        if status.state != SequencerState.DONE or status.strokes_started != len(schedule.strokes):
            begun = f"{status.strokes_started} of {len(schedule.strokes)} strokes began"
            raise _not_flown(f"The run did not end ({begun}): were the switches pressed again?")
        return samples
    finally:
        bench.disarm()


def _not_flown(what: str) -> TfsatError:
    return TfsatError(
        what=f"{what.rstrip('.')}.",
        meaning="The sequencer was disarmed; nothing was concluded.",
        next_step="Repeat the step: let go of both switches, and leave them for some seconds.",
    )


@contextmanager
def _restoring(bench: Bench) -> Iterator[None]:
    """Have the board hold afterwards what it holds now; the factory's maneuver becomes an uploaded one."""
    stored, settings = bench.sequencer.read_back(), bench.sequencer.settings().settings
    try:
        yield
    finally:
        try:
            if bench.sequencer.settings().settings != settings:
                bench.sequencer.write_settings(settings)
            if bench.sequencer.read_back().crc != stored.crc:
                bench.sequencer.upload(schedule_maneuver(maneuver_from_board(stored)))
        except TfsatError as error:
            # What went wrong before is graver, and goes on; this is said beside it.
            bench.note(
                f"  What the sequencer held was not put back ({error.what}) Before a drop: "
                f"{NextStep('upload-sequence')} and {NextStep('upload-servos')}"
            )
        else:
            if stored.origin == Origin.FACTORY:
                bench.note(
                    f"  The sequencer holds the factory's maneuver again, as an uploaded one (CRC {stored.crc:04x})."
                )


def _one_by_one() -> Schedule:
    """Return small strokes, one at a time, over the time of a fall."""
    strokes = [
        Stroke(joint, sign * SMALL_DEG, t_s)
        for (sign, joint), t_s in zip(product((1, -1), (1, 2, 3)), SMALL_AT_S, strict=True)
    ]
    return schedule_maneuver(Maneuver(tuple(strokes), name="loopback of time"))


def _together(at_once: int) -> Schedule:
    """Return a schedule in which joints 1 to `at_once` open together, and close together."""
    strokes = [
        Stroke(joint, sign * STROKE_DEG, t_s)
        for sign, t_s in ((1, 0.7), (-1, 1.4))
        for joint in range(1, at_once + 1)
    ]
    return schedule_maneuver(Maneuver(tuple(strokes), name=f"{at_once} at once"))
