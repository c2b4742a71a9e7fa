"""The quiet minutes of a recording before its release (paper, section "Calibrations"): the freshest bias there is."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.calibration.bias import DRIFT_RAD_S, GRAVITY_G, SHAKE_G, STILL_RATE_RAD_S
from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.evidence import Evidence, Origin
from tfsat_host.calibration.steps.step import rest
from tfsat_host.sdlog import DropLog

LEAST_S = 10.0
"""A shorter rest tells the bias less surely than `calibrate bias` does."""
NEARLY_AS_LONG = 0.9
"""Of rests about as long as the longest the newest is taken: biases move with the temperature."""
_RELEASE_MARGIN_US = 1_000_000
"""So long before the release the hook may already move the robot."""
_ACCEL, _GYRO = slice(0, 3), slice(4, 7)


def quiet_before_release(log: DropLog) -> Counts | None:
    """The longest stretch before the release in which no gyro and no accelerometer saw anything move.

    The recording is judged second by second, by the criteria of `calibrate bias`: the gyros' scatter, how far their
    means drift from one second of the stretch to another, the accelerometers' scatter and size. A second in which
    a sample is invalid, clipped, late or lost interrupts the stretch.

    Args:
        log: Decoded; without a release all of it may be quiet.

    Returns:
        Its samples; None if nothing rested for `LEAST_S`.
    """
    end_us = int(log.t_us[-1]) + 1 if log.release is None else log.release.interval_us[0] - _RELEASE_MARGIN_US
    rows = int(np.searchsorted(log.t_us, end_us))
    per_second = max(4, round(log.header.rate_hz))
    seconds = rows // per_second
    if seconds < LEAST_S:
        return None
    first = rows - seconds * per_second  # whole seconds, counted back from the release
    rates, quiet = _judged(log, slice(first, rows), seconds)
    quiet &= _unbroken(log, slice(first, rows), seconds)
    start, count = _best(_stretches(rates, quiet))
    if count < LEAST_S:
        return None
    begin = first + start * per_second
    return Counts.from_log(log).part(slice(begin, begin + count * per_second))


def _judged(log: DropLog, rows: slice, seconds: int) -> tuple[FloatArray, BoolArray]:
    """(seconds, 12) mean rates, rad/s, and (seconds,) whether the second alone was quiet."""
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
    whole = counts.astype(np.int64)
    n = counts.shape[1]
    mean = whole.sum(axis=1) / n
    variance = (whole * whole).sum(axis=1) / n - mean**2
    return mean, np.sqrt(np.maximum(variance, 0.0))


def _unbroken(log: DropLog, rows: slice, seconds: int) -> BoolArray:
    """(seconds,) every sensor answered at every tick, and no sample is missing before or between them."""
    good = (log.imu_valid[rows] & ~log.clipped[rows]).all(axis=1)
    step = np.diff(log.sample_index[rows], prepend=log.sample_index[rows.start] - 1)
    good &= step == 1
    late = log.late_rows[(log.late_rows >= rows.start) & (log.late_rows < rows.stop)] - rows.start
    good[late] = False
    return np.asarray(good.reshape(seconds, -1).all(axis=1))


def _stretches(rates: FloatArray, quiet: BoolArray) -> list[tuple[int, int]]:
    """First second and number of seconds of every stretch that no quiet second could prolong.

    In each no gyro's mean drifts, from one of its seconds to another, by more than `DRIFT_RAD_S`.
    """
    found: list[tuple[int, int]] = []
    begin, low, high = 0, np.empty(0), np.empty(0)
    for second in range(len(quiet) + 1):
        if second < len(quiet) and quiet[second]:
            if begin < second:
                low, high = np.minimum(low, rates[second]), np.maximum(high, rates[second])
            else:
                low = high = rates[second]
            if (high - low <= DRIFT_RAD_S).all():
                continue
            found.append((begin, second - begin))
            begin = _first_that_agrees(rates, begin, second)
            low, high = rates[begin : second + 1].min(axis=0), rates[begin : second + 1].max(axis=0)
            continue
        if second > begin:
            found.append((begin, second - begin))
        begin = second + 1
    return found


def _first_that_agrees(rates: FloatArray, begin: int, second: int) -> int:
    """From which second on, of those since `begin`, none drifts from `second` or from one between."""
    backwards = rates[begin : second + 1][::-1]
    spread = np.maximum.accumulate(backwards) - np.minimum.accumulate(backwards)
    agreeing = int(np.argmin(np.append((spread <= DRIFT_RAD_S).all(axis=1), False)))
    return second + 1 - agreeing


def _best(stretches: list[tuple[int, int]]) -> tuple[int, int]:
    """The newest of those that are nearly as long as the longest; no seconds if there is none."""
    longest = max((count for _, count in stretches), default=0)
    return next(
        ((start, count) for start, count in reversed(stretches) if count >= NEARLY_AS_LONG * longest), (0, 0)
    )


def rest_of(log: DropLog, file: Path, origin: Origin) -> Evidence:
    """The rest before a recording's release, as one on the bench is kept.

    Args:
        log: Decoded.
        file: As errors name it.
        origin: Whose sensors it is of.

    Raises:
        CalibrationError: nothing rested, or the recording has no time of day.
    """
    counts = quiet_before_release(log)
    if counts is None:
        raise CalibrationError(
            what=f"The robot in {file} never rested for {LEAST_S:g} s before its release.",
            meaning="The biases cannot be separated from its motion; nothing was kept.",
            next_step="Take them on the bench: tfsat-host calibrate bias",
        )
    if log.unix_offset_us is None:
        raise CalibrationError(
            what=f"{file} does not say at what time of day it was recorded.",
            meaning="Whether its biases are older than a landing could never be known; nothing was kept.",
            next_step="Take them on the bench: tfsat-host calibrate bias",
        )
    taken = datetime.fromtimestamp(0, UTC) + timedelta(microseconds=log.unix_offset_us + int(counts.t_us[0]))
    return Evidence(rest(), counts, taken, origin)
