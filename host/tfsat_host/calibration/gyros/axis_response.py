"""Directions from swings and sweeps: the joint's axis as each moved gyro sees it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.gyros.response import Response, direction
from tfsat_host.calibration.steps.view import MotionView

FloatArray = NDArray[np.float64]


def axis_response(view: MotionView, body: int) -> Response:
    """How the gyro of a moved body (1 to 4) answers to a rotation about the joint; its direction alone.

    Its covariance holds how the parts of the recording scatter, how well the joints in between are known, and what a
    held body's gyro that is not calibrated itself leaves of that body's motion.
    """
    readings = view.readings(body)
    joint_rate = np.gradient(view.angle_rad[:, view.pattern.joint - 1], view.recording.t_s)
    seen = direction(readings, view.axis(body), view.sense(body) * joint_rate)
    gyro = view.gyros[body - 1]
    to_reading = gyro.scale[:, None] * gyro.rotation.T
    covariance = seen.covariance + to_reading @ view.axis_covariance(body) @ to_reading.T
    covariance += _left_of_held(view, readings) ** 2 * np.eye(3)
    across = np.eye(3) - np.outer(seen.reading, seen.reading)
    return Response(seen.axis_body, seen.reading, across @ covariance @ across, False)


def _left_of_held(view: MotionView, readings: FloatArray) -> float:
    """Share of the moved body's motion that the held one's may still make, for its mounting is not exact."""
    held = view.gyros[view.held - 1]
    rates = held.body_rates(view.recording.rate_rad_s[:, view.held - 1])
    share = float(np.sqrt((rates**2).sum() / (readings**2).sum()))
    return share * float(np.sqrt(np.trace(held.covariance[3:6, 3:6]) / 3.0))
