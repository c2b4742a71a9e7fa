"""Healthy drops, and recordings with one thing wrong, made from those by changing their raw counts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from tests.evaluation.drops import MODEL, certificate, com_offsets, estimate_motion, fly_drop
from tests.fixtures.emulated_drop import Drop
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.evaluation.checks.check import Check
from tfsat_host.evaluation.checks.drop_checks import checks_of
from tfsat_host.evaluation.com_fit.com_fit import fit_model
from tfsat_host.evaluation.com_fit.momentum_residual import flown_of
from tfsat_host.robot import RobotModel
from tfsat_host.sdlog import DropLog

Wrong = Callable[[DropLog], DropLog]

ACCEL, GYRO = slice(0, 3), slice(4, 7)


@dataclass(frozen=True, eq=False)
class Flown:
    """A healthy drop and what its sensors were calibrated to."""

    drop: Drop
    calibration: Calibration

    def run_checks(
        self, wrong: Wrong = lambda log: log, *, fitted: bool = False, model: RobotModel = MODEL
    ) -> tuple[Check, ...]:
        """Run the checks on the drop with one thing wrong.

        Fitting the model takes a second and is done only on demand.
        """
        log = wrong(self.drop.log)
        motion = estimate_motion(log, self.calibration, model)
        fit = fit_model(com_offsets(model), flown_of(motion)) if fitted else None
        return checks_of(motion, fit, log, self.calibration, model)


@cache
def healthy_drop(seed: int = 1, dlpf_cfg: int = 3) -> Flown:
    """Return a healthy drop whose CoM offsets and initial rates follow from the seed."""
    random = np.random.default_rng(seed)
    # Skip the numbers from which fly_drop draws the offsets, so that rates are independent of them.
    random.uniform(size=9)  # the offsets
    rates = tuple(np.deg2rad(random.uniform(-2.0, 2.0, 3)).tolist())
    drop = fly_drop(seed, dlpf_cfg, rate_rad_s=rates)
    return Flown(drop, certificate(drop, seed))


def failures_by_name(checks: tuple[Check, ...]) -> dict[str, Check]:
    """Return the failed checks by name."""
    return {check.name: check for check in checks if check.failed}


def with_imu(log: DropLog, body: int, part: slice, counts: FloatArray) -> DropLog:
    """Return the log with the accelerometer or gyro counts (n, 3) of body 1 to 4 replaced."""
    other = log.imu_counts.copy()
    # A 16-bit register: readings beyond its range are clipped, as in the sensor.
    other[:, body - 1, part] = np.clip(np.round(counts), -32768, 32767)
    return replace(log, imu_counts=other)


def axes_exchanged(log: DropLog, body: int, exchange: Sequence[Sequence[int]], part: slice = GYRO) -> DropLog:
    """`exchange` (3, 3) makes what is shown of what is true."""
    return with_imu(log, body, part, log.imu_counts[:, body - 1, part] @ np.array(exchange).T.astype(float))


def imus_in_order(log: DropLog, order: Sequence[int]) -> DropLog:
    """Place i of the log shows the IMU of body `order[i]`, read when it was."""
    # The read offset belongs to the bus position, so it moves with the IMU.
    offsets_us = tuple(log.header.imu_offset_us[body - 1] for body in order)
    header = replace(log.header, imu_offset_us=offsets_us)
    return replace(log, header=header, imu_counts=log.imu_counts[:, np.array(order) - 1])


def gyro_plus(log: DropLog, body: int, rate_deg_s: Sequence[float] | FloatArray) -> DropLog:
    """Return the log with `rate_deg_s`, (3,) or (n, 3), added to a body's gyro readings."""
    added = np.asarray(rate_deg_s) * log.header.gyro_lsb_per_deg_s
    return with_imu(log, body, GYRO, log.imu_counts[:, body - 1, GYRO] + added)


def gyro_scaled(log: DropLog, body: int, factor: Sequence[float]) -> DropLog:
    """Return the log with each axis of a body's gyro scaled by its own factor."""
    return with_imu(log, body, GYRO, log.imu_counts[:, body - 1, GYRO] * np.array(factor))


def gyros_late(log: DropLog, bodies: Sequence[int], samples: int) -> DropLog:
    """They show what they should have shown some samples before."""
    other = log.imu_counts.copy()
    for body in bodies:
        # The first samples keep their values: nothing was recorded before them.
        other[samples:, body - 1, GYRO] = log.imu_counts[:-samples, body - 1, GYRO]
    return replace(log, imu_counts=other)


def gyro_stuck(log: DropLog, body: int, from_s: float) -> DropLog:
    """It repeats one reading, and its flag says that it is well."""
    row = int(np.searchsorted(log.t_s, from_s))
    counts = log.imu_counts[:, body - 1, GYRO].astype(float)
    counts[row:] = counts[row]
    return with_imu(log, body, GYRO, counts)


def with_angles(log: DropLog, column: int, counts: NDArray[np.int64]) -> DropLog:
    """Angle sensor 0 to 5 gives these counts (n,), modulo a turn."""
    other = log.angle_counts.copy()
    # Counts wrap at a turn, as the sensor's register does.
    other[:, column] = np.mod(counts, log.header.angle_counts_per_turn)
    return replace(log, angle_counts=other)


def sensor_reversed(log: DropLog, column: int) -> DropLog:
    """It counts the other way round."""
    return with_angles(log, column, -log.angle_counts[:, column].astype(np.int64))


def sensor_moved(log: DropLog, column: int, angle_deg: float) -> DropLog:
    """It was turned on its shaft."""
    counts = round(angle_deg / 360.0 * log.header.angle_counts_per_turn)
    return with_angles(log, column, log.angle_counts[:, column].astype(np.int64) + counts)


def sensor_late(log: DropLog, column: int, samples: int) -> DropLog:
    """It shows what it should have shown some samples before."""
    counts = log.angle_counts[:, column].astype(np.int64)
    counts[samples:] = log.angle_counts[:-samples, column]
    return with_angles(log, column, counts)


def sensor_stuck(log: DropLog, column: int, from_s: float) -> DropLog:
    """It repeats one reading."""
    row = int(np.searchsorted(log.t_s, from_s))
    counts = log.angle_counts[:, column].astype(np.int64)
    counts[row:] = counts[row]
    return with_angles(log, column, counts)


def sensors_exchanged(log: DropLog, first: int, second: int) -> DropLog:
    """Return the log with the cables of two angle sensors exchanged."""
    other = log.angle_counts.copy()
    other[:, [first, second]] = log.angle_counts[:, [second, first]]
    return replace(log, angle_counts=other)


def silence_imu(log: DropLog, body: int, from_s: float, until_s: float) -> DropLog:
    """Return the log with a body's IMU not answering between two times."""
    valid = log.imu_valid.copy()
    valid[(log.t_s >= from_s) & (log.t_s < until_s), body - 1] = False
    return replace(log, imu_valid=valid)


def without_samples(log: DropLog, from_s: float, until_s: float) -> DropLog:
    """Return the log without the samples between two times."""
    keep_mask = (log.t_s < from_s) | (log.t_s >= until_s)
    # Every column that has one row a sample; events and header stay.
    columns = ["sample_index", "t_us", "imu_counts", "angle_counts", "imu_valid", "angle_valid"]
    columns += ["switch_open", "clipped"]
    return replace(log, **{name: getattr(log, name)[keep_mask] for name in columns})
