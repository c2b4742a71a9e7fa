"""How a gyro sits on its body, and its scale factors: from its responses to rotations about known axes.

Unknown are the rotation M from sensor to body axes and the scale factors s; a response about the body axis a is
s * (M^T a). The rotation starts from Wahba's problem (solved by SVD, Markley 1988) and is then found together with
the scale factors by Gauss-Newton steps. A scale that no response tells keeps the datasheet's tolerance as its
uncertainty.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tfsat_host.calibration.gyros.response import Response
from tfsat_host.calibration.sensors.gyro import SCALE_STD

FloatArray = NDArray[np.float64]

_STEPS = 50
_CONVERGED = 1e-13
_AXES = "xyz"


@dataclass(frozen=True, eq=False)
class Mounting:
    """How one gyro sits, and what it makes of a rate.

    Attributes:
        rotation: (3, 3) from sensor to body axes.
        scale: (3,) reading over truth, sensor axes.
        covariance: (6, 6) of a rotation vector in sensor axes (rad), then of the scale.
        misfit: Sum of squares of what the responses leave, each in its standard deviations.
        degrees_of_freedom: How many numbers that sum has more than the parameters that they determine.
    """

    rotation: FloatArray
    scale: FloatArray
    covariance: FloatArray
    misfit: float
    degrees_of_freedom: int


@dataclass(frozen=True, eq=False)
class Design:
    """How a gyro is meant to sit: what holds where nothing was measured.

    Attributes:
        rotation: (3, 3) from sensor to body axes.
        std_rad: Standard deviation of the true mounting about each axis.
    """

    rotation: FloatArray
    std_rad: float


def solve_mounting(responses: Sequence[Response], design: Design | None = None) -> Mounting:
    """The mounting that fits responses about different body axes.

    Args:
        responses: About two or three axes; with `design` about any number of them.
        design: Also weighs in, so that what no response tells keeps the design's uncertainty.

    Raises:
        ValueError: without a design, responses about a single axis: the rotation about it stays unknown.
    """
    if spans_two_axes(responses):
        rotation = wahba(responses)
    elif design is not None:
        rotation = design.rotation
    else:
        raise ValueError("a mounting needs responses about two different axes")
    scale = np.ones(3)
    for _ in range(_STEPS):
        normal, right, _ = _linearized(responses, rotation, scale, design)
        step = np.linalg.solve(normal, right)
        rotation = rotation @ Rotation.from_rotvec(step[:3]).as_matrix()
        scale = scale + step[3:]
        if np.abs(step).max() < _CONVERGED:
            break
    normal, _, misfit = _linearized(responses, rotation, scale, design)
    numbers = sum(3 if response.has_length else 2 for response in responses)
    known = 3 if design is None else 6
    return Mounting(
        rotation, scale, np.asarray(np.linalg.inv(normal), dtype=np.float64), misfit, numbers + known - 6
    )


def spans_two_axes(responses: Sequence[Response]) -> bool:
    """Whether the responses determine a rotation."""
    axes = np.array([response.axis_body for response in responses])
    return len(axes) >= 2 and bool(np.linalg.svd(axes, compute_uv=False)[1] > 0.1)


def wahba(responses: Sequence[Response]) -> FloatArray:
    """The rotation that turns the readings' directions nearest to the axes."""
    attitude = sum(
        np.outer(response.axis_body, response.reading / np.linalg.norm(response.reading))
        for response in responses
    )
    left, _, right = np.linalg.svd(attitude)
    return np.asarray(left @ np.diag([1.0, 1.0, np.linalg.det(left) * np.linalg.det(right)]) @ right)


def _linearized(
    responses: Sequence[Response], rotation: FloatArray, scale: FloatArray, design: Design | None
) -> tuple[FloatArray, FloatArray, float]:
    """Normal matrix (6, 6), right side (6,) and misfit about a rotation and scale factors."""
    normal, right = np.zeros((6, 6)), np.zeros(6)
    normal[3:, 3:] = np.eye(3) / SCALE_STD**2
    right[3:] = (1.0 - scale) / SCALE_STD**2
    misfit = float(((1.0 - scale) / SCALE_STD) @ ((1.0 - scale) / SCALE_STD))
    if design is not None:
        off = Rotation.from_matrix(rotation.T @ design.rotation).as_rotvec() / design.std_rad
        normal[:3, :3] += np.eye(3) / design.std_rad**2
        right[:3] += off / design.std_rad
        misfit += float(off @ off)
    for response in responses:
        seen = rotation.T @ response.axis_body
        # M exp(d): the axis is then seen at seen + seen x d.
        turn = np.array([[0.0, -seen[2], seen[1]], [seen[2], 0.0, -seen[0]], [-seen[1], seen[0], 0.0]])
        jacobian = np.hstack([scale[:, None] * turn, np.diag(seen)])
        expected = scale * seen
        if not response.has_length:
            size = np.linalg.norm(expected)
            direction = expected / size
            across = (np.eye(3) - np.outer(direction, direction)) / size
            jacobian, expected = across @ jacobian, direction
        left = response.reading - expected
        weight = np.linalg.pinv(response.covariance, rcond=1e-9, hermitian=True)
        normal += jacobian.T @ weight @ jacobian
        right += jacobian.T @ weight @ left
        misfit += float(left @ weight @ left)
    return normal, right, misfit


def described(rotation: FloatArray, nominal: FloatArray) -> str:
    """How a sensor is mounted against its design, in words; empty where it is mounted as designed.

    Args:
        rotation: (3, 3) from sensor to body axes, as measured.
        nominal: (3, 3) the same by design.
    """
    between = nominal.T @ rotation  # from true sensor axes to those of the design
    best = max(_right_angles(), key=lambda turn: float(np.trace(turn.T @ between)))
    if np.array_equal(best, np.eye(3)):
        return ""
    shown = ["", "", ""]
    for column in range(3):
        row = int(np.argmax(np.abs(best[:, column])))
        shown[column] = ("-" if best[row, column] < 0 else "") + _AXES[row]
    moved = [axis for axis in range(3) if shown[axis].lstrip("-") != _AXES[axis]]
    if len(moved) == 2:
        first, second = (_AXES[axis] for axis in moved)
        return f"looks mounted with {first} and {second} exchanged (its x, y, z lie along {', '.join(shown)})"
    return f"looks turned: its x, y, z lie along {', '.join(shown)} of where they should"


@cache
def _right_angles() -> tuple[FloatArray, ...]:
    """The 24 rotations that lead axes to axes."""
    return tuple(np.rint(turn) for turn in Rotation.create_group("O").as_matrix())
