"""Samples taken for a calibration, in SI units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.messages import LiveReply, LiveSampleStream

FloatArray = NDArray[np.float64]

STANDARD_GRAVITY_M_S2 = 9.80665
_TEMPERATURE_LSB_PER_C = 340.0  # MPU-6050: RM-MPU-6000A rev. 4.2, register 65
_TEMPERATURE_OFFSET_C = 36.53


@dataclass(frozen=True, eq=False)
class Recording:
    """n samples of all sensors.

    Attributes:
        t_s: (n,) seconds on the logger's clock.
        rate_rad_s: (n, 4, 3) angular rates in sensor axes, as read, bias included.
        accel_m_s2: (n, 4, 3) specific forces in sensor axes, as read.
        temperature_c: (n, 4) of the IMUs' dies.
        sensor_angle_rad: (n, 6) absolute angle sensors, 0 to 2 pi.
        imu_valid: (n, 4) the IMU answered and did not clip.
        samples_lost: Samples that the logger took and that never arrived.
    """

    t_s: FloatArray
    rate_rad_s: FloatArray
    accel_m_s2: FloatArray
    temperature_c: FloatArray
    sensor_angle_rad: FloatArray
    imu_valid: NDArray[np.bool_]
    samples_lost: int

    @classmethod
    def from_live(cls, samples: Sequence[LiveSampleStream], scales: LiveReply) -> Recording:
        """Converts live samples with the scales that the logger named; at least one sample."""
        gyro, accel, temperature = (
            np.array(
                [[getattr(imu, name) for imu in sample.sample.imu] for sample in samples], dtype=np.float64
            )
            for name in ("gyro", "accel", "temperature")
        )
        counts = np.array([sample.sample.angle for sample in samples], dtype=np.float64)
        flags = np.array([sample.sample.flags for sample in samples])
        bits = flags[:, None] >> np.arange(4)
        return cls(
            t_s=np.array([sample.time_us for sample in samples]) * 1e-6,
            rate_rad_s=np.deg2rad(gyro / scales.gyro_lsb_per_deg_s),
            accel_m_s2=accel * (STANDARD_GRAVITY_M_S2 / scales.accel_lsb_per_g),
            temperature_c=temperature / _TEMPERATURE_LSB_PER_C + _TEMPERATURE_OFFSET_C,
            sensor_angle_rad=counts * (2 * np.pi / scales.angle_counts_per_turn),
            imu_valid=(bits & 1 > 0) & (bits >> 12 & 1 == 0),
            samples_lost=samples[-1].index - samples[0].index + 1 - len(samples),
        )
