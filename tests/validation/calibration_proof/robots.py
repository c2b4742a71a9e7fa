"""Emulated robots that nobody has calibrated, a calibration of each, and how far it is from the truth."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from tests.calibration.emulated_day import CalibrationDay, calibration_day
from tfsat_host.angles import wrap_angle
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.acceptance import check_step
from tfsat_host.calibration.sensors.gyro import BIAS, MOUNTING, SCALE, SKEW, skews_of
from tfsat_host.calibration.sensors.joint_sensors import harmonics
from tfsat_host.calibration.solution import Solution, solve
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.emulated.imperfections import draw_as_built
from tfsat_host.emulated.manual_motion import Operator
from tfsat_host.rehearsal.faults.fault_catalog import fault_named
from tfsat_host.rehearsal.truth import Truth
from tfsat_host.robot import RobotModel, load_robot

QUANTITIES = ("bias", "misalignment", "scale", "skew", "zero")


@dataclass(frozen=True, eq=False)
class Errors:
    """Of one quantity of one robot.

    Attributes:
        error: (k,) estimate less truth: deg/s, deg, %, deg.
        std: (k,) as stated, in the same units.
    """

    error: FloatArray
    std: FloatArray

    @property
    def rms(self) -> float:
        """Root mean square of the errors."""
        return float(np.sqrt((self.error**2).mean()))


LEANING = "wrong-hinge-axes=0.5"
"""One standard deviation, as `joint_axis_deg` of the robot file."""


def design(seed: int) -> RobotModel:
    """Return the drop tower robot with each IMU in one of the 24 right-angled orientations, drawn.

    The robot's file states these orientations.
    """
    random = np.random.default_rng([seed, 24])
    # The octahedral group: rint removes the rounding of the 24 matrices, which are exact permutations with signs.
    turns = np.rint(Rotation.create_group("O").as_matrix())
    model = load_robot()
    imus = tuple(replace(imu, sensor_to_body=turns[random.integers(24)]) for imu in model.imus)
    return replace(model, imus=imus)


def recorded_day(seed: int) -> CalibrationDay:
    """Simulate all calibration steps on one robot, performed by a human with human errors.

    The robot's clocks are exact; the page lists what is not. Its hinges are exact too, and its file says so:
    a mounting is measured against them.
    """
    truth = replace(draw_as_built(seed), sequencer_clock_ppm=0.0, logger_clock_ppm=0.0)
    filed = design(seed)
    assert filed.uncertainty is not None
    # A stated hinge uncertainty would widen the misalignments' std, although these hinges are exact.
    exact = replace(filed, uncertainty=replace(filed.uncertainty, joint_axis_rad=0.0))
    return calibration_day(exact, truth, Operator.human(seed), seed)


def leaning_day(seed: int) -> CalibrationDay:
    """Simulate the same calibration day with hinges that lean as the robot's file says they may."""
    truth, filed = draw_as_built(seed), design(seed)
    built = fault_named(LEANING).apply(Truth(seed, filed, truth, np.zeros(3)))
    return replace(calibration_day(built.model, truth, Operator.human(seed), seed), model=filed)


def calibrate_day(day: CalibrationDay) -> Solution:
    """Solve the calibration as `tfsat-host calibrate` does.

    Each step is checked with what is known before it. Raises CalibrationError.
    """
    accepted: list[Evidence] = []
    for evidence in day.evidence:
        # In order, as on the bench: a step is judged with the evidence of the steps before it only.
        check_step(evidence, accepted, day.model)
        accepted.append(evidence)
    return solve(accepted, day.model)


def errors_of(day: CalibrationDay, solution: Solution) -> dict[str, Errors]:
    """Against the hidden truth, for each of QUANTITIES."""
    gyros = [_gyro_errors(day, solution, body) for body in range(len(solution.gyros))]
    zeros = [_zero_errors(day, solution, joint) for joint in range(len(solution.joints))]
    parts = {name: [gyro[name] for gyro in gyros] for name in QUANTITIES[:4]} | {"zero": zeros}
    return {
        name: Errors(
            np.concatenate([errors.error for errors in ones]), np.concatenate([errors.std for errors in ones])
        )
        for name, ones in parts.items()
    }


def _gyro_errors(day: CalibrationDay, solution: Solution, body: int) -> dict[str, Errors]:
    gyro, truth = solution.gyros[body], day.truth
    std = np.sqrt(np.diag(gyro.covariance))
    # Sensor to body as built: the misalignment on top of the orientation of the file.
    mounted = truth.mounting[body] @ day.model.imus[body].sensor_to_body
    # In the sensor's own axes, in which the covariance of the certificate stands.
    off = Rotation.from_matrix(mounted.T @ gyro.rotation).as_rotvec()
    bias = gyro.bias_rad_s - truth.gyro_bias_rad_s[body]
    return {
        "bias": Errors(np.rad2deg(bias), np.rad2deg(std[BIAS])),
        "misalignment": Errors(np.rad2deg(off), np.rad2deg(std[MOUNTING])),
        "scale": Errors(100 * (gyro.scale - truth.gyro_scale[body]), 100 * std[SCALE]),
        "skew": Errors(100 * (gyro.skew - skews_of(truth.gyro_cross_axis[body])), 100 * std[SKEW]),
    }


def _zero_errors(day: CalibrationDay, solution: Solution, joint: int) -> Errors:
    sensors, truth = solution.joints[joint], day.truth
    error = []
    for k, column in enumerate((2 * joint, 2 * joint + 1)):
        straight = day.model.angle_sensors[column].zero_offset_rad + truth.angle_zero_rad[column]
        # The angle sensor bends once and twice a turn; at the zero position this is part of its offset.
        true_zero_rad = straight + harmonics(np.array([straight]))[0] @ truth.angle_nonlinearity_rad[column]
        # Two angles on either side of ±180 deg are close: the difference is wrapped.
        error.append(float(wrap_angle(np.array([sensors.zero_rad[k] - true_zero_rad]))[0]))
    return Errors(np.rad2deg(error), np.rad2deg(np.sqrt(np.diag(sensors.zero_covariance))))
