"""Covariances taken apart into independent errors."""

from __future__ import annotations

import numpy as np
import pytest

from tfsat_host.calibration.statistics import root_of


@pytest.mark.parametrize("rank", [0, 1, 4, 6])
def test_a_root_times_itself_is_the_covariance_singular_or_not(rank: int) -> None:
    errors = np.random.default_rng(rank).standard_normal((6, rank)) * 1e-3
    covariance = errors @ errors.T
    root = root_of(covariance)
    assert root.shape == (6, 6)
    assert root @ root.T == pytest.approx(covariance, abs=1e-18)
    assert np.isfinite(root).all()
