"""All responses of one gyro, old and new, and the mounting that they tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.gyros.mounting import Design, solve_mounting, spans_two_axes
from tfsat_host.calibration.gyros.response import Response
from tfsat_host.calibration.sensors.gyro import MOUNTING_STD_RAD, GyroCalibration
from tfsat_host.calibration.steps.step import AXES
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]

LANDING_TILT_STD_RAD = np.deg2rad(1.0)
"""About each axis: so far may a landing have turned a sensor on its body."""
FORGOTTEN_STD_RAD = np.deg2rad(20.0)
"""Of a direction from before a landing, once newer ones tell the mounting: it weighs no more."""
SCALE_KNOWN = 0.005
_ALONG = 0.9


@dataclass(frozen=True, eq=False)
class Seen:
    """A response, when it was recorded, and whether that was after the last landing."""

    response: Response
    taken: datetime
    fresh: bool


def fresh(seen: Sequence[Seen]) -> list[Response]:
    """Of the time since the last landing."""
    return [one.response for one in seen if one.fresh]


def mounted(gyro: GyroCalibration, seen: Sequence[Seen], model: RobotModel) -> GyroCalibration:
    """The gyro with the mounting and the scale factors that its responses tell.

    Where they disagree by more than they should, their covariances are widened by as much (Birge 1932).
    """
    design = Design(model.imus[gyro.body - 1].sensor_to_body, MOUNTING_STD_RAD)
    responses = _weighed(seen)
    found = solve_mounting(responses, design)
    ratio = found.misfit / max(1, found.degrees_of_freedom)
    if ratio > 1.0:
        responses = [replace(one, covariance=ratio * one.covariance) for one in responses]
        found = solve_mounting(responses, design)
    covariance = gyro.covariance.copy()
    covariance[3:, 3:] = found.covariance
    if not fresh(seen) and seen:
        covariance[3:6, 3:6] += LANDING_TILT_STD_RAD**2 * np.eye(3)
    changed = replace(gyro, rotation=found.rotation, scale=found.scale, covariance=covariance)
    return replace(changed, axes=_directions(seen), scaled=_lengths(changed, seen))


def _weighed(seen: Sequence[Seen]) -> list[Response]:
    """The responses; where some are newer than the last landing, the others with what it may have done to them."""
    new = fresh(seen)
    if not new:
        return [one.response for one in seen]
    # A landing turns a sensor once: as many old directions as there are, they tell no more of it than one.
    old = len(seen) - len(new)
    doubt_rad = FORGOTTEN_STD_RAD if spans_two_axes(new) else LANDING_TILT_STD_RAD * old**0.5
    return [one.response if one.fresh else _doubted(one.response, doubt_rad) for one in seen]


def _doubted(response: Response, doubt_rad: float) -> Response:
    length = float(np.linalg.norm(response.reading))
    axis = response.reading / length
    across = (length * doubt_rad) ** 2 * (np.eye(3) - np.outer(axis, axis))
    return replace(response, covariance=response.covariance + across)


def _directions(seen: Sequence[Seen]) -> dict[str, datetime]:
    found: dict[str, list[datetime]] = {
        axis: [one.taken for one in seen if abs(one.response.axis_body[i]) > _ALONG]
        for i, axis in enumerate(AXES)
    }
    return {axis: max(times) for axis, times in found.items() if times}


def _lengths(gyro: GyroCalibration, seen: Sequence[Seen]) -> dict[str, datetime]:
    """Axes whose scale factor is known, by a length that was measured about them.

    Directions alone may seem to tell it where a sensor sits askew, but only if the joints' axes are as square as the
    robot file has them.
    """
    found: dict[str, datetime] = {}
    for i, axis in enumerate(AXES):
        along = [
            one.taken for one in seen if one.response.has_length and abs(one.response.axis_body[i]) > _ALONG
        ]
        if along and gyro.scale_about(i)[1] < SCALE_KNOWN:
            found[axis] = max(along)
    return found
