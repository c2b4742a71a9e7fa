"""How a servo is measured: where it is sent, and where it came to rest."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.sensors.joint_sensors import JointSensors, harmonics, sensor_columns
from tfsat_host.calibration.servos.fit import fit_servo_map
from tfsat_host.calibration.servos.servo_map import ServoMap, ServoPoint
from tfsat_host.calibration.statistics import mean_and_covariance, root_of
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.evidence import Evidence, Visit
from tfsat_host.calibration.steps.sensor_samples import SensorSamples
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.limits import JOINT_ANGLE_MAX_CDEG, JOINT_ANGLE_MIN_CDEG
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.robot import RobotModel

REST_US: Final = 600_000
"""The last part of a visit: by then the servo has caught up with its pulses, and the joint has settled."""
BATCHES: Final = 10
MIN_SAMPLES: Final = 2 * BATCHES
"""In a visit; 34 Hz give them."""
MAX_MOTION_RAD: Final = np.deg2rad(1.0)
"""Between the batches of a visit: more, and the joint was not at rest."""
AT_STOP_RAD: Final = np.deg2rad(0.5)
"""From the end of a joint's range as the robot file has it: what that, the zero point and a stop's give may be off."""
MAX_DISAGREEMENT_RAD: Final = np.deg2rad(2.0)
"""Between the two sensors of the joint, by the zero points in force."""


def servo_map_of(evidence: Evidence, joints: Sequence[JointSensors], model: RobotModel) -> ServoMap:
    """Fit the servo map to the visits of a servo step.

    Its covariance includes the uncertainty of the angle sensors' zero points and bend, which is common to all
    visits, so that no scatter shows it. Visits that may have ended at the joint's stops are left out.

    Args:
        evidence: A servo step.
        joints: Sensors of joints 1 to 3, as calibrated.
        model: For the sensors' places in the log, and the ends of the joint's range.

    Raises:
        CalibrationError: see `servo_points` and `fit_servo_map`.
        ValueError: it is no servo step.
    """
    sensors = joints[joint_of(evidence) - 1]
    every = servo_points(evidence, joints, model)
    # At a stop the frame decides where the joint rests, not the servo.
    points = [
        point for point, met in zip(every, at_stops(every, sensors.joint, model), strict=True) if not met
    ]
    servo_map = fit_servo_map(points, sensors.joint, setting_of(evidence), evidence.recorded_at)
    pulse_us = np.array([point.pulse_us for point in points])
    direction = np.array([point.direction for point in points])
    design = np.column_stack([np.ones(len(points)), pulse_us - servo_map.middle_us, -direction / 2.0])
    # Errors common to all visits pass through the fit: (3, 10), a column for each independent one.
    shared = np.linalg.pinv(design) @ shared_errors(
        sensors, np.array([point.reached_rad for point in points])
    )
    return replace(servo_map, covariance=servo_map.covariance + shared @ shared.T)


def servo_points(
    evidence: Evidence, joints: Sequence[JointSensors], model: RobotModel
) -> tuple[ServoPoint, ...]:
    """Estimate the joint's angle at rest at each visit, in order of time.

    Raises:
        CalibrationError: the joint has no measured zero point, or a visit is no rest for both sensors.
        ValueError: it is no servo step.
    """
    sensors = joints[joint_of(evidence) - 1]
    require_zero(sensors)
    return points_of(evidence.visits, evidence.counts, sensors, model)


def points_of(
    visits: Iterable[Visit], counts: Counts, sensors: JointSensors, model: RobotModel
) -> tuple[ServoPoint, ...]:
    """Estimate the angle at rest of a joint with these sensors at each visit.

    Raises CalibrationError: see `servo_points`.
    """
    recording = SensorSamples.from_counts(counts)
    columns = sensor_columns(model, sensors.joint)
    readings_rad, valid = recording.sensor_angle_rad[:, columns], counts.angle_valid[:, columns]
    points = []
    for visit in visits:
        inside = (counts.t_us >= visit.from_us) & (counts.t_us <= visit.to_us)
        points.append(_point(visit, readings_rad[inside], valid[inside], sensors, recording.angle_step_rad))
    return tuple(points)


def at_stops(points: Sequence[ServoPoint], joint: int, model: RobotModel) -> tuple[bool, ...]:
    """Return whether the joint may have rested against an end of its range, for each visit.

    A servo commanded below 0 deg is stopped there, and a map fitted through that is too flat. All visits to
    that place from that side count as stopped: those that got less far would not scatter about the servo's
    mean.
    """
    ends_rad = model.joint_limits_rad[joint - 1]
    met = {
        (point.pulse_us, point.direction)
        for point in points
        if point.reached_rad < ends_rad[0] + AT_STOP_RAD or point.reached_rad > ends_rad[1] - AT_STOP_RAD
    }
    return tuple((point.pulse_us, point.direction) in met for point in points)


def joint_of(evidence: Evidence) -> int:
    """1 to 3. Raises ValueError if it is no step of a joint."""
    if evidence.step.joint is None:
        raise ValueError("a servo step needs a joint")
    return evidence.step.joint


def setting_of(evidence: Evidence) -> ServoSetting:
    """Return the servo's setting in force at the recording, or raise ValueError if there is none.

    The limits are the widest, because they are not recorded.
    """
    if evidence.servo_setting is None:
        raise ValueError("a servo step needs the servo's setting")
    return ServoSetting(*evidence.servo_setting, JOINT_ANGLE_MIN_CDEG, JOINT_ANGLE_MAX_CDEG)


def require_zero(sensors: JointSensors) -> None:
    """Raises CalibrationError where the joint's angle sensors have no measured zero point."""
    if sensors.zero_recorded_at is not None:
        return
    raise CalibrationError(
        what=f"The zero point of joint {sensors.joint} is not calibrated.",
        meaning="Its angle sensors do not tell where its servo comes to rest. The board keeps its servo settings.",
        next_step=Advice(
            "Put the holding attachment on, then: ",
            NextStep("calibrate zero", ("--joint", str(sensors.joint))),
        ),
    )


def _point(
    visit: Visit,
    shown_rad: FloatArray,
    valid: NDArray[np.bool_],
    sensors: JointSensors,
    step_rad: float,
) -> ServoPoint:
    """Estimate the joint's angle at rest during a visit from the readings (n, 2) of both sensors."""
    # The angle is the mean of both sensors: take the samples in which both answered.
    both = valid.all(axis=1)
    if np.count_nonzero(both) < MIN_SAMPLES:
        raise _too_few(visit, valid, sensors.joint)
    by_each = sensors.each(shown_rad[both])
    angle = by_each.mean(axis=1)
    mean, covariance = mean_and_covariance(angle[:, None], BATCHES)
    # Batch means average the noise out, so that what is left between them is motion.
    batches = [float(part.mean()) for part in np.array_split(angle, BATCHES)]
    _check_rest(visit, float(np.ptp(batches)), by_each.mean(axis=0), sensors.joint)
    # Floor: a uniform error of one count in each of two sensors; time averages may not remove it.
    of_steps = step_rad / np.sqrt(12.0) / np.sqrt(2.0)
    std_rad = max(float(np.sqrt(covariance[0, 0])), float(of_steps))
    return ServoPoint(visit.pulse_us, visit.direction, float(mean[0]), std_rad)


def _check_rest(visit: Visit, motion_rad: float, by_each_rad: FloatArray, joint: int) -> None:
    again = NextStep("calibrate servo", ("--joint", str(joint)))
    if motion_rad > MAX_MOTION_RAD:
        raise CalibrationError(
            what=f"Joint {joint} did not come to rest at {visit.pulse_us:g} us: it moved by "
            f"{np.rad2deg(motion_rad):.1f} deg while it should stand still.",
            meaning="It was touched, or its servo hunts or has lost its power. The board keeps its servo settings.",
            next_step=Advice("Keep hands and cables off the joint, check the servos' battery, then: ", again),
        )
    first, second = np.rad2deg(by_each_rad)
    if abs(by_each_rad[0] - by_each_rad[1]) > MAX_DISAGREEMENT_RAD:
        raise CalibrationError(
            what=f"The two sensors of joint {joint} disagree: by their zero points they stand at {first:+.1f} and "
            f"{second:+.1f} deg.",
            meaning="One of them has slipped on the joint's axis since its zero was taken. "
            "The board keeps its servo settings.",
            next_step=Advice(
                "Fix both magnets, then ",
                NextStep("calibrate zero", ("--joint", str(joint))),
                ", then: ",
                again,
            ),
        )


def _too_few(visit: Visit, valid: NDArray[np.bool_], joint: int) -> CalibrationError:
    again = NextStep("calibrate servo", ("--joint", str(joint)))
    if len(valid) >= MIN_SAMPLES:
        silent = int(np.argmin(valid.mean(axis=0))) + 1
        return CalibrationError(
            what=f"Angle sensor {silent} of joint {joint} gave no value while the joint rested at "
            f"{visit.pulse_us:g} us.",
            meaning="Where the servo came to rest is not known. The board keeps its servo settings.",
            next_step=Advice("Check its cable with ", NextStep("monitor"), ", then: ", again),
        )
    return CalibrationError(
        what=f"Only {len(valid)} samples came while joint {joint} rested at {visit.pulse_us:g} us; "
        f"{MIN_SAMPLES} are needed.",
        meaning="Where the servo came to rest is not known well. The board keeps its servo settings.",
        next_step=Advice(
            "Let the logger sample at its usual rate (",
            NextStep("logger-settings"),
            " shows it), without a hub between, then: ",
            again,
        ),
    )


def shared_errors(sensors: JointSensors, reached_rad: FloatArray) -> FloatArray:
    """(n, 10) by how much each angle is off for one standard deviation of each independent error of the sensors."""
    # The joint's angle is the mean of both: a zero point enters by half, against the sensor's direction.
    half = -0.5 * sensors.direction
    of_zero = np.tile(half, (len(reached_rad), 1)) @ root_of(sensors.zero_covariance)
    sensor_angles_rad = sensors.zero_rad + np.outer(reached_rad, sensors.direction)
    # (n, 4) of each sensor: bend at the visit less bend at zero, which the zero point contains.
    curves = [
        half[k] * (harmonics(sensor_angles_rad[:, k]) - harmonics(sensors.zero_rad[k : k + 1]))
        for k in range(2)
    ]
    return np.concatenate(
        [of_zero, np.concatenate(curves, axis=1) @ root_of(sensors.bend_covariance)], axis=1
    )
