"""Whether a recorded step is what was asked for, before it may replace an earlier one."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from tfsat_host.angles import wrapped
from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.calibration.gyros.bias import estimate_biases
from tfsat_host.calibration.joints.zero import estimate_zero
from tfsat_host.calibration.sensors.joint_sensors import JointSensors, sensor_columns
from tfsat_host.calibration.solution import Solution, solve
from tfsat_host.calibration.steps.angle_checks import check_answers
from tfsat_host.calibration.steps.completeness import check_complete
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.calibration.steps.motion_checks import check_motion
from tfsat_host.calibration.steps.recording import Recording
from tfsat_host.calibration.steps.step import Step, StepKind
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]

MOST_OPEN_RAD = np.deg2rad(3.0)
"""A joint may be so far from closed while the robot is turned: it tilts the outer bodies' axis by as much."""
_COMPARED_WITH = (StepKind.REST, StepKind.ZERO)
"""A step is judged by biases and zero points alone: what motions told before need not be solved for it."""


def check_step(evidence: Evidence, earlier: Iterable[Evidence], model: RobotModel) -> None:
    """Refuses a step that does not show what it should; whether it fits the other steps, `solution.solve` says.

    Args:
        evidence: The step, just recorded.
        earlier: What was accepted before it, in any order: rests tell biases, zeros what a new one is compared with.
        model: The robot.

    Raises:
        CalibrationError: why not, what it means, and what to do.
    """
    step = evidence.step
    before = solve((one for one in earlier if one.step.kind in _COMPARED_WITH), model)
    recording = Recording.from_counts(evidence.counts)
    if step.kind == StepKind.REST:
        estimate_biases(recording)
        return
    if step.kind == StepKind.ZERO:
        check_complete(recording, ())
        for sensors in before.joints:
            if step.joint in (None, sensors.joint):
                estimate_zero(recording, evidence.counts.angle_valid, sensors, model)
        return
    check_complete(recording, range(1, len(before.gyros) + 1))
    if step.kind == StepKind.SERVO:
        return
    _check_biases(before)
    if step.kind == StepKind.TURN:
        _check_closed(recording, before, model)
        return
    for joint in _joints_that_matter(step):
        check_answers(evidence.counts.angle_valid[:, sensor_columns(model, joint)], joint, most_silent=0.0)
    rates = recording.rate_rad_s - np.array([gyro.bias_rad_s for gyro in before.gyros])
    by_each = np.stack([_by_each(recording, sensors, model) for sensors in before.joints], axis=1)
    check_motion(step, rates, by_each)


def _check_biases(before: Solution) -> None:
    if any(gyro.bias_taken is None for gyro in before.gyros):
        raise CalibrationError(
            what="The gyros' biases are not known yet.",
            meaning="A gyro that reads 5 deg/s at rest would be taken for a body that moves.",
            next_step="Let the robot rest on the bench and type: tfsat-host calibrate bias",
        )


def _joints_that_matter(step: Step) -> list[int]:
    """The one that is moved, and those between moved bodies."""
    between = [body for body in step.moved if body + 1 in step.moved]
    return between if step.joint is None else sorted({step.joint, *between})


def _by_each(recording: Recording, sensors: JointSensors, model: RobotModel) -> FloatArray:
    """(n, 2) a joint's angle by each sensor, unwrapped; without a zero from where the recording begins."""
    angles = np.unwrap(
        sensors.each(recording.sensor_angle_rad[:, sensor_columns(model, sensors.joint)]), axis=0
    )
    if sensors.zero_taken is None:
        angles -= angles[: max(1, len(angles) // 50)].mean(axis=0)
    return np.asarray(angles)


def _check_closed(recording: Recording, before: Solution, model: RobotModel) -> None:
    """All bodies must be parallel in a turn, or each would turn about an axis of its own."""
    for sensors in before.joints:
        angle = _by_each(recording, sensors, model).mean(axis=1)
        open_rad = float(np.abs(wrapped(angle)).max())
        if open_rad > MOST_OPEN_RAD:
            raise CalibrationError(
                what=f"Joint {sensors.joint} was {np.rad2deg(open_rad):.1f} deg open while the robot was turned.",
                meaning="The bodies beyond it turned about another of their axes; their scale would be wrong.",
                next_step="Close all joints, leave the attachments on, and run this command again.",
            )
