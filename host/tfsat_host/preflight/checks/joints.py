"""The joints' absolute angle sensors: both of each joint in agreement, and the joint at its start pose."""

from __future__ import annotations

import numpy as np

from tfsat_host.angles import wrapped
from tfsat_host.calibration.sensors.joint_sensors import sensor_columns
from tfsat_host.calibration.zero import MOST_DISAGREEMENT_RAD
from tfsat_host.preflight.check import PreflightCheck, judged, not_made
from tfsat_host.preflight.evidence import (
    Evidence,
    Sensors,
    believed,
    certificate_of_these,
    joint_angles,
    sensors_of,
)
from tfsat_host.protocol.limits import START_POSE_TOLERANCE_CDEG

START_POSE_DEG = START_POSE_TOLERANCE_CDEG / 100.0
_LEAST_SAMPLES = 200
"""Noise of half a count lets a sensor show one value so many times with a probability below 1e-30."""


def check_sensors(evidence: Evidence) -> PreflightCheck:
    """Every angle sensor answers, has its noise, and agrees with the other one of its joint."""
    sensors = sensors_of(evidence)
    angles = joint_angles(sensors, evidence)
    valid = sensors.live.counts.angle_valid
    apart = np.abs(wrapped(angles[:, 0] - angles[:, 1]))
    frozen = _frozen(sensors, evidence)
    wrong = []
    for row, joint in enumerate(range(1, len(angles) + 1)):
        for k, column in enumerate(sensor_columns(evidence.robot, joint), 1):
            if not valid[:, column].all():
                wrong.append(f"sensor {k} of joint {joint} does not answer at every sample")
            elif column in frozen:
                wrong.append(f"sensor {k} of joint {joint} shows one value without any noise")
        if np.isfinite(apart[row]) and apart[row] > MOST_DISAGREEMENT_RAD:
            first, second = np.rad2deg(angles[row])
            wrong.append(f"the two of joint {joint} show {first:+.1f} and {second:+.1f} deg")
    return judged(
        wrong,
        "Of the angle sensors {}.",
        "tfsat-host monitor shows them: check wire and magnet. One whose magnet had slipped needs "
        "tfsat-host calibrate zero --joint N --anew",
        f"Both sensors of each joint answer and agree within {np.rad2deg(apart.max()):.1f} deg.",
        joint_deg=np.rad2deg(angles).tolist(),
        apart_deg=np.rad2deg(apart).tolist(),
        allowed_deg=float(np.rad2deg(MOST_DISAGREEMENT_RAD)),
        valid_samples=valid.sum(axis=0).tolist(),
    )


def check_start_pose(evidence: Evidence) -> PreflightCheck:
    """Each joint is where ARM wants it, by its calibrated sensors."""
    degrees = np.rad2deg(believed(joint_angles(sensors_of(evidence), evidence)))
    if not np.isfinite(degrees).all():
        return not_made("A joint has no sensor that answers.", "See joint-sensors.")
    away = [
        f"joint {joint} is at {angle:+.1f} deg"
        for joint, angle in enumerate(degrees, 1)
        if abs(angle) > START_POSE_DEG
    ]
    return judged(
        [", ".join(away)] if away else [],
        f"The start pose is 0 ± {START_POSE_DEG:g} deg, but {{}}.",
        "Bring the joint to 0 deg by hand or with tfsat-host jog, then run this preflight again.",
        f"All joints are at the start pose: {', '.join(f'{angle:+.1f}' for angle in degrees)} deg.",
        joint_deg=degrees.tolist(),
        allowed_deg=START_POSE_DEG,
    )


def _frozen(sensors: Sensors, evidence: Evidence) -> set[int]:
    """Columns of sensors that showed one value, although their calibration found noise of half a count or more."""
    counts = sensors.live.counts
    if len(counts.t_us) < _LEAST_SAMPLES:
        return set()
    return {
        column
        for joint in certificate_of_these(evidence).joints
        for k, column in enumerate(sensor_columns(evidence.robot, joint.joint))
        if joint.noise_rad[k] >= 0.5 * sensors.si.angle_step_rad
        and not np.ptp(counts.angle_counts[:, column])
    }
