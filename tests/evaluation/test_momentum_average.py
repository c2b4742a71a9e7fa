"""The paper's moving average and its objective: by hand, at uneven times, and on emulated drops."""

from __future__ import annotations

import numpy as np
import pytest

from tests.evaluation.drops import few_of, fit_drop
from tests.fixtures.emulated_drop import DLPF_5_HZ, DLPF_42_HZ
from tfsat_host.evaluation.com_fit.momentum_average import (
    PAPER_SIZE,
    averaged_momentum,
    cutoff_hz,
    moving_average,
)

RATE_HZ = 280.0


def test_the_papers_window_has_the_papers_cutoff() -> None:
    assert PAPER_SIZE == 25
    assert cutoff_hz(25, RATE_HZ) == pytest.approx(5.0, abs=0.05)


def test_on_an_even_grid_it_is_the_mean_of_so_many_samples() -> None:
    random = np.random.default_rng(0)
    t = 0.03 + np.arange(200) / RATE_HZ
    values = random.standard_normal((2, 200, 3))
    average = moving_average(t, values, 25)
    windows = np.lib.stride_tricks.sliding_window_view(values, 25, axis=1)
    assert (average.size, len(average.t_s)) == (25, 176)
    np.testing.assert_allclose(average.t_s, t[12:-12])
    np.testing.assert_allclose(average.values, windows.mean(axis=-1), atol=1e-12)
    assert average.cutoff_hz == pytest.approx(cutoff_hz(25, RATE_HZ))


def test_at_uneven_times_it_averages_over_time_not_over_samples() -> None:
    random = np.random.default_rng(1)
    t = (np.arange(700) + random.uniform(-0.4, 0.4, 700)) / RATE_HZ
    t = np.delete(t, np.arange(300, 308))  # and a hole
    wave = np.sin(2.0 * np.pi * 4.0 * t)[:, None]
    average = moving_average(t, wave, 25)
    damped = np.sinc(4.0 * average.width_s) * np.sin(2.0 * np.pi * 4.0 * average.t_s)
    off = np.abs(average.values[:, 0] - damped)
    by_count = np.convolve(wave[:, 0], np.full(25, 1 / 25), mode="valid")
    by_count_off = np.abs(by_count - np.sinc(4.0 * average.width_s) * wave[12:-12, 0])
    assert off.max() < 0.03
    assert off.max() < 0.3 * by_count_off.max()


def test_only_whole_windows_count() -> None:
    random = np.random.default_rng(2)
    t = np.sort(random.uniform(0.0, 1.0, 280))
    average = moving_average(t, np.ones((280, 1)), 25)
    period = float(np.median(np.diff(t)))
    assert average.width_s == 25 * period
    assert average.t_s[0] >= t[0] + 12 * period - 1e-9
    assert average.t_s[-1] <= t[-1] - 12 * period + 1e-9
    np.testing.assert_allclose(average.values, 1.0, atol=1e-12)


def test_a_window_that_lacks_many_of_its_samples_has_no_average() -> None:
    t = np.delete(np.arange(300) / RATE_HZ, np.arange(140, 160))
    average = moving_average(t, np.ones((280, 1)), 25)
    near = average.t_s * RATE_HZ
    # Of 25 samples around number 133 six are lost, around number 134 seven.
    assert near[near < 150].max() == pytest.approx(133)
    assert near[near > 150].min() == pytest.approx(166)


@pytest.mark.parametrize(("samples", "size"), [(10, 11), (10, 0), (1, 1)])
def test_too_few_samples_are_refused(samples: int, size: int) -> None:
    with pytest.raises(ValueError, match="samples"):
        moving_average(np.arange(samples) / RATE_HZ, np.ones((samples, 3)), size)


def test_frequencies_and_sizes_without_sense_are_refused() -> None:
    with pytest.raises(ValueError, match="one sample or more"):
        cutoff_hz(0, RATE_HZ)


def test_the_objective_is_the_papers_sum() -> None:
    t = np.arange(4) / RATE_HZ
    average = moving_average(
        t, np.array([[1.0, 0.0, 0.0], [1.0, 3.0, 4.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]), 1
    )
    np.testing.assert_allclose(average.strayed, [0.0, 5.0, 0.0, 1.0], atol=1e-12)
    assert average.objective == pytest.approx(6.0)


@pytest.mark.parametrize("dlpf_cfg", few_of(DLPF_42_HZ, DLPF_5_HZ))
def test_the_true_robots_momentum_stays(dlpf_cfg: int) -> None:
    for seed in (1, 2, 3):
        fitted_drop = fit_drop(seed, dlpf_cfg)
        vectors = np.stack([np.zeros(9), fitted_drop.fit.values, fitted_drop.drop.true_com_offsets_mm])
        before, fit, truth = averaged_momentum(
            fitted_drop.fit.offsets.apply(vectors), fitted_drop.flown
        ).objective
        assert truth < 0.05 * before
        assert fit < 0.05 * before
