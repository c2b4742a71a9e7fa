"""What the gyros read, made fit for derivatives: holes bridged by straight lines, and where not to believe that."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.evaluation.motion.samples import Samples

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_NEIGHBOURS = 2
"""Taking off the lag needs so many on either side."""


@dataclass(frozen=True, eq=False)
class Readings:
    """Of all gyros at n samples.

    Attributes:
        gyros: As calibrated.
        reading_rad_s: (n, 4, 3) sensor axes, late by their low-pass, without NaN.
        usable: (n, 4) its neighbours are there as well; at least one gyro at every sample.
    """

    gyros: tuple[GyroCalibration, ...]
    reading_rad_s: FloatArray
    usable: BoolArray

    @classmethod
    def of(cls, samples: Samples, gyros: Sequence[GyroCalibration]) -> Readings:
        """Of one drop, calibrated with `gyros`."""
        own = [g.readings(samples.rate_rad_s[:, b]) + g.bias_rad_s for b, g in enumerate(gyros)]
        bridged = _bridged_over(samples.t_s, np.stack(own, axis=1))
        return cls(tuple(gyros), bridged, _away_from_holes(samples.answered))

    def with_errors(self, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(n, 4, 3) rates in body axes if the gyros' parameters are off by (4, 9), and (n, 4, 3, 9) by those."""
        right = [gyro.corrected(off) for gyro, off in zip(self.gyros, parameters, strict=True)]
        rates = [gyro.body_rates(self.reading_rad_s[:, b]) for b, gyro in enumerate(right)]
        by = [gyro.jacobian(self.reading_rad_s[:, b]) for b, gyro in enumerate(right)]
        return np.stack(rates, axis=1), np.stack(by, axis=1)


def _bridged_over(t_s: FloatArray, readings: FloatArray) -> FloatArray:
    """Without NaN, by straight lines in time, so that neighbours of a lost sample still have a derivative."""
    filled = readings.copy()
    for index in np.ndindex(readings.shape[1:]):
        column = readings[(slice(None), *index)]
        known = np.isfinite(column)
        filled[(slice(None), *index)] = np.interp(t_s, t_s[known], column[known]) if known.any() else 0.0
    return filled


def _away_from_holes(answered: BoolArray) -> BoolArray:
    near = ~answered
    for shift in range(1, _NEIGHBOURS + 1):
        near[shift:] |= ~answered[:-shift]
        near[:-shift] |= ~answered[shift:]
    nobody = np.logical_and.reduce(near, axis=1)
    return np.where(nobody[:, None], answered, ~near)
