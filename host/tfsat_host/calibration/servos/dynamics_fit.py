"""Speed, acceleration and delay of a servo each way, fitted to the strokes of a recorded run.

A stroke begins a delay after the stroke line rises, speeds up at its greatest acceleration to its greatest rate and
slows down likewise: the profile of `dynamics/history.py`. All strokes of a joint in one direction share these three.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import NamedTuple

import numpy as np
from scipy.optimize import OptimizeResult, least_squares

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.sensors.joint_sensors import JointSensors, sensor_columns
from tfsat_host.calibration.servos.servo_map import ServoMap
from tfsat_host.calibration.servos.visits import shared_errors
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.dynamics.history import ServoMotion, history_of
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.quantity import number
from tfsat_host.robot import RobotModel
from tfsat_host.robot.model import Servo, ServoDynamics

LEAD_S = 0.1
"""A joint rests so long before its stroke: the angle that it starts from."""
REST_SAMPLES = 8
"""Averaged for a first guess of where a stroke begins and ends: 29 ms at 280 Hz."""
MIN_CRUISE_S = 0.03
"""At the greatest rate; a shorter stroke does not tell it."""
MIN_SHARE = 0.5
"""Of the commanded angle; a joint that went less did not make its stroke."""
MAX_RESIDUAL_RAD = np.deg2rad(0.5)
"""Between the joint and the servo's profile, rms."""
PULSE_STD_S = 0.3e-3
"""A servo reads a pulse at its end, 1 to 2 ms after the line rises: what that varies by with the commanded angle."""
_GUESSED_DELAY_S = 0.005
_MARGIN_S = 0.01
_NOT_KEPT = "Its strokes were not kept."


@dataclass(frozen=True, eq=False, kw_only=True)
class MeasuredDynamics(ServoDynamics):
    """How fast a servo moves its joint one way, as measured.

    Attributes:
        joint: 1 to 3.
        direction: +1 towards larger angles, -1 towards smaller ones.
        strokes: How many were fitted.
        residual_rad: Of the joint's angle about the profile, rms.
        recorded_at: When.
    """

    covariance: FloatArray
    joint: int
    direction: int
    strokes: int
    residual_rad: float
    recorded_at: datetime

    @property
    def std(self) -> FloatArray:
        """(3,) standard deviations of rate, acceleration and delay, SI."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))


def with_servos(
    robot: RobotModel, fits: Iterable[MeasuredDynamics], servo_maps: Iterable[ServoMap] = ()
) -> RobotModel:
    """Return the robot with its servos as measured, on a sequencer that has the settings of the maps."""
    servos = list(robot.servos)
    for servo_map in servo_maps:
        servos[servo_map.joint - 1] = replace(
            servos[servo_map.joint - 1],
            play_rad=max(0.0, servo_map.backlash_rad),
            stop_std_rad=servo_map.stop_std_rad,
        )
    for fit in fits:
        servo = servos[fit.joint - 1]
        closing, opening = servo.measured
        measured = (closing, fit) if fit.direction > 0 else (fit, opening)
        servos[fit.joint - 1] = replace(servo, measured=measured)
    return replace(robot, servos=tuple(servos))


class _Travel(NamedTuple):
    """One stroke: (n,) times after the stroke line's rise, (n,) joint angles, and the commanded change."""

    t_s: FloatArray
    angle_rad: FloatArray
    commanded_rad: float


def fit_dynamics(
    evidence: Evidence, joints: Sequence[JointSensors], model: RobotModel
) -> tuple[MeasuredDynamics, ...]:
    """Fit the dynamics of a servo in each direction in which its joint made a stroke.

    Args:
        evidence: A step of strokes.
        joints: Sensors of joints 1 to 3, as calibrated.
        model: For the sensors' places in the log, and a first guess of the dynamics.

    Raises:
        CalibrationError: the joint did not move, never reached its greatest rate, or did not move as a servo does.
    """
    joint = evidence.step.moving_joint
    sensors, columns = joints[joint - 1], sensor_columns(model, joint)
    both = evidence.counts.angle_valid[:, columns].all(axis=1)
    readings_rad = evidence.recording.sensor_angle_rad[both][:, columns]
    angle = sensors.from_start(np.unwrap(sensors.each(readings_rad), axis=0)).mean(axis=1)
    t_s = evidence.recording.t_s[both]
    lines_s = [1e-6 * stroke.line_us for stroke in evidence.strokes]
    travels = []
    # Each stroke has the samples from a rest before it to the same joint's next stroke.
    for stroke, line_s, until_s in zip(evidence.strokes, lines_s, [*lines_s[1:], np.inf], strict=True):
        own = (t_s >= line_s - LEAD_S) & (t_s < until_s)
        travels.append(_Travel(t_s[own] - line_s, angle[own], float(np.deg2rad(0.01 * stroke.angle_cdeg))))
    return tuple(
        _fit_direction(direction, chosen, evidence, sensors, model.servos[joint - 1])
        for direction in (1, -1)
        if (chosen := [travel for travel in travels if direction * travel.commanded_rad > 0.0])
    )


def _fit_direction(
    direction: int, travels: Sequence[_Travel], evidence: Evidence, sensors: JointSensors, servo: Servo
) -> MeasuredDynamics:
    """Fit the strokes of one direction. Raises CalibrationError as `fit_dynamics`."""
    guess = [servo.max_rate_rad_s, servo.acceleration_rad_s2, _GUESSED_DELAY_S]
    for travel in travels:
        begin = float(travel.angle_rad[:REST_SAMPLES].mean())
        size = float(travel.angle_rad[-REST_SAMPLES:].mean()) - begin
        if size / travel.commanded_rad < MIN_SHARE:
            got, commanded_deg = np.rad2deg([size, travel.commanded_rad])
            raise _refusal(
                f"Joint {sensors.joint} went {number(got, '+.1f')} deg instead of {commanded_deg:+g} deg.",
                "Its servo has no power, is blocked, or another maneuver was flown.",
            )
        guess += [begin, size]
    everything = np.concatenate([travel.angle_rad for travel in travels])
    # Only speed and acceleration are bounded: far from zero, where a servo would not move.
    lower = np.append(0.01 * np.array(guess[:2]), np.full(len(guess) - 2, -np.inf))

    def solve(start: FloatArray, used: BoolArray) -> OptimizeResult:
        def residuals(x: FloatArray) -> FloatArray:
            modelled = [
                _angles_rad(travel.t_s, _motion(x, k), x[2 * k + 3]) for k, travel in enumerate(travels)
            ]
            return np.asarray((np.concatenate(modelled) - everything)[used])

        return least_squares(residuals, start, bounds=(lower, np.inf), x_scale="jac")

    # First all samples, then without the braking: a servo may overshoot there, which is no part of its profile.
    coarse = solve(np.array(guess), np.full(len(everything), True)).x
    used = np.concatenate([~_is_braking(travel.t_s, _motion(coarse, k)) for k, travel in enumerate(travels)])
    fit = solve(coarse, used)
    x = fit.x
    residual = float(np.sqrt((fit.fun**2).mean()))
    if residual > MAX_RESIDUAL_RAD:
        raise _refusal(
            f"Joint {sensors.joint} is {np.rad2deg(residual):.1f} deg rms off the motion of a servo.",
            "It was touched, turned back before it arrived, or its servo hunts or lacks power.",
        )
    if np.abs(x[4::2]).max() / x[0] - x[0] / x[1] < MIN_CRUISE_S:
        raise _refusal(
            f"Joint {sensors.joint} was not at its servo's greatest rate for {1e3 * MIN_CRUISE_S:g} ms.",
            "Its strokes are too short: speed and acceleration cannot be told apart.",
        )
    # Noise by the scatter; errors that all samples share, of zero point and nonlinearity, pass through the fit.
    gain = np.linalg.pinv(fit.jac)
    by_shared = gain @ shared_errors(sensors, everything[used])
    variance = (fit.fun**2).sum() / (len(fit.fun) - len(x))
    covariance = (variance * gain @ gain.T + by_shared @ by_shared.T)[:3, :3]
    covariance[2, 2] += PULSE_STD_S**2
    return MeasuredDynamics(
        **dict(zip(("max_rate_rad_s", "acceleration_rad_s2", "delay_s"), x[:3].tolist(), strict=True)),
        covariance=covariance,
        joint=sensors.joint,
        direction=direction,
        strokes=len(travels),
        residual_rad=residual,
        recorded_at=evidence.recorded_at,
    )


def _motion(x: FloatArray, k: int) -> ServoMotion:
    """Return stroke k of parameters x: rate, acceleration, delay, then start angle and size of each stroke."""
    return ServoMotion.of([0], x[2 * k + 4, None], x[2, None], np.zeros(1), x[0, None], x[1, None])


def _angles_rad(t_s: FloatArray, motion: ServoMotion, start_rad: float) -> FloatArray:
    """(n,) angles at the times (n,) of a motion from `start_rad`."""
    breaks_s = np.unique(np.concatenate([t_s[[0, -1]], motion.changes_s]))
    return history_of(motion, breaks_s, np.array([start_rad])).angles_rad(t_s)[:, 0]


def _is_braking(t_s: FloatArray, motion: ServoMotion) -> BoolArray:
    """(n,) whether the joint slows down, or may swing back from beyond its end for as long again."""
    ramp_s = motion.ramp_s[0] + _MARGIN_S
    return np.asarray(np.abs(t_s - motion.end_s[0]) < ramp_s)


def _refusal(what: str, meaning: str) -> CalibrationError:
    return CalibrationError(
        what=what,
        meaning=f"{meaning} {_NOT_KEPT}",
        next_step=Advice(
            "Run a maneuver with strokes of 60 deg or more, joints free to move, then: ",
            NextStep("calibrate servo", ("--log", "SD.bin")),
        ),
    )
