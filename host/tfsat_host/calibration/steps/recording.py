"""Samples taken for a calibration, in SI units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.offsets import at_sample_times
from tfsat_host.units import STANDARD_GRAVITY_M_S2

FloatArray = NDArray[np.float64]

_ACCEL, _TEMPERATURE, _GYRO = slice(0, 3), 3, slice(4, 7)


@dataclass(frozen=True, eq=False)
class Recording:
    """n samples of all sensors, each at its sample's time: when a sensor was really read, and that low-passes of
    different parts are late by different times, is taken into account here.

    Attributes:
        t_s: (n,) seconds on the logger's clock.
        rate_rad_s: (n, 4, 3) angular rates in sensor axes, as read, bias included.
        accel_m_s2: (n, 4, 3) specific forces in sensor axes, as read.
        temperature_c: (n, 4) of the IMUs' dies.
        sensor_angle_rad: (n, 6) absolute angle sensors, 0 to 2 pi: the middle of the count, for a converter cuts off.
        imu_valid: (n, 4) the IMU answered and did not clip.
        clipped: (n, 4) a value of the IMU is at its full scale.
        samples_lost: Samples that the logger took and that never arrived.
        angle_step_rad: One count of an angle sensor.
    """

    t_s: FloatArray
    rate_rad_s: FloatArray
    accel_m_s2: FloatArray
    temperature_c: FloatArray
    sensor_angle_rad: FloatArray
    imu_valid: NDArray[np.bool_]
    clipped: NDArray[np.bool_]
    samples_lost: int
    angle_step_rad: float

    @classmethod
    def from_counts(cls, counts: Counts) -> Recording:
        """In SI units, by the scales that came with the counts."""
        scales, low_pass = counts.scales, counts.scales.low_pass
        step_rad = 2 * np.pi / scales.angle_counts_per_turn
        t_s = np.asarray(counts.t_us * 1e-6, dtype=np.float64)
        imu_s, angle_s = 1e-6 * np.array(scales.imu_offset_us), 1e-6 * np.array(scales.angle_offset_us)
        rates = np.deg2rad(counts.imu_counts[:, :, _GYRO] / scales.gyro_lsb_per_deg_s)
        forces = counts.imu_counts[:, :, _ACCEL] * np.float64(STANDARD_GRAVITY_M_S2 / scales.accel_lsb_per_g)
        shown = np.asarray((counts.angle_counts + 0.5) * step_rad, dtype=np.float64)
        answered = counts.imu_valid & ~counts.clipped
        return cls(
            t_s=t_s,
            rate_rad_s=at_sample_times(t_s, rates, imu_s - low_pass.gyros_later_s, answered),
            accel_m_s2=at_sample_times(t_s, forces, imu_s - low_pass.accels_later_s, answered),
            temperature_c=scales.temperature_c(counts.imu_counts[:, :, _TEMPERATURE]),
            sensor_angle_rad=at_sample_times(t_s, shown, angle_s, counts.angle_valid, angles=True),
            imu_valid=answered,
            clipped=counts.clipped,
            samples_lost=counts.samples_lost,
            angle_step_rad=step_rad,
        )
