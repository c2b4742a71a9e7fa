"""What trades against what: against fits in which it is really known, and with scale factors that are not."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.evaluation.fitted_drops import MODEL, fitted
from tfsat_host.evaluation.model_fit.fit import ModelFit, fit_model
from tfsat_host.evaluation.model_fit.offsets import com_offsets
from tfsat_host.evaluation.model_fit.trades import trades, with_scale_std
from tfsat_host.evaluation.model_fit.unexplained import Flown

BODY_1_Z, BODY_2_Z = 2, 5
SENSORS = {"gyro bias", "gyro mounting", "gyro scale", "joint angles"}


@cache
def with_inertias() -> ModelFit:
    return fit_model(com_offsets(MODEL, masses=True, inertias=True), fitted(1).flown)


def exact(flown: Flown, *, gyros: bool, angles: bool) -> Flown:
    """The drop as if the calibration had no errors in it."""
    return replace(
        flown,
        gyro_root=flown.gyro_root * (0.0 if gyros else 1.0),
        angle_errors=flown.angle_errors * (0.0 if angles else 1.0),
    )


def test_std_alone_is_that_of_a_fit_with_exact_sensors() -> None:
    one = fitted(1)
    sharp = fit_model(one.fit.offsets, exact(one.flown, gyros=True, angles=True))
    found = trades(one.fit, one.flown)
    # Sensors said to be exact leave something over, which such a fit adds to its stds.
    expected = sharp.std / np.sqrt(sharp.excess)
    np.testing.assert_allclose([trade.std_alone for trade in found], expected, rtol=0.03)
    np.testing.assert_allclose([trade.std for trade in found], one.fit.std)
    assert all(set(trade.growth) == SENSORS for trade in found)


def test_growth_is_that_of_a_fit_with_only_that_group_uncertain() -> None:
    one = fitted(1)
    unsure = fit_model(one.fit.offsets, exact(one.flown, gyros=True, angles=False))
    for trade, std in zip(trades(one.fit, one.flown), unsure.std / np.sqrt(unsure.excess), strict=True):
        assert trade.growth["joint angles"] * trade.std_alone == pytest.approx(std, rel=0.05)
        assert all(growth >= 1.0 - 1e-6 for growth in trade.growth.values())
        assert max(trade.growth.values()) * trade.std_alone <= trade.std * (1.0 + 1e-6)


def test_inertias_are_what_the_offsets_trade_against_if_they_are_free() -> None:
    one = fitted(1)
    found = trades(with_inertias(), one.flown)
    assert [trade.name for trade in found] == list(one.fit.offsets.names)
    for trade, alone in zip(found, trades(one.fit, one.flown), strict=True):
        assert set(trade.growth) == SENSORS | {"masses", "inertias"}
        assert trade.std_alone == pytest.approx(alone.std_alone, rel=0.1)
        assert max(trade.growth, key=lambda group: trade.growth[group]) == "inertias"
        assert trade.std > 3.0 * alone.std
        assert 0.2 < trade.std < 2.5, "3 % of the inertias are worth a millimetre"
        assert "most of it by inertias" in trade.sentence()


def test_offsets_with_free_inertias_hold_the_truth_within_their_stds() -> None:
    one, fit = fitted(1), with_inertias()
    off = (fit.values[:9] - one.drop.true_com_offsets_mm) / fit.std[:9]
    assert np.abs(off).max() < 3.0


def test_a_scale_factor_that_nobody_calibrated_is_seen_in_the_offsets() -> None:
    one = fitted(1)
    flown = with_scale_std(one.flown, 0.03)
    prior, calibration = (
        np.sqrt((drop.gyro_root**2).sum(axis=1)).reshape(4, 9) for drop in (flown, one.flown)
    )
    np.testing.assert_allclose(prior[:, 6:], 0.03)
    np.testing.assert_allclose(prior[:, :6], calibration[:, :6])
    fit = fit_model(one.fit.offsets, flown)
    calibrated, loose = trades(one.fit, one.flown), trades(fit, flown)
    for before, after in zip(calibrated, loose, strict=True):
        assert after.std > before.std
        assert after.growth["gyro scale"] > before.growth["gyro scale"]
        assert after.growth["gyro bias"] == pytest.approx(before.growth["gyro bias"], abs=0.05)
    assert max(loose[BODY_1_Z].growth, key=lambda group: loose[BODY_1_Z].growth[group]) == "gyro scale"
    assert int(np.argmax([trade.std for trade in loose])) == BODY_2_Z


def test_correlations_are_those_of_the_covariance() -> None:
    one = fitted(1)
    names = one.fit.offsets.names
    std = np.sqrt(np.diag(one.fit.covariance))
    for row, trade in enumerate(trades(one.fit, one.flown)):
        sizes = [abs(correlation) for _, correlation in trade.partners]
        assert sizes == sorted(sizes, reverse=True)
        assert sizes[0] <= 1.0
        for partner, correlation in trade.partners:
            if partner in names:
                column = names.index(partner)
                assert column != row
                expected = one.fit.covariance[row, column] / (std[row] * std[column])
                assert correlation == pytest.approx(expected)
