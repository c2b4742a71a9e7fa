"""What recorded steps determine of a robot's sensors: each quantity from the newest recording of its step."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Protocol, TypeVar

import numpy as np

from tfsat_host.calibration.bias import estimate_biases, with_bias
from tfsat_host.calibration.mounting import check_mounting, check_sense, check_turn_axis, with_mounting
from tfsat_host.calibration.response import (
    Response,
    axis_response,
    turn_response,
    with_length,
    without_length,
)
from tfsat_host.calibration.sensors.gyro import GyroCalibration, by_design
from tfsat_host.calibration.sensors.joint_sensors import JointSensors, sensors_by_design
from tfsat_host.calibration.steps.evidence import Evidence, newest
from tfsat_host.calibration.steps.motion import Motion
from tfsat_host.calibration.steps.step import StepKind
from tfsat_host.calibration.sweep_fit import Rests, fit_sweeps, rests_of_sweep
from tfsat_host.calibration.zero import estimate_zero, with_zero
from tfsat_host.robot import RobotModel

_PASSES = 3
"""The held body's motion is taken off with what its own gyro is known to do: each pass knows that better."""
Estimate = TypeVar("Estimate")


class Baseline:
    """The biases and zero points of some evidence: for a motion count those that were the newest when it was recorded.

    A sensor that is fastened at another angle, or that warms up, does not change what an earlier recording says.

    Args:
        evidence: In any order.
        model: For the sensors' places in the log.

    Raises:
        CalibrationError: one of the rests or zeros is not what it should be.
    """

    def __init__(self, evidence: Iterable[Evidence], model: RobotModel) -> None:
        by_time = sorted(evidence, key=lambda one: one.taken)
        self._rests = [
            (one, estimate_biases(one.recording)) for one in by_time if one.step.kind == StepKind.REST
        ]
        zeros = [one for one in by_time if one.step.kind == StepKind.ZERO]
        self._zeros = [
            [
                (one, estimate_zero(one.recording, one.counts.angle_valid, sensors, model))
                for one in zeros
                if one.step.joint in (None, sensors.joint)
            ]
            for sensors in (sensors_by_design(model, joint) for joint in range(1, model.n_joints + 1))
        ]

    def gyros(
        self, gyros: Sequence[GyroCalibration], at: datetime | None = None
    ) -> tuple[GyroCalibration, ...]:
        """Return the gyros with the biases in force at `at`; the newest ones if it is None."""
        rest = _at(self._rests, at)
        if rest is None:
            return tuple(gyros)
        one, biases = rest
        return tuple(with_bias(gyro, bias, one.taken) for gyro, bias in zip(gyros, biases, strict=True))

    def joints(self, joints: Sequence[JointSensors], at: datetime | None = None) -> tuple[JointSensors, ...]:
        """Return the angle sensors with the zero points in force at `at`; the newest ones if it is None."""
        zeros = [_at(zeros, at) for zeros in self._zeros]
        return tuple(
            sensors if zero is None else with_zero(sensors, zero[1], zero[0].taken)
            for sensors, zero in zip(joints, zeros, strict=True)
        )

    def used(self, at: Iterable[datetime]) -> list[Evidence]:
        """Return the evidence behind the newest values and those in force at these times."""
        found = [
            one[0]
            for when in (None, *at)
            for one in (_at(self._rests, when), *(_at(zeros, when) for zeros in self._zeros))
            if one is not None
        ]
        return list({one.taken: one for one in found}.values())


def _at(
    by_time: Sequence[tuple[Evidence, Estimate]], at: datetime | None
) -> tuple[Evidence, Estimate] | None:
    """Find the last estimate not after `at`, or the first if there is none; the newest if `at` is None."""
    before = [one for one in by_time if at is None or one[0].taken <= at]
    return before[-1] if before else by_time[0] if by_time else None


class SensorKnowledge(Protocol):
    """What is known of the sensors: a solution, or a certificate."""

    @property
    def gyros(self) -> tuple[GyroCalibration, ...]:
        """Of bodies 1 to 4."""

    @property
    def joints(self) -> tuple[JointSensors, ...]:
        """Sensors of joints 1 to 3."""


@dataclass(frozen=True, eq=False)
class Solution:
    """What the evidence determines.

    Attributes:
        gyros: Of bodies 1 to 4.
        joints: Sensors of joints 1 to 3.
        servos: Servo steps with the angle sensors as they were then.
        used: The evidence that it rests on, in order of time.
    """

    gyros: tuple[GyroCalibration, ...]
    joints: tuple[JointSensors, ...]
    servos: tuple[tuple[Evidence, tuple[JointSensors, ...]], ...]
    used: tuple[Evidence, ...]


def solve(evidence: Iterable[Evidence], model: RobotModel, last_landing: datetime | None = None) -> Solution:
    """Calibrates everything that the newest recording of each step allows.

    Each motion is read with the biases and zero points that were in force when it was recorded.

    Args:
        evidence: Recordings that were accepted, in any order.
        model: Whose axes, designs and tolerances hold.
        last_landing: What was recorded before it makes directions less certain.

    Raises:
        CalibrationError: what the recordings say cannot all be true.
    """
    given = list(evidence)
    baseline = Baseline(given, model)
    gyros = tuple(by_design(body, imu.sensor_to_body) for body, imu in enumerate(model.imus, 1))
    joints = tuple(sensors_by_design(model, joint) for joint in range(1, model.n_joints + 1))
    moving = [one for one in newest(given).values() if one.step.kind not in (StepKind.REST, StepKind.ZERO)]
    by_hand = [one for one in moving if one.step.kind != StepKind.SERVO]
    for _ in range(_PASSES if by_hand else 0):
        responses = _Responses(last_landing)
        for one in by_hand:
            responses.add(one, baseline.gyros(gyros, one.taken), baseline.joints(joints, one.taken), model)
        joints = tuple(responses.bent(sensors, model) for sensors in joints)
        for gyro in gyros:
            fresh = [response for response in responses.of_body(gyro.body) if response.fresh]
            check_mounting(gyro.body, fresh, model)
        gyros = tuple(with_mounting(gyro, responses.of_body(gyro.body), model) for gyro in gyros)
    used = [*moving, *baseline.used(one.taken for one in moving)]
    return Solution(
        baseline.gyros(gyros),
        baseline.joints(joints),
        tuple((one, baseline.joints(joints, one.taken)) for one in moving if one.step.kind == StepKind.SERVO),
        tuple(sorted(used, key=lambda one: one.taken)),
    )


class _Responses:
    """How the gyros answered to all motions, by what was known of them in the pass before."""

    def __init__(self, last_landing: datetime | None) -> None:
        self._last_landing = last_landing
        self._found: dict[int, list[Response]] = {}
        self._sweeps: dict[int, list[tuple[Response, Rests]]] = {}

    def of_body(self, body: int) -> list[Response]:
        """Return the responses of the gyro of a body (1 to 4)."""
        return self._found.setdefault(body, [])

    def add(
        self,
        one: Evidence,
        gyros: Sequence[GyroCalibration],
        joints: Sequence[JointSensors],
        model: RobotModel,
    ) -> None:
        """Adds the responses of a swing or a turn; those of a sweep, `bent` adds."""
        if one.step.kind == StepKind.TURN:
            check_turn_axis(one.recording, one.step, gyros)
            for gyro in gyros:
                turned = turn_response(one.recording, one.step, gyro)
                self.of_body(gyro.body).append(self._with_date(turned, one))
            return
        motion = Motion(one.step, one.recording, gyros, joints, model)
        found = [self._with_date(axis_response(motion, body), one) for body in one.step.moved]
        check_sense(one.step, found, model)
        for body, response in zip(one.step.moved, found, strict=True):
            if one.step.kind == StepKind.SWING:
                self.of_body(body).append(response)
            else:
                rests = rests_of_sweep(motion, body, response)
                self._sweeps.setdefault(one.step.moving_joint, []).append((response, rests))

    def _with_date(self, response: Response, one: Evidence) -> Response:
        fresh = self._last_landing is None or one.taken > self._last_landing
        return replace(response, taken=one.taken, fresh=fresh)

    def bent(self, joint: JointSensors, model: RobotModel) -> JointSensors:
        """Adds the lengths of a joint's sweeps; gives its sensors with their bend."""
        sweeps = self._sweeps.get(joint.joint, ())
        if not sweeps:
            return joint
        sensors = [sensor for sensor in model.angle_sensors if sensor.joint == joint.joint - 1]
        tolerances = np.array([sensor.nonlinearity_rad for sensor in sensors])
        turns = [self._turn_about(response, rests.body) for response, rests in sweeps]
        lengths, bend, covariance = fit_sweeps(
            joint.joint, [rests for _, rests in sweeps], tolerances, [_length(turn) for turn in turns]
        )
        for (response, rests), turn in zip(sweeps, turns, strict=True):
            found = self.of_body(rests.body)
            if turn is not None:  # its length is in the fit now
                found.remove(turn)
                found.append(without_length(turn))
            found.append(with_length(response, *lengths[rests.body]))
        taken = min(response.taken for response, _ in sweeps)
        return replace(joint, bend=bend, bend_covariance=covariance, bend_taken=taken)

    def _turn_about(self, response: Response, body: int) -> Response | None:
        """Find the body's response to a turn about the same axis."""
        found = (one for one in self.of_body(body) if one.has_length)
        return next((one for one in found if one.axis_body @ response.axis_body > 0.99), None)


def _length(turn: Response | None) -> tuple[float, float] | None:
    """Length and its standard deviation."""
    if turn is None:
        return None
    along = turn.reading / turn.length
    return turn.length, float(np.sqrt(along @ turn.covariance @ along))
