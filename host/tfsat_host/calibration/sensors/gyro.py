"""One gyro's calibration: what it makes of a body's rate, and back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime
from functools import cached_property

import numpy as np

from tfsat_host.arrays import FloatArray

SCALE_STD = 0.03 / 3.0**0.5
"""Standard deviation of a scale factor that lies anywhere within 3 % (PS-MPU-6000A rev. 3.4, section 6.1)."""
BIAS_STD_RAD_S = np.deg2rad(20.0) / 3.0**0.5
"""Of a gyro whose bias was never measured: anywhere within 20 deg/s (PS-MPU-6000A rev. 3.4, section 6.1)."""
MOUNTING_STD_RAD = np.deg2rad(5.0)
"""About each axis, of a sensor that was mounted with care and never measured."""
SKEW_STD = 0.02 / 6.0**0.5
"""Of each skew: each axis shows 2 % of a rate about another at most (PS-MPU-6000A rev. 3.4, section 6.1), anywhere
within; half the sum of two such shares is a skew, half their difference a rotation."""
BIAS, MOUNTING, SCALE, SKEW = slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 12)
"""Of a gyro's parameters."""
RESPONSE = slice(6, 12)
"""Scale factors and skews together."""
PARAMETERS = 12
SHARED = 12
"""Numbers that the calibrations of several gyros rest on: tilts of the three joints' axes, about each of the two
directions across it, then of the three body axes about which the whole robot is turned by hand."""
_ACROSS = ((1, 2), (2, 0), (0, 1))
"""Of each skew the two axes: y and z, z and x, x and y."""


@dataclass(frozen=True, eq=False)
class GyroCalibration:
    """The gyro of one body: reading = response rotation^T rate + bias.

    The response (3, 3) is symmetric: scale factors on its diagonal, skews (cross-axis sensitivity) beside it.

    Attributes:
        body: 1 to 4.
        bias_rad_s: (3,) sensor axes.
        rotation: (3, 3) from sensor to body axes.
        scale: (3,) reading over truth, sensor axes.
        skew: (3,) what the axes y and z, z and x, x and y show of a rate about the other one, over that rate.
        covariance: (12, 12) of bias (rad/s), of a rotation vector in sensor axes (rad), of the scale and of the skew.
        noise_rad_s: (3,) standard deviation of one sample about its mean; NaN where none rested.
        temperature_c: Of the die when the bias was taken; NaN where it was not.
        axes: Body axis to when its direction was measured last, such as {"x": ..., "y": ...}.
        scaled: Body axis to when the length about it was measured, where the scale factor is known to 0.5 %.
        bias_recorded_at: None where none rested: it is by design.
        shared: (12, SHARED) what the truth is apart from these values where each of those numbers is one standard
            deviation off: `shared` times its transpose is part of the covariance, and between two gyros all of it.
        absent: The body has no IMU, by the robot file: nothing is measured or missed.
    """

    body: int
    bias_rad_s: FloatArray
    rotation: FloatArray
    scale: FloatArray
    skew: FloatArray
    covariance: FloatArray
    noise_rad_s: FloatArray
    temperature_c: float
    axes: Mapping[str, datetime]
    scaled: Mapping[str, datetime]
    bias_recorded_at: datetime | None
    shared: FloatArray = field(default_factory=lambda: np.zeros((PARAMETERS, SHARED)))
    absent: bool = False

    @cached_property
    def response(self) -> FloatArray:
        """(3, 3) reading of a rate in sensor axes, symmetric."""
        return response_matrix(self.scale, self.skew)

    @cached_property
    def inverse_response(self) -> FloatArray:
        """(3, 3) rate in sensor axes of a reading without its bias, symmetric."""
        return np.asarray(np.linalg.inv(self.response))

    @property
    def bias_std_rad_s(self) -> FloatArray:
        """(3,) standard deviations of the bias, sensor axes."""
        return np.asarray(np.sqrt(np.diag(self.covariance)[:3]))

    def body_rates(self, readings_rad_s: FloatArray) -> FloatArray:
        """(n, 3) rates in body axes of readings (n, 3) in sensor axes."""
        return np.asarray((readings_rad_s - self.bias_rad_s) @ self.inverse_response @ self.rotation.T)

    def readings(self, rates_rad_s: FloatArray) -> FloatArray:
        """(n, 3) in sensor axes, without bias, of rates (n, 3) in body axes."""
        return np.asarray((rates_rad_s @ self.rotation) @ self.response)

    def add_errors(self, parameters: FloatArray) -> GyroCalibration:
        """Apply corrections (12,) to bias, rotation vector, scale and skew, in the order of `covariance`."""
        from scipy.spatial.transform import Rotation  # half the time that reading a certificate takes

        # From the right: the rotation vector is in sensor axes.
        turn = Rotation.from_rotvec(parameters[MOUNTING]).as_matrix()
        return replace(
            self,
            bias_rad_s=self.bias_rad_s + parameters[BIAS],
            rotation=self.rotation @ turn,
            scale=self.scale + parameters[SCALE],
            skew=self.skew + parameters[SKEW],
        )

    def scale_about(self, axis: int) -> tuple[float, float]:
        """Reading over truth for a rotation about a body axis (0 to 2), and its standard deviation."""
        # What the reading shows along a unit vector u, u S u, is linear in scale factors and skews.
        along = self.rotation[axis]
        by_each = along @ by_response(along)
        scale = by_each @ np.concatenate([self.scale, self.skew])
        return float(scale), float(np.sqrt(by_each @ self.covariance[RESPONSE, RESPONSE] @ by_each))

    def jacobian(self, readings_rad_s: FloatArray) -> FloatArray:
        """(n, 3, 12) of the body rates by the parameters, in the order of `covariance`."""
        # J = M [-S^-1, -[v]x, -S^-1 diag(v), -S^-1 (e_i v_j + e_j v_i)] with v = S^-1 (r - b) (docs/calibration.md).
        rates = (readings_rad_s - self.bias_rad_s) @ self.inverse_response
        # (n, 3, 3): the rows e_k x v are the cross-product matrix [v]x.
        cross = np.cross(np.eye(3), rates[:, None, :])
        by_bias = np.broadcast_to(-self.inverse_response, cross.shape)
        by_responses = -self.inverse_response @ by_response(rates)
        return np.asarray(self.rotation @ np.concatenate([by_bias, -cross, by_responses], axis=2))


def response_matrix(scale: FloatArray, skew: FloatArray) -> FloatArray:
    """(3, 3) the symmetric response of scale factors (3,) and skews (3,)."""
    response = np.diag(scale)
    for value, (first, second) in zip(skew, _ACROSS, strict=True):
        response[first, second] = response[second, first] = value
    return response


def skews_of(response: FloatArray) -> FloatArray:
    """(3,) skews of a symmetric response (3, 3)."""
    return np.array([response[pair] for pair in _ACROSS])


def by_response(rates: FloatArray) -> FloatArray:
    """(..., 3, 6) of readings by scale factors and skews, for rates (..., 3) in sensor axes."""
    out = np.zeros((*rates.shape, 6))
    for axis in range(3):
        out[..., axis, axis] = rates[..., axis]
    for skew, (first, second) in enumerate(_ACROSS, 3):
        out[..., first, skew], out[..., second, skew] = rates[..., second], rates[..., first]
    return out


def by_design(body: int, nominal: FloatArray, *, absent: bool = False) -> GyroCalibration:
    """Build a gyro's calibration by design, before anything is measured.

    `nominal` (3, 3) is its mounting by design, from sensor to body axes. `absent`: the body has none.
    """
    deviations = np.repeat([BIAS_STD_RAD_S, MOUNTING_STD_RAD, SCALE_STD, SKEW_STD], 3)
    return GyroCalibration(
        body,
        np.zeros(3),
        nominal,
        np.ones(3),
        np.zeros(3),
        np.diag(deviations**2),
        np.full(3, np.nan),
        float("nan"),
        {},
        {},
        None,
        absent=absent,
    )
