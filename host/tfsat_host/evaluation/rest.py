"""The robot hanging still in the releaser, before anything turns: what its sensors show then.

`Rest` holds up to half a minute of the gyros: their noise, and their biases where no calibration gives them.
`RestBeforeRelease` holds the last seconds of all sensors, for the checks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tfsat_host.arrays import BoolArray, FloatArray, IntArray
from tfsat_host.calibration.apply import apply_calibration
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.sensors.joint_sensors import sensor_columns
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.evaluation.micro_gravity import MIN_SAMPLES, AtRest
from tfsat_host.evaluation.motion.gyro_signal import BLOCK_S, noise_densities
from tfsat_host.evaluation.motion.samples import Blocks
from tfsat_host.robot import RobotModel
from tfsat_host.sdlog import DropLog
from tfsat_host.sdlog.droplog import rows_of

MAX_DURATION_S = 30.0
"""Earlier, the crane and people may still have been at the robot."""
MIN_DURATION_S = 1.0
GUARD_S = 0.3
"""So long before the release the burning wire and the hook may already move the robot."""
STILL_RAD_S = np.deg2rad(0.3)
"""A block whose mean is farther from the median of all saw something move: a servo that was armed, a knock."""
HANGING_STD_RAD_S = np.deg2rad(0.02)
"""A robot on a magnet is not bolted to the ground: slow swings leave so much in any mean."""
_BLOCK_S = 0.25
_MIN_SHARE = 0.5
"""If more of the blocks moved, the robot swung, and its median is no bias."""


@dataclass(frozen=True, eq=False)
class Rest:
    """What the gyros showed.

    Attributes:
        duration_s: How long it was.
        rate_rad_s: (4, 3) mean of each gyro, sensor axes: its bias, if nothing moved. NaN where it did not rest.
        rate_std_rad_s: (4, 3) standard deviation of that mean.
        densities_rad_s_rthz: (4,) one-sided noise density.
    """

    duration_s: float
    rate_rad_s: FloatArray
    rate_std_rad_s: FloatArray
    densities_rad_s_rthz: FloatArray


def rest_before_release(log: DropLog) -> Rest:
    """Reads it from a drop; without a rest everything is NaN, and the noise is the data sheet's."""
    rows = np.flatnonzero((log.t_s >= -MAX_DURATION_S) & (log.t_s < -GUARD_S))
    if log.release is None or len(rows) < 2:
        rows = np.zeros(0, np.int64)
    t_s, rates = log.t_s[rows], log.rate_rad_s[rows]
    # Blocks average the noise down, so that slow disturbances stand out of their means.
    means = Blocks.of(t_s - t_s.max(initial=-MAX_DURATION_S), _BLOCK_S).mean(rates)
    still = np.full(rates.shape[1:], np.nan)
    spread = still.copy()
    for gyro in range(means.shape[1]):
        # A missing reading makes its block's mean NaN: leave the block out for this gyro.
        valid_means = means[np.isfinite(means[:, gyro]).all(axis=1), gyro]
        if len(valid_means) * _BLOCK_S < MIN_DURATION_S:
            continue
        # Compare with the median, which a knock or a servo being armed does not move.
        still_means = valid_means[
            (np.abs(valid_means - np.median(valid_means, axis=0)) < STILL_RAD_S).all(axis=1)
        ]
        # A bias only if half of the blocks agree: the median of a swinging robot is none.
        if len(still_means) >= _MIN_SHARE * len(valid_means):
            still[gyro] = still_means.mean(axis=0)
            # Block means hold the noise; swings slower than the rest show in no scatter and are added.
            spread[gyro] = np.hypot(
                still_means.std(axis=0, ddof=1) / np.sqrt(len(still_means)), HANGING_STD_RAD_S
            )
    duration_s = float(t_s[-1] - t_s[0]) if len(t_s) else 0.0
    return Rest(duration_s, still, spread, noise_densities(t_s, rates))


BEFORE_RELEASE_S = 0.1
"""The releaser's springs and the edges of its switch are not part of the rest."""
HANGING_LONGEST_S = 6.0
"""No longer is needed, and earlier people may still have been at the robot."""
HANGING_LEAST_S = 1.0
HANGING_STILL_RAD_S = np.deg2rad(0.15)
"""Means over 0.1 s of a robot that hangs still wander by 0.01 deg/s; one whose swaying spoils a bias shows more."""


STILL_SHARE = 0.8
"""Of those means: a knock, as when the crane stops or a servo takes hold, leaves the rest a rest."""

CONTRADICTION_RAD = np.deg2rad(3.0)
"""Two sensors of a joint that are so far apart tell nothing of down, which is known no better."""


@dataclass(frozen=True, eq=False)
class RestBeforeRelease:
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


def hanging_before_release(
    log: DropLog, calibration: Calibration, model: RobotModel
) -> RestBeforeRelease | None:
    """Measure the robot hanging still before the release; None if it was not still, or not recorded.

    Gyros alone cannot tell a steady turn from a bias, but nothing that hangs on a magnet turns steadily.
    """
    hanging_rows = np.flatnonzero((log.t_s >= -HANGING_LONGEST_S) & (log.t_s < -BEFORE_RELEASE_S))
    if len(hanging_rows) < MIN_SAMPLES:
        return None
    part = rows_of(log, slice(int(hanging_rows[0]), int(hanging_rows[-1]) + 1))
    answered = part.imu_valid & ~part.clipped
    rates = np.where(answered[..., None], part.rate_rad_s, np.nan)
    blocks = Blocks.of(part.t_s - part.t_s[0], BLOCK_S)
    means = _means(rates, blocks.edges)
    still = _still(means)
    if still.sum() * BLOCK_S < HANGING_LEAST_S or still.mean() < STILL_SHARE:
        return None
    still_means = means[still]
    valid_counts = np.isfinite(still_means).sum(axis=0)
    enough = valid_counts >= MIN_SAMPLES
    reading = np.where(enough, np.nansum(still_means, axis=0) / np.maximum(valid_counts, 1), np.nan)
    # Standard error of the mean by the scatter of block means, which allows for correlated noise.
    spread = np.sqrt(
        np.nansum((still_means - reading) ** 2, axis=0)
        / np.maximum(valid_counts - 1, 1)
        / np.maximum(valid_counts, 1)
    )
    calibrated = apply_calibration(Counts.from_log(part), calibration, model)
    # Carry the blocks' verdict to their samples, for the forces and angles of the same rest.
    rows = np.repeat(still, blocks.counts)
    return RestBeforeRelease(
        float(still.sum() * BLOCK_S),
        reading,
        np.where(enough, spread, np.nan),
        tuple(AtRest.of(calibrated, rows, b) for b in range(len(model.imus))),
        angles_at_rest(part, rows, calibration, model),
    )


def _means(rates: FloatArray, edges: IntArray) -> FloatArray:
    """(blocks, 4, 3); NaN where nothing answered."""
    is_finite = np.isfinite(rates)
    # Sum what answered: here one lost reading must not void its block.
    counts = np.add.reduceat(is_finite.astype(np.int64), edges, axis=0)
    sums = np.add.reduceat(np.where(is_finite, rates, 0.0), edges, axis=0)
    return np.asarray(np.where(counts > 0, sums / np.maximum(counts, 1), np.nan))


def _still(means: FloatArray) -> BoolArray:
    """(blocks,) all gyros are near their medians."""
    flat = means.reshape(len(means), -1)
    usual = np.array([np.median(c[np.isfinite(c)]) if np.isfinite(c).any() else 0.0 for c in flat.T])
    # NaN compares false: a silent gyro does not make a block a disturbed one.
    with np.errstate(invalid="ignore"):
        return np.asarray(~(np.abs(flat - usual) > HANGING_STILL_RAD_S).any(axis=1))


def angles_at_rest(log: DropLog, rows: BoolArray, calibration: Calibration, model: RobotModel) -> FloatArray:
    """(3,) of the joints, rad, in the (n,) chosen samples; NaN: no sensor answered, or two contradict each other."""
    angles = np.full(len(calibration.joints), np.nan)
    for joint, sensors in enumerate(calibration.joints):
        each = sensors.each(log.sensor_angle_rad[rows][:, sensor_columns(model, joint + 1)]).T
        # Medians resist single wrong readings; their difference shows a sensor that slipped.
        medians = [
            float(np.median(sensor_angles[np.isfinite(sensor_angles)]))
            for sensor_angles in each
            if np.isfinite(sensor_angles).any()
        ]
        if medians and np.ptp(medians) < CONTRADICTION_RAD:
            angles[joint] = np.mean(medians)
    return angles
