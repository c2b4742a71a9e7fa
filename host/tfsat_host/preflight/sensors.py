"""Live samples of some seconds at rest, by body and joint, with a calibration where there is one of these sensors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.angles import wrapped
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.sensors.joint_sensors import sensor_columns
from tfsat_host.calibration.steps.recording import Recording
from tfsat_host.calibration.zero import MOST_DISAGREEMENT_RAD
from tfsat_host.preflight.evidence import Evidence, LiveSamples, Missing

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Sensors:
    """Live samples.

    Attributes:
        live: Raw.
        si: The same in SI units, sensor axes.
    """

    live: LiveSamples
    si: Recording


def sensors_of(evidence: Evidence) -> Sensors | Missing:
    """What came live; Missing: nothing did."""
    if isinstance(evidence.logger, Missing):
        return evidence.logger
    live = evidence.logger.live
    if isinstance(live, Missing):
        return live
    return Sensors(live, Recording.from_counts(live.counts))


def certificate_of_these(evidence: Evidence) -> Calibration | Missing:
    """The calibration, if its numbers are of these sensors; whether it is fresh is another check's."""
    calibration, origin = evidence.calibration, evidence.origin
    if isinstance(calibration, Missing):
        return Missing("It takes a calibration of these sensors.", "See calibration.")
    if origin is None:
        return Missing("The logger did not say whose sensors these are.", "tfsat-host status")
    subject = calibration.subject
    if (subject.logger_serial, subject.emulated) != (origin.logger_serial, origin.emulated):
        return Missing("It takes a calibration of these sensors; this one is of others.", "See calibration.")
    return calibration


def believed(angles_rad: FloatArray) -> FloatArray:
    """(3,) angle of each joint from those by each sensor, (3, 2); NaN where neither answered.

    Their mean. Of two that contradict each other the one that is nearer to the start pose counts, for nothing here
    tells which is right; the contradiction itself is a check's.
    """
    apart = np.abs(wrapped(angles_rad[:, 0] - angles_rad[:, 1]))
    known = np.isfinite(angles_rad)
    mean = np.where(known, angles_rad, 0.0).sum(axis=1) / np.maximum(known.sum(axis=1), 1)
    nearer = angles_rad[
        np.arange(len(angles_rad)), np.argmin(np.where(known, np.abs(angles_rad), np.inf), axis=1)
    ]
    chosen = np.where(apart > MOST_DISAGREEMENT_RAD, nearer, mean)
    return np.where(known.any(axis=1), chosen, np.nan)


def joint_angles(sensors: Sensors, evidence: Evidence) -> FloatArray | Missing:
    """(3, 2) mean angle of each joint by each of its two sensors, rad; NaN where one did not answer.

    Missing: there is no calibration of these sensors, or a zero point was never measured.
    """
    calibration = certificate_of_these(evidence)
    if isinstance(calibration, Missing):
        return calibration
    angles = np.full((len(calibration.joints), 2), np.nan)
    for row, joint in enumerate(calibration.joints):
        if joint.zero_taken is None:
            return Missing(
                f"The zero point of joint {joint.joint} was never measured.",
                f"tfsat-host calibrate zero --joint {joint.joint}",
            )
        columns = sensor_columns(evidence.robot, joint.joint)
        valid = sensors.live.counts.angle_valid[:, columns]
        each = joint.each(sensors.si.sensor_angle_rad[:, columns])
        for k in range(2):
            if valid[:, k].any():
                # About its circular mean: a sensor at half a turn from its zero must not average to nothing.
                angles[row, k] = np.angle(np.exp(1j * each[valid[:, k], k]).mean())
    return angles
