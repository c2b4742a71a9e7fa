"""The angle sensors' part of the fit, of one joint that stands still."""

from __future__ import annotations

import numpy as np
import pytest

from tfsat_host.calibration.sensors.joint_sensors import JointSensors
from tfsat_host.evaluation.motion.joints import SensedJoint, errors_by_sensors

SAMPLES = 800
NOISE_RAD = np.deg2rad(0.053)
BEND_STD_RAD = np.deg2rad(0.04)
ZERO_STD_RAD = np.deg2rad(0.002)
START_STD_RAD = np.pi


def standing(angle_rad: float, seed: int) -> SensedJoint:
    """A joint at an angle; its sensors are as calibrated, and that may be off by a bend."""
    random = np.random.default_rng(seed)
    sensors = JointSensors(
        joint=3,
        direction=np.array([1.0, -1.0]),
        zero_rad=np.array([5.1, 1.8]),
        zero_covariance=ZERO_STD_RAD**2 * np.eye(2),
        bend=np.zeros((2, 4)),
        bend_covariance=BEND_STD_RAD**2 * np.eye(8),
        noise_rad=np.full(2, NOISE_RAD),
        zero_taken=None,
        bend_taken=None,
    )
    shown = (
        sensors.zero_rad + sensors.direction * angle_rad + NOISE_RAD * random.standard_normal((SAMPLES, 2))
    )
    return SensedJoint.of(sensors, shown, 0.0, np.zeros(SAMPLES))


@pytest.mark.parametrize("angle_deg", [-20.0, -2.2, 0.0, 2.2, 20.0])
def test_a_standing_joints_bend_does_not_follow_the_sensors_noise(angle_deg: float) -> None:
    """Noise times itself, sample for sample, would look like a bend of slope one: some percent of the angle."""
    by_start = np.full((SAMPLES, 1, 1), START_STD_RAD)
    off_deg = []
    for seed in range(20):
        joint = standing(np.deg2rad(angle_deg), seed)
        begin = np.full((SAMPLES, 1), joint.mean_rad.mean())
        errors, _ = errors_by_sensors(
            [joint], begin, by_start, np.zeros(1), np.ones(1, bool), (np.zeros((1, 1)), np.zeros(1))
        )
        found_rad = begin[0, 0] + START_STD_RAD * errors[0]
        off_deg.append(np.rad2deg(found_rad) - angle_deg)
    mean_std_deg = np.rad2deg(NOISE_RAD) / np.sqrt(2 * SAMPLES * len(off_deg))
    assert abs(np.mean(off_deg)) < 4.0 * mean_std_deg
