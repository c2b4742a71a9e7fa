"""What recorded steps determine of a robot's sensors: each quantity from the newest recording of its step."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Protocol

import numpy as np

from tfsat_host.calibration.baseline import Baseline
from tfsat_host.calibration.misalignment import with_misalignment
from tfsat_host.calibration.mounting_checks import check_misalignment, check_sense, check_turn_axis
from tfsat_host.calibration.replacements import NEVER_REPLACED, Specimens
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
from tfsat_host.robot import RobotModel
from tfsat_host.robot.absent_parts import ignore_absent

_PASSES = 3
"""The held body's motion is taken off with what its own gyro is known to do: each pass knows that better."""


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


def solve(
    evidence: Iterable[Evidence],
    model: RobotModel,
    last_landing: datetime | None = None,
    specimens: Specimens = NEVER_REPLACED,
) -> Solution:
    """Calibrates everything that the newest recording of each step allows.

    Each motion is read with the biases and zero points that were in force when it was recorded, and with the sensors
    that were in place: each specimen is a sensor of its own, and only those in place now are in the solution.

    Args:
        evidence: Recordings that were accepted, in any order.
        model: Whose axes, designs and tolerances hold.
        last_landing: What was recorded before it makes directions less certain.
        specimens: Which specimen of each part was in place when.

    Raises:
        CalibrationError: what the recordings say cannot all be true.
    """
    entries = [_without_absent(entry, model) for entry in evidence]
    baseline = Baseline(entries, model, specimens)
    sensors = _AllSensors.by_design(model, specimens)
    # Rests and zeros are the baseline; of the motions only the newest of each step counts.
    by_servo = (StepKind.SERVO, StepKind.STROKES)
    moving = [
        entry
        for entry in newest(entries).values()
        if entry.step.kind not in (StepKind.REST, StepKind.ZERO)
        and not (entry.step.kind in by_servo and _of_former_servo(entry, specimens))
        and not (entry.step.joint and model.servos[entry.step.joint - 1].absent)
    ]
    # Servo steps determine nothing of the gyros; they are read afterwards with the sensors found here.
    by_hand = [entry for entry in moving if entry.step.kind not in by_servo]
    # Fixed-point iteration: each pass takes the held body's motion off by the mountings of the one before.
    for _ in range(_PASSES if by_hand else 0):
        responses = _Responses(last_landing, specimens)
        # Each motion with bias and zero of its own time, but with the latest mounting and bend.
        for entry in by_hand:
            at = entry.recorded_at
            responses.add(
                entry, baseline.gyros(sensors.gyros(at), at), baseline.joints(sensors.joints(at), at), model
            )
        # After all turns are in: a turn's length is what separates a scale factor from a bend.
        joints = [
            [responses.bent(entry, number, model) for number, entry in enumerate(row)]
            for row in sensors.joint_rows
        ]
        for row in sensors.gyro_rows:
            for number, gyro in enumerate(row):
                # Check fresh responses only: before a landing the sensor may have sat otherwise.
                fresh = [response for response in responses.of_gyro(gyro.body, number) if response.fresh]
                check_misalignment(gyro.body, fresh, model)
        gyros = [
            [
                with_misalignment(gyro, responses.of_gyro(gyro.body, number), model)
                for number, gyro in enumerate(row)
            ]
            for row in sensors.gyro_rows
        ]
        sensors = replace(sensors, gyro_rows=gyros, joint_rows=joints)
    used_evidence = [*moving, *baseline.evidence_in_force(entry.recorded_at for entry in moving)]
    return Solution(
        baseline.gyros(sensors.gyros()),
        baseline.joints(sensors.joints()),
        tuple(
            (entry, baseline.joints(sensors.joints(entry.recorded_at), entry.recorded_at))
            for entry in moving
            if entry.step.kind in by_servo
        ),
        tuple(sorted(used_evidence, key=lambda entry: entry.recorded_at)),
    )


def _without_absent(entry: Evidence, model: RobotModel) -> Evidence:
    """Return a step as if what is absent now had been absent when it was recorded."""
    counts = ignore_absent(entry.counts, model)
    return entry if counts is entry.counts else replace(entry, counts=counts)


def _of_former_servo(entry: Evidence, specimens: Specimens) -> bool:
    """Return whether a servo's step was made with a servo, or a sequencer, that has been replaced since."""
    joint = entry.step.moving_joint
    return specimens.servo(joint, entry.recorded_at) != specimens.servo(joint)


@dataclass(frozen=True, slots=True)
class _AllSensors:
    """All specimens of all gyros and angle sensors, a row for each body and joint.

    Attributes:
        gyro_rows: Of bodies 1 to 4, each specimen in order of time.
        joint_rows: Of joints 1 to 3.
        specimens: Which was in place when.
    """

    gyro_rows: Sequence[Sequence[GyroCalibration]]
    joint_rows: Sequence[Sequence[JointSensors]]
    specimens: Specimens

    @classmethod
    def by_design(cls, model: RobotModel, specimens: Specimens) -> _AllSensors:
        """Begin with what design and data sheets say."""
        return cls(
            [
                [by_design(body, imu.sensor_to_body, absent=imu.absent)] * (specimens.gyro(body) + 1)
                for body, imu in enumerate(model.imus, 1)
            ],
            [
                [sensors_by_design(model, joint)] * (specimens.angle(joint) + 1)
                for joint in range(1, model.n_joints + 1)
            ],
            specimens,
        )

    def gyros(self, at: datetime | None = None) -> tuple[GyroCalibration, ...]:
        """Return those in place at a time; None: now."""
        return tuple(row[self.specimens.gyro(body, at)] for body, row in enumerate(self.gyro_rows, 1))

    def joints(self, at: datetime | None = None) -> tuple[JointSensors, ...]:
        """Return those in place at a time; None: now."""
        return tuple(row[self.specimens.angle(joint, at)] for joint, row in enumerate(self.joint_rows, 1))


class _Responses:
    """How the gyros answered to all motions, by what was known of them in the pass before."""

    def __init__(self, last_landing: datetime | None, specimens: Specimens) -> None:
        self._last_landing = last_landing
        self._specimens = specimens
        self._found: dict[tuple[int, int], list[Response]] = {}
        self._sweeps: dict[tuple[int, int], list[tuple[Response, Rests]]] = {}

    def of_gyro(self, body: int, specimen: int) -> list[Response]:
        """Return the responses of a specimen of the gyro of a body (1 to 4)."""
        return self._found.setdefault((body, specimen), [])

    def _of_body(self, body: int, at: datetime | None) -> list[Response]:
        """Return the responses of the gyro that was in place at a time."""
        return self.of_gyro(body, self._specimens.gyro(body, at))

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
            turning = [gyro for gyro in gyros if gyro.body in evidence.bodies_sensed]
            check_turn_axis(evidence.recording, evidence.step, turning)
            for gyro in turning:
                turned = turn_response(evidence.recording, evidence.step, gyro)
                self._of_body(gyro.body, evidence.recorded_at).append(self._with_date(turned, evidence))
            return
        motion = Motion(evidence.step, evidence.recording, gyros, joints, model)
        moved = [body for body in evidence.step.moved if body in evidence.bodies_sensed]
        responses = [self._with_date(axis_response(motion, body), evidence) for body in moved]
        check_sense(evidence.step, responses, model)
        for body, response in zip(moved, responses, strict=True):
            if evidence.step.kind == StepKind.SWING:
                self._of_body(body, evidence.recorded_at).append(response)
            else:
                # Sweeps of a joint share its sensors' bend: their lengths are fitted together later.
                rests = rests_of_sweep(motion, body, response)
                joint = evidence.step.moving_joint
                specimen = self._specimens.angle(joint, evidence.recorded_at)
                self._sweeps.setdefault((joint, specimen), []).append((response, rests))

    def _with_date(self, response: Response, evidence: Evidence) -> Response:
        fresh = self._last_landing is None or evidence.recorded_at > self._last_landing
        return replace(response, recorded_at=evidence.recorded_at, fresh=fresh)

    def bent(self, joint: JointSensors, specimen: int, model: RobotModel) -> JointSensors:
        """Adds the lengths of a joint's sweeps with these sensors; gives them with their bend."""
        sweeps = self._sweeps.get((joint.joint, specimen), ())
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
            responses = self._of_body(rests.body, response.recorded_at)
            if turn is not None:  # its length is in the fit now
                responses.remove(turn)
                responses.append(without_length(turn))
            responses.append(with_length(response, *lengths[rests.body]))
        recorded_at = min(response.recorded_at for response, _ in sweeps)
        return replace(joint, bend=bend, bend_covariance=covariance, bend_recorded_at=recorded_at)

    def _turn_about(self, response: Response, body: int) -> Response | None:
        """Find the body's response to a turn about the same axis."""
        of_gyro = self._of_body(body, response.recorded_at)
        turns = (candidate for candidate in of_gyro if candidate.has_length)
        return next((turn for turn in turns if turn.axis_body @ response.axis_body > 0.99), None)


def _length(turn: Response | None) -> tuple[float, float] | None:
    """Length and its standard deviation."""
    if turn is None:
        return None
    # Project the covariance onto the response itself: the deviation of its length.
    along = turn.reading / turn.length
    return turn.length, float(np.sqrt(along @ turn.covariance @ along))
