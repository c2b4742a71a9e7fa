"""How a gyro sits on its body, and its scale factors: from its responses to rotations about known axes.

Unknown are the rotation M from sensor to body axes and the scale factors s; a response about the body axis a is
s * (M^T a). The rotation starts from Wahba's problem (solved by SVD, Markley 1988) and is then found together with
the scale factors by Gauss-Newton steps. What no response tells keeps the uncertainty of the design and of the data
sheet.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.response import Response, across
from tfsat_host.calibration.sensors.gyro import MOUNTING_STD_RAD, SCALE_STD, GyroCalibration
from tfsat_host.calibration.steps.step import AXES
from tfsat_host.robot import RobotModel

LANDING_TILT_STD_RAD = np.deg2rad(1.0)
"""About each axis: so far may a landing have turned a sensor on its body."""
FORGOTTEN_STD_RAD = np.deg2rad(20.0)
"""Of a direction from before a landing, once newer ones tell the mounting: it weighs no more."""
SCALE_KNOWN = 0.005
_ALONG = 0.9
_STEPS = 50
_CONVERGED = 1e-13


@dataclass(frozen=True, eq=False)
class Mounting:
    """How one gyro sits, and what it makes of a rate.

    Attributes:
        rotation: (3, 3) from sensor to body axes.
        scale: (3,) reading over truth, sensor axes.
        covariance: (6, 6) of a rotation vector in sensor axes (rad), then of the scale.
        misfit: Sum of squares of what responses and design leave, each in its standard deviations.
        degrees_of_freedom: Of that sum.
    """

    rotation: FloatArray
    scale: FloatArray
    covariance: FloatArray
    misfit: float
    degrees_of_freedom: int


def solve_mounting(responses: Sequence[Response], nominal: FloatArray) -> Mounting:
    """The mounting that fits responses about any number of axes best, and the design.

    Args:
        responses: Of one gyro.
        nominal: (3, 3) from sensor to body axes by design, `MOUNTING_STD_RAD` off about each axis.
    """
    rotation = wahba(responses) if spans_two_axes(responses) else nominal
    scale = np.ones(3)
    for _ in range(_STEPS):
        normal, right, _ = _linearized(responses, rotation, scale, nominal)
        step = np.linalg.solve(normal, right)
        rotation = rotation @ Rotation.from_rotvec(step[:3]).as_matrix()
        scale = scale + step[3:]
        if np.abs(step).max() < _CONVERGED:
            break
    normal, _, misfit = _linearized(responses, rotation, scale, nominal)
    freedom = sum(3 if response.has_length else 2 for response in responses)
    return Mounting(rotation, scale, np.asarray(np.linalg.inv(normal)), misfit, freedom)


def spans_two_axes(responses: Sequence[Response]) -> bool:
    """Whether the responses determine a rotation."""
    axes = np.array([response.axis_body for response in responses])
    return len(axes) >= 2 and bool(np.linalg.svd(axes, compute_uv=False)[1] > 0.1)


def wahba(responses: Sequence[Response]) -> FloatArray:
    """(3, 3) the rotation that turns the readings' directions nearest to the axes."""
    attitude = sum(np.outer(response.axis_body, response.reading / response.length) for response in responses)
    left, _, right = np.linalg.svd(attitude)
    return np.asarray(left @ np.diag([1.0, 1.0, np.linalg.det(left) * np.linalg.det(right)]) @ right)


def _linearized(
    responses: Sequence[Response], rotation: FloatArray, scale: FloatArray, nominal: FloatArray
) -> tuple[FloatArray, FloatArray, float]:
    """Normal matrix (6, 6), right side (6,) and misfit about a rotation and scale factors."""
    off = Rotation.from_matrix(rotation.T @ nominal).as_rotvec()
    prior = np.concatenate([off / MOUNTING_STD_RAD, (1.0 - scale) / SCALE_STD])
    std = np.repeat([MOUNTING_STD_RAD, SCALE_STD], 3)
    normal, right, misfit = np.diag(1.0 / std**2), prior / std, float(prior @ prior)
    for response in responses:
        axis = rotation.T @ response.axis_body
        # M exp(d): the axis is then at axis + axis x d.
        jacobian = np.hstack([scale[:, None] * np.cross(np.eye(3), axis), np.diag(axis)])
        expected = scale * axis
        if not response.has_length:
            size = np.linalg.norm(expected)
            expected = expected / size
            jacobian = across(expected) / size @ jacobian
        left = response.reading - expected
        weight = np.linalg.pinv(response.covariance, rcond=1e-9, hermitian=True)
        normal += jacobian.T @ weight @ jacobian
        right += jacobian.T @ weight @ left
        misfit += float(left @ weight @ left)
    return normal, right, misfit


def with_mounting(gyro: GyroCalibration, responses: Sequence[Response], model: RobotModel) -> GyroCalibration:
    """The gyro with the mounting and the scale factors that its responses tell.

    Where they disagree by more than they should, their covariances are widened by as much (Birge 1932).
    """
    nominal = model.imus[gyro.body - 1].sensor_to_body
    weighed = _weighed(responses)
    found = solve_mounting(weighed, nominal)
    ratio = found.misfit / max(1, found.degrees_of_freedom)
    if ratio > 1.0:
        weighed = [replace(one, covariance=ratio * one.covariance) for one in weighed]
        found = solve_mounting(weighed, nominal)
    covariance = gyro.covariance.copy()
    covariance[3:, 3:] = found.covariance
    if responses and not any(one.fresh for one in responses):
        covariance[3:6, 3:6] += LANDING_TILT_STD_RAD**2 * np.eye(3)
    changed = replace(gyro, rotation=found.rotation, scale=found.scale, covariance=covariance)
    along: dict[str, list[Response]] = {
        axis: [one for one in responses if abs(one.axis_body[i]) > _ALONG] for i, axis in enumerate(AXES)
    }
    # Directions alone may seem to tell a scale factor where a sensor sits askew, but only if the joints' axes are as
    # square as the robot file has them.
    lengths = {
        axis: [one for one in along[axis] if one.has_length]
        for i, axis in enumerate(AXES)
        if changed.scale_about(i)[1] < SCALE_KNOWN
    }
    axes, scaled = (
        {axis: max(one.taken for one in found) for axis, found in times.items() if found}
        for times in (along, lengths)
    )
    return replace(changed, axes=axes, scaled=scaled)


def _weighed(responses: Sequence[Response]) -> list[Response]:
    """The responses; where some are newer than the last landing, the others with what it may have done to them."""
    new = [one for one in responses if one.fresh]
    if not new:
        return list(responses)
    # A landing turns a sensor once: as many old directions as there are, they tell no more of it than one.
    old = len(responses) - len(new)
    doubt_rad = FORGOTTEN_STD_RAD if spans_two_axes(new) else LANDING_TILT_STD_RAD * old**0.5
    return [one if one.fresh else _doubted(one, doubt_rad) for one in responses]


def _doubted(response: Response, doubt_rad: float) -> Response:
    doubt = (response.length * doubt_rad) ** 2 * across(response.reading / response.length)
    return replace(response, covariance=response.covariance + doubt)
