"""Whether the logger samples as it is told, and what it is told can see the maneuver."""

from __future__ import annotations

import math

import numpy as np

from tfsat_host.preflight.check import Check, go, no_go, not_made
from tfsat_host.preflight.evidence import Evidence, Missing, unreached
from tfsat_host.preflight.sensors import sensors_of

MOST_JITTER_US = 100.0
"""Root mean square. At 200 deg/s a sample that comes 100 us late is 0.02 deg off, less than an angle sensor's step."""
RATE_TOLERANCE = 1e-3
"""Relative, on the logger's own clock: the timer and the clock are one crystal's."""
LEAST_RATE_HZ = 100
"""The shortest stroke speeds up within 0.05 s; five samples tell its shape."""
RANGE_OVER_RATE = 1.5
"""A body turns with its joint, against it, and with what the release left: a gyro needs more than the fastest joint."""


def check_sampling(evidence: Evidence) -> Check:
    """Rate as set, times even, no tick left out; by live samples on the logger's clock."""
    name = "sampling"
    if isinstance(evidence.logger, Missing):
        return unreached(name, evidence.logger)
    sensors = sensors_of(evidence)
    if isinstance(sensors, Missing):
        return unreached(name, sensors)
    live, wanted_hz = sensors.live, evidence.logger.settings.rate_hz
    t_us = live.counts.t_us
    steps_us = np.diff(t_us)[np.diff(live.index) == 1]
    if len(steps_us) < 2 or t_us[-1] <= t_us[0]:
        return not_made(
            name, "Too few live samples came one after the other.", "Plug the logger in without a hub."
        )
    rate_hz = float(live.index[-1] - live.index[0]) * 1e6 / float(t_us[-1] - t_us[0])
    jitter_us = float(np.sqrt(np.mean((steps_us - 1e6 / wanted_hz) ** 2)))
    late = evidence.logger.later.late_ticks - evidence.logger.status.late_ticks
    numbers = {
        "rate_hz": rate_hz,
        "set_hz": wanted_hz,
        "jitter_rms_us": jitter_us,
        "longest_us": int(steps_us.max()),
        "late_ticks": late,
        "not_arrived": live.counts.samples_lost,
    }
    said = []
    if abs(rate_hz / wanted_hz - 1.0) > RATE_TOLERANCE:
        said.append(f"it samples at {rate_hz:.2f} Hz, not {wanted_hz}")
    if late > 0:
        said.append(f"{late} ticks of its timer passed without a sample")
    if jitter_us > MOST_JITTER_US:
        said.append(f"samples come {jitter_us:.0f} us early or late ({MOST_JITTER_US:g} are allowed)")
    if said:
        return no_go(
            name,
            f"The logger does not keep its time: {'; '.join(said)}.",
            "An IMU that answers slowly holds it up: tfsat-host status, and check wires and pull-ups of the buses; "
            "or lower the rate: tfsat-host logger-settings set --rate 280",
            **numbers,
        )
    return go(name, f"{rate_hz:.2f} Hz, jitter {jitter_us:.1f} us, no tick left out.", **numbers)


def check_ranges(evidence: Evidence) -> Check:
    """Rate and ranges of the settings in force hold the fastest stroke."""
    name = "logger-settings"
    if isinstance(evidence.logger, Missing):
        return unreached(name, evidence.logger)
    settings = evidence.logger.settings
    fastest = max((math.degrees(servo.max_rate_rad_s) for servo in evidence.robot.servos), default=0.0)
    needed = RANGE_OVER_RATE * fastest
    numbers = {
        "rate_hz": settings.rate_hz,
        "gyro_range_deg_s": settings.gyro_range_deg_s,
        "needed_gyro_range_deg_s": needed,
        "accel_range_g": settings.accel_range_g,
        "dlpf_cfg": settings.dlpf_cfg,
    }
    said = []
    if settings.gyro_range_deg_s < needed:
        said.append(f"gyros up to {settings.gyro_range_deg_s} deg/s; joints reach {fastest:.0f}")
    if settings.rate_hz < LEAST_RATE_HZ:
        said.append(f"{settings.rate_hz} Hz; a stroke needs {LEAST_RATE_HZ}")
    if said:
        return no_go(
            name,
            f"The logger's settings do not hold the maneuver: {'; '.join(said)}.",
            "tfsat-host logger-settings set --factory, or name better ones",
            **numbers,
        )
    return go(
        name,
        f"{settings.rate_hz} Hz, gyros to {settings.gyro_range_deg_s} deg/s for joints of {fastest:.0f} deg/s.",
        **numbers,
    )
