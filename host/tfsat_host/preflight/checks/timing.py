"""Clocks and sampling: what a recording's date, a stroke's moment and a sample's time rest on."""

from __future__ import annotations

import math
from datetime import UTC, datetime, timedelta

import numpy as np

from tfsat_host.next_step import Advice, NextStep
from tfsat_host.preflight.live_sensors import sensors_of
from tfsat_host.preflight.preflight_check import PreflightCheck, go, judge, no_go, not_made
from tfsat_host.preflight.preflight_evidence import Evidence, Missing, Pace, require
from tfsat_host.units import US_PER_S

EARLIEST = datetime(2026, 1, 1, tzinfo=UTC)
"""This program is not older."""
BEHIND = timedelta(minutes=1)
"""By so much two computers of one team may differ."""
MAX_CLOCK_DIFFERENCE_S = 2.0
"""Between logger and computer: landings and calibrations are ordered by it, and minutes lie between them."""
_SHOWN_S = 0.1
MAX_CLOCK_RATE_ERROR = 5e-3
"""Relative. Crystals are within 1e-4; by 5e-3 the last stroke would come 11 ms off, one sample period and the next."""
MAX_JITTER_US = 100.0
"""Root mean square. At 200 deg/s a sample that comes 100 us late is 0.02 deg off, less than an angle sensor's step."""
RATE_TOLERANCE = 1e-3
"""Relative, on the logger's own clock: the timer and the clock are one crystal's."""
MIN_RATE_HZ = 100
"""The shortest stroke speeds up within 0.05 s, of which five samples show the shape."""
RANGE_OVER_RATE = 1.5
"""A body turns with its joint, against it, and with what the release left: a gyro needs more than the fastest joint."""
_SET = Advice(NextStep("logger-settings set", ("--clock",)))


def check_clock(evidence: Evidence) -> PreflightCheck:
    """Check that the computer's time of day is plausible, and that the logger's clock agrees with it."""
    now = f"{evidence.now.astimezone(UTC):%Y-%m-%d %H:%M} UTC"
    numbers: dict[str, object] = {"computer": evidence.now.astimezone(UTC).isoformat()}
    # The computer's clock first, as the logger's is judged by it.
    if behind := _behind(evidence):
        newest, whose = behind
        return no_go(
            f"Computer's clock: {now}, before {whose} of {newest.astimezone(UTC):%Y-%m-%d %H:%M} UTC.",
            Advice("Set this computer's clock, then the logger's: ", _SET),
            **numbers,
        )
    logger = require(evidence.logger)
    if not logger.status.unix_us:
        return no_go("Logger's clock: not set since power on.", _SET, **numbers, logger=None)
    apart_s = logger.status.unix_us / US_PER_S - logger.computer_unix_s
    numbers["logger_apart_s"] = apart_s
    if abs(apart_s) > MAX_CLOCK_DIFFERENCE_S:
        return no_go(
            f"Logger's clock: {apart_s:+.1f} s off this computer's (limit {MAX_CLOCK_DIFFERENCE_S:g} s).",
            _SET,
            **numbers,
        )
    off = f"within {_SHOWN_S} s of" if abs(apart_s) < _SHOWN_S else f"{apart_s:+.1f} s off"
    return go(f"{now}; the logger's is {off} it.", **numbers)


def _behind(evidence: Evidence) -> tuple[datetime, str] | None:
    """Find a date that is later than the computer's clock allows, and its source.

    Returns None if no such date is known.
    """
    # Dates that must lie in the past: this program's, the certificate's, the youngest file's.
    known_dates = [(EARLIEST, "this program")]
    if not isinstance(evidence.calibration, Missing):
        known_dates.append((evidence.calibration.written, f"the certificate {evidence.calibration_file}"))
    if evidence.newest_file is not None:
        known_dates.append(evidence.newest_file)
    newest, whose = max(known_dates)
    if evidence.now >= newest - BEHIND:
        return None
    return newest, whose


def check_paces(evidence: Evidence) -> PreflightCheck:
    """Neither board's clock runs fast or slow by more than half a percent, over this preflight."""
    paces = {"sequencer": require(evidence.sequencer).pace, "logger": require(evidence.logger).pace}
    wrong, numbers = [], {}
    for board, pace in paces.items():
        if pace is None:
            return not_made(f"The {board} restarted meanwhile.", "See restarts.")
        off, doubt = _off(pace)
        numbers[f"{board}_off_ppm"] = 1e6 * off
        numbers[f"{board}_doubt_ppm"] = 1e6 * doubt
        # The doubt alone exceeds the limit: neither GO nor NO-GO can be said.
        if doubt >= MAX_CLOCK_RATE_ERROR:
            return not_made(
                f"The {board} answered too slowly to compare its clock: it is known to {100 * doubt:.1f} % only.",
                "Plug it in without a hub, and run this preflight again.",
                **numbers,
            )
        # Beyond doubt only: slow answers over USB must not condemn a board.
        if abs(off) - doubt > MAX_CLOCK_RATE_ERROR:
            wrong.append(f"{board} {100 * abs(off):.1f} % {'fast' if off > 0 else 'slow'}")
    return judge(
        wrong,
        f"Clock rate: {{}} (limit {100 * MAX_CLOCK_RATE_ERROR:g} %).",
        "Replace that board: strokes and samples would come at other times than they are noted.",
        f"Clock rates: both boards within {100 * MAX_CLOCK_RATE_ERROR:g} % of this computer's.",
        **numbers,
    )


def _off(pace: Pace) -> tuple[float, float]:
    """Compute the relative rate error of the board's clock, positive if fast, and its uncertainty."""
    if pace.computer_s <= 0.0:
        return 0.0, 1.0
    return pace.board_s / pace.computer_s - 1.0, pace.doubt_s / pace.computer_s


def check_sampling(evidence: Evidence) -> PreflightCheck:
    """Rate as set, times even, no tick left out; by live samples on the logger's clock."""
    logger, live = require(evidence.logger), sensors_of(evidence).live
    wanted_hz, t_us = logger.settings.rate_hz, live.counts.t_us
    # Between consecutive numbers only: samples that the link lost are no jitter of the timer.
    steps_us = np.diff(t_us)[np.diff(live.index) == 1]
    if len(steps_us) < 2 or t_us[-1] <= t_us[0]:
        return not_made("Too few live samples came one after the other.", "Plug the logger in without a hub.")
    # By sample numbers, so that lost ones do not lower the rate.
    rate_hz = float(live.index[-1] - live.index[0]) * 1e6 / float(t_us[-1] - t_us[0])
    jitter_us = float(np.sqrt(np.mean((steps_us - 1e6 / wanted_hz) ** 2)))
    late = logger.later.late_ticks - logger.status.late_ticks
    wrong = []
    if abs(rate_hz / wanted_hz - 1.0) > RATE_TOLERANCE:
        wrong.append(f"rate {rate_hz:.2f} Hz (set: {wanted_hz} Hz)")
    if late > 0:
        wrong.append(f"{late} timer ticks without a sample (limit 0)")
    if jitter_us > MAX_JITTER_US:
        wrong.append(f"jitter {jitter_us:.0f} us rms (limit {MAX_JITTER_US:g} us)")
    return judge(
        wrong,
        "Sampling: {}.",
        Advice(
            "An IMU that answers slowly holds it up: ",
            NextStep("status"),
            ", and check wires and pull-ups of the buses; or lower the rate: ",
            NextStep("logger-settings set", ("--rate", "280")),
        ),
        f"Sampling: {rate_hz:.2f} Hz, jitter {jitter_us:.1f} us rms, no tick left out.",
        rate_hz=rate_hz,
        set_hz=wanted_hz,
        jitter_rms_us=jitter_us,
        longest_us=int(steps_us.max()),
        late_ticks=late,
        not_arrived=live.counts.samples_lost,
    )


def check_ranges(evidence: Evidence) -> PreflightCheck:
    """Rate and ranges of the settings in force hold the fastest stroke."""
    settings = require(evidence.logger).settings
    fastest = max((math.degrees(servo.max_rate_rad_s) for servo in evidence.robot.servos), default=0.0)
    needed_deg_s = RANGE_OVER_RATE * fastest
    wrong = []
    if settings.gyro_range_deg_s < needed_deg_s:
        wrong.append(
            f"gyro range {settings.gyro_range_deg_s} deg/s (limit {needed_deg_s:.0f} deg/s, joints reach {fastest:.0f})"
        )
    if settings.rate_hz < MIN_RATE_HZ:
        wrong.append(f"rate {settings.rate_hz} Hz (limit {MIN_RATE_HZ} Hz)")
    return judge(
        wrong,
        "Logger settings too low for the maneuver: {}.",
        Advice(NextStep("logger-settings set", ("--factory",)), ", or name better ones"),
        f"Logger settings: {settings.rate_hz} Hz, gyro range {settings.gyro_range_deg_s} deg/s for joints of "
        f"{fastest:.0f} deg/s.",
        rate_hz=settings.rate_hz,
        gyro_range_deg_s=settings.gyro_range_deg_s,
        needed_gyro_range_deg_s=needed_deg_s,
        accel_range_g=settings.accel_range_g,
        dlpf_cfg=settings.dlpf_cfg,
    )
