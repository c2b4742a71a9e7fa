"""What a gyro reads at rest, on the bench or in a recording before its release (paper, section "Calibrations")."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.statistics import mean_and_covariance
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.evidence import Evidence, Origin
from tfsat_host.calibration.steps.sensor_samples import SensorSamples, check_complete
from tfsat_host.calibration.steps.step import rest
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.sdlog import DropLog
from tfsat_host.units import STANDARD_GRAVITY_M_S2

STILL_RATE_RAD_S = np.deg2rad(1.0)
"""A gyro whose readings scatter more than this is not still."""
DRIFT_RAD_S = np.deg2rad(0.1)
"""A body whose rate changes by more from the first half to the second turns slowly, or warms up fast."""
SHAKE_G = 0.05
"""An accelerometer that scatters more is carried or shaken."""
GRAVITY_G = (0.85, 1.15)
"""What a resting accelerometer reads: 1 g, with an MPU-6050's offset and scale (PS-MPU-6000A rev. 3.4,
section 6.2)."""
TILT_RAD = np.deg2rad(0.2)
"""Gravity may turn in a body's axes by so much from the first third to the last: more, and the body turns slowly."""
_MORE_THAN_NOISE = 3.0
"""Standard deviations. The difference of two halves has twice that of the whole's mean."""
MIN_DURATION_S = 10.0
"""A shorter rest gives a less certain bias than `calibrate bias` does."""
NEARLY_AS_LONG = 0.9
"""Of rests about as long as the longest the newest is taken: biases move with the temperature."""
_RELEASE_MARGIN_US = 1_000_000
"""So long before the release the hook may already move the robot."""
_ACCEL, _GYRO = slice(0, 3), slice(4, 7)
_AGAIN = "Let the robot rest on the bench without touching it, and run this command again."


@dataclass(frozen=True, eq=False)
class BiasEstimate:
    """The zero-rate output of one gyro.

    Attributes:
        body: 1 to 4.
        bias_rad_s: (3,) sensor axes.
        covariance: (3, 3) of it, (rad/s)^2; noise that repeats itself through the low-pass is accounted for.
        noise_rad_s: (3,) standard deviation of one sample.
        temperature_c: Mean of the die, for the bias moves with it.
    """

    body: int
    bias_rad_s: FloatArray
    covariance: FloatArray
    noise_rad_s: FloatArray
    temperature_c: float


def estimate_biases(still: SensorSamples, bodies: Collection[int] = (1, 2, 3, 4)) -> tuple[BiasEstimate, ...]:
    """Estimate the biases of the gyros of some bodies (1 to 4) from a recording in which nothing moved.

    Raises:
        CalibrationError: samples or a gyro are missing, or a body moved; says which, and how.
    """
    check_complete(still, bodies)
    return tuple(_estimate(still, body) for body in bodies)


def with_bias(gyro: GyroCalibration, bias: BiasEstimate, recorded_at: datetime) -> GyroCalibration:
    """Return the gyro's calibration with a new bias."""
    covariance = gyro.covariance.copy()
    covariance[:3, :3] = bias.covariance
    return replace(
        gyro,
        bias_rad_s=bias.bias_rad_s,
        covariance=covariance,
        noise_rad_s=bias.noise_rad_s,
        temperature_c=bias.temperature_c,
        bias_recorded_at=recorded_at,
    )


def _estimate(still: SensorSamples, body: int) -> BiasEstimate:
    rates = still.rate_rad_s[:, body - 1]
    # Gyros first, then gravity: a turn slow enough to pass for bias still tilts the accelerometer.
    _check_rates(rates, body)
    _check_forces(still.accel_m_s2[:, body - 1] / STANDARD_GRAVITY_M_S2, body)
    bias, covariance = mean_and_covariance(rates)
    # A drift that exceeds noise has carried the bias off its mean by the end of the rest: add it.
    covariance = covariance + np.diag(_bias_drift(rates, covariance) ** 2)
    return BiasEstimate(
        body,
        bias,
        covariance,
        rates.std(axis=0),
        float(still.temperature_c[:, body - 1].mean()),
    )


def _bias_drift(rates: FloatArray, covariance: FloatArray) -> FloatArray:
    """(3,) how far the bias has gone from its mean by the end of the rest, where that is more than noise."""
    first, second = (half.mean(axis=0) for half in np.array_split(rates, 2))
    # From one half's middle to the other's it goes as far as from the mean to the end.
    apart = np.abs(second - first)
    # Each half's mean has sqrt(2) times the whole's deviation, so their difference has twice it.
    return np.where(apart > _MORE_THAN_NOISE * 2.0 * np.sqrt(np.diag(covariance)), apart, 0.0)


def _check_rates(rates: FloatArray, body: int) -> None:
    # Identical samples are a frozen register, not a quiet gyro.
    if not np.ptp(rates, axis=0).any():
        raise CalibrationError(
            what=f"The gyro on body {body} gave the very same value in all {len(rates)} samples.",
            meaning="A gyro always has noise: this one measures nothing.",
            next_step=Advice(
                "Switch the logger off and on; replace the IMU if ",
                NextStep("monitor"),
                " shows the same again.",
            ),
        )
    scatter = float(rates.std(axis=0).max())
    if scatter > STILL_RATE_RAD_S:
        raise CalibrationError(
            what=f"Body {body} was not still: its gyro scattered by {np.rad2deg(scatter):.2f} deg/s.",
            meaning="The bias would be wrong, and with it every angle.",
            next_step=_AGAIN,
        )
    # A slow drift hides in the scatter, but not in the means of both halves.
    first, second = (half.mean(axis=0) for half in np.array_split(rates, 2))
    drift = float(np.abs(second - first).max())
    if drift > DRIFT_RAD_S:
        raise CalibrationError(
            what=f"The gyro on body {body} drifted by {np.rad2deg(drift):.2f} deg/s while it was read.",
            meaning="The body turned slowly, or the board is still warming up: the bias would not hold.",
            next_step="Wait some minutes with the power on and the robot at rest, and run this command again.",
        )


def _check_forces(forces_g: FloatArray, body: int) -> None:
    shake = float(forces_g.std(axis=0).max())
    if shake > SHAKE_G:
        raise CalibrationError(
            what=f"Body {body} was shaken: its accelerometer scattered by {shake:.2f} g.",
            meaning="The bias would be wrong, and with it every angle.",
            next_step=_AGAIN,
        )
    # A body that turns slowly shows by gravity's direction, from the first third to the last.
    first, _, last = (third.mean(axis=0) for third in np.array_split(forces_g, 3))
    tilt = float(np.arctan2(np.linalg.norm(np.cross(first, last)), first @ last))
    if tilt > TILT_RAD:
        raise CalibrationError(
            what=f"Body {body} was tilted by {np.rad2deg(tilt):.1f} deg while its gyro was read.",
            meaning="What it turned would be taken for bias.",
            next_step=_AGAIN,
        )
    size = float(np.linalg.norm(forces_g.mean(axis=0)))
    if not GRAVITY_G[0] <= size <= GRAVITY_G[1]:
        raise CalibrationError(
            what=f"The accelerometer on body {body} reads {size:.2f} g at rest, not 1 g.",
            meaning="The body does not rest, or its IMU is broken; its gyro is not to be trusted.",
            next_step=Advice(
                "Check the IMU with ",
                NextStep("monitor"),
                "; replace it if it stays so, and run this command again.",
            ),
        )


def quiet_before_release(log: DropLog) -> Counts | None:
    """Find the longest stretch before the release in which no gyro or accelerometer measured motion.

    The recording is judged second by second, by the criteria of `calibrate bias`: the gyros' scatter, the
    drift of their means between the seconds of the stretch, the accelerometers' scatter and magnitude. A
    second in which a sample is invalid, clipped, late or lost interrupts the stretch.

    Args:
        log: Decoded recording; without a release all of it may be quiet.

    Returns:
        The stretch's samples; None if nothing rested for `MIN_DURATION_S`.
    """
    # Stop before the earliest time the release may have been: the hook may move the robot.
    end_us = int(log.t_us[-1]) + 1 if log.release is None else log.release.interval_us[0] - _RELEASE_MARGIN_US
    rows = int(np.searchsorted(log.t_us, end_us))
    per_second = max(4, round(log.header.rate_hz))
    seconds = rows // per_second
    if seconds < MIN_DURATION_S:
        return None
    first = rows - seconds * per_second  # whole seconds, counted back from the release
    # Judge every second alone, then join neighbours whose means agree.
    rates, quiet = _mean_rates_by_second(log, slice(first, rows), seconds)
    quiet &= _unbroken(log, slice(first, rows), seconds)
    start, count = _best(_stretches(rates, quiet))
    if count < MIN_DURATION_S:
        return None
    begin = first + start * per_second
    return Counts.from_log(log).part(slice(begin, begin + count * per_second))


def _mean_rates_by_second(log: DropLog, rows: slice, seconds: int) -> tuple[FloatArray, BoolArray]:
    """(seconds, 12) mean rates, rad/s, and (seconds,) whether the second alone was quiet."""
    # Shape (seconds, samples, bodies, channels): statistics are over the samples.
    counts = log.imu_counts[rows].reshape(seconds, -1, 4, 7)
    to_rad_s = np.deg2rad(1.0 / log.header.gyro_lsb_per_deg_s)
    rates, scatter = _mean_and_std(counts[..., _GYRO])
    forces, shake = _mean_and_std(counts[..., _ACCEL])
    to_g = 1.0 / log.header.accel_lsb_per_g
    weight_g = np.linalg.norm(forces * to_g, axis=2)
    quiet = (
        (scatter * to_rad_s <= STILL_RATE_RAD_S).all(axis=(1, 2))
        & (shake * to_g <= SHAKE_G).all(axis=(1, 2))
        & ((weight_g >= GRAVITY_G[0]) & (weight_g <= GRAVITY_G[1])).all(axis=1)
    )
    return rates.reshape(seconds, -1) * to_rad_s, quiet


def _mean_and_std(counts: NDArray[np.int16]) -> tuple[FloatArray, FloatArray]:
    """(seconds, 4, 3) each, of (seconds, n, 4, 3); exact: sums of 16-bit numbers and their squares."""
    # Squares of 16-bit counts fill 31 bits, and their sums more: accumulate in 64.
    wide_counts = counts.astype(np.int64)
    n = counts.shape[1]
    mean = wide_counts.sum(axis=1) / n
    variance = (wide_counts * wide_counts).sum(axis=1) / n - mean**2
    return mean, np.sqrt(np.maximum(variance, 0.0))


def _unbroken(log: DropLog, rows: slice, seconds: int) -> BoolArray:
    """(seconds,) every sensor answered at every tick, and no sample is missing before or between them."""
    good = (log.imu_valid[rows] & ~log.clipped[rows]).all(axis=1)
    # A step of one in the running index means that nothing was lost; the first row is granted one.
    step = np.diff(log.sample_index[rows], prepend=log.sample_index[rows.start] - 1)
    good &= step == 1
    late = log.late_rows[(log.late_rows >= rows.start) & (log.late_rows < rows.stop)] - rows.start
    good[late] = False
    return np.asarray(good.reshape(seconds, -1).all(axis=1))


def _stretches(rates: FloatArray, quiet: BoolArray) -> list[tuple[int, int]]:
    """First second and number of seconds of every stretch that no quiet second could prolong.

    In each no gyro's mean drifts, from one of its seconds to another, by more than `DRIFT_RAD_S`.
    """
    stretches: list[tuple[int, int]] = []
    # Sliding window with the envelope of its seconds' mean rates.
    begin, low, high = 0, np.empty(0), np.empty(0)
    # One second past the end closes a stretch that lasts until then.
    for second in range(len(quiet) + 1):
        if second < len(quiet) and quiet[second]:
            if begin < second:
                low, high = np.minimum(low, rates[second]), np.maximum(high, rates[second])
            else:
                low = high = rates[second]
            if (high - low <= DRIFT_RAD_S).all():
                continue
            # It cannot grow any more; its successor begins at the first second that agrees with this one.
            stretches.append((begin, second - begin))
            begin = _first_that_agrees(rates, begin, second)
            low, high = rates[begin : second + 1].min(axis=0), rates[begin : second + 1].max(axis=0)
            continue
        if second > begin:
            stretches.append((begin, second - begin))
        begin = second + 1
    return stretches


def _first_that_agrees(rates: FloatArray, begin: int, second: int) -> int:
    """Find the first second since `begin` from which no gyro's mean drifts up to and including `second`."""
    # Running spread from `second` backwards; the appended False ends the search where all agree.
    backwards = rates[begin : second + 1][::-1]
    spread = np.maximum.accumulate(backwards) - np.minimum.accumulate(backwards)
    agreeing = int(np.argmin(np.append((spread <= DRIFT_RAD_S).all(axis=1), False)))
    return second + 1 - agreeing


def _best(stretches: list[tuple[int, int]]) -> tuple[int, int]:
    """Return the newest stretch nearly as long as the longest; (0, 0) if there is none."""
    longest = max((count for _, count in stretches), default=0)
    return next(
        ((start, count) for start, count in reversed(stretches) if count >= NEARLY_AS_LONG * longest), (0, 0)
    )


def rest_of(log: DropLog, file: Path, origin: Origin) -> Evidence:
    """Build the evidence of the rest before a recording's release, as of a rest on the bench.

    Args:
        log: Decoded recording.
        file: Its name in errors.
        origin: Origin of its sensors.

    Raises:
        CalibrationError: nothing rested, or the recording has no time of day.
    """
    counts = quiet_before_release(log)
    if counts is None:
        raise CalibrationError(
            what=f"{file}: no rest of {MIN_DURATION_S:g} s before the release.",
            meaning="Biases cannot be told from motion; nothing was kept.",
            next_step=Advice("To measure them on the bench: ", NextStep("calibrate bias")),
        )
    if log.unix_offset_us is None:
        raise CalibrationError(
            what=f"{file} does not say at what time of day it was recorded.",
            meaning="Whether its biases are older than a landing could never be known; nothing was kept.",
            next_step=Advice("To measure them on the bench: ", NextStep("calibrate bias")),
        )
    recorded_at = datetime.fromtimestamp(0, UTC) + timedelta(
        microseconds=log.unix_offset_us + int(counts.t_us[0])
    )
    return Evidence(rest(), counts, recorded_at, origin)
