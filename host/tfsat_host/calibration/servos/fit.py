"""From visits to a servo map: weighted least squares, with what repeated visits and the places' bends add.

A visit's angle is a straight line in the pulse, less half the backlash in the direction of the motion, plus the
servo's scatter from arrival to arrival, plus the sensors' error. Scatter comes from visits to the same pulse from the
same side; what the places' means deviate from the line beyond that is the servo's bend. Both variances are
estimated by moments (Searle, Casella, McCulloch, "Variance Components", chapter 5).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtri

from tfsat_host.calibration.servos.checks import (
    check_fit,
    check_following,
    check_number,
    check_range,
)
from tfsat_host.calibration.servos.points import ServoPoint
from tfsat_host.calibration.servos.servo_map import ServoMap
from tfsat_host.calibration.statistics import few
from tfsat_host.protocol.messages import ServoSetting

FloatArray = NDArray[np.float64]

LEAST_STD_RAD: Final = np.deg2rad(0.001)
"""No sensor is better; visits without an error of their own would have no weight."""
CHANCE: Final = 0.9999
"""Of a straight servo, about so many measurements are not called bent."""


def fit_servo_map(points: Sequence[ServoPoint], joint: int, setting: ServoSetting) -> ServoMap:
    """The servo map that fits the visits best.

    Args:
        points: In any order. Visits with an unknown direction (0) are left out.
        joint: 1 to 3.
        setting: Of that joint, in force on the board while it was measured.

    Raises:
        CalibrationError: too few visits, too small a range, or the servo is dead, reversed, slipping or bent.
    """
    known = [point for point in points if point.direction]
    pulse_us = np.array([point.pulse_us for point in known])
    direction = np.array([point.direction for point in known], dtype=np.float64)
    reached_rad = np.array([point.reached_rad for point in known])
    variance = np.maximum([point.std_rad for point in known], LEAST_STD_RAD) ** 2
    place, side = _places(pulse_us), _places(np.column_stack([pulse_us, direction]))
    repeats = side.shape[1] - side.shape[0]
    check_number(joint, place.shape[0], repeats, direction)
    check_range(joint, pulse_us, setting)
    check_following(joint, pulse_us, reached_rad, setting)

    arrival = _arrival_variance(side, reached_rad, variance, repeats)
    middle_us = float((pulse_us.min() + pulse_us.max()) / 2)
    design = np.column_stack([np.ones(len(known)), pulse_us - middle_us, -direction / 2])
    line = _least_squares(design, reached_rad, variance + arrival, place, repeats)
    by_chance = float(fdtri(place.shape[0] - 2, repeats, CHANCE))
    check_fit(joint, np.sqrt(arrival), np.sqrt(line.bend), certain=line.excess > by_chance)
    return ServoMap(
        joint=joint,
        middle_us=middle_us,
        middle_rad=float(line.estimate[0]),
        slope_rad_per_us=float(line.estimate[1]),
        backlash_rad=float(line.estimate[2]),
        covariance=line.covariance,
        repeatability_rad=float(np.sqrt(arrival)),
        repeats=repeats,
        nonlinearity_rad=float(np.sqrt(line.bend)),
        places=place.shape[0],
        pulse_range_us=(float(pulse_us.min()), float(pulse_us.max())),
        setting=setting,
    )


def _places(keys: FloatArray) -> FloatArray:
    """(groups, n): 1 where a visit belongs to the group of those with an equal key."""
    if len(keys) == 0:
        return np.zeros((0, 0))
    groups, index = np.unique(keys, axis=0, return_inverse=True)
    return np.asarray(np.arange(len(groups))[:, None] == index.reshape(1, -1), dtype=np.float64)


def _arrival_variance(side: FloatArray, reached_rad: FloatArray, variance: FloatArray, repeats: int) -> float:
    """Of one arrival, without the sensors' part."""
    visits = side.sum(axis=1)
    left = reached_rad - side.T @ (side @ reached_rad / visits)
    of_sensors = variance @ (1.0 - side.T @ (1.0 / visits))
    return float(max((left @ left - of_sensors) / repeats, 0.0))


@dataclass(frozen=True, eq=False)
class _Line:
    """The line through the visits.

    Attributes:
        estimate: (3,) middle, slope and backlash.
        covariance: (3, 3) of it, with what scatter and bends do to it.
        bend: Variance of the places' bends.
        excess: The places' squared deviations from the line, over what scatter alone would make of them.
    """

    estimate: FloatArray
    covariance: FloatArray
    bend: float
    excess: float


def _least_squares(
    design: FloatArray, reached_rad: FloatArray, variance: FloatArray, place: FloatArray, repeats: int
) -> _Line:
    inverse = np.linalg.inv((design.T / variance) @ design)
    gain = inverse @ (design.T / variance)
    estimate = gain @ reached_rad
    means = place / place.sum(axis=1, keepdims=True)
    left = means @ (reached_rad - design @ estimate)
    # What scatter alone would leave of the means, and what a bend of unit variance would.
    of_scatter = np.trace(means @ (np.diag(variance) - design @ inverse @ design.T) @ means.T)
    of_bends = np.sum((means @ (place.T - design @ gain @ place.T)) ** 2)
    bend = float(max((left @ left - of_scatter) / of_bends, 0.0))
    excess = float(left @ left / of_scatter)
    of_places = gain @ place.T
    covariance = few(repeats) * inverse + few(len(place) - 2) * bend * of_places @ of_places.T
    return _Line(estimate, covariance, bend, excess)
