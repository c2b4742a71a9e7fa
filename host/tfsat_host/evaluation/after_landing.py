"""How much less is known of what was measured before a landing that may have changed it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from tfsat_host.calibration.certificate.certificate import Shortcoming
from tfsat_host.calibration.gyros.seen import LANDING_TILT_STD_RAD
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.sensors.joint_sensors import JointSensors

LANDING_BIAS_STD_RAD_S = np.deg2rad(0.5)
"""Of a bias: shocks of 10,000 g are survived, not unnoticed; assumed, as no data sheet says."""
LANDING_ZERO_STD_RAD = np.deg2rad(1.0)
"""Of an angle sensor's zero point: as far as a sensor may turn in its mount, assumed like the gyros' tilt."""

Lacking = Mapping[str, Shortcoming]


def gyro_since(gyro: GyroCalibration, lacking: Lacking) -> GyroCalibration:
    """With what a landing may have done to the stale part of it."""
    covariance = gyro.covariance.copy()
    if _is_stale(lacking, f"bias of body {gyro.body}"):
        covariance[:3, :3] += LANDING_BIAS_STD_RAD_S**2 * np.eye(3)
    if any(_is_stale(lacking, f"misalignment of body {gyro.body} about {axis}") for axis in "xyz"):
        covariance[3:6, 3:6] += LANDING_TILT_STD_RAD**2 * np.eye(3)
    return replace(gyro, covariance=covariance)


def sensors_since(sensors: JointSensors, lacking: Lacking) -> JointSensors:
    """The same of a joint's angle sensors, each of which may have turned by itself."""
    if not _is_stale(lacking, f"zero point of joint {sensors.joint}"):
        return sensors
    return replace(sensors, zero_covariance=sensors.zero_covariance + LANDING_ZERO_STD_RAD**2 * np.eye(2))


def _is_stale(lacking: Lacking, name: str) -> bool:
    return name in lacking and lacking[name].reason == "stale"
