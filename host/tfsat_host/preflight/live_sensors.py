"""The live samples of a preflight as its checks use them: in SI units, and by the certificate of these sensors."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tfsat_host.angles import wrap_angle
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.sensors.joint_sensors import sensor_columns
from tfsat_host.calibration.steps.sensor_samples import SensorSamples
from tfsat_host.calibration.zero import MAX_DISAGREEMENT_RAD
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.preflight.preflight_evidence import Evidence, LiveSamples, Missing, Unreached, require
from tfsat_host.robot.absent_parts import ignore_absent


@dataclass(frozen=True, eq=False)
class Sensors:
    """Live samples.

    Attributes:
        live: Raw.
        si: The same in SI units, sensor axes.
    """

    live: LiveSamples
    si: SensorSamples

    def responding_imus(self) -> NDArray[np.intp]:
        """Bodies from 0 whose IMU gave anything, one at least. Raises Unreached: there is none."""
        bodies = np.flatnonzero(self.live.counts.imu_valid.any(axis=0))
        if not len(bodies):
            raise Unreached(Missing("No IMU answered.", "See gyros-present."))
        return bodies


def sensors_of(evidence: Evidence) -> Sensors:
    """Return the live sensor samples. Raises Unreached: none were received."""
    live = require(require(evidence.logger).live)
    live = replace(live, counts=ignore_absent(live.counts, evidence.robot))
    return Sensors(live, SensorSamples.from_counts(live.counts))


def certificate_of_these(evidence: Evidence) -> Calibration:
    """Return the calibration if its numbers are of these sensors, fresh or not.

    Raises Unreached: there is none.
    """
    calibration, origin = evidence.calibration, evidence.origin
    if isinstance(calibration, Missing):
        raise Unreached(Missing("It takes a calibration of these sensors.", "See calibration."))
    if origin is None:
        raise Unreached(
            Missing("Whose sensors these are the logger did not answer.", Advice(NextStep("status")))
        )
    subject = calibration.subject
    if (subject.logger_serial, subject.emulated) != (origin.logger_serial, origin.emulated):
        what = "It takes a calibration of these sensors; this one is of others."
        raise Unreached(Missing(what, "See calibration."))
    return calibration


def merge_sensor_angles(angles_rad: FloatArray) -> FloatArray:
    """(3,) angle of each joint from those by each sensor, (3, 2); NaN where neither answered.

    Their mean. Of two that contradict each other the one that is nearer to the start pose counts, for nothing here
    shows which is right; the contradiction itself is found by a check.
    """
    # (3,); NaN where a sensor is silent, which no threshold exceeds.
    apart = np.abs(wrap_angle(angles_rad[:, 0] - angles_rad[:, 1]))
    is_finite = np.isfinite(angles_rad)
    # Mean over the sensors that answered; the maximum avoids 0/0 where none did.
    mean = np.where(is_finite, angles_rad, 0.0).sum(axis=1) / np.maximum(is_finite.sum(axis=1), 1)
    # A silent sensor counts as infinitely far, so that argmin passes it over.
    nearest = np.argmin(np.where(is_finite, np.abs(angles_rad), np.inf), axis=1)
    nearer = np.take_along_axis(angles_rad, nearest[:, None], axis=1)[:, 0]
    chosen = np.where(apart > MAX_DISAGREEMENT_RAD, nearer, mean)
    return np.where(is_finite.any(axis=1), chosen, np.nan)


def joint_angles(sensors: Sensors, evidence: Evidence) -> FloatArray:
    """(3, 2) mean angle of each joint by each of its two sensors, rad; NaN where one did not answer.

    Raises:
        Unreached: there is no calibration of these sensors, or a zero point was never measured.
    """
    calibration = certificate_of_these(evidence)
    angles = np.full((len(calibration.joints), 2), np.nan)
    for row, joint in enumerate(calibration.joints):
        if not joint.has_zero:
            what = f"The zero point of joint {joint.joint} was never measured."
            command = NextStep("calibrate zero", ("--joint", str(joint.joint)))
            raise Unreached(Missing(what, Advice(command)))
        columns = sensor_columns(evidence.robot, joint.joint)
        valid = sensors.live.counts.angle_valid[:, columns]
        each = joint.each(sensors.si.sensor_angle_rad[:, columns])
        for k in range(2):
            if valid[:, k].any():
                # About its circular mean: a sensor at half a turn from its zero must not average to nothing.
                angles[row, k] = np.angle(np.exp(1j * each[valid[:, k], k]).mean())
    return angles
