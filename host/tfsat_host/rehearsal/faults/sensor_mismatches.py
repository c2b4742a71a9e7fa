"""How a hidden robot can be another one than its certificate says, which stays as it is.

Where several numbers go wrong, the size is one standard deviation of each, as in a robot file's `[uncertainty]`;
signs, directions and bodies follow from the day's seed.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.emulated.emulated_certificate import worse_certificate
from tfsat_host.protocol.limits import ANGLE_SENSOR_COUNT, IMU_COUNT
from tfsat_host.rehearsal.day import Day
from tfsat_host.rehearsal.faults.fault import Fault, Moment, Outcome, Size, mismatch, outcomes_between
from tfsat_host.rehearsal.truth import Truth

Random = np.random.Generator
PERCENT, MS, DEG = 1e-2, 1e-3, np.pi / 180.0
RINGS_AFTER_DEG_S2 = 1000.0
"""Change of a body's angular acceleration that the size of the mounts' ringing is given for."""
_BENT_AT_RAD_S = 170.0 * DEG
"""Rate that a change of the scale factors is given for: the servos'."""
_FASTEST_BODIES = (0, 2, 3)
"""Indices: rates of the others stay below 100 deg/s in the paper's maneuver."""


def _sensors(truth: Truth, **fields: Any) -> Truth:
    return replace(truth, imperfections=replace(truth.imperfections, **fields))


def _change_gyro_scale(truth: Truth, percent: float, random: Random) -> Truth:
    was = truth.imperfections
    scale = was.gyro_scale.copy()
    # The same magnitude on all axes of one gyro, with a sign for each.
    scale[random.integers(IMU_COUNT)] *= 1.0 + PERCENT * percent * random.choice([-1.0, 1.0], 3)
    # It changed after the calibration: the certificate is of the sensors before.
    return replace(_sensors(truth, gyro_scale=scale), calibrated=truth.calibrated or was)


def _bend_scale(truth: Truth, percent: float, random: Random) -> Truth:
    was = truth.imperfections.gyro_bend_s
    bends = PERCENT * percent / _BENT_AT_RAD_S * random.choice([-1.0, 1.0], was.shape)
    return _sensors(truth, gyro_bend_s=was + bends)


def _add_g_sensitivity(truth: Truth, deg_s_g: float, random: Random) -> Truth:
    was = truth.imperfections.gyro_g_sensitivity_rad_s_g
    return _sensors(truth, gyro_g_sensitivity_rad_s_g=was + DEG * deg_s_g * random.standard_normal(was.shape))


def _add_cross_axis(truth: Truth, percent: float, random: Random) -> Truth:
    was = truth.imperfections.gyro_cross_axis
    deviations = PERCENT * percent * random.standard_normal(was.shape)
    # Off the diagonal only: on it would be the scale factor, which calibration finds.
    return _sensors(truth, gyro_cross_axis=was + deviations * (1.0 - np.eye(3)))


def _delay_imu(truth: Truth, ms: float, random: Random) -> Truth:
    return _sensors(truth, imu_late_s=_of_one(random.integers(IMU_COUNT), MS * ms))


def _detune_imus(truth: Truth, percent: float, random: Random) -> Truth:
    was = truth.imperfections.imu_clock_ppm
    # 1 % is 1e4 ppm; every IMU has an oscillator of its own.
    return _sensors(truth, imu_clock_ppm=was + 1e4 * percent * random.uniform(-1.0, 1.0, was.shape))


def _limit_front_end(truth: Truth, deg_s: float, random: Random) -> Truth:
    return _sensors(truth, gyro_front_end_limit_rad_s=_of_one(random.choice(_FASTEST_BODIES), DEG * deg_s))


def _of_one(body: np.signedinteger[Any], value: float) -> FloatArray:
    return np.where(np.arange(IMU_COUNT) == body, value, 0.0)


def _add_mount_ripple(truth: Truth, deg_s: float, _: Random) -> Truth:
    return _sensors(truth, mount_ripple_s=deg_s / RINGS_AFTER_DEG_S2)


def _step_bias(day: Day, deg_s: float, random: Random) -> None:
    towards = random.standard_normal(3)
    body = int(random.integers(IMU_COUNT)) + 1
    # A normalized Gaussian vector: the step's size is as asked for, its direction anywhere.
    day.robot.faults.gyro_bias_step(body, DEG * deg_s * towards / np.linalg.norm(towards))


def _slip_sensor(day: Day, deg: float, random: Random) -> None:
    index = int(random.integers(ANGLE_SENSOR_COUNT)) + 1
    day.robot.faults.angle_sensor(index, "turned", float(deg * random.choice([-1.0, 1.0])))


def _worsen_certificate(day: Day, times: float, random: Random) -> None:
    day.calibration = worse_certificate(day.calibration, times, random)


FAULTS = (
    mismatch(
        "gyro-scale-changed",
        "One gyro's scale factors have changed since the calibration.",
        _change_gyro_scale,
        Size(1.0, "%", most=20.0),
        noticed="gyro of body",
    ),
    mismatch(
        "gyro-scale-bends",
        "The gyros' scale factors change with the rate: by as much from none to 170 deg/s.",
        _bend_scale,
        Size(0.2, "%", most=20.0),
    ),
    mismatch(
        "gyro-g-sensitive",
        "The gyros feel forces more than their data sheet says.",
        _add_g_sensitivity,
        Size(0.5, "deg/s/g", most=10.0),
        noticed="g-sensitivity",
    ),
    mismatch(
        "gyro-cross-axis",
        "Each axis of a gyro shows some of the rates about the others.",
        _add_cross_axis,
        Size(1.0, "%", most=20.0),
    ),
    Fault(
        "gyro-bias-step",
        "One gyro's bias jumps.",
        Moment.FALLING,
        outcomes_between(Moment.RECORDING, Moment.BEFORE_LANDING, Outcome.FLIES),
        action=_step_bias,
        noticed="gyro of body",
        size=Size(0.3, "deg/s", most=100.0),
    ),
    Fault(
        "angle-sensor-crept",
        "The magnet of an angle sensor slips a little.",
        Moment.FALLING,
        outcomes_between(Moment.RECORDING, Moment.BEFORE_LANDING, Outcome.FLIES),
        action=_slip_sensor,
        noticed="slipped",
        size=Size(1.0, "deg", most=180.0),
    ),
    mismatch(
        "imu-late",
        "All that one IMU shows comes late.",
        _delay_imu,
        Size(2.0, "ms", most=10.0),
        noticed="late",
    ),
    mismatch(
        "imu-clocks",
        "Each IMU converts by an oscillator of its own, which is off by as much or less.",
        _detune_imus,
        Size(1.0, "%", most=5.0),
    ),
    mismatch(
        "gyro-saturated-unflagged",
        "One gyro shows no rate beyond this, cut off before its low-pass, so that no count is at its end.",
        _limit_front_end,
        Size(100.0, "deg/s", most=2000.0),
        noticed="saturat",
    ),
    Fault(
        "certificate-wrong",
        "Gyros and angle sensors are off from the certificate by so many times its own ± more.",
        Moment.POWERED,
        {Moment.POWERED: Outcome.FLIES},
        action=_worsen_certificate,
        noticed="certificate",
        preflight=(),
        part="calibration",
        size=Size(3.0, "times", most=1000.0),
    ),
    mismatch(
        "mount-ripple",
        "What the IMUs stand on rings at 30 Hz after strokes: so fast after a change of 1000 deg/s².",
        _add_mount_ripple,
        Size(2.0, "deg/s", most=100.0),
    ),
)
