"""The figures against scipy, and standard errors against the spread of many studies."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from tfsat_host.plan.spread import rank_correlation, share, spread, variance_shares


def test_ranks_are_spearman_s_ties_included() -> None:
    rng = np.random.default_rng(0)
    deviates = rng.normal(size=(300, 2))
    output = np.round(np.exp(deviates[:, 0]) + 0.3 * rng.normal(size=300), 1)
    coefficients = [stats.spearmanr(output, column).statistic for column in deviates.T]
    np.testing.assert_allclose(rank_correlation(output, deviates), coefficients, atol=1e-12)


def test_shares_of_a_sum_are_those_of_its_terms() -> None:
    deviates = np.random.default_rng(1).normal(size=(200_000, 2))
    output = 3.0 * deviates[:, 0] + 4.0 * deviates[:, 1] + 7.0
    np.testing.assert_allclose(variance_shares(output, deviates), [0.36, 0.64], atol=0.01)


def test_standard_errors_are_the_spread_of_many_studies() -> None:
    draws = np.random.default_rng(2).gamma(4.0, size=(2000, 400))
    spreads = [spread(row) for row in draws]
    for estimates in (
        [s.mean for s in spreads],
        [s.std for s in spreads],
        [s.percentiles[84.0] for s in spreads],
    ):
        empirical_std = np.std([estimate.value for estimate in estimates])
        mean_standard_error = np.mean([estimate.standard_error for estimate in estimates])
        assert mean_standard_error == pytest.approx(empirical_std, rel=0.1)


def test_percentiles_are_numpy_s() -> None:
    values = np.random.default_rng(3).normal(size=1001)
    percentiles = spread(values).percentiles
    np.testing.assert_allclose(
        [e.value for e in percentiles.values()], np.percentile(values, list(percentiles))
    )


def test_no_hit_at_all_is_no_certainty() -> None:
    estimate = share(np.zeros(100, dtype=bool))
    assert estimate.value == 0.0
    assert 0.005 < estimate.standard_error < 0.02
