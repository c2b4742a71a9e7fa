"""The robot hanging still in the releaser: what all its sensors show before anything turns, to be checked.

`fall.rest` asks another question of other seconds: what the gyros' biases and noise are, for want of a calibration.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.apply import apply_calibration
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.sensors.joint_sensors import sensor_columns
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.evaluation.fall.gravity_check import LEAST_SAMPLES, AtRest
from tfsat_host.evaluation.motion.noise import BLOCK_S
from tfsat_host.robot import RobotModel
from tfsat_host.sdlog import DropLog
from tfsat_host.sdlog.droplog import rows_of

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

BEFORE_RELEASE_S = 0.1
"""The releaser's springs and the edges of its switch are not part of the rest."""
LONGEST_S = 6.0
"""No longer is needed, and earlier hands may still have been at the robot."""
LEAST_S = 1.0
STILL_RAD_S = np.deg2rad(0.15)
"""Means over 0.1 s of a robot that hangs still wander by 0.01 deg/s; one whose swaying spoils a bias shows more."""


STILL_SHARE = 0.8
"""Of those means: a knock, as when the crane stops or a servo takes hold, leaves the rest a rest."""

CONTRADICTION_RAD = np.deg2rad(3.0)
"""Two sensors of a joint that are so far apart tell nothing of down, which is known no better."""


@dataclass(frozen=True, eq=False)
class Hanging:
    """What is still before the release.

    Attributes:
        seconds: Of it.
        reading_rad_s: (4, 3) mean of each gyro, sensor axes, bias included; NaN without enough samples.
        reading_std_rad_s: (4, 3) of that mean, by the scatter of means over 0.1 s.
        force: Of each body; None without enough samples.
        angles_rad: (3,) of the joints by the angle sensors; NaN where none answered, or two contradict each other.
    """

    seconds: float
    reading_rad_s: FloatArray
    reading_std_rad_s: FloatArray
    force: tuple[AtRest | None, ...]
    angles_rad: FloatArray


def hanging_before_release(log: DropLog, calibration: Calibration, model: RobotModel) -> Hanging | None:
    """What hung still before the release; None if the robot was not still, or not recorded.

    A steady turn cannot be told from a bias by gyros alone, but nothing that hangs on a magnet turns steadily.
    """
    wanted = np.flatnonzero((log.t_s >= -LONGEST_S) & (log.t_s < -BEFORE_RELEASE_S))
    if len(wanted) < LEAST_SAMPLES:
        return None
    part = rows_of(log, slice(int(wanted[0]), int(wanted[-1]) + 1))
    answered = part.imu_valid & ~part.clipped
    rates = np.where(answered[..., None], part.rate_rad_s, np.nan)
    block = np.floor((part.t_s - part.t_s[0]) / BLOCK_S)
    means = _means(rates, np.flatnonzero(np.diff(block, prepend=-1.0)))
    still = _still(means)
    if still.sum() * BLOCK_S < LEAST_S or still.mean() < STILL_SHARE:
        return None
    kept = means[still]
    blocks = np.isfinite(kept).sum(axis=0)
    enough = blocks >= LEAST_SAMPLES
    reading = np.where(enough, np.nansum(kept, axis=0) / np.maximum(blocks, 1), np.nan)
    spread = np.sqrt(
        np.nansum((kept - reading) ** 2, axis=0) / np.maximum(blocks - 1, 1) / np.maximum(blocks, 1)
    )
    calibrated = apply_calibration(Counts.from_log(part), calibration, model)
    rows = np.repeat(still, np.diff(np.flatnonzero(np.diff(block, prepend=-1.0)), append=len(block)))
    return Hanging(
        float(still.sum() * BLOCK_S),
        reading,
        np.where(enough, spread, np.nan),
        tuple(AtRest.of(calibrated, rows, b) for b in range(4)),
        angles_at_rest(part, rows, calibration, model),
    )


def _means(rates: FloatArray, edges: NDArray[np.int64]) -> FloatArray:
    """(blocks, 4, 3); NaN where nothing answered."""
    known = np.isfinite(rates)
    counts = np.add.reduceat(known.astype(np.int64), edges, axis=0)
    sums = np.add.reduceat(np.where(known, rates, 0.0), edges, axis=0)
    return np.asarray(np.where(counts > 0, sums / np.maximum(counts, 1), np.nan))


def _still(means: FloatArray) -> BoolArray:
    """(blocks,) all gyros are near their medians."""
    flat = means.reshape(len(means), -1)
    usual = np.array([np.median(c[np.isfinite(c)]) if np.isfinite(c).any() else 0.0 for c in flat.T])
    with np.errstate(invalid="ignore"):
        return np.asarray(~(np.abs(flat - usual) > STILL_RAD_S).any(axis=1))


def angles_at_rest(log: DropLog, rows: BoolArray, calibration: Calibration, model: RobotModel) -> FloatArray:
    """(3,) of the joints, rad, in the (n,) chosen samples; NaN: no sensor answered, or two contradict each other."""
    angles = np.full(len(calibration.joints), np.nan)
    for joint, sensors in enumerate(calibration.joints):
        each = sensors.each(log.sensor_angle_rad[rows][:, sensor_columns(model, joint + 1)]).T
        medians = [float(np.median(one[np.isfinite(one)])) for one in each if np.isfinite(one).any()]
        if medians and np.ptp(medians) < CONTRADICTION_RAD:
            angles[joint] = np.mean(medians)
    return angles
