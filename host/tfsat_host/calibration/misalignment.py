"""How a gyro sits on its body, and its response, from what it reads of rotations about known axes.

Unknown are the rotation M from sensor to body axes and the gyro's symmetric response S, its scale factors and skews; a
response about the body axis a is S (M^T a). The rotation starts from Wahba's problem (solved by SVD, Markley 1988) and
is then found together with S by Gauss-Newton steps. What no response determines keeps the uncertainty of the design and
of the data sheet. The joints' axes are tilted by what the robot file's `[uncertainty]` says, and so is the axis of a
turn by hand: two of them that a gyro sees askew are so, or the gyro makes it so, or both. These tilts are the same for
all gyros (`GyroCalibration.shared`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.response import TILT_STD_RAD, Response, across
from tfsat_host.calibration.sensors.gyro import (
    MOUNTING,
    MOUNTING_STD_RAD,
    SCALE_STD,
    SHARED,
    SKEW_STD,
    GyroCalibration,
    by_response,
    response_matrix,
)
from tfsat_host.calibration.steps.step import AXES
from tfsat_host.dynamics.multibody import across as directions_across
from tfsat_host.protocol.limits import JOINT_COUNT
from tfsat_host.robot import ASSUMED, RobotModel

LANDING_TILT_STD_RAD = np.deg2rad(1.0)
"""About each axis: so far may a landing have turned a sensor on its body."""
FORGOTTEN_STD_RAD = np.deg2rad(20.0)
"""Of a direction from before a landing, once newer ones determine the mounting: it weighs no more."""
# A scale factor counts as measured once its deviation is below 0.5 %; the data sheet alone leaves 1.7 %.
SCALE_KNOWN = 0.005
# Cosine: a motion within 26 deg of an axis counts as one about it.
_ALONG = 0.9
NO_HINGES = np.zeros((0, 3))
_STEPS = 50
# Largest Gauss-Newton step, rad and parts of one: just above the rounding of double precision.
_CONVERGED = 1e-13


@dataclass(frozen=True, eq=False)
class Misalignment:
    """How one gyro sits, and what it makes of a rate.

    Attributes:
        rotation: (3, 3) from sensor to body axes.
        scale: (3,) reading over truth, sensor axes.
        skew: (3,) see `GyroCalibration`.
        covariance: (9, 9) of a rotation vector in sensor axes (rad), of the scale and of the skew.
        shared: (9, SHARED) see `GyroCalibration`.
        misfit: Sum of squares of what responses and design leave, each in its standard deviations.
        degrees_of_freedom: Of that sum.
    """

    rotation: FloatArray
    scale: FloatArray
    skew: FloatArray
    covariance: FloatArray
    shared: FloatArray
    misfit: float
    degrees_of_freedom: int


def solve_misalignment(
    responses: Sequence[Response],
    nominal: FloatArray,
    hinges: FloatArray = NO_HINGES,
    tilt_std_rad: float = 0.0,
) -> Misalignment:
    """Fit the mounting to responses about any number of axes, with the design as prior.

    Args:
        responses: Of one gyro.
        nominal: (3, 3) from sensor to body axes by design, uncertain by `MOUNTING_STD_RAD` about each axis.
        hinges: (h, 3) axes of the joints, in their order; all motions about one share the same error, its tilt.
        tilt_std_rad: Standard deviation of such a tilt, about each of two directions across the axis.
    """
    # Start from the closed-form attitude; one axis alone leaves the turn about it to the design.
    rotation = wahba(responses) if spans_two_axes(responses) else nominal
    response = np.concatenate([np.ones(3), np.zeros(3)])
    tilts = np.zeros((SHARED // 2, 2))
    prior = _Prior(nominal, hinges, tilt_std_rad)
    for _ in range(_STEPS):
        normal, right, _ = _linearize(responses, rotation, response, tilts, prior)
        # The priors keep the normal matrix regular, whatever the responses leave undetermined.
        step = np.linalg.solve(normal, right)
        # Compose on the right: the error vector lives in sensor axes, as the covariance does.
        rotation = rotation @ Rotation.from_rotvec(step[:3]).as_matrix()
        response = response + step[3:9]
        tilts = tilts + step[9:].reshape(tilts.shape)
        if np.abs(step).max() < _CONVERGED:
            break
    # Linearize once more, so that covariance and misfit belong to the final parameters.
    normal, _, misfit = _linearize(responses, rotation, response, tilts, prior)
    # Every prior row pays for the parameter that it constrains; a direction has two components across it.
    freedom = sum(3 if response.has_length else 2 for response in responses)
    # Cut the tilts out only after inverting: the marginal covariance includes what they leave open.
    covariance = np.asarray(np.linalg.inv(normal))
    # For x - x0 of variance P0 the error of a fit with that prior is its posterior covariance with x, over P0.
    shared = covariance[:9, 9:] / prior.tilt_std
    return Misalignment(rotation, response[:3], response[3:], covariance[:9, :9], shared, misfit, freedom)


def spans_two_axes(responses: Sequence[Response]) -> bool:
    """Return whether the responses determine a rotation."""
    # The second singular value of two unit vectors is 0.1 where they are 8 deg apart.
    axes = np.array([response.axis_body for response in responses])
    return len(axes) >= 2 and bool(np.linalg.svd(axes, compute_uv=False)[1] > 0.1)


def wahba(responses: Sequence[Response]) -> FloatArray:
    """(3, 3) the rotation that turns the readings' directions nearest to the axes."""
    # Attitude profile matrix of unit vectors with equal weights (Markley 1988).
    attitude = sum(np.outer(response.axis_body, response.reading / response.length) for response in responses)
    left_vectors, _, right = np.linalg.svd(attitude)
    # The determinants in the last place force a proper rotation where the matrix is nearer to a reflection.
    return np.asarray(
        left_vectors @ np.diag([1.0, 1.0, np.linalg.det(left_vectors) * np.linalg.det(right)]) @ right
    )


class _Prior(NamedTuple):
    """See `solve_misalignment`."""

    nominal: FloatArray
    hinges: FloatArray
    hinge_tilt_std_rad: float

    @property
    def tilt_std(self) -> FloatArray:
        """(SHARED,) standard deviations of the tilts, rad."""
        # Without a tilt any positive deviation does: no response depends on it, so it stays at zero.
        return np.repeat([self.hinge_tilt_std_rad or 1.0, TILT_STD_RAD], SHARED // 2)

    def tilted_axis(self, response: Response) -> tuple[int, FloatArray] | None:
        """Return which pair of tilts displaces a motion's axis, and the Jacobian (3, 2) of the axis by the two.

        None: the axis is exact.
        """
        tilted_by = response.tilted_by
        by_joint = tilted_by is not None and tilted_by < JOINT_COUNT
        if tilted_by is None or (by_joint and self.hinge_tilt_std_rad == 0.0):
            return None
        # A turn by hand is about a body axis itself.
        axis = self.hinges[tilted_by] if by_joint else np.abs(response.axis_body)
        sense = np.sign(axis @ response.axis_body)
        return tilted_by, sense * np.cross(directions_across(axis), axis).T


def _linearize(
    responses: Sequence[Response],
    rotation: FloatArray,
    scale_skew: FloatArray,
    tilts: FloatArray,
    prior: _Prior,
) -> tuple[FloatArray, FloatArray, float]:
    """Normal matrix (9 + SHARED, square), right side and misfit about rotation, scale and skew (6,), tilts (., 2)."""
    # Rotation vector from the present mounting to the design: the prior's residual, in sensor axes.
    off = Rotation.from_matrix(rotation.T @ prior.nominal).as_rotvec()
    std = np.concatenate([np.repeat([MOUNTING_STD_RAD, SCALE_STD, SKEW_STD], 3), prior.tilt_std])
    left_of_prior = np.concatenate([off, 1.0 - scale_skew[:3], -scale_skew[3:], -tilts.ravel()]) / std
    gain = response_matrix(scale_skew[:3], scale_skew[3:])
    normal, right = np.diag(1.0 / std**2), left_of_prior / std
    misfit = float(left_of_prior @ left_of_prior)
    for response in responses:
        # All motions about one hinge share its tilt, so that repeating them does not average it out.
        tilted = prior.tilted_axis(response)
        axis = response.axis_body if tilted is None else response.axis_body + tilted[1] @ tilts[tilted[0]]
        axis = rotation.T @ axis
        # M exp(d): the axis is then at axis + axis x d.
        jacobian = np.zeros((3, len(std)))
        jacobian[:, :9] = np.hstack([gain @ np.cross(np.eye(3), axis), by_response(axis)])
        if tilted is not None:
            jacobian[:, 9 + 2 * tilted[0] : 11 + 2 * tilted[0]] = gain @ rotation.T @ tilted[1]
        expected = gain @ axis
        # Only a direction was measured: normalize the model, and project its derivative likewise.
        if not response.has_length:
            size = np.linalg.norm(expected)
            expected = expected / size
            jacobian = across(expected) / size @ jacobian
        residual = response.reading - expected
        # A direction's covariance has rank 2: the pseudoinverse gives its length no weight.
        weight = np.linalg.pinv(response.covariance, rcond=1e-9, hermitian=True)
        normal += jacobian.T @ weight @ jacobian
        right += jacobian.T @ weight @ residual
        misfit += float(residual @ weight @ residual)
    return normal, right, misfit


def with_misalignment(
    gyro: GyroCalibration, responses: Sequence[Response], model: RobotModel
) -> GyroCalibration:
    """Fit the gyro's mounting and scale factors to its responses.

    If the responses disagree by more than they should, their covariances are widened by as much (Birge 1932).
    """
    nominal = model.imus[gyro.body - 1].sensor_to_body
    weighed = _weigh_by_age(responses)
    tilt_std_rad = (model.uncertainty or ASSUMED).joint_axis_rad
    mounting_fit = solve_misalignment(weighed, nominal, model.joint_axis, tilt_std_rad)
    # Birge ratio: excess misfit widens all responses alike; a small misfit never narrows them.
    ratio = mounting_fit.misfit / max(1, mounting_fit.degrees_of_freedom)
    if ratio > 1.0:
        weighed = [replace(response, covariance=ratio * response.covariance) for response in weighed]
        mounting_fit = solve_misalignment(weighed, nominal, model.joint_axis, tilt_std_rad)
    covariance, shared = gyro.covariance.copy(), np.zeros_like(gyro.shared)
    covariance[3:, 3:], shared[3:] = mounting_fit.covariance, mounting_fit.shared
    # All directions date from before the last landing, which may have turned the sensor since.
    if responses and not any(response.fresh for response in responses):
        covariance[MOUNTING, MOUNTING] += LANDING_TILT_STD_RAD**2 * np.eye(3)
    changed = replace(
        gyro,
        rotation=mounting_fit.rotation,
        scale=mounting_fit.scale,
        skew=mounting_fit.skew,
        covariance=covariance,
        shared=shared,
    )
    # A direction's age is what a landing ends; the newest response about an axis decides.
    axes: dict[str, datetime] = {}
    scaled: dict[str, datetime] = {}
    for i, axis in enumerate(AXES):
        along = [response for response in responses if abs(response.axis_body[i]) > _ALONG]
        if along:
            axes[axis] = max(response.recorded_at for response in along)
        # Directions alone may seem to determine a scale factor where a sensor sits askew, but only with joints as
        # square as in the robot file.
        lengths = [response for response in along if response.has_length]
        if lengths and changed.scale_about(i)[1] < SCALE_KNOWN:
            scaled[axis] = max(response.recorded_at for response in lengths)
    return replace(changed, axes=axes, scaled=scaled)


def _weigh_by_age(responses: Sequence[Response]) -> list[Response]:
    """Widen the responses from before the last landing by what it may have done to them.

    Without newer responses all are returned unchanged.
    """
    new = [response for response in responses if response.fresh]
    if not new:
        return list(responses)
    # A landing turns a sensor once: as many old directions as there are, they determine no more of it than one.
    old = len(responses) - len(new)
    # Two fresh axes determine the mounting alone; with one, the old ones still fix the turn about it.
    doubt_rad = FORGOTTEN_STD_RAD if spans_two_axes(new) else LANDING_TILT_STD_RAD * old**0.5
    return [response if response.fresh else _add_doubt(response, doubt_rad) for response in responses]


def _add_doubt(response: Response, doubt_rad: float) -> Response:
    # A tilt displaces the response across itself by length times angle; its length is not in doubt.
    doubt = (response.length * doubt_rad) ** 2 * across(response.reading / response.length)
    return replace(response, covariance=response.covariance + doubt)
