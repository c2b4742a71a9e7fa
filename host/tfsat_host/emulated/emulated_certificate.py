"""The certificate that a careful day on the bench would have left of an emulated robot, without the day.

Every number is the truth, off by a draw from the uncertainty that the certificate states; and that is what a hundred
emulated robots were calibrated to (docs/calibration-proof.md). So a rehearsal of a drop takes seconds. The biases it
measures (`rehearsal/day.py`); to rehearse the whole calibration there is `tfsat-host calibrate --emulated`.
"""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.certificate.certificate import QUANTITY_NAMES, Calibration, Subject
from tfsat_host.calibration.sensors.gyro import (
    MOUNTING,
    PARAMETERS,
    SCALE,
    SKEW,
    GyroCalibration,
    by_design,
    skews_of,
)
from tfsat_host.calibration.sensors.joint_sensors import JointSensors, harmonics, sensors_by_design
from tfsat_host.calibration.servos.fit import fit_servo_map
from tfsat_host.calibration.servos.servo_map import ServoMap, ServoPoint, arrivals, board_pulse_us, servo_plan
from tfsat_host.emulated.imperfections import Imperfections
from tfsat_host.protocol.limits import IMU_COUNT, JOINT_COUNT
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.robot import PulseMap, RobotModel
from tfsat_host.servo_settings import FACTORY

TEMPERATURE_C = 25.0

_BIAS_STD_RAD_S = np.deg2rad(0.001)
_MOUNTING_STD_RAD = np.deg2rad(0.005)
_SCALE_STD = 4e-4
_SKEW_STD = 5e-4
_ZERO_STD_RAD = np.deg2rad(0.002)
_BEND_STD_RAD = np.deg2rad(0.02)
_NOISE_BANDWIDTH_HZ = 64.0
"""White noise that passes an IMU's low-pass; of 0.005 deg/s/sqrt(Hz) it leaves 0.04 deg/s in a sample."""
_RESOLUTION_STD_RAD_S = np.deg2rad(1.0 / 65.5) / 12.0**0.5
"""Of a MPU-6050's count at 500 deg/s full scale: no reading is quieter."""
_UP = np.array([0.0, 0.0, 1.0])
"""In every body, for all axes are parallel at the start pose."""
_ANGLE_NOISE_RAD = np.deg2rad(0.053)


def careful_certificate(
    model: RobotModel, truth: Imperfections, seed: int, measured: datetime
) -> Calibration:
    """Gyros, angle sensors and servos of a robot with these hidden errors.

    `seed` draws what the certificate is off by; `measured` is when the day would have been.
    """
    # The second number makes a stream of its own: what is drawn here shifts no other draw of the seed.
    random = np.random.default_rng([seed, 5])
    gyros = tuple(_gyro(model, truth, body, random, measured) for body in range(IMU_COUNT))
    joints = tuple(_sensors(model, truth, joint, random, measured) for joint in range(JOINT_COUNT))
    who_am_i = bytes(0 if model.imus[body].absent else part for body, part in enumerate(truth.imu_who_am_i))
    subject = Subject(model.name, truth.logger_serial.hex(), who_am_i.hex(), True)
    servos = careful_servo_maps(model, truth, seed, measured)
    return Calibration(
        subject,
        gyros,
        joints,
        servos,
        (),
        (),
        measured,
        simulated_quantities=tuple(QUANTITY_NAMES),
    )


def worse_certificate(calibration: Calibration, times: float, random: np.random.Generator) -> Calibration:
    """Return the calibration with errors added to the values of its gyros and angle sensors.

    The errors are drawn from the stated covariances, scaled by `times` standard deviations.
    """

    def off(covariance: FloatArray) -> FloatArray:
        # Draw jointly: errors are correlated as the certificate states.
        return np.asarray(times * random.multivariate_normal(np.zeros(len(covariance)), covariance))

    gyros = tuple(gyro.add_errors(off(gyro.covariance)) for gyro in calibration.gyros)
    joints = tuple(
        replace(
            sensors,
            zero_rad=sensors.zero_rad + off(sensors.zero_covariance),
            bend=sensors.bend + off(sensors.bend_covariance).reshape(sensors.bend.shape),
        )
        for sensors in calibration.joints
    )
    return replace(calibration, gyros=gyros, joints=joints)


def _gyro(
    model: RobotModel, truth: Imperfections, body: int, random: np.random.Generator, measured: datetime
) -> GyroCalibration:
    imu = model.imus[body]
    if imu.absent:
        return by_design(body + 1, imu.sensor_to_body, absent=True)
    # Order of the gyro's parameters: bias, mounting, scale, skew, three of each.
    std = np.repeat([_BIAS_STD_RAD_S, _MOUNTING_STD_RAD, _SCALE_STD, _SKEW_STD], 3)
    off = std * random.standard_normal(PARAMETERS)
    placed = truth.mounting[body] @ imu.sensor_to_body
    # What the chip shows of a rate in its axes: its symmetric part is what calibration calls response, the rest turns.
    left, gains, right = np.linalg.svd(truth.gyro_response[body])
    mounted, response = placed @ (left @ right).T, (left * gains) @ left.T
    return GyroCalibration(
        body=body + 1,
        bias_rad_s=_bias_on_the_bench(truth, body, placed) + off[:3],
        # A small rotation on the right: the calibration's error is in sensor axes.
        rotation=mounted @ Rotation.from_rotvec(off[MOUNTING]).as_matrix(),
        scale=np.diag(response) + off[SCALE],
        skew=skews_of(response) + off[SKEW],
        covariance=np.diag(std**2),
        noise_rad_s=np.full(
            # Density times the root of the bandwidth, but no less than the quantization noise q / sqrt(12).
            3,
            max(truth.gyro_noise_rad_s_rthz * np.sqrt(_NOISE_BANDWIDTH_HZ), _RESOLUTION_STD_RAD_S),
        ),
        temperature_c=TEMPERATURE_C,
        axes={"x": measured, "y": measured},
        scaled={"x": measured, "y": measured, "z": measured},
        bias_recorded_at=measured,
    )


def _bias_on_the_bench(truth: Imperfections, body: int, mounted: FloatArray) -> FloatArray:
    """(3,) what a gyro shows of a robot that stands still and cold: what gravity makes it show is in it."""
    return np.asarray(
        # At rest the specific force is 1 g upwards: turn it into sensor axes, where the sensitivity holds.
        truth.gyro_bias_rad_s[body] + truth.gyro_g_sensitivity_rad_s_g[body] @ (mounted.T @ _UP)
    )


def _sensors(
    model: RobotModel, truth: Imperfections, joint: int, random: np.random.Generator, measured: datetime
) -> JointSensors:
    columns = [i for i, sensor in enumerate(model.angle_sensors) if sensor.joint == joint]
    if model.angle_sensors[columns[0]].absent:
        return sensors_by_design(model, joint + 1)
    straight = np.array([model.angle_sensors[c].zero_offset_rad + truth.angle_zero_rad[c] for c in columns])
    bend = truth.angle_nonlinearity_rad[columns]
    # (2, 4) harmonics by (2, 4) coefficients, summed per sensor: the bend at joint angle zero.
    zero_reading_rad = straight + np.einsum("ij,ij->i", harmonics(straight), bend)
    return JointSensors(
        joint=joint + 1,
        direction=np.array([float(model.angle_sensors[c].direction) for c in columns]),
        # A sensor reads within one turn.
        zero_rad=np.mod(zero_reading_rad + _ZERO_STD_RAD * random.standard_normal(2), 2.0 * np.pi),
        zero_covariance=_ZERO_STD_RAD**2 * np.eye(2),
        bend=bend + _BEND_STD_RAD * random.standard_normal((2, 4)),
        bend_covariance=_BEND_STD_RAD**2 * np.eye(8),
        noise_rad=np.full(2, _ANGLE_NOISE_RAD),
        zero_recorded_at=measured,
        bend_recorded_at=measured,
    )


_REST_STD_RAD = np.deg2rad(0.01)
"""Of a rest's mean by both angle sensors."""


def careful_servo_maps(
    model: RobotModel, truth: Imperfections, seed: int, measured: datetime
) -> tuple[ServoMap, ...]:
    """Fit the maps that `calibrate servo` would find, from visits simulated with the servos' true errors.

    The board is taken to hold the factory settings, as in a rehearsal, so a servo's error is its true error.
    The ends of a joint's range are left out, because the joint lies against its stops there.

    `seed` draws the servos' scatter and the sensors' noise; `measured` is when the day would have been.
    """
    return tuple(
        fit_servo_map(
            _visits(servo.pulses, truth, index, np.random.default_rng([seed, 7, index])),
            index + 1,
            FACTORY.of(index + 1),
            measured,
        )
        for index, servo in enumerate(model.servos[:JOINT_COUNT])
        if servo.pulses is not None and not servo.absent
    )


def _visits(
    pulses: PulseMap, truth: Imperfections, index: int, random: np.random.Generator
) -> list[ServoPoint]:
    setting: ServoSetting = FACTORY.of(index + 1)
    plan = servo_plan(setting)
    scatter = truth.servo_repeat_rad[index] * random.standard_normal(len(plan))
    noise = _REST_STD_RAD * random.standard_normal(len(plan))
    points = []
    for number, (angle_cdeg, direction) in enumerate(zip(plan, arrivals(plan), strict=True)):
        # At the ends the joint lies against its stops; before it moves the side of the play is unknown.
        if direction and setting.min_cdeg < angle_cdeg < setting.max_cdeg:
            pulse_us = board_pulse_us(setting, angle_cdeg)
            # Invert the robot file's linear map: the angle that an exact servo takes for this pulse.
            nominal = (
                pulses.reference_angle_rad + (pulse_us - pulses.reference_pulse_us) / pulses.pulse_us_per_rad
            )
            centred = truth.servo_offset_rad[index] + truth.servo_gain[index] * nominal
            # Play leaves the joint half of it short of its target, on the side where it came from.
            reached = centred - direction * truth.servo_backlash_rad[index] / 2.0
            points.append(
                ServoPoint(pulse_us, direction, reached + scatter[number] + noise[number], _REST_STD_RAD)
            )
    return points
