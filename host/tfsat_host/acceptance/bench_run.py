"""Armed runs on the bench: the loopback of time, in which the logger dates the sequencer's strokes, and the supply.

The maneuver and the servo settings that the board held are put back afterwards, whatever happens.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace

import numpy as np

from tfsat_host.acceptance.bench import Bench, Task
from tfsat_host.acceptance.wires import STROKE_LINE_PINS
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.sensor_samples import SensorSamples
from tfsat_host.devices.board_errors import NoAnswer
from tfsat_host.devices.sequencer import StoredManeuver, maneuver_from_board
from tfsat_host.devices.serial_ports import PortError
from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.clocks import CRYSTAL_PPM, align_clocks
from tfsat_host.maneuver import Maneuver, Schedule, Stroke, four_stroke, schedule_maneuver
from tfsat_host.preflight.logger_queries import Trace, fetch_recording, record_and_remove
from tfsat_host.preflight.preflight_check import PreflightCheck, go, judge, no_go
from tfsat_host.protocol.enums import Origin, SequencerState
from tfsat_host.protocol.limits import JOINT_COUNT
from tfsat_host.sdlog import DropLog
from tfsat_host.servo_settings import ServoSettings

HANDS_TIMEOUT_S = 60.0
"""For two hands to let go of both switches."""
RUN_POLL_S = 0.5
"""An armed or running sequencer is asked twice a second at the most."""
AFTER_RUN_S = 2.0
MAX_STROKE_RESIDUAL_S = 100e-6
MAX_RELEASE_RESIDUAL_S = 1e-3
MAX_MOVED_DEG = 10.0
"""Of joints without servo power, while hands let go of the switches."""
STROKE_DEG = 40.0
PAPER_DEG = (59.0, 70.0)
"""The maneuver of the paper's drop: what a board flies that never received an upload."""


def check_time(bench: Bench) -> list[PreflightCheck]:
    """Fly the stored maneuver without servo power while the logger records, and compare the boards' dates.

    Raises:
        BoardRefusal: ARM was refused, such as for a switch that is open.
        TfsatError: nobody let go, or a recording failed.
    """
    with _restoring(bench) as stored:
        if stored.origin == Origin.FACTORY:
            bench.sequencer.upload(schedule_maneuver(four_stroke(*PAPER_DEG)))
        schedule = _schedule_of(bench.sequencer.read_back())
        log = record_and_remove(
            bench.logger,
            bench.logger.status(),
            Trace(),
            lambda: _run(bench, schedule, Task.PRESS_BOTH_UNPOWERED),
            fetch_recording,
        )
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
    last_s = schedule.strokes[-1].t_s
    shift_us = 1e6 * last_s * (1.0 / clock.slope - 1.0)
    strokes = [residual for residual in clock.residuals if residual.pair.event != "release"]
    release = [residual for residual in clock.residuals if residual.pair.event == "release"]
    worst_s = max((abs(residual.residual_s) for residual in strokes), default=0.0)
    rate = f"{clock.rate_ppm:+.1f} ± {clock.rate_ppm_std:.1f} ppm"
    checks = [
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
        judge(
            [rate] if abs(clock.rate_ppm) > CRYSTAL_PPM else [],
            f"Clock ratio: {{}} (limit {CRYSTAL_PPM:g}).",
            "Change the board whose crystal is off.",
            f"Clock ratio: Micro against Teensy {rate}, {shift_us:+.0f} µs at the last stroke.",
            rate_ppm=clock.rate_ppm,
            rate_ppm_std=clock.rate_ppm_std,
            at_last_stroke_us=shift_us,
        ),
        judge(
            [f"{1e6 * worst_s:.0f} µs"]
            if worst_s > MAX_STROKE_RESIDUAL_S or not all(r.used for r in strokes)
            else [],
            f"Stroke times: residual {{}} (limit {1e6 * MAX_STROKE_RESIDUAL_S:.0f} µs).",
            "Repeat the step; if it stays, flash the sequencer again.",
            f"Stroke times: within {1e6 * worst_s:.0f} µs of the schedule, clock ratio removed.",
            scheduled_s=[residual.pair.clock_s for residual in strokes],
            residual_us=[1e6 * residual.residual_s for residual in strokes],
        ),
    ]
    for residual in release:
        apart_s = abs(residual.residual_s)
        checks.append(
            judge(
                [f"{1e3 * apart_s:.1f} ms"] if apart_s > MAX_RELEASE_RESIDUAL_S else [],
                "Release: both boards' dates differ by {}.",
                "Check the switches' wires to both boards; repeat the step.",
                f"Release: both boards' dates agree within {max(1.0, 1e6 * apart_s):.0f} µs.",
                apart_us=1e6 * residual.residual_s,
            )
        )
    return checks


def check_supply(bench: Bench) -> PreflightCheck:
    """Start one, two and three servos at once; a restart of the sequencer shows in its uptime.

    Stops at the first number that the supply does not carry. Raises as `check_time`.
    """
    carried, restarts = 0, ""
    with _restoring(bench):
        settings = bench.sequencer.settings().settings
        for at_once in range(1, JOINT_COUNT + 1):
            bench.sequencer.write_settings(replace(settings, moving_at_once=at_once))
            schedule = _together(at_once)
            bench.sequencer.upload(schedule)
            if restarts := _restarts(bench, schedule, at_once):
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
    return go(f"Supply: {carried} {several} at once without a restart{at_more}.", moving_at_once=carried)


def _restarts(bench: Bench, schedule: Schedule, at_once: int) -> str:
    """Fly once and describe the restart that it caused; empty: none."""
    before = bench.sequencer.status()
    began_s = bench.logger.now_s()
    # A restart takes the USB link with it: then `_run` has found the board again.
    with suppress(NoAnswer, PortError):
        _run(bench, schedule, Task.PRESS_BOTH_POWERED, at_once)
    after = bench.sequencer.status()
    passed_ms = 1000 * (bench.logger.now_s() - began_s)
    if after.uptime_ms - before.uptime_ms > 0.5 * passed_ms:
        return ""
    return f"up for {after.uptime_ms / 1000:.0f} s, {after.reset_cause.name.lower().replace('_', ' ')}"


def _run(bench: Bench, schedule: Schedule, task: Task, number: int = 0) -> None:
    """Arm with both switches pressed, have them let go, wait for the end of the run; disarm whatever happens.

    Raises:
        BoardRefusal: ARM was refused.
        NoAnswer, PortError: the link broke; the sequencer was found again and disarmed.
        TfsatError: nobody let go.
        StillArmed: it could not be disarmed.
    """
    bench.hands.do(task, number)
    bench.sequencer.arm()
    try:
        bench.hands.do(Task.LET_GO)
        deadline_s = bench.sequencer.now_s() + HANDS_TIMEOUT_S
        while bench.sequencer.status().state == SequencerState.ARMED:
            if bench.sequencer.now_s() > deadline_s:
                raise TfsatError(
                    what=f"Both switches were not let go within {HANDS_TIMEOUT_S:g} s.",
                    meaning="The sequencer was disarmed; nothing moved.",
                    next_step="Repeat the step.",
                )
            bench.sequencer.wait(RUN_POLL_S)
        bench.sequencer.wait(schedule.end_s + AFTER_RUN_S)
    finally:
        bench.disarm()


@contextmanager
def _restoring(bench: Bench) -> Iterator[StoredManeuver]:
    """Give what the board holds; afterwards it holds that again, or the paper's maneuver in place of the factory's."""
    stored, settings = bench.sequencer.read_back(), bench.sequencer.settings().settings
    try:
        yield stored
    except BaseException:
        # What went wrong is graver than a maneuver that could not be put back: preflight compares that.
        with suppress(TfsatError):
            _put_back(bench, stored, settings)
        raise
    _put_back(bench, stored, settings)


def _put_back(bench: Bench, stored: StoredManeuver, settings: ServoSettings) -> None:
    if bench.sequencer.settings().settings != settings:
        bench.sequencer.write_settings(settings)
    if bench.sequencer.read_back().crc != stored.crc:
        bench.sequencer.upload(_schedule_of(stored))


def _schedule_of(stored: StoredManeuver) -> Schedule:
    return schedule_maneuver(maneuver_from_board(stored))


def _together(at_once: int) -> Schedule:
    """Return a schedule in which joints 1 to `at_once` open together, and close together."""
    strokes = [
        Stroke(joint, sign * STROKE_DEG, t_s)
        for sign, t_s in ((1, 0.7), (-1, 1.4))
        for joint in range(1, at_once + 1)
    ]
    return schedule_maneuver(Maneuver(tuple(strokes), name=f"{at_once} at once"))
