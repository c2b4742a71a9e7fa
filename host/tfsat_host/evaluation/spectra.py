"""Amplitude spectra before and after a correction, as the paper shows them, and what their window does to them.

A spectrum needs an even grid; samples are carried there by straight lines between them, which take about
(pi f / f_s)^2 / 3 of an amplitude at f: 0.1 % at 5 Hz and 280 Hz, 14 % at 60 Hz.

Normalisation: a sine of amplitude a whose frequency is one of the grid's shows a, whatever the window. Between two of
the grid's frequencies it shows less, 0.64 a at worst with the rectangular window and 0.85 a with Hann's. The mean is
taken off first and stands, by its magnitude, at 0 Hz.

The paper's spectra have the rectangular window: they are of all samples as they are. What does not end where it began,
such as an attitude error that grew, then leaks into all frequencies as 1/f; Hann's window leaks as 1/f^3 and has a main
lobe twice as wide (F. J. Harris, On the use of windows for harmonic analysis with the discrete Fourier transform,
Proc. IEEE 66, 1978).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.signal import get_window

from tfsat_host.arrays import FloatArray

Window = Literal["rectangular", "Hann"]

WINDOWS: tuple[Window, ...] = ("rectangular", "Hann")
PAPER_CUTOFF_HZ = 5.0
_FINER = 16


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Amplitudes of d components.

    Attributes:
        frequency_hz: (k,) from 0 on, 1 / duration apart.
        amplitude: (k, d) in the values' unit.
        window: That was used.
        noise_bandwidth: Of the window, in steps of the frequency: 1 for the rectangular one, 1.5 for Hann's.
        even: The number of samples was even, so that the last frequency is half the sampling rate.
    """

    frequency_hz: FloatArray
    amplitude: FloatArray
    window: Window
    noise_bandwidth: float
    even: bool

    def band_rms(self, until_hz: float) -> FloatArray:
        """(d,) root mean square of what varies up to `until_hz`; the mean is not in it.

        With the rectangular window exact: over all frequencies it is the standard deviation (Parseval).
        """
        inside = (self.frequency_hz > 0.0) & (self.frequency_hz <= until_hz)
        # A sine of amplitude a has the mean square a^2 / 2; the Nyquist line alternates and has all of a^2.
        power = 0.5 * self.amplitude**2
        if self.even:
            power[-1] = self.amplitude[-1] ** 2
        return np.asarray(np.sqrt(power[inside].sum(axis=0) / self.noise_bandwidth))


@dataclass(frozen=True, eq=False)
class ComparedSpectra:
    """Spectra of the same quantity before and after a correction.

    Attributes:
        before: Spectrum.
        after: Spectrum.
        cutoff_hz: Up to here the two are compared.
        rms_before: Root mean square up to the cutoff, of all components together, without the mean.
        rms_after: The same after.
    """

    before: Spectrum
    after: Spectrum
    cutoff_hz: float
    rms_before: float
    rms_after: float

    @property
    def left(self) -> float:
        """Share that is left; NaN if there was nothing."""
        return self.rms_after / self.rms_before if self.rms_before > 0.0 else float("nan")


def evenly(t_s: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(n,) even times from the first sample to the last, at the usual sampling rate, and (n, d) values there.

    Args:
        t_s: (m,) ascending; samples may be missing.
        values: (m, d), no NaN.

    Raises:
        ValueError: there are fewer than four samples, their times do not ascend, or a value is not finite.
    """
    if len(t_s) < 4 or not (np.diff(t_s) > 0.0).all():
        raise ValueError("a spectrum needs four samples or more, each later than the one before")
    if not np.isfinite(values).all():
        raise ValueError("a spectrum needs finite values")
    # The median step is the sampling period even where samples are missing.
    steps = round(float((t_s[-1] - t_s[0]) / np.median(np.diff(t_s))))
    grid = np.linspace(t_s[0], t_s[-1], steps + 1)
    return grid, np.column_stack([np.interp(grid, t_s, column) for column in values.T])


def amplitude_spectrum(t_s: FloatArray, values: FloatArray, window: Window = "rectangular") -> Spectrum:
    """Compute the amplitude spectrum of samples (m, d) at uneven times (m,). Raises ValueError as `evenly`."""
    grid, even_values = evenly(t_s, values)
    n = len(grid)
    weights = _weights(n, window)
    # Take the mean off first: behind a window it would leak into the lowest lines.
    mean = even_values.mean(axis=0)
    raw = np.abs(np.fft.rfft((even_values - mean) * weights[:, None], axis=0))
    # Over the coherent gain, and twice: half of a real sine lies at its negative frequency.
    amplitude = 2.0 * raw / weights.sum()
    # The Nyquist line is its own mirror image: it must not be doubled.
    if n % 2 == 0:
        amplitude[-1] /= 2.0
    amplitude[0] = np.abs(mean)
    frequency = np.fft.rfftfreq(n, (grid[-1] - grid[0]) / (n - 1))
    # Equivalent noise bandwidth in lines, by which powers in a band are too great (Harris 1978).
    bandwidth = n * float((weights**2).sum()) / float(weights.sum()) ** 2
    return Spectrum(frequency, amplitude, window, bandwidth, n % 2 == 0)


def leakage(t_s: FloatArray, window: Window, until_hz: float) -> tuple[FloatArray, FloatArray]:
    """Compute the spectral leakage of a pure sine by the distance from its frequency.

    Args:
        t_s: (m,) of the samples.
        window: The spectrum's.
        until_hz: Greatest distance.

    Returns:
        (k,) distances from 0 on, Hz, sixteen to each step of the spectrum; (k,) share of the sine's amplitude.
    """
    grid, _ = evenly(t_s, np.zeros((len(t_s), 1)))
    n = len(grid)
    weights = _weights(n, window)
    # Zero padding samples the window's transform between the spectrum's lines.
    shares = np.abs(np.fft.rfft(weights, _FINER * n)) / weights.sum()
    distance = np.fft.rfftfreq(_FINER * n, (grid[-1] - grid[0]) / (n - 1))
    near = distance <= until_hz
    return distance[near], shares[near]


def compare_spectra(
    t_s: FloatArray,
    before: FloatArray,
    after: FloatArray,
    *,
    window: Window = "rectangular",
) -> ComparedSpectra:
    """Compare two spectra of momentum, rate error or attitude error (m, d). Raises ValueError as `evenly`."""
    first, second = (amplitude_spectrum(t_s, values, window) for values in (before, after))
    rms = [float(np.linalg.norm(spectrum.band_rms(PAPER_CUTOFF_HZ))) for spectrum in (first, second)]
    return ComparedSpectra(first, second, PAPER_CUTOFF_HZ, rms[0], rms[1])


def _weights(n: int, window: Window) -> FloatArray:
    """(n,) periodic, as the spectrum's grid is: Hann's then has exactly three lines a sine."""
    return np.asarray(get_window("boxcar" if window == "rectangular" else "hann", n))
