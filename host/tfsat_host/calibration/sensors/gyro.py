"""One gyro's calibration: what it makes of a body's rate, and back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from tfsat_host.arrays import FloatArray

SCALE_STD = 0.03 / 3.0**0.5
"""Standard deviation of a scale factor that lies anywhere within 3 % (PS-MPU-6000A rev. 3.4, section 6.1)."""
BIAS_STD_RAD_S = np.deg2rad(20.0) / 3.0**0.5
"""Of a gyro whose bias was never measured: anywhere within 20 deg/s (PS-MPU-6000A rev. 3.4, section 6.1)."""
MOUNTING_STD_RAD = np.deg2rad(5.0)
"""About each axis, of a sensor that was mounted with care and never measured."""


@dataclass(frozen=True, eq=False)
class GyroCalibration:
    """The gyro of one body: reading = scale * (rotation^T rate) + bias, component by component.

    Attributes:
        body: 1 to 4.
        bias_rad_s: (3,) sensor axes.
        rotation: (3, 3) from sensor to body axes.
        scale: (3,) reading over truth, sensor axes.
        covariance: (9, 9) of bias (rad/s), of a rotation vector in sensor axes (rad) and of the scale.
        noise_rad_s: (3,) standard deviation of one sample about its mean; NaN where none rested.
        temperature_c: Of the die when the bias was taken; NaN where it was not.
        axes: Body axis to when its direction was measured last, such as {"x": ..., "y": ...}.
        scaled: Body axis to when the length about it was measured, where the scale factor is known to 0.5 %.
        bias_recorded_at: None where none rested: it is by design.
    """

    body: int
    bias_rad_s: FloatArray
    rotation: FloatArray
    scale: FloatArray
    covariance: FloatArray
    noise_rad_s: FloatArray
    temperature_c: float
    axes: Mapping[str, datetime]
    scaled: Mapping[str, datetime]
    bias_recorded_at: datetime | None

    @property
    def bias_std_rad_s(self) -> FloatArray:
        """(3,) standard deviations of the bias, sensor axes."""
        return np.asarray(np.sqrt(np.diag(self.covariance)[:3]))

    def body_rates(self, readings_rad_s: FloatArray) -> FloatArray:
        """(n, 3) rates in body axes of readings (n, 3) in sensor axes."""
        return np.asarray(((readings_rad_s - self.bias_rad_s) / self.scale) @ self.rotation.T)

    def readings(self, rates_rad_s: FloatArray) -> FloatArray:
        """(n, 3) in sensor axes, without bias, of rates (n, 3) in body axes."""
        return np.asarray(self.scale * (rates_rad_s @ self.rotation))

    def add_errors(self, parameters: FloatArray) -> GyroCalibration:
        """Apply corrections (9,) to bias, rotation vector and scale, in the order of `covariance`."""
        from scipy.spatial.transform import Rotation  # half the time that reading a certificate takes

        # From the right: the rotation vector is in sensor axes.
        turn = Rotation.from_rotvec(parameters[3:6]).as_matrix()
        return replace(
            self,
            bias_rad_s=self.bias_rad_s + parameters[:3],
            rotation=self.rotation @ turn,
            scale=self.scale + parameters[6:],
        )

    def scale_about(self, axis: int) -> tuple[float, float]:
        """Reading over truth for a rotation about a body axis (0 to 2), and its standard deviation."""
        # A rotation about a body axis is spread over the sensor's axes by the squared cosines.
        shares = self.rotation[axis] ** 2
        return float(shares @ self.scale), float(np.sqrt(shares @ self.covariance[6:, 6:] @ shares))

    def jacobian(self, readings_rad_s: FloatArray) -> FloatArray:
        """(n, 3, 9) of the body rates by the parameters, in the order of `covariance`."""
        # J = M [-diag(1/s), -[v]x, -diag(v/s)] with v = (r - b) / s (docs/calibration.md).
        rates = (readings_rad_s - self.bias_rad_s) / self.scale
        # (n, 3, 3): the rows e_k x v are the cross-product matrix [v]x.
        cross = np.cross(np.eye(3), rates[:, None, :])
        by_bias = np.broadcast_to(np.diag(-1.0 / self.scale), cross.shape)
        by_scale = -(rates / self.scale)[:, :, None] * np.eye(3)
        return np.asarray(self.rotation @ np.concatenate([by_bias, -cross, by_scale], axis=2))


def by_design(body: int, nominal: FloatArray) -> GyroCalibration:
    """Build a gyro's calibration by design, before anything is measured.

    `nominal` (3, 3) is its mounting by design, from sensor to body axes.
    """
    deviations = np.repeat([BIAS_STD_RAD_S, MOUNTING_STD_RAD, SCALE_STD], 3)
    return GyroCalibration(
        body,
        np.zeros(3),
        nominal,
        np.ones(3),
        np.diag(deviations**2),
        np.full(3, np.nan),
        float("nan"),
        {},
        {},
        None,
    )
