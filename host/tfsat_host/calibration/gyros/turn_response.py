"""Responses to turns of the whole robot by hand: for the axis about which no joint turns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.calibration.gyros.mounting_checks import angle_between, mounted_otherwise
from tfsat_host.calibration.gyros.response import Response, direction, length_between_rests, with_length
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.steps.recording import Recording
from tfsat_host.calibration.steps.rests import TURN_SHARE, find_rests
from tfsat_host.calibration.steps.step import AXES, Step

FloatArray = NDArray[np.float64]

TILT_STD_RAD = np.deg2rad(0.2)
"""How far a body's axis may be from the one about which it is turned on a table, about each of two axes."""
MOST_OFF_RAD = np.deg2rad(20.0)
"""A sensor that is mounted by hand, on a robot that is laid by hand."""
PLACING_STD_RAD = np.deg2rad(0.1)
"""How straight a person lays an edge of 100 mm on: to 0.2 mm."""
ANGLE_TOLERANCE = 0.1
"""A turn that is off by more than this share (gyros are wrong by 0.03) was another one than the screen says."""
_LEAST_SWEEPS = 5


def turn_response(recording: Recording, step: Step, gyro: GyroCalibration) -> Response:
    """How one gyro answers to turns through a known angle, there and back.

    Raises:
        CalibrationError: too few turns, or they were by another angle or the other way round.
    """
    if step.axis is None:
        raise ValueError("a turn has an axis")
    axis = np.eye(3)[AXES.index(step.axis)]
    readings = recording.rate_rad_s[:, gyro.body - 1] - gyro.bias_rad_s
    expected = gyro.readings(axis)
    seen = direction(readings, axis, readings @ expected)
    along = readings @ seen.reading
    rests = find_rests(recording.t_s, along, TURN_SHARE)
    if len(rests) <= _LEAST_SWEEPS:
        raise CalibrationError(
            what=f"The robot was turned {max(0, len(rests) - 1)} times; at least {_LEAST_SWEEPS} turns "
            f"are needed.",
            meaning="Their scatter is what tells how sure the scale factor is.",
            next_step="Turn it there and back three times, resting a second at each end, and run this "
            "command again.",
        )
    angles = _angles(recording.t_s, along, rests, step)
    length, std = length_between_rests(recording.t_s, along, rests, angles, PLACING_STD_RAD)
    tilted = seen.covariance + TILT_STD_RAD**2 * (np.eye(3) - np.outer(seen.reading, seen.reading))
    return with_length(Response(axis, seen.reading, tilted, False), length, std)


def check_turn_axis(recording: Recording, step: Step, gyros: Sequence[GyroCalibration]) -> None:
    """Refuses a turn about another axis, and a gyro that alone sees one.

    Raises:
        CalibrationError: the robot was laid wrongly, or a sensor is mounted otherwise than the robot file says.
    """
    if step.axis is None:
        raise ValueError("a turn has an axis")
    axis = np.eye(3)[AXES.index(step.axis)]
    readings = [recording.rate_rad_s[:, gyro.body - 1] - gyro.bias_rad_s for gyro in gyros]
    expected = [gyro.readings(axis) for gyro in gyros]
    along = np.array([one @ each for one, each in zip(readings, expected, strict=True)])
    together = np.median(along, axis=0)
    seen = [direction(one, axis, together).reading for one in readings]
    off = [angle_between(one, each) for one, each in zip(seen, expected, strict=True)]
    wrong = [number for number, angle in enumerate(off) if angle > MOST_OFF_RAD]
    if len(wrong) > len(gyros) // 2:
        raise CalibrationError(
            what=f"The robot was turned about another axis, {np.rad2deg(np.median(off)):.0f} deg from {step.axis}.",
            meaning="The scale factor of another axis would have been taken for this one's.",
            next_step=f"Close all joints, lay the robot so that its {step.axis} axis is upright, and run "
            f"this command again.",
        )
    if wrong:
        first = wrong[0]
        raise mounted_otherwise(gyros[first].body, axis, seen[first], expected[first])


def _angles(t_s: FloatArray, along: FloatArray, rests: list[slice], step: Step) -> FloatArray:
    """(k,) the known angle at each rest: there and back in turn."""
    known = np.deg2rad(step.angle_deg) * (np.arange(len(rests)) % 2)
    steps = 0.5 * (along[1:] + along[:-1]) * np.diff(t_s)
    turned = np.concatenate([[0.0], np.cumsum(steps)])
    legs = np.diff([turned[rest].mean() for rest in rests])
    asked = np.diff(known)
    wrong = np.abs(legs / asked - 1.0)
    if wrong.max() > ANGLE_TOLERANCE:
        first = int(np.argmax(wrong > ANGLE_TOLERANCE))
        raise CalibrationError(
            what=f"Turn {first + 1} was one of {np.rad2deg(legs[first]):+.0f} deg, not of "
            f"{np.rad2deg(asked[first]):+.0f} deg.",
            meaning="The scale factor would be wrong by as much.",
            next_step=f"Turn it by {step.angle_deg:g} deg, counter-clockwise as seen against the "
            f"{step.axis} axis, then back, "
            "from edge to edge, and run this command again.",
        )
    return np.asarray(known)
