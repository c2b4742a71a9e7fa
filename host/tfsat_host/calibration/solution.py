"""All that the recorded steps tell of gyros and angle sensors, computed anew from the newest of each step."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.gyros.axis_response import axis_response
from tfsat_host.calibration.gyros.bias import estimate_biases
from tfsat_host.calibration.gyros.gyro import MOUNTING_STD_RAD, GyroCalibration, by_design
from tfsat_host.calibration.gyros.mounting import Design, solve_mounting, spans_two_axes
from tfsat_host.calibration.gyros.mounting_checks import check_mounting, check_sense
from tfsat_host.calibration.gyros.response import Response, with_length
from tfsat_host.calibration.gyros.turn_response import check_turn_axis, turn_response
from tfsat_host.calibration.joints.joint_sensors import JointSensors, sensors_by_design
from tfsat_host.calibration.joints.sweep_fit import Rests, fit_sweeps, rests_of_sweep
from tfsat_host.calibration.joints.zero import estimate_zero, with_zero
from tfsat_host.calibration.steps.evidence import Evidence, newest
from tfsat_host.calibration.steps.recording import Recording
from tfsat_host.calibration.steps.step import AXES, StepKind
from tfsat_host.calibration.steps.view import MotionView
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]

LANDING_TILT_STD_RAD = np.deg2rad(1.0)
"""About each axis: so far may a landing have turned a sensor on its body."""
FORGOTTEN_STD_RAD = np.deg2rad(20.0)
"""Of a direction from before a landing, once newer ones tell the mounting: it weighs no more."""
SCALE_KNOWN = 0.005
_PASSES = 3
"""The held body's motion is taken off with what its own gyro is known to do: each pass knows that better."""


@dataclass(frozen=True, eq=False)
class Solution:
    """What the evidence tells.

    Attributes:
        gyros: Of bodies 1 to 4.
        joints: Sensors of joints 1 to 3.
        used: The evidence that it rests on, in order of time.
    """

    gyros: tuple[GyroCalibration, ...]
    joints: tuple[JointSensors, ...]
    used: tuple[Evidence, ...]


@dataclass(frozen=True, eq=False)
class Seen:
    """A response with where it comes from."""

    response: Response
    taken: datetime
    fresh: bool


def solve(evidence: Iterable[Evidence], model: RobotModel, last_landing: datetime | None = None) -> Solution:
    """Calibrates everything that the newest recording of each step allows.

    Args:
        evidence: Recordings that were accepted, in any order.
        model: Whose axes, designs and tolerances hold.
        last_landing: What was recorded before it tells directions less surely.

    Raises:
        CalibrationError: what the recordings say cannot all be true.
    """
    found = newest(evidence)
    gyros = _with_biases(
        [by_design(body, imu.sensor_to_body) for body, imu in enumerate(model.imus, 1)], found
    )
    joints = _with_zeros(
        [sensors_by_design(model, joint + 1) for joint in range(model.n_joints)], found, model
    )
    motions = [one for one in found.values() if one.step.kind in (StepKind.SWING, StepKind.SWEEP)]
    turns = [one for one in found.values() if one.step.kind == StepKind.TURN]
    if motions or turns:
        gyros, joints = _with_mountings(motions, turns, gyros, joints, model, last_landing)
    used = tuple(sorted(found.values(), key=lambda one: one.taken))
    return Solution(tuple(gyros), tuple(joints), used)


def _with_mountings(
    motions: Sequence[Evidence],
    turns: Sequence[Evidence],
    gyros: list[GyroCalibration],
    joints: list[JointSensors],
    model: RobotModel,
    last_landing: datetime | None,
) -> tuple[list[GyroCalibration], list[JointSensors]]:
    seen: dict[int, list[Seen]] = {}
    for _ in range(_PASSES):
        seen, joints = _responses(motions, turns, gyros, joints, model, last_landing)
        for gyro in gyros:
            check_mounting(gyro.body, _fresh(seen[gyro.body]), model)
        gyros = [_mounted(gyro, seen[gyro.body], model) for gyro in gyros]
    return gyros, joints


def _with_biases(gyros: list[GyroCalibration], found: Mapping[str, Evidence]) -> list[GyroCalibration]:
    rest = found.get(str(StepKind.REST))
    if rest is None:
        return gyros
    recording = Recording.from_counts(rest.counts)
    return [
        replace(
            gyro,
            bias_rad_s=bias.bias_rad_s,
            covariance=_with_block(gyro.covariance, 0, bias.covariance),
            noise_rad_s=bias.noise_rad_s,
            temperature_c=bias.temperature_c,
            bias_taken=rest.taken,
        )
        for gyro, bias in zip(gyros, estimate_biases(recording), strict=True)
    ]


def _with_zeros(
    joints: list[JointSensors], found: Mapping[str, Evidence], model: RobotModel
) -> list[JointSensors]:
    zeros = []
    for sensors in joints:
        own = [
            one
            for one in found.values()
            if one.step.kind == StepKind.ZERO and one.step.joint in (None, sensors.joint)
        ]
        if own:
            last = max(own, key=lambda one: one.taken)
            recording = Recording.from_counts(last.counts)
            zero = estimate_zero(recording, last.counts.angle_valid, sensors, model)
            sensors = with_zero(sensors, zero, last.taken)
        zeros.append(sensors)
    return zeros


def _responses(
    motions: Sequence[Evidence],
    turns: Sequence[Evidence],
    gyros: Sequence[GyroCalibration],
    joints: Sequence[JointSensors],
    model: RobotModel,
    last_landing: datetime | None,
) -> tuple[dict[int, list[Seen]], list[JointSensors]]:
    """What each body's gyro answers, and the angle sensors with their bend."""
    seen: dict[int, list[Seen]] = {gyro.body: [] for gyro in gyros}
    for one in turns:
        recording = Recording.from_counts(one.counts)
        check_turn_axis(recording, one.step, gyros)
        for gyro in gyros:
            _keep(seen[gyro.body], turn_response(recording, one.step, gyro), one, last_landing)
    sweeps: dict[int, list[tuple[Evidence, Response, Rests]]] = {}
    for one in motions:
        view = MotionView.of(one, gyros, joints, model)
        responses = [axis_response(view, body) for body in one.step.moved]
        check_sense(view.pattern, responses, model)
        for body, response in zip(one.step.moved, responses, strict=True):
            if one.step.kind == StepKind.SWING:
                _keep(seen[body], response, one, last_landing)
            else:
                rests = rests_of_sweep(view, body, response)
                sweeps.setdefault(view.pattern.joint, []).append((one, response, rests))
    bent = list(joints)
    for joint, of_joint in sweeps.items():
        bent[joint - 1] = _swept(joint, of_joint, seen, joints[joint - 1], model, last_landing)
    return seen, bent


def _swept(
    joint: int,
    sweeps: Sequence[tuple[Evidence, Response, Rests]],
    seen: dict[int, list[Seen]],
    sensors: JointSensors,
    model: RobotModel,
    last_landing: datetime | None,
) -> JointSensors:
    """Adds the lengths of a joint's sweeps to `seen`; gives its sensors with their bend."""
    bends = np.array([sensor.nonlinearity_rad for sensor in model.angle_sensors if sensor.joint == joint - 1])
    known = [_turned(seen[rests.body], response) for _, response, rests in sweeps]
    fit = fit_sweeps(joint, [rests for _, _, rests in sweeps], bends, [length for length, _ in known])
    for (one, response, rests), (_, turn) in zip(sweeps, known, strict=True):
        if turn is not None:  # its length is in the fit now
            seen[rests.body].remove(turn)
            seen[rests.body].append(replace(turn, response=_without_length(turn.response)))
        _keep(seen[rests.body], with_length(response, *fit.lengths[rests.body]), one, last_landing)
    return replace(
        sensors,
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


def _keep(seen: list[Seen], response: Response, one: Evidence, last_landing: datetime | None) -> None:
    seen.append(Seen(response, one.taken, last_landing is None or one.taken > last_landing))


def _weighed(seen: Sequence[Seen]) -> list[Response]:
    """The responses, those from before the last landing with what it may have done to their directions."""
    doubt_rad = FORGOTTEN_STD_RAD if spans_two_axes(_fresh(seen)) else LANDING_TILT_STD_RAD
    weighed = []
    for one in seen:
        response = one.response
        if not one.fresh:
            length = float(np.linalg.norm(response.reading))
            axis = response.reading / length
            across = (length * doubt_rad) ** 2 * (np.eye(3) - np.outer(axis, axis))
            response = replace(response, covariance=response.covariance + across)
        weighed.append(response)
    return weighed


def _fresh(seen: Sequence[Seen]) -> list[Response]:
    return [one.response for one in seen if one.fresh]


def _mounted(gyro: GyroCalibration, seen: Sequence[Seen], model: RobotModel) -> GyroCalibration:
    nominal = model.imus[gyro.body - 1].sensor_to_body
    mounting = solve_mounting(_weighed(seen), Design(nominal, MOUNTING_STD_RAD))
    scaled = "".join(
        axis for i, axis in enumerate(AXES) if mounting.covariance[3 + i, 3 + i] < SCALE_KNOWN**2
    )
    valid = [one for one in seen if one.fresh] or seen
    return replace(
        gyro,
        rotation=mounting.rotation,
        scale=mounting.scale,
        covariance=_with_block(gyro.covariance, 3, mounting.covariance),
        axes="".join(
            axis for i, axis in enumerate(AXES) if any(abs(one.response.axis_body[i]) > 0.9 for one in valid)
        ),
        scaled=scaled,
        axes_taken=min((one.taken for one in valid), default=None),
        scale_taken=min((one.taken for one in seen if one.response.has_length), default=None),
    )


def _with_block(covariance: FloatArray, at: int, block: FloatArray) -> FloatArray:
    changed = covariance.copy()
    end = at + len(block)
    changed[at:end, :] = 0.0
    changed[:, at:end] = 0.0
    changed[at:end, at:end] = block
    return changed
