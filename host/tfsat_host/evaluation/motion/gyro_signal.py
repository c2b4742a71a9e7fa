"""Two things that a gyro adds to the rate: noise, and the lag of its low-pass."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import solve_banded
from scipy.signal import savgol_filter

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.evaluation.motion.samples import Blocks

BLOCK_S = 0.1
"""Longer than any low-pass remembers: means over blocks are as independent as those of white noise."""
_DENSITY_BLOCK_S = 0.25
"""Of a density: means over 0.1 s of what the 5 Hz low-pass lets through scatter by a sixth less than white noise's."""
MIN_BLOCKS = 10
AGE_SHARE = 0.6
"""Ages of successive readings run through the chip's output period, so in an integral they cancel in part: over a
servo's ramp of a dozen samples, the chip's clock free, this share of what independent ages would do is left."""
SHEET_DENSITY_RAD_S_RTHZ = np.deg2rad(0.005)
"""One-sided (PS-MPU-6000A rev. 3.4, section 6.1)."""


MIN_DENSITY_RAD_S_RTHZ = 0.1 * SHEET_DENSITY_RAD_S_RTHZ
"""Of readings that stand still: their steps hide a noise that is smaller than they are."""


def noise_densities(t_s: FloatArray, rate_rad_s: FloatArray) -> FloatArray:
    """(4,) one-sided noise density of each gyro, rad/s/sqrt(Hz), from a rest; the data sheet's without one.

    By the differences of means over neighbouring blocks, so that a robot that sways slowly on its magnet does not
    count: the median tells, so that a knock does not either. The mean over T of white noise of density N has the
    variance N^2 / 2T.

    Args:
        t_s: (n,) samples of a rest.
        rate_rad_s: (n, 4, 3); NaN where a gyro did not answer.
    """
    means = Blocks.of(t_s - t_s[:1], _DENSITY_BLOCK_S).mean(rate_rad_s)
    # Two-sample variance: half the squared difference of neighbouring means, as in an Allan variance.
    squares = (np.diff(means, axis=0) / np.sqrt(2.0)) ** 2
    return np.array([_density(squares[:, gyro]) for gyro in range(rate_rad_s.shape[1])])


def _density(squares: FloatArray) -> float:
    """Estimate a gyro's noise density from (blocks, 3) single estimates of a block mean's variance.

    They are NaN where the gyro did not answer.
    """
    finite_squares = squares[np.isfinite(squares)]
    # Too short a rest, or readings that never change: neither shows the noise.
    if len(finite_squares) < 3 * MIN_BLOCKS or not finite_squares.any():
        return float(SHEET_DENSITY_RAD_S_RTHZ)
    # The median of a squared normal deviate is 0.4549 of its variance.
    density = float(np.sqrt(2.0 * _DENSITY_BLOCK_S * np.median(finite_squares) / 0.4549))
    return max(density, MIN_DENSITY_RAD_S_RTHZ)  # type: ignore[no-any-return]


def sample_covariance(
    densities: FloatArray, t_s: FloatArray, rate_rad_s: FloatArray, rate_hz: float, low_pass: LowPass
) -> FloatArray:
    """(n, 4, 3, 3) of a gyro's sample, as white noise of the same effect would have it, (rad/s)^2.

    The noise itself, and that of the reading's age: a reading is between nothing and one output period of the chip old,
    which matters while the rate changes. All axes of a gyro have the same age.

    Args:
        densities: (4,) one-sided.
        t_s: (n,).
        rate_rad_s: (n, 4, 3), no NaN.
        rate_hz: Sampling rate.
        low_pass: Of the gyros.
    """
    # Ages are spread evenly over the output period: a twelfth of its square.
    age_variance = (AGE_SHARE * low_pass.output_period_s) ** 2 / 12.0
    change = derivative(t_s, rate_rad_s)
    # A one-sided density N makes the variance N^2 f_s / 2 in a sample.
    white = 0.5 * rate_hz * densities[:, None, None] ** 2 * np.eye(3)
    # One age for three axes: the outer product of the rate's change.
    return np.asarray(white + age_variance * change[..., None] * change[..., None, :])


DELAY_STD_S = 1e-3
"""How far a chip may be from its sheet, and a reading from its time stamp: before anything is measured."""
READ_APART_STD_S = 0.3e-3
"""Of each gyro: IMUs are read one after the other."""
PLAUSIBLE_STDS = 3.0
"""A delay farther from the data sheet's, by what chips may differ, is none: the data sheet's is taken off instead."""
FINE_S = 0.5e-3
"""Steps in which rates are passed through the low-pass: finer than any of its settings but the widest."""
_MIN_TIME_CONSTANT_S = 1e-6
_HOLE_STEPS = 3.0
"""Across so many sampling periods two samples tell no slope."""
MIN_STROKE_RAD = np.deg2rad(10.0)
"""A joint that moved less tells nothing of the delay."""


@dataclass(frozen=True, slots=True)
class Lag:
    """The first moments of the gyros' response.

    Attributes:
        delay_s: d, from the motion to the time stamp of the reading.
        delay_std_s: Its standard deviation.
        second_s2: Second moment e of the low-pass: with y the integral of its output, the angle is y + d y' + e y''.
        expected_s: d by the data sheet.
        measured: By the strokes; else it is the data sheet's.
        implausible_s: What the strokes gave that no chip can be; the data sheet's is used instead. None: nothing such.
    """

    delay_s: float
    delay_std_s: float
    second_s2: float
    expected_s: float
    measured: bool
    implausible_s: float | None = None

    def remove(self, t_s: FloatArray, signal: FloatArray) -> FloatArray:
        """(n, ...) what was to be shown at each time, of what was shown."""
        # Invert the low-pass by the first two terms of its Taylor series.
        first = derivative(t_s, signal)
        return np.asarray(signal + self.delay_s * first + self.second_s2 * derivative(t_s, first))

    def apply(self, t_s: FloatArray, exact: FloatArray) -> FloatArray:
        """(n, k) what the gyros show of rates (n, k): one pole and a pure delay with these moments.

        With the time constant T and the delay D, d = T + D and e = (d^2 - T^2) / 2.
        """
        # A delay that a fit found below zero is no low-pass: all of it is then a shift.
        constant_s = min(float(np.sqrt(max(self.delay_s**2 - 2.0 * self.second_s2, 0.0))), self.delay_s)
        # The pole's exponent divides by it: never quite zero.
        constant_s = max(constant_s, _MIN_TIME_CONSTANT_S)
        # Cubics carry the samples onto a grid that is fine enough for the pole.
        fine_s = np.arange(t_s[0], t_s[-1] + FINE_S, FINE_S)
        fine = CubicSpline(t_s, exact)(np.minimum(fine_s, t_s[-1]))
        filtered = _one_pole(fine, constant_s / FINE_S)
        # What the time constant leaves of the delay is a pure shift.
        late_s = t_s - (self.delay_s - constant_s)
        return np.column_stack([np.interp(late_s, fine_s, column) for column in filtered.T])


def _one_pole(signals: FloatArray, constant: float) -> FloatArray:
    """(n, k) of signals that are linear between two samples; the time constant is in samples. It begins settled."""
    # First-order hold: exact for an input that is linear between its samples.
    pole = np.exp(-1.0 / constant)
    mean = (1.0 - pole) * constant
    driven = np.concatenate([signals[:1], (1.0 - mean) * signals[1:] + (mean - pole) * signals[:-1]])
    # y[n] - pole y[n - 1] = driven[n], all rows at once.
    rows = np.stack([np.ones(len(signals)), np.full(len(signals), -pole)])
    return np.asarray(solve_banded((1, 0), rows, driven))


SMOOTHED_SAMPLES = 11
"""A servo's ramp is a dozen; 25 flatten it at 42 Hz."""


def smooth_rates(rates: FloatArray) -> FloatArray:
    """(n, ...) rates for derivatives by errors and offsets: cubics through neighbours.

    With a sample's own noise in them, that noise times itself would be taken for information, and pull what is fitted.
    """
    # An odd window, as the filter needs, and no longer than the record.
    window = min(SMOOTHED_SAMPLES, len(rates) - 1 + len(rates) % 2)
    return np.asarray(savgol_filter(rates, window, 3, axis=0) if window > 3 else rates)


def sheet_lag(low_pass: LowPass) -> Lag:
    """Return the data sheet's lag; its second moment e is that of two equal poles."""
    # On average a reading is half an output period old when it is read.
    delay_s = low_pass.gyro_delay_s + 0.5 * low_pass.output_period_s
    return Lag(delay_s, DELAY_STD_S, 0.25 * delay_s**2, delay_s, measured=False)


def derivative(t_s: FloatArray, values: FloatArray) -> FloatArray:
    """(n, ...) by the parabola through each three neighbours; none of them across a hole."""
    steps = np.diff(t_s)
    # Split at holes, and differentiate each part alone: a slope across a hole is none.
    holes = np.flatnonzero(steps > _HOLE_STEPS * np.median(steps)) + 1
    parts = [np.arange(first, last) for first, last in pairwise([0, *holes.tolist(), len(t_s)])]
    return np.concatenate(
        [
            np.gradient(values[part], t_s[part], axis=0) if len(part) > 1 else np.zeros_like(values[part])
            for part in parts
        ]
    )
