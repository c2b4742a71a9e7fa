"""How a gyro answers to a rotation about an axis of its body that is known: a joint's, or one turned by hand.

A gyro with scale factors s (one for each of its axes) that is mounted by the rotation M (from sensor to body axes)
reads s * (M^T a) for unit rate about the body axis a. This vector, measured about two or three axes, is all that
`mounting` needs. Its direction comes from every sample of some swings; its length needs the angle that was turned, from
rest to rest, because the sensor's low-pass shortens and delays whatever swings.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.statistics import few

FloatArray = NDArray[np.float64]

_BATCHES = 10
EXPERIENCE = 4


@dataclass(frozen=True, eq=False)
class Response:
    """The reading of one gyro for unit rate about a known axis.

    Attributes:
        axis_body: (3,) unit vector in body axes; the rotation is positive about it.
        reading: (3,) in sensor axes; of length 1 where the length was not measured.
        covariance: (3, 3) of the reading; without `has_length` across it alone.
        has_length: Whether the length is measured, too.
    """

    axis_body: FloatArray
    reading: FloatArray
    covariance: FloatArray
    has_length: bool


def direction(rate_rad_s: FloatArray, axis_body: FloatArray, along_rad_s: FloatArray) -> Response:
    """The direction alone, from swings.

    The first right singular vector of the rates is the line nearest to them in the sense of total least squares. What
    crosses it is noise and the sway of the body that was held, both correlated in time: the scatter of the directions
    of a tenth of the motion each gives the covariance. A tenth of the samples would not do: one in which the body
    rests, before it is swung or after, points anywhere.

    Args:
        rate_rad_s: (n, 3) rates in sensor axes, free of bias.
        axis_body: (3,) unit vector, body axes.
        along_rad_s: (n,) the rate about it by another sensor, rough: its sign is used alone.
    """
    line = _line(rate_rad_s)
    sign = np.sign((rate_rad_s @ line) @ along_rad_s) or 1.0
    axis = sign * line
    done = np.cumsum((rate_rad_s**2).sum(axis=1))
    ends = np.searchsorted(done, done[-1] * np.arange(1, _BATCHES) / _BATCHES)
    lines = np.array([_line(part) for part in np.split(rate_rad_s, ends) if len(part)])
    lines *= np.sign(lines @ axis)[:, None]
    return Response(
        axis_body, axis, _across(axis, few(_BATCHES - 1) * np.cov(lines, rowvar=False) / _BATCHES), False
    )


def with_length(response: Response, length: float, std: float) -> Response:
    """The same direction with the length that was measured and its standard deviation."""
    axis = response.reading / np.linalg.norm(response.reading)
    covariance = length**2 * response.covariance + std**2 * np.outer(axis, axis)
    return Response(response.axis_body, length * axis, covariance, True)


def length_between_rests(
    t_s: FloatArray,
    along_rad_s: FloatArray,
    rests: list[slice],
    angles_rad: FloatArray,
    expected_rad: float = 0.0,
) -> tuple[float, float]:
    """The integral of a rate for each radian that was turned, from rest to rest, and its standard deviation.

    Each sweep lies between two rests. The rests tell the bias that is left, too. What is off at one rest, such as an
    edge that was not laid on quite straight, is taken as independent of the other rests.

    Args:
        t_s: (n,) times.
        along_rad_s: (n,) the gyro's rate along its own direction, bias taken off.
        rests: k + 1 stretches in which nothing moved, in order of time.
        angles_rad: (k + 1,) as known, in each rest.
        expected_rad: Standard deviation of an angle, as experience has it; counts as much as EXPERIENCE rests, for
            the scatter of a few rests is small by chance now and then. 0: none.

    Raises:
        ValueError: there are fewer than five sweeps: their scatter would say nothing.
    """
    if len(rests) < 6:
        raise ValueError(f"{len(rests) - 1} sweeps are too few: five at least")
    steps = 0.5 * (along_rad_s[1:] + along_rad_s[:-1]) * np.diff(t_s)
    turned = np.concatenate([[0.0], np.cumsum(steps)])
    means = np.array([turned[rest].mean() for rest in rests])
    times = np.array([t_s[rest].mean() for rest in rests])
    columns = np.column_stack([angles_rad, times - times.mean(), np.ones(len(rests))])
    solution, *_ = np.linalg.lstsq(columns, means, rcond=None)
    left = means - columns @ solution
    freedom = len(left) - 3
    squares = float(left @ left)
    if expected_rad > 0.0:
        freedom += EXPERIENCE
        squares += EXPERIENCE * (float(solution[0]) * expected_rad) ** 2
    covariance = few(freedom) * squares / freedom * np.linalg.inv(columns.T @ columns)
    return float(solution[0]), float(np.sqrt(covariance[0, 0]))


def _line(rate_rad_s: FloatArray) -> FloatArray:
    _, _, rows = np.linalg.svd(rate_rad_s, full_matrices=False)
    return np.asarray(rows[0])


def _across(axis: FloatArray, covariance: FloatArray) -> FloatArray:
    project = np.eye(3) - np.outer(axis, axis)
    return np.asarray(project @ covariance @ project)
