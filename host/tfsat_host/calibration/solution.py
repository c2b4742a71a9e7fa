"""All that the recorded steps tell: gyros, angle sensors and servos, computed anew from the newest of each step."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.gyros.axis_response import axis_response
from tfsat_host.calibration.gyros.mounting_checks import check_mounting, check_sense
from tfsat_host.calibration.gyros.response import Response, with_length
from tfsat_host.calibration.gyros.seen import Seen, fresh, mounted
from tfsat_host.calibration.gyros.turn_response import check_turn_axis, turn_response
from tfsat_host.calibration.in_force import InForce
from tfsat_host.calibration.joints.sweep_fit import Rests, fit_sweeps, rests_of_sweep
from tfsat_host.calibration.sensors.gyro import GyroCalibration, by_design
from tfsat_host.calibration.sensors.joint_sensors import JointSensors, sensors_by_design
from tfsat_host.calibration.steps.evidence import Evidence, newest
from tfsat_host.calibration.steps.recording import Recording
from tfsat_host.calibration.steps.step import StepKind
from tfsat_host.calibration.steps.view import MotionView
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]

_PASSES = 3
"""The held body's motion is taken off with what its own gyro is known to do: each pass knows that better."""


@dataclass(frozen=True, eq=False)
class Solution:
    """What the evidence tells.

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


@dataclass(frozen=True, eq=False)
class _Known:
    """What is known between two passes, and how motions are seen with it."""

    gyros: Sequence[GyroCalibration]
    joints: Sequence[JointSensors]
    in_force: InForce
    model: RobotModel
    last_landing: datetime | None

    def view(self, one: Evidence) -> MotionView:
        gyros, joints = (
            self.in_force.gyros(self.gyros, one.taken),
            self.in_force.joints(self.joints, one.taken),
        )
        return MotionView.of(one, gyros, joints, self.model)

    def seen(self, response: Response, one: Evidence) -> Seen:
        return Seen(response, one.taken, self.last_landing is None or one.taken > self.last_landing)


def solve(evidence: Iterable[Evidence], model: RobotModel, last_landing: datetime | None = None) -> Solution:
    """Calibrates everything that the newest recording of each step allows.

    Each motion is read with the biases and zero points that were in force when it was recorded.

    Args:
        evidence: Recordings that were accepted, in any order.
        model: Whose axes, designs and tolerances hold.
        last_landing: What was recorded before it tells directions less surely.

    Raises:
        CalibrationError: what the recordings say cannot all be true.
    """
    given = list(evidence)
    in_force = InForce(given, model)
    latest = newest(given)
    gyros: Sequence[GyroCalibration] = [
        by_design(body, imu.sensor_to_body) for body, imu in enumerate(model.imus, 1)
    ]
    joints: Sequence[JointSensors] = [sensors_by_design(model, joint + 1) for joint in range(model.n_joints)]
    moving = [one for one in latest.values() if one.step.kind not in (StepKind.REST, StepKind.ZERO)]
    if any(one.step.kind != StepKind.SERVO for one in moving):
        for _ in range(_PASSES):
            gyros, joints = _pass(moving, _Known(gyros, joints, in_force, model, last_landing))
    servos = [one for one in moving if one.step.kind == StepKind.SERVO]
    used = [*moving, *in_force.used(one.taken for one in moving)]
    return Solution(
        tuple(in_force.gyros(gyros)),
        tuple(in_force.joints(joints)),
        tuple((one, tuple(in_force.joints(joints, one.taken))) for one in servos),
        tuple(sorted(used, key=lambda one: one.taken)),
    )


def _pass(moving: Sequence[Evidence], known: _Known) -> tuple[list[GyroCalibration], list[JointSensors]]:
    """Mountings and bends, better known than before."""
    seen: dict[int, list[Seen]] = {gyro.body: [] for gyro in known.gyros}
    for one in moving:
        if one.step.kind == StepKind.TURN:
            _add_turn(seen, one, known)
    joints = _with_bends(seen, moving, known)
    for gyro in known.gyros:
        check_mounting(gyro.body, fresh(seen[gyro.body]), known.model)
    return [mounted(gyro, seen[gyro.body], known.model) for gyro in known.gyros], joints


def _add_turn(seen: Mapping[int, list[Seen]], one: Evidence, known: _Known) -> None:
    recording = Recording.from_counts(one.counts)
    gyros = known.in_force.gyros(known.gyros, one.taken)
    check_turn_axis(recording, one.step, gyros)
    for gyro in gyros:
        seen[gyro.body].append(known.seen(turn_response(recording, one.step, gyro), one))


def _with_bends(
    seen: Mapping[int, list[Seen]], moving: Sequence[Evidence], known: _Known
) -> list[JointSensors]:
    """Adds what swings and sweeps tell to `seen`; gives the angle sensors with their bend."""
    sweeps: dict[int, list[tuple[Evidence, Response, Rests]]] = {}
    for one in moving:
        if one.step.kind not in (StepKind.SWING, StepKind.SWEEP):
            continue
        view = known.view(one)
        responses = [axis_response(view, body) for body in one.step.moved]
        check_sense(view.pattern, responses, known.model)
        for body, response in zip(one.step.moved, responses, strict=True):
            if one.step.kind == StepKind.SWING:
                seen[body].append(known.seen(response, one))
            else:
                rests = rests_of_sweep(view, body, response)
                sweeps.setdefault(view.pattern.joint, []).append((one, response, rests))
    bent = list(known.joints)
    for joint, of_joint in sweeps.items():
        bent[joint - 1] = _swept(joint, of_joint, seen, known)
    return bent


def _swept(
    joint: int,
    sweeps: Sequence[tuple[Evidence, Response, Rests]],
    seen: Mapping[int, list[Seen]],
    known: _Known,
) -> JointSensors:
    """Adds the lengths of a joint's sweeps to `seen`; gives its sensors with their bend."""
    sensors = [sensor for sensor in known.model.angle_sensors if sensor.joint == joint - 1]
    bends = np.array([sensor.nonlinearity_rad for sensor in sensors])
    turned = [_turned(seen[rests.body], response) for _, response, rests in sweeps]
    fit = fit_sweeps(joint, [rests for _, _, rests in sweeps], bends, [length for length, _ in turned])
    for (one, response, rests), (_, turn) in zip(sweeps, turned, strict=True):
        if turn is not None:  # its length is in the fit now
            seen[rests.body].remove(turn)
            seen[rests.body].append(replace(turn, response=_without_length(turn.response)))
        seen[rests.body].append(known.seen(with_length(response, *fit.lengths[rests.body]), one))
    return replace(
        known.joints[joint - 1],
        bend=fit.bend,
        bend_covariance=fit.bend_covariance,
        bend_taken=min(one.taken for one, _, _ in sweeps),
    )


def _turned(seen: Sequence[Seen], response: Response) -> tuple[tuple[float, float] | None, Seen | None]:
    """Length and deviation of a turn about the same axis, and where it stands."""
    for one in seen:
        if one.response.has_length and one.response.axis_body @ response.axis_body > 0.99:
            length = float(np.linalg.norm(one.response.reading))
            along = one.response.reading / length
            return (length, float(np.sqrt(along @ one.response.covariance @ along))), one
    return None, None


def _without_length(response: Response) -> Response:
    length = float(np.linalg.norm(response.reading))
    axis = response.reading / length
    across = np.eye(3) - np.outer(axis, axis)
    return Response(response.axis_body, axis, across @ response.covariance @ across / length**2, False)
