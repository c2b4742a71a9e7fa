"""Amplitude spectra: of sines that are known, and of the momentum of emulated drops."""

from __future__ import annotations

import numpy as np
import pytest

from tests.evaluation.drops import few_of, fit_drop
from tests.fixtures.emulated_drop import DLPF_5_HZ, DLPF_42_HZ
from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.com_fit.momentum_residual import inertial_momentum
from tfsat_host.evaluation.spectra import (
    WINDOWS,
    Window,
    amplitude_spectrum,
    compare_spectra,
    evenly,
    leakage,
)

RATE_HZ = 280.0


def times(n: int) -> FloatArray:
    return 0.03 + np.arange(n) / RATE_HZ


def sine(t_s: FloatArray, line: float, amplitude: float = 1.0) -> FloatArray:
    """Return a sine with `line` periods in all samples."""
    return np.asarray(amplitude * np.sin(2.0 * np.pi * line * (t_s - t_s[0]) * RATE_HZ / len(t_s) + 0.3))


@pytest.mark.parametrize("window", WINDOWS)
@pytest.mark.parametrize("n", [700, 701])
def test_a_sine_shows_its_amplitude(window: Window, n: int) -> None:
    t = times(n)
    values = np.column_stack([sine(t, 12, 0.7) + 5.0, sine(t, 80, 2.0) - 1.5])
    spectrum = amplitude_spectrum(t, values, window)
    assert spectrum.frequency_hz[12] == pytest.approx(12 * RATE_HZ / n)
    assert spectrum.amplitude[12, 0] == pytest.approx(0.7)
    assert spectrum.amplitude[80, 1] == pytest.approx(2.0)
    assert spectrum.amplitude[0] == pytest.approx([5.0, 1.5])
    others = np.abs(np.arange(len(spectrum.frequency_hz)) - 12) > 1
    others[0] = False
    assert spectrum.amplitude[others, 0].max() < 1e-9
    assert np.linalg.norm(spectrum.amplitude[80]) == pytest.approx(np.hypot(2.0, spectrum.amplitude[80, 0]))


def test_half_the_sampling_rate_shows_its_amplitude_too() -> None:
    t = times(700)
    spectrum = amplitude_spectrum(t, np.tile([0.4, -0.4], 350)[:, None])
    assert spectrum.frequency_hz[-1] == pytest.approx(140.0)
    assert spectrum.amplitude[-1, 0] == pytest.approx(0.4)
    assert spectrum.band_rms(140.0)[0] == pytest.approx(0.4)


@pytest.mark.parametrize("n", [640, 641])
def test_the_whole_band_has_the_standard_deviation(n: int) -> None:
    values = np.random.default_rng(0).standard_normal((n, 3)) + 7.0
    spectrum = amplitude_spectrum(times(n), values)
    np.testing.assert_allclose(spectrum.band_rms(200.0), values.std(axis=0))


@pytest.mark.parametrize("window", WINDOWS)
def test_a_band_holds_the_sines_that_are_in_it(window: Window) -> None:
    t = times(700)  # lines 0.4 Hz apart
    before = np.column_stack([sine(t, 5, 2.0) + sine(t, 40, 9.0), sine(t, 7, 1.0)])
    after = np.column_stack([sine(t, 5, 0.2) + sine(t, 40, 9.0), 3.0 + 0.0 * t])
    comparison = compare_spectra(t, before, after, window=window)
    assert comparison.rms_before == pytest.approx(np.sqrt(2.0**2 / 2 + 1.0 / 2))
    assert comparison.rms_after == pytest.approx(0.2 / np.sqrt(2.0))
    assert comparison.left == pytest.approx(0.2 / np.sqrt(5.0))


@pytest.mark.parametrize("window", WINDOWS)
def test_white_noise_has_the_same_band_in_every_window(window: Window) -> None:
    values = np.random.default_rng(1).standard_normal((50_000, 1))
    spectrum = amplitude_spectrum(times(50_000), values, window)
    assert spectrum.band_rms(70.0)[0] == pytest.approx(np.sqrt(0.5), rel=0.02)


@pytest.mark.parametrize("window", WINDOWS)
def test_leakage_says_what_a_sine_between_two_lines_shows(window: Window) -> None:
    t = times(700)
    distance, share = leakage(t, window, 20.0)
    spectrum = amplitude_spectrum(t, sine(t, 100.5)[:, None], window)
    off_hz = np.abs(spectrum.frequency_hz - 100.5 * RATE_HZ / 700)
    near = off_hz < 20.0
    predicted = np.interp(off_hz[near], distance, share)
    np.testing.assert_allclose(spectrum.amplitude[near, 0], predicted, atol=5e-3)
    assert spectrum.amplitude.max() == pytest.approx(
        {"rectangular": 2 / np.pi, "Hann": 8 / (3 * np.pi)}[window], abs=5e-3
    )


def test_hanns_window_leaks_less_farther_off() -> None:
    t = times(700)
    shares = {window: leakage(t, window, 140.0) for window in WINDOWS}
    distance = shares["Hann"][0]
    assert [share[0] for _, share in shares.values()] == pytest.approx([1.0, 1.0])
    far = distance > 5.0
    assert shares["Hann"][1][far].max() < 0.02 * shares["rectangular"][1][far].max()
    # First zeros: one step of the spectrum, and two.
    zeros = [float(distance[np.argmax(share < 1e-9)]) for _, share in shares.values()]
    assert zeros == pytest.approx([0.4, 0.8])


def test_uneven_times_and_holes_are_carried_to_an_even_grid() -> None:
    random = np.random.default_rng(2)
    t = np.delete(times(700) + random.uniform(-1e-3, 1e-3, 700), [50, 51, 300])
    grid, _ = evenly(t, np.zeros((697, 1)))
    assert len(grid) == pytest.approx(700, abs=8)
    assert np.ptp(np.diff(grid)) < 1e-12
    assert (grid[0], grid[-1]) == pytest.approx((t[0], t[-1]))
    wave = 0.5 * np.sin(2.0 * np.pi * 4.0 * t)[:, None]
    spectrum = amplitude_spectrum(t, wave, "Hann")
    assert spectrum.amplitude[np.abs(spectrum.frequency_hz - 4.0).argmin(), 0] == pytest.approx(0.5, rel=0.01)


@pytest.mark.parametrize("frequency_hz", [5.0, 60.0])
def test_straight_lines_take_what_they_are_said_to_take(frequency_hz: float) -> None:
    steps = np.arange(28_000)
    # The samples drift to and fro by 20 periods, so that the grid's points lie everywhere between them.
    t = (steps + 20.0 * np.sin(2.0 * np.pi * steps / 27_999)) / RATE_HZ
    spectrum = amplitude_spectrum(t, np.sin(2.0 * np.pi * frequency_hz * t)[:, None])
    amplitude = spectrum.amplitude[np.abs(spectrum.frequency_hz - frequency_hz).argmin(), 0]
    assert amplitude == pytest.approx(np.sinc(frequency_hz / RATE_HZ) ** 2, abs=0.01)


@pytest.mark.parametrize(
    ("t_s", "values", "match"),
    [
        (np.arange(3.0), np.zeros((3, 1)), "four samples"),
        (np.array([0.0, 1.0, 1.0, 2.0]), np.zeros((4, 1)), "later"),
        (np.arange(4.0), np.array([[0.0], [np.nan], [0.0], [0.0]]), "finite"),
    ],
)
def test_what_has_no_spectrum_is_refused(t_s: FloatArray, values: FloatArray, match: str) -> None:
    with pytest.raises(ValueError, match=match):
        amplitude_spectrum(t_s, values)


@pytest.mark.parametrize("window", WINDOWS)
@pytest.mark.parametrize("dlpf_cfg", few_of(DLPF_42_HZ, DLPF_5_HZ))
def test_the_correction_takes_the_momentum_below_the_cutoff(window: Window, dlpf_cfg: int) -> None:
    for seed in (1, 2, 3):
        fitted_drop = fit_drop(seed, dlpf_cfg)
        before, after = (
            inertial_momentum(fitted_drop.fit.offsets.correct(values), fitted_drop.flown)
            for values in (np.zeros(9), fitted_drop.fit.values)
        )
        comparison = compare_spectra(fitted_drop.flown.t_s, before, after, window=window)
        assert comparison.cutoff_hz == 5.0
        assert comparison.left < 0.05
        assert comparison.before.window == comparison.after.window == window
