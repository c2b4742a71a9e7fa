"""How late the gyros are, measured against the angle sensors, which have no low-pass; and taken off.

A gyro shows a rate through its low-pass. For motions slower than that, all a filter does is in the first moments of its
response: with the delay d and the second moment m of the impulse response, what was turned until now is

    q(t) = y(t) + d y'(t) + e y''(t),    e = d^2 - m / 2

where y is the integral of what the gyro shows. A pure delay has e = d^2 / 2, two equal poles d^2 / 4, a single pole 0.
The part's sheet gives the delay only (`protocol.imus`); the strokes give both to some 10 us, because
two sensors tell each joint's angle at once and two gyros tell it late (see `sensor_fusion`). What is so measured holds
for all gyros: they have one setting, and what parts differ by is taken off before (`LowPass`).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.linalg import solve_banded

from tfsat_host.calibration.steps.low_pass import LowPass

FloatArray = NDArray[np.float64]

DELAY_STD_S = 1e-3
"""How far a chip may be from its sheet, and a reading from its time stamp: before anything is measured."""
PLAUSIBLE_STDS = 3.0
"""A delay farther from the data sheet's, by what chips may differ, is none: the data sheet's is taken off instead."""
FINE_S = 0.5e-3
"""Steps in which rates are passed through the low-pass: finer than any of its settings but the widest."""
_HOLE_STEPS = 3.0
"""Across so many sampling periods two samples tell no slope."""
LEAST_STROKE_RAD = np.deg2rad(10.0)
"""A joint that moved less tells nothing of the delay."""


@dataclass(frozen=True, slots=True)
class Lag:
    """The first moments of the gyros' response.

    Attributes:
        delay_s: d, from the motion to the time stamp of the reading.
        delay_std_s: Its standard deviation.
        second_s2: e, see the module.
        expected_s: d by the data sheet.
        measured: Strokes have told it; else it is the data sheet's.
        implausible_s: What strokes told that no chip can be; the data sheet's is used instead. None: nothing such.
    """

    delay_s: float
    delay_std_s: float
    second_s2: float
    expected_s: float
    measured: bool
    implausible_s: float | None = None

    def removed(self, t_s: FloatArray, shown: FloatArray) -> FloatArray:
        """(n, ...) what was to be shown at each time, of what was shown."""
        first = derivative(t_s, shown)
        return np.asarray(shown + self.delay_s * first + self.second_s2 * derivative(t_s, first))

    def applied(self, t_s: FloatArray, exact: FloatArray) -> FloatArray:
        """(n, k) what the gyros show of rates (n, k): one pole and a pure delay with these moments.

        With the time constant T and the delay D, d = T + D and e = (d^2 - T^2) / 2.
        """
        constant_s = min(float(np.sqrt(max(self.delay_s**2 - 2.0 * self.second_s2, 1e-12))), self.delay_s)
        fine_s = np.arange(t_s[0], t_s[-1] + FINE_S, FINE_S)
        fine = CubicSpline(t_s, exact)(np.minimum(fine_s, t_s[-1]))
        filtered = _one_pole(fine, constant_s / FINE_S)
        late_s = t_s - (self.delay_s - constant_s)
        return np.column_stack([np.interp(late_s, fine_s, column) for column in filtered.T])


def _one_pole(shown: FloatArray, constant: float) -> FloatArray:
    """(n, k) of signals that are linear between two samples; the time constant is in samples. It begins settled."""
    pole = np.exp(-1.0 / constant)
    mean = (1.0 - pole) * constant
    driven = np.concatenate([shown[:1], (1.0 - mean) * shown[1:] + (mean - pole) * shown[:-1]])
    # y[n] - pole y[n - 1] = driven[n], all rows at once.
    rows = np.stack([np.ones(len(shown)), np.full(len(shown), -pole)])
    return np.asarray(solve_banded((1, 0), rows, driven))


def sheet_lag(low_pass: LowPass) -> Lag:
    """By the data sheet; e that of two equal poles."""
    delay_s = low_pass.gyro_delay_s + 0.5 * low_pass.output_period_s
    return Lag(delay_s, DELAY_STD_S, 0.25 * delay_s**2, delay_s, measured=False)


def derivative(t_s: FloatArray, values: FloatArray) -> FloatArray:
    """(n, ...) by the parabola through each three neighbours; none of them across a hole."""
    steps = np.diff(t_s)
    holes = np.flatnonzero(steps > _HOLE_STEPS * np.median(steps)) + 1
    parts = [np.arange(first, last) for first, last in pairwise([0, *holes.tolist(), len(t_s)])]
    return np.concatenate(
        [
            np.gradient(values[part], t_s[part], axis=0) if len(part) > 1 else np.zeros_like(values[part])
            for part in parts
        ]
    )
