"""Whether a recorded step is what was asked for, before it may replace an earlier one."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from tfsat_host.angles import wrap_angle
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.bias import estimate_biases
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.replacements import NEVER_REPLACED, Specimens
from tfsat_host.calibration.sensors.joint_sensors import JointSensors, sensor_columns
from tfsat_host.calibration.solution import Solution, solve
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.calibration.steps.sensor_samples import SensorSamples, check_answers, check_complete
from tfsat_host.calibration.steps.step import Step, StepKind, bodies
from tfsat_host.calibration.zero import estimate_zero
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.robot import RobotModel
from tfsat_host.robot.absent_parts import bodies_with_imu

MAX_OPEN_RAD = np.deg2rad(3.0)
"""A joint may be so far from closed while the robot is turned: it tilts the outer bodies' axis by as much."""
MIN_RMS_RAD_S = {StepKind.SWING: np.deg2rad(5.0), StepKind.SWEEP: np.deg2rad(2.0)}
"""A moved body must turn at least this fast, rms."""
MIN_TRAVEL_RAD = {StepKind.SWING: np.deg2rad(20.0), StepKind.SWEEP: np.deg2rad(45.0)}
"""So far must the joint go."""
MAX_HELD_FRACTION = 0.15
"""A held body may turn at most this fraction of the moved one's rms rate; what it turns is taken off."""
MAX_FOLLOWING_SHARE = 0.01
"""A closed joint between moved bodies may follow the moved one by this share: it tilts the axis by as much."""
MAX_FOLLOWING_RAD = np.deg2rad(5.0)
"""So far may such a joint wander at all."""
MAX_DIFFERENCE_RAD = np.deg2rad(4.0)
"""Between the two sensors of a joint: twice what two poorly adjusted magnets make."""
# Far below every motion that is asked for: a sensor that goes less shows none.
_SILENT_RAD = np.deg2rad(3.0)
# Of the fastest body's rate: above it a body counts as moving.
_MOVES_FRACTION = 0.4
_DEAD_RAD_S = np.deg2rad(1.0)
"""A joint that goes 20 deg at less takes 20 s."""
_AGAIN = "and run this command again."


def check_step(
    evidence: Evidence,
    earlier: Iterable[Evidence],
    model: RobotModel,
    specimens: Specimens = NEVER_REPLACED,
) -> None:
    """Refuses a step that does not show what it should; whether it fits the other steps, `solution.solve` says.

    Args:
        evidence: The step, just recorded.
        earlier: What was accepted before it, in any order; a step is judged by biases and zero points alone.
        model: The robot.
        specimens: Which specimen of each part was in place when.

    Raises:
        CalibrationError: why not, what it means, and what to do.
    """
    step, valid, sensed = evidence.step, evidence.counts.angle_valid, bodies_with_imu(model)
    # Judge by biases and zero points alone, so that no earlier motion bears on this one.
    at_rest = (entry for entry in earlier if entry.step.kind in (StepKind.REST, StepKind.ZERO))
    before = solve(at_rest, model, specimens=specimens)
    recording = evidence.recording
    if step.kind == StepKind.REST:
        estimate_biases(recording, sensed)
        return
    # Zeros and strokes need no gyro; every other step needs all gyros valid throughout.
    without_gyros = step.kind in (StepKind.ZERO, StepKind.STROKES)
    check_complete(recording, () if without_gyros else sensed)
    if step.kind == StepKind.ZERO:
        for sensors in before.joints:
            if step.joint in (None, sensors.joint) and not sensors.absent:
                estimate_zero(recording, valid, sensors, model)
        return
    if step.kind == StepKind.STROKES:
        check_answers(valid[:, sensor_columns(model, step.moving_joint)], step.moving_joint, most_silent=0.0)
    if step.kind in (StepKind.SERVO, StepKind.STROKES):
        return
    if any(gyro.bias_recorded_at is None and not gyro.absent for gyro in before.gyros):
        raise CalibrationError(
            what="The gyros' biases are not known yet.",
            meaning="A gyro that reads 5 deg/s at rest would be taken for a body that moves.",
            next_step=Advice("Let the robot rest on the bench and type: ", NextStep("calibrate bias")),
        )
    if step.kind == StepKind.TURN:
        _check_closed(recording, before, model)
        return
    # Joint k joins bodies k and k + 1: one between moved bodies must be seen to stay closed.
    between = {body for body in step.moved if body + 1 in step.moved}
    for joint in sorted(between | {step.moving_joint}):
        check_answers(valid[:, sensor_columns(model, joint)], joint, most_silent=0.0)
    rates = recording.rate_rad_s - np.array([gyro.bias_rad_s for gyro in before.gyros])
    by_each = np.stack([_by_each(recording, sensors, model) for sensors in before.joints], axis=1)
    _check_motion(step, rates, by_each)


def _by_each(recording: SensorSamples, sensors: JointSensors, model: RobotModel) -> FloatArray:
    """(n, 2) a joint's angle by each sensor, unwrapped; without a zero from where the recording begins."""
    readings_rad = recording.sensor_angle_rad[:, sensor_columns(model, sensors.joint)]
    return sensors.from_start(np.unwrap(sensors.each(readings_rad), axis=0))


def _check_closed(recording: SensorSamples, before: Solution, model: RobotModel) -> None:
    """Refuse a turn whose bodies are not parallel: each would turn about its own axis."""
    for sensors in before.joints:
        angle = _by_each(recording, sensors, model).mean(axis=1)
        open_rad = float(np.abs(wrap_angle(angle)).max())
        if open_rad > MAX_OPEN_RAD:
            raise CalibrationError(
                what=f"Joint {sensors.joint} was {np.rad2deg(open_rad):.1f} deg open while the robot was turned.",
                meaning="The bodies beyond it turned about another of their axes; their scale would be wrong.",
                next_step=f"Close all joints, leave the attachments on, {_AGAIN}",
            )


def _check_motion(step: Step, rates_rad_s: FloatArray, by_each_rad: FloatArray) -> None:
    """Refuses what is not the motion of a swing or a sweep.

    Args:
        step: What was asked.
        rates_rad_s: (n, 4, 3) bias taken off, sensor axes.
        by_each_rad: (n, 3, 2) joint angles by each of their sensors, unwrapped; where a zero is not known, from
            where the recording begins.
    """
    # (4,): rms of each body's rate vector over the recording.
    rms = np.sqrt((rates_rad_s**2).sum(axis=2).mean(axis=0))
    # Order matters: what follows takes for granted that this joint was moved.
    _check_joint_moved(step, np.ptp(by_each_rad, axis=0), rms)
    _check_sensors_agree(step.moving_joint, by_each_rad[:, step.moving_joint - 1])
    _check_bodies(step, rms)
    _check_closed_joints(step, by_each_rad.mean(axis=2))


def _check_joint_moved(step: Step, travel_rad: FloatArray, rms: FloatArray) -> None:
    """Refuses where the angle sensors do not show that the joint was moved.

    Args:
        step: Which joint was asked for.
        travel_rad: (3, 2) how far each sensor of each joint went.
        rms: (4,) of each body's rate, rad/s.
    """
    joint, least_rad = step.moving_joint, MIN_TRAVEL_RAD[step.kind]
    # A joint counts as moved by the lesser travel of its two sensors.
    own, both = travel_rad[joint - 1], travel_rad.min(axis=1)
    if own.min() >= least_rad:
        return
    turning = bool(rms.max() > MIN_RMS_RAD_S[step.kind])
    silent = own.max() < _SILENT_RAD
    others = [other for other, travel in enumerate(both, 1) if other != joint and travel > least_rad]
    # Another joint moved instead: the wrong one, or the cables of two joints are exchanged.
    if others and silent:
        raise CalibrationError(
            what=f"Joint {others[0]} was moved by {np.rad2deg(both[others[0] - 1]):.0f} deg, not joint {joint}.",
            meaning="The axis of another joint would have been taken for this one's. "
            "Where the right joint was moved, the angle sensors of the two are exchanged.",
            next_step=f"Move joint {joint}, or put the angle sensors' cables right, {_AGAIN}",
        )
    # One sensor sees the motion, and its twin on the same axis does not.
    if own.min() < _SILENT_RAD and own.max() > least_rad:
        raise _one_sensor(joint, travel_rad, least_rad)
    # All gyros turn at similar rates about a stiff joint: the robot was turned as a whole.
    if silent and turning and rms.min() > _MOVES_FRACTION * rms.max():
        raise CalibrationError(
            what=f"All bodies turned as one, and joint {joint} did not move.",
            meaning="The axis of the joint cannot be separated from a rotation of the whole robot.",
            next_step=f"Hold one side on the bench, move joint {joint} alone, {_AGAIN}",
        )
    if silent and turning:
        raise CalibrationError(
            what=f"Neither angle sensor of joint {joint} shows a motion while gyros turn.",
            meaning="Without them the joint's angle is not known, now or in the drop.",
            next_step=Advice(
                "Check their cables and magnets with ",
                NextStep("monitor"),
                f", move joint {joint}, {_AGAIN}",
            ),
        )
    raise CalibrationError(
        what=f"Joint {joint} moved by {np.rad2deg(own.min()):.0f} deg; at least {np.rad2deg(least_rad):.0f} "
        f"are needed.",
        meaning="The axis could not be separated from noise.",
        next_step=f"Move joint {joint} farther, through its whole range if you can, {_AGAIN}",
    )


def _one_sensor(joint: int, travel_rad: FloatArray, least_rad: float) -> CalibrationError:
    """Build the error for one of the joint's sensors that shows no motion.

    It is dead, or its cable is exchanged with another joint's.
    """
    silent = int(np.argmin(travel_rad[joint - 1])) + 1
    # Exchanged cables show as one silent and one moving sensor on each of two joints.
    for other, travel in enumerate(travel_rad, 1):
        if other != joint and travel.max() > least_rad and travel.min() < _SILENT_RAD:
            stray = int(np.argmax(travel)) + 1
            return CalibrationError(
                what=f"Angle sensor {silent} of joint {joint} and angle sensor {stray} of joint {other} look "
                f"exchanged: the one shows no motion, the other moves.",
                meaning="Both joints' angles would be wrong in the drop.",
                next_step=Advice(
                    "Exchange their cables, take the zero points again (",
                    NextStep("calibrate zero", ("--all", "--anew")),
                    f"), {_AGAIN}",
                ),
            )
    return CalibrationError(
        what=f"Angle sensor {silent} of joint {joint} shows no motion while the other one moves.",
        meaning="It is dead, or its magnet is loose; the joint's angle in the drop would be wrong.",
        next_step=Advice("Check its cable and its magnet with ", NextStep("monitor"), f", {_AGAIN}"),
    )


def _check_sensors_agree(joint: int, by_each_rad: FloatArray) -> None:
    """Refuses what two sensors (n, 2), counted from the joint's zero or from the recording's start, do not share."""
    apart = by_each_rad[:, 0] - by_each_rad[:, 1]
    # Unwrapped angles may start whole turns apart: that is no disagreement.
    apart = apart - 2 * np.pi * np.round(apart[0] / (2 * np.pi))
    worst = float(np.abs(apart).max())
    if worst <= MAX_DIFFERENCE_RAD:
        return
    # Opposite senses: anticorrelated, and apart by more than half of both travels together.
    opposed = np.corrcoef(by_each_rad[:, 0], by_each_rad[:, 1])[0, 1] < -0.9
    if opposed and worst > 0.5 * np.ptp(by_each_rad, axis=0).sum():
        raise CalibrationError(
            what=f"The two angle sensors of joint {joint} go opposite ways: one counts the other way than the "
            f"robot file says.",
            meaning="Their mean would not be the joint's angle.",
            next_step=Advice(
                "Move the joint and look at both with ",
                NextStep("monitor"),
                "; correct the direction of the wrong one in the robot file, give that with --robot, "
                f"{_AGAIN}",
            ),
        )
    raise CalibrationError(
        what=f"The two angle sensors of joint {joint} disagree by up to {np.rad2deg(worst):.1f} deg "
        f"over the motion.",
        meaning="One of them slips on the axis, or sits off its centre; it may slip again in the drop.",
        next_step=Advice(
            "Look at both with ",
            NextStep("monitor"),
            " while the joint moves; fasten the one that lags, take its zero again (",
            NextStep("calibrate zero", ("--joint", str(joint), "--anew")),
            f"), {_AGAIN}",
        ),
    )


def _check_bodies(step: Step, rms: FloatArray) -> None:
    """Refuses where others moved than should have, by the rms rate (4,) of each body."""
    joint, moved, held_bodies = step.moving_joint, set(step.moved), set(step.held)
    # Bodies that only go along are not judged; the others are split by rate relative to the fastest.
    fastest = max(float(rms[body - 1]) for body in moved | held_bodies)
    slowest = min(step.moved, key=lambda body: float(rms[body - 1]))
    moving = {body for body in moved | held_bodies if rms[body - 1] > _MOVES_FRACTION * fastest}
    missing, extra = sorted(moved - moving), sorted(moving - moved)
    # Too slow is the finding only where nobody moves or the right bodies do: else the cause is another.
    if fastest < MIN_RMS_RAD_S[step.kind] or (
        moving == moved and rms[slowest - 1] < MIN_RMS_RAD_S[step.kind]
    ):
        if rms[slowest - 1] < _DEAD_RAD_S:
            raise _dead(step, slowest, rms)
        raise CalibrationError(
            what=f"Body {slowest} turned at {np.rad2deg(rms[slowest - 1]):.1f} deg/s rms; "
            f"at least {np.rad2deg(MIN_RMS_RAD_S[step.kind]):.0f} are needed.",
            meaning="The axis could not be separated from noise.",
            next_step=f"Move {bodies(step.moved)} about joint {joint} wider and faster, {_AGAIN}",
        )
    if moving == moved:
        # The right bodies moved: now hold the others to the stricter limit.
        extra = [body for body in step.held if rms[body - 1] > MAX_HELD_FRACTION * rms[slowest - 1]]
    # One body too few and one too many: two gyros have changed places.
    if len(missing) == len(extra) == 1:
        raise CalibrationError(
            what=f"The gyros of body {missing[0]} and body {extra[0]} look exchanged: joint {joint} moved, and the "
            f"gyro of body {extra[0]} turned instead of that of body {missing[0]}.",
            meaning="Every rate in the drop would be taken for another body's; so were those of the steps so far.",
            next_step=Advice(
                "Exchange their cables (or their address jumpers) and begin again: ",
                NextStep("calibrate bias"),
                f", then misalignment --joint 1. If their cables are right, move body {missing[0]}, "
                f"not body {extra[0]}.",
            ),
        )
    if moving == held_bodies:
        raise CalibrationError(
            what=f"The wrong side moved: {bodies(held_bodies)} turned, and {bodies(moved)} was held.",
            meaning="Nothing was kept: the gyros of the side that is asked for measured no rotation.",
            next_step=f"Hold {bodies(held_bodies)} on the bench and move {bodies(moved)}, {_AGAIN} "
            "If you did so, the cables of the gyros' two buses are exchanged.",
        )
    if missing:
        raise _dead(step, missing[0], rms)
    if extra:
        raise CalibrationError(
            what=f"Body {extra[0]} should have been held, and turned at {np.rad2deg(rms[extra[0] - 1]):.1f} "
            f"deg/s rms.",
            meaning="The rotation was not about the joint alone; the axis would be wrong.",
            next_step=f"Hold {bodies(step.held)} firmly on the bench, {_AGAIN}",
        )


def _dead(step: Step, body: int, rms: FloatArray) -> CalibrationError:
    return CalibrationError(
        what=f"The gyro of body {body} showed {np.rad2deg(rms[body - 1]):.1f} deg/s rms while joint {step.joint} "
        f"was moved.",
        meaning="It is broken, or its body was not moved.",
        next_step=Advice(
            f"Move {bodies(step.moved)} about joint {step.joint}; look at the gyro with ",
            NextStep("monitor"),
            ".",
        ),
    )


def _check_closed_joints(step: Step, angles_rad: FloatArray) -> None:
    """Joints between moved bodies: what moves with the joint in question tilts the axis that the farther gyro shows."""
    joint = step.moving_joint
    moved = angles_rad[:, joint - 1] - angles_rad[:, joint - 1].mean()
    for other, angle in enumerate(angles_rad.T, 1):
        if other == joint or not {other, other + 1} <= set(step.moved):
            continue
        # Least-squares slope of this joint's angle on the moved one's.
        share = abs(float(moved @ angle) / float(moved @ moved))
        if share > MAX_FOLLOWING_SHARE or np.ptp(angle) > MAX_FOLLOWING_RAD:
            raise CalibrationError(
                what=f"Joint {other} moved by {np.rad2deg(np.ptp(angle)):.1f} deg while joint {joint} was "
                f"moved; it should stay closed.",
                meaning=f"The gyro beyond it turned about both; the axis of joint {joint} would be wrong for it.",
                next_step=f"Close joint {other} and grip {bodies((other, other + 1))} as one, or leave the "
                f"attachment on it, {_AGAIN}",
            )
