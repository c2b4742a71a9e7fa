"""Whether what the sensors saw is what the step asked for: who moved, how far, and which sensors say so."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.calibration.steps.angle_checks import check_joint_moved, check_sensors_agree
from tfsat_host.calibration.steps.step import Step, StepKind

FloatArray = NDArray[np.float64]

LEAST_RMS_RAD_S = {StepKind.SWING: np.deg2rad(5.0), StepKind.SWEEP: np.deg2rad(2.0)}
"""A moved body must turn at least this fast, rms."""
LEAST_TRAVEL_RAD = {StepKind.SWING: np.deg2rad(20.0), StepKind.SWEEP: np.deg2rad(45.0)}
"""So far must the joint go."""
MOST_HELD_FRACTION = 0.15
"""A held body may turn at most this fraction of the moved one's rms rate; what it turns is taken off."""
MOST_CARRIED_SHARE = 0.01
"""A closed joint between moved bodies may follow the moved one by this share: it tilts the axis by as much."""
MOST_CARRIED_RAD = np.deg2rad(5.0)
"""So far may such a joint wander at all."""
_MOVES_FRACTION = 0.4
_DEAD_RAD_S = np.deg2rad(1.0)
"""A joint that goes 20 deg at less takes 20 s."""


def check_motion(step: Step, rates_rad_s: FloatArray, by_each_rad: FloatArray) -> None:
    """Refuses what is not the motion of a swing or a sweep.

    Args:
        step: What was asked.
        rates_rad_s: (n, 4, 3) bias taken off, sensor axes.
        by_each_rad: (n, 3, 2) joint angles by each of their sensors, unwrapped; where a zero is not known, from
            where the recording begins.

    Raises:
        CalibrationError: another joint or side was moved, too little, a held body moved, or sensors are exchanged.
    """
    if step.joint is None:
        raise ValueError(f"a {step.kind} moves no joint")
    rms = np.sqrt((rates_rad_s**2).sum(axis=2).mean(axis=0))
    turning = bool(rms.max() > LEAST_RMS_RAD_S[step.kind])
    check_joint_moved(
        step.joint,
        np.ptp(by_each_rad, axis=0),
        LEAST_TRAVEL_RAD[step.kind],
        carried=turning and bool(rms.min() > _MOVES_FRACTION * rms.max()),
        turning=turning,
    )
    check_sensors_agree(step.joint, by_each_rad[:, step.joint - 1])
    _check_bodies(step, step.joint, rms)
    _check_closed_joints(step, step.joint, by_each_rad.mean(axis=2))


def _check_bodies(step: Step, joint: int, rms: FloatArray) -> None:
    moved, held = set(step.moved), set(step.held)
    fastest = max(float(rms[body - 1]) for body in moved | held)
    if fastest < LEAST_RMS_RAD_S[step.kind]:
        raise _hardly_moved(step, joint, rms)
    moving = {body for body in moved | held if rms[body - 1] > _MOVES_FRACTION * fastest}
    if moving == moved:
        _check_excitation(step, joint, rms)
        return
    missing, extra = sorted(moved - moving), sorted(moving - moved)
    if len(missing) == len(extra) == 1:
        raise _exchanged(joint, missing[0], extra[0])
    if moving == held:
        raise CalibrationError(
            what=f"The wrong side moved: {bodies(held)} turned, and {bodies(moved)} was held.",
            meaning="Nothing was kept: the gyros of the side that is asked for saw no rotation.",
            next_step=f"Hold {bodies(held)} on the bench and move {bodies(moved)}, and run this command "
            f"again. If you did so, the cables of the gyros' two buses are exchanged.",
        )
    if missing:
        raise _dead(step, joint, missing[0], rms)
    raise _held_moved(step, extra[0], float(rms[extra[0] - 1]))


def _exchanged(joint: int, missing: int, extra: int) -> CalibrationError:
    return CalibrationError(
        what=f"The gyros of body {missing} and body {extra} look exchanged: joint {joint} moved, and the "
        f"gyro of body {extra} turned instead of that of body {missing}.",
        meaning="Every rate in the drop would be taken for another body's; so were those of the steps so far.",
        next_step=f"Exchange their cables (or their address jumpers) and begin anew: tfsat-host calibrate bias, "
        f"then misalignment --joint 1. If their cables are right, move body {missing}, not body {extra}.",
    )


def _dead(step: Step, joint: int, body: int, rms: FloatArray) -> CalibrationError:
    return CalibrationError(
        what=f"The gyro of body {body} showed {np.rad2deg(rms[body - 1]):.1f} deg/s rms while joint {joint} "
        f"was moved.",
        meaning="It is broken, or its body was not moved.",
        next_step=f"Move {bodies(step.moved)} about joint {joint}; look at the gyro with tfsat-host monitor.",
    )


def _check_excitation(step: Step, joint: int, rms: FloatArray) -> None:
    slowest = min(step.moved, key=lambda body: float(rms[body - 1]))
    if rms[slowest - 1] < LEAST_RMS_RAD_S[step.kind]:
        raise _hardly_moved(step, joint, rms)
    for body in step.held:
        if rms[body - 1] > MOST_HELD_FRACTION * rms[slowest - 1]:
            raise _held_moved(step, body, float(rms[body - 1]))


def _hardly_moved(step: Step, joint: int, rms: FloatArray) -> CalibrationError:
    slowest = min(step.moved, key=lambda body: float(rms[body - 1]))
    if rms[slowest - 1] < _DEAD_RAD_S:
        return _dead(step, joint, slowest, rms)
    return CalibrationError(
        what=f"Body {slowest} turned at {np.rad2deg(rms[slowest - 1]):.1f} deg/s rms; "
        f"at least {np.rad2deg(LEAST_RMS_RAD_S[step.kind]):.0f} are needed.",
        meaning="The axis could not be told from noise.",
        next_step=f"Move {bodies(step.moved)} about joint {joint} wider and faster, and run this command again.",
    )


def _held_moved(step: Step, body: int, rms_rad_s: float) -> CalibrationError:
    return CalibrationError(
        what=f"Body {body} should have been held, and turned at {np.rad2deg(rms_rad_s):.1f} deg/s rms.",
        meaning="The rotation was not about the joint alone; the axis would be wrong.",
        next_step=f"Hold {bodies(step.held)} firmly on the bench, and run this command again.",
    )


def _check_closed_joints(step: Step, joint: int, angles_rad: FloatArray) -> None:
    """Joints between moved bodies: what moves with the joint in question tilts the axis that the farther gyro sees."""
    moved = angles_rad[:, joint - 1] - angles_rad[:, joint - 1].mean()
    for other in range(1, angles_rad.shape[1] + 1):
        if other == joint or not {other, other + 1} <= set(step.moved):
            continue
        angle = angles_rad[:, other - 1]
        share = abs(float(moved @ angle) / float(moved @ moved))
        if share > MOST_CARRIED_SHARE or np.ptp(angle) > MOST_CARRIED_RAD:
            raise CalibrationError(
                what=f"Joint {other} moved by {np.rad2deg(np.ptp(angle)):.1f} deg while joint {joint} was "
                f"moved; it should stay closed.",
                meaning=f"The gyro beyond it turned about both; the axis of joint {joint} would be wrong "
                f"for it.",
                next_step=f"Close joint {other} and grip {bodies((other, other + 1))} as one, or leave the "
                f"attachment on it, and run this command again.",
            )


def bodies(numbers: Iterable[int]) -> str:
    """In words: body 1; bodies 1 and 2; bodies 2, 3 and 4."""
    *first, last = map(str, sorted(numbers))
    return f"bodies {', '.join(first)} and {last}" if first else f"body {last}"
