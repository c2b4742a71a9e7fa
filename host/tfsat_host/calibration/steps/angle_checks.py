"""Whether a joint's two angle sensors answered, followed a motion, and agree."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.errors import CalibrationError

FloatArray = NDArray[np.float64]

MOST_APART_RAD = np.deg2rad(4.0)
"""Between the two sensors of a joint: twice what two poorly adjusted magnets make."""
_SILENT_RAD = np.deg2rad(3.0)


def check_answers(valid: NDArray[np.bool_], joint: int, most_silent: float) -> None:
    """Refuses samples (n, 2) of which more than the share `most_silent` are missing.

    Raises:
        CalibrationError: naming the sensor.
    """
    for index, answered in enumerate(valid.mean(axis=0)):
        if answered < 1.0 - most_silent:
            raise CalibrationError(
                what=f"Angle sensor {index + 1} of joint {joint} gave no value in "
                f"{100 * (1 - answered):.2g} % of the samples.",
                meaning="Without it the joint's angle is not known, now or in the drop.",
                next_step="Check its cable with tfsat-host monitor, and run this command again.",
            )


def check_joint_moved(
    joint: int, travel_rad: FloatArray, least_rad: float, *, carried: bool, turning: bool
) -> None:
    """Refuses where the angle sensors do not show that this joint was moved.

    Args:
        joint: 1 to 3, which was asked for.
        travel_rad: (3, 2) how far each sensor of each joint went.
        least_rad: How far it must go.
        carried: All bodies turned alike.
        turning: At least one body turned.

    Raises:
        CalibrationError: another joint moved, sensors are exchanged or dead, or it moved too little.
    """
    own, both = travel_rad[joint - 1], travel_rad.min(axis=1)
    if own.min() >= least_rad:
        return
    others = [other + 1 for other in range(len(both)) if other != joint - 1 and both[other] > least_rad]
    if others and own.max() < _SILENT_RAD:
        raise _another_joint(joint, others[0], float(both[others[0] - 1]))
    if own.min() < _SILENT_RAD and own.max() > least_rad:
        raise _one_sensor(joint, travel_rad, least_rad)
    if own.max() < _SILENT_RAD and carried:
        raise CalibrationError(
            what=f"All bodies turned as one, and joint {joint} did not move.",
            meaning="The axis of the joint cannot be told from a rotation of the whole robot.",
            next_step=f"Hold one side on the bench, move joint {joint} alone, and run this command again.",
        )
    if own.max() < _SILENT_RAD and turning:
        raise CalibrationError(
            what=f"Neither angle sensor of joint {joint} shows a motion while gyros turn.",
            meaning="Without them neither the sign nor the size of the rotation is known, nor the joint's "
            "angle in the drop.",
            next_step=f"Check their cables and magnets with tfsat-host monitor, move joint {joint}, and run "
            "this command again.",
        )
    raise CalibrationError(
        what=f"Joint {joint} moved by {np.rad2deg(own.min()):.0f} deg; at least {np.rad2deg(least_rad):.0f} "
        f"are needed.",
        meaning="The axis could not be told from noise.",
        next_step=f"Move joint {joint} farther, through its whole range if you can, and run this command again.",
    )


def _another_joint(joint: int, other: int, travel_rad: float) -> CalibrationError:
    return CalibrationError(
        what=f"Joint {other} was moved by {np.rad2deg(travel_rad):.0f} deg, not joint {joint}.",
        meaning="The axis of another joint would have been taken for this one's. "
        "Where the right joint was moved, the angle sensors of the two are exchanged.",
        next_step=f"Move joint {joint}, or put the angle sensors' cables right, and run this command again.",
    )


def _one_sensor(joint: int, travel_rad: FloatArray, least_rad: float) -> CalibrationError:
    """One of the joint's own does not move: dead, or its cable is another joint's."""
    silent = int(np.argmin(travel_rad[joint - 1])) + 1
    for other, of_other in enumerate(travel_rad, 1):
        if other != joint and of_other.max() > least_rad and of_other.min() < _SILENT_RAD:
            stray = int(np.argmax(of_other)) + 1
            return CalibrationError(
                what=f"Angle sensor {silent} of joint {joint} and angle sensor {stray} of joint {other} look "
                f"exchanged: the one shows no motion, the other moves.",
                meaning="Both joints' angles would be wrong in the drop.",
                next_step="Exchange their cables, take the zero points again (tfsat-host calibrate zero --all "
                "--anew), and run this command again.",
            )
    return CalibrationError(
        what=f"Angle sensor {silent} of joint {joint} shows no motion while the other one moves.",
        meaning="It is dead, or its magnet is loose; the joint's angle in the drop would be wrong.",
        next_step="Check its cable and its magnet with tfsat-host monitor, and run this command again.",
    )


def check_sensors_agree(joint: int, by_each_rad: FloatArray) -> None:
    """Refuses what two sensors (n, 2), counted from the joint's zero or from the recording's start, do not share.

    Raises:
        CalibrationError: one slips, or counts the other way.
    """
    apart = by_each_rad[:, 0] - by_each_rad[:, 1]
    apart = apart - 2 * np.pi * np.round(apart[0] / (2 * np.pi))
    worst = float(np.abs(apart).max())
    if worst <= MOST_APART_RAD:
        return
    first, second = np.ptp(by_each_rad, axis=0)
    opposed = np.corrcoef(by_each_rad[:, 0], by_each_rad[:, 1])[0, 1] < -0.9 and worst > 0.5 * (
        first + second
    )
    if opposed:
        raise CalibrationError(
            what=f"The two angle sensors of joint {joint} go opposite ways: one counts the other way than the "
            f"robot file says.",
            meaning="Their mean would not be the joint's angle.",
            next_step="Move the joint and look at both with tfsat-host monitor; correct the direction of the "
            "wrong one in the robot file, give that with --robot, and run this command again.",
        )
    raise CalibrationError(
        what=f"The two angle sensors of joint {joint} disagree by up to {np.rad2deg(worst):.1f} deg "
        f"over the motion.",
        meaning="One of them slips on the axis, or sits off its centre; it may slip again in the drop.",
        next_step="Look at both with tfsat-host monitor while the joint moves; fasten the one that lags, take "
        f"its zero again (tfsat-host calibrate zero --joint {joint} --anew), and run this command again.",
    )
