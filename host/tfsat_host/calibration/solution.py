"""What recorded steps determine of a robot's sensors: each quantity from the newest recording of its step."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Protocol, TypeVar

import numpy as np

from tfsat_host.calibration.bias import estimate_biases, with_bias
from tfsat_host.calibration.misalignment import (
    check_misalignment,
    check_sense,
    check_turn_axis,
    with_misalignment,
)
from tfsat_host.calibration.response import (
    Response,
    axis_response,
    turn_response,
    with_length,
    without_length,
)
from tfsat_host.calibration.sensors.gyro import GyroCalibration, by_design
from tfsat_host.calibration.sensors.joint_sensors import JointSensors, sensors_by_design
from tfsat_host.calibration.servos.dynamics_fit import MeasuredDynamics, fit_dynamics
from tfsat_host.calibration.servos.servo_map import ServoMap
from tfsat_host.calibration.servos.visits import servo_map_of
from tfsat_host.calibration.steps.evidence import Evidence, newest
from tfsat_host.calibration.steps.step import StepKind
from tfsat_host.calibration.steps.step_motion import Motion
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
        by_time = sorted(evidence, key=lambda entry: entry.recorded_at)
        self._rests = [
            (entry, estimate_biases(entry.recording)) for entry in by_time if entry.step.kind == StepKind.REST
        ]
        zeros = [entry for entry in by_time if entry.step.kind == StepKind.ZERO]
        # A zero of all joints counts for each of them; every joint keeps its own history.
        self._zeros = [
            [
                (entry, estimate_zero(entry.recording, entry.counts.angle_valid, sensors, model))
                for entry in zeros
                if entry.step.joint in (None, sensors.joint)
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
        evidence, biases = rest
        return tuple(
            with_bias(gyro, bias, evidence.recorded_at) for gyro, bias in zip(gyros, biases, strict=True)
        )

    def joints(self, joints: Sequence[JointSensors], at: datetime | None = None) -> tuple[JointSensors, ...]:
        """Return the angle sensors with the zero points in force at `at`; the newest ones if it is None."""
        zeros = [_at(zeros, at) for zeros in self._zeros]
        return tuple(
            sensors if zero is None else with_zero(sensors, zero[1], zero[0].recorded_at)
            for sensors, zero in zip(joints, zeros, strict=True)
        )

    def evidence_in_force(self, at: Iterable[datetime]) -> list[Evidence]:
        """Return the evidence behind the newest values and those in force at these times."""
        evidence = [
            pair[0]
            for when in (None, *at)
            for pair in (_at(self._rests, when), *(_at(zeros, when) for zeros in self._zeros))
            if pair is not None
        ]
        # One rest may serve several motions: name it once.
        return list({entry.recorded_at: entry for entry in evidence}.values())


def _at(
    by_time: Sequence[tuple[Evidence, Estimate]], at: datetime | None
) -> tuple[Evidence, Estimate] | None:
    """Find the last estimate not after `at`, or the first if there is none; the newest if `at` is None."""
    before = [pair for pair in by_time if at is None or pair[0].recorded_at <= at]
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
        servos: Steps in which servos move, with the angle sensors as they were then.
        used_evidence: The evidence that it rests on, in order of time.
    """

    gyros: tuple[GyroCalibration, ...]
    joints: tuple[JointSensors, ...]
    servos: tuple[tuple[Evidence, tuple[JointSensors, ...]], ...]
    used_evidence: tuple[Evidence, ...]

    def servo_maps(self, model: RobotModel) -> tuple[ServoMap, ...]:
        """Fit the map of each measured servo, by joint. Raises CalibrationError: see `servo_map_of`."""
        servo_maps = (
            servo_map_of(evidence, joints, model)
            for evidence, joints in self.servos
            if evidence.step.kind == StepKind.SERVO
        )
        return tuple(sorted(servo_maps, key=lambda servo_map: servo_map.joint))

    def servo_dynamics(self, model: RobotModel) -> tuple[MeasuredDynamics, ...]:
        """Fit each measured servo's dynamics, by joint. Raises CalibrationError: see `fit_dynamics`."""
        fits = (
            fit
            for evidence, joints in self.servos
            if evidence.step.kind == StepKind.STROKES
            for fit in fit_dynamics(evidence, joints, model)
        )
        return tuple(sorted(fits, key=lambda fit: (fit.joint, -fit.direction)))


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
    entries = list(evidence)
    baseline = Baseline(entries, model)
    gyros = tuple(by_design(body, imu.sensor_to_body) for body, imu in enumerate(model.imus, 1))
    joints = tuple(sensors_by_design(model, joint) for joint in range(1, model.n_joints + 1))
    # Rests and zeros are the baseline; of the motions only the newest of each step counts.
    moving = [
        entry for entry in newest(entries).values() if entry.step.kind not in (StepKind.REST, StepKind.ZERO)
    ]
    # Servo steps determine nothing of the gyros; they are read afterwards with the sensors found here.
    by_servo = (StepKind.SERVO, StepKind.STROKES)
    by_hand = [entry for entry in moving if entry.step.kind not in by_servo]
    # Fixed-point iteration: each pass takes the held body's motion off by the mountings of the one before.
    for _ in range(_PASSES if by_hand else 0):
        responses = _Responses(last_landing)
        # Each motion with bias and zero of its own time, but with the latest mounting and bend.
        for entry in by_hand:
            responses.add(
                entry,
                baseline.gyros(gyros, entry.recorded_at),
                baseline.joints(joints, entry.recorded_at),
                model,
            )
        # After all turns are in: a turn's length is what separates a scale factor from a bend.
        joints = tuple(responses.bent(sensors, model) for sensors in joints)
        for gyro in gyros:
            # Check fresh responses only: before a landing the sensor may have sat otherwise.
            fresh = [response for response in responses.of_body(gyro.body) if response.fresh]
            check_misalignment(gyro.body, fresh, model)
        gyros = tuple(with_misalignment(gyro, responses.of_body(gyro.body), model) for gyro in gyros)
    used_evidence = [*moving, *baseline.evidence_in_force(entry.recorded_at for entry in moving)]
    return Solution(
        baseline.gyros(gyros),
        baseline.joints(joints),
        tuple(
            (entry, baseline.joints(joints, entry.recorded_at))
            for entry in moving
            if entry.step.kind in by_servo
        ),
        tuple(sorted(used_evidence, key=lambda entry: entry.recorded_at)),
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
        evidence: Evidence,
        gyros: Sequence[GyroCalibration],
        joints: Sequence[JointSensors],
        model: RobotModel,
    ) -> None:
        """Adds the responses of a swing or a turn; those of a sweep, `bent` adds."""
        if evidence.step.kind == StepKind.TURN:
            # A rigid turn is common to all gyros: one that shows another axis stands out.
            check_turn_axis(evidence.recording, evidence.step, gyros)
            for gyro in gyros:
                turned = turn_response(evidence.recording, evidence.step, gyro)
                self.of_body(gyro.body).append(self._with_date(turned, evidence))
            return
        motion = Motion(evidence.step, evidence.recording, gyros, joints, model)
        responses = [self._with_date(axis_response(motion, body), evidence) for body in evidence.step.moved]
        check_sense(evidence.step, responses, model)
        for body, response in zip(evidence.step.moved, responses, strict=True):
            if evidence.step.kind == StepKind.SWING:
                self.of_body(body).append(response)
            else:
                # Sweeps of a joint share its sensors' bend: their lengths are fitted together later.
                rests = rests_of_sweep(motion, body, response)
                self._sweeps.setdefault(evidence.step.moving_joint, []).append((response, rests))

    def _with_date(self, response: Response, evidence: Evidence) -> Response:
        fresh = self._last_landing is None or evidence.recorded_at > self._last_landing
        return replace(response, recorded_at=evidence.recorded_at, fresh=fresh)

    def bent(self, joint: JointSensors, model: RobotModel) -> JointSensors:
        """Adds the lengths of a joint's sweeps; gives its sensors with their bend."""
        sweeps = self._sweeps.get(joint.joint, ())
        if not sweeps:
            return joint
        sensors = [sensor for sensor in model.angle_sensors if sensor.joint == joint.joint - 1]
        tolerances = np.array([sensor.nonlinearity_rad for sensor in sensors])
        turns = [self._turn_about(response, rests.body) for response, rests in sweeps]
        # All sweeps of the joint at once, with the lengths by hand as prior.
        lengths, bend, covariance = fit_sweeps(
            joint.joint, [rests for _, rests in sweeps], tolerances, [_length(turn) for turn in turns]
        )
        for (response, rests), turn in zip(sweeps, turns, strict=True):
            responses = self.of_body(rests.body)
            if turn is not None:  # its length is in the fit now
                responses.remove(turn)
                responses.append(without_length(turn))
            responses.append(with_length(response, *lengths[rests.body]))
        recorded_at = min(response.recorded_at for response, _ in sweeps)
        return replace(joint, bend=bend, bend_covariance=covariance, bend_recorded_at=recorded_at)

    def _turn_about(self, response: Response, body: int) -> Response | None:
        """Find the body's response to a turn about the same axis."""
        turns = (candidate for candidate in self.of_body(body) if candidate.has_length)
        return next((turn for turn in turns if turn.axis_body @ response.axis_body > 0.99), None)


def _length(turn: Response | None) -> tuple[float, float] | None:
    """Length and its standard deviation."""
    if turn is None:
        return None
    # Project the covariance onto the response itself: the deviation of its length.
    along = turn.reading / turn.length
    return turn.length, float(np.sqrt(along @ turn.covariance @ along))
