"""What trades against what: against fits in which it is really known, and with scale factors that are not."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.evaluation.drops import MODEL, calibrated_from_truth, fit_drop
from tests.fixtures.emulated_drop import DLPF_42_HZ
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.evaluation.com_fit.com_fit import ModelFit, fit_model
from tfsat_host.evaluation.com_fit.identifiability import couplings
from tfsat_host.evaluation.com_fit.momentum_residual import FallSamples, flown_of, momentum_of
from tfsat_host.evaluation.com_fit.offsets import model_offsets
from tfsat_host.evaluation.motion.motion import motion_of

BODY_2_Z = 5
TOGETHER = {f"body {body} CoM y" for body in (1, 2, 3, 4)} | {f"joint {joint} point y" for joint in (1, 3)}
"""Joint 2 turns about y, along which its point is free."""
EVERYTHING, GYROS = slice(None), slice(0, 44)
"""The gyros' 36 parameters, the two moments of their delay and the tilts of the axes."""
SENSORS = {"gyro delay", "gyro bias", "gyro misalignment", "gyro scale", "hinge axes", "joint angles"}


@cache
def with_nuisance() -> ModelFit:
    return fit_model(model_offsets(MODEL), fit_drop(1).flown)


def exact(fall_samples: FallSamples, known_errors: slice) -> FallSamples:
    """Return the drop with the `known_errors` sensor errors known to be zero."""
    error_rows = fall_samples.sensor_errors[known_errors]
    free = np.eye(error_rows.shape[1]) - np.linalg.pinv(error_rows, rcond=1e-10) @ error_rows
    return replace(
        fall_samples,
        rate_errors=fall_samples.rate_errors @ free,
        angle_errors=fall_samples.angle_errors @ free,
        tilt_errors=fall_samples.tilt_errors @ free,
        own=replace(fall_samples.own, errors=fall_samples.own.errors @ free),
    )


def test_std_alone_is_that_of_a_fit_with_exact_sensors() -> None:
    fitted_drop = fit_drop(1)
    sharp = fit_model(fitted_drop.fit.offsets, exact(fitted_drop.flown, EVERYTHING))
    trades = couplings(fitted_drop.fit, fitted_drop.flown)
    # Sensors said to be exact leave something over, which such a fit adds to its stds, and the fit itself its own.
    expected = sharp.std * np.sqrt(fitted_drop.fit.excess / sharp.excess)
    np.testing.assert_allclose([trade.std_alone for trade in trades], expected, rtol=0.03)
    np.testing.assert_allclose([trade.std for trade in trades], fitted_drop.fit.std)
    assert all(set(trade.growth) == SENSORS for trade in trades)


def test_growth_is_that_of_a_fit_with_only_that_group_uncertain() -> None:
    fitted_drop = fit_drop(1)
    unsure = fit_model(fitted_drop.fit.offsets, exact(fitted_drop.flown, GYROS))
    expected = unsure.std * np.sqrt(fitted_drop.fit.excess / unsure.excess)
    for trade, std in zip(couplings(fitted_drop.fit, fitted_drop.flown), expected, strict=True):
        assert trade.growth["joint angles"] * trade.std_alone == pytest.approx(std, rel=0.08)
        assert all(growth >= 1.0 - 1e-6 for growth in trade.growth.values())
        assert max(trade.growth.values()) * trade.std_alone <= trade.std * (1.0 + 1e-6)


def test_inertias_are_what_the_offsets_trade_against() -> None:
    fitted_drop = fit_drop(1)
    trades = couplings(with_nuisance(), fitted_drop.flown)
    assert [trade.name for trade in trades] == list(fitted_drop.fit.offsets.names)
    for trade, alone in zip(trades, couplings(fitted_drop.fit, fitted_drop.flown), strict=True):
        assert set(trade.growth) == SENSORS | {
            "masses",
            "inertias",
            "hinge points",
            "center of mass of body 4",
        }
        assert trade.std_alone == pytest.approx(alone.std_alone, rel=0.1)
        assert max(trade.growth, key=lambda group: trade.growth[group]) in ("inertias", "hinge points")
        assert trade.std > 3.0 * alone.std
        assert 0.2 < trade.std < 2.5, "3 % of the inertias are worth a millimetre"


def test_a_hinge_point_and_a_center_of_mass_that_move_together_are_determined_as_a_sum() -> None:
    """Moved by as much, they are another origin of the frames: the motion is the same to the last digit."""
    fitted_drop, fit = fit_drop(1), with_nuisance()
    combinations = {trade.name: trade.determined for trade in couplings(fit, fitted_drop.flown)}
    combined = combinations["body 1 CoM y"]
    assert combined is not None and combined.name == "body 1 CoM y - joint 1 point y"
    assert combined.std < 0.8 * fit.std[list(fit.offsets.names).index("body 1 CoM y")]
    assert abs(combined.value - fitted_drop.drop.true_com_offsets_mm[1]) < 4.0 * combined.std
    moved = np.array([float(name in TOGETHER) for name in fit.offsets.names])
    bodies = [fit.offsets.correct(vector) for vector in (np.zeros(len(moved)), 5.0 * moved)]
    fall_samples = replace(fitted_drop.flown, tilt_rad=np.zeros((3, 2)))
    before, after = (momentum_of(body, fall_samples) for body in bodies)
    np.testing.assert_allclose(before, after, rtol=1e-12, atol=1e-15)


def test_offsets_with_nuisance_parameters_hold_the_truth_within_their_stds() -> None:
    fitted_drop, fit = fit_drop(1), with_nuisance()
    off = (fit.values[:9] - fitted_drop.drop.true_com_offsets_mm) / fit.std[:9]
    assert np.abs(off).max() < 3.0


def test_a_scale_factor_that_nobody_calibrated_is_seen_in_the_offsets() -> None:
    fitted_drop = fit_drop(1)
    samples = fitted_drop.motion.samples
    covariance = samples.parameter_covariance.copy()
    covariance[:, 6:9, :], covariance[:, :, 6:9] = 0.0, 0.0
    covariance[:, 6:9, 6:9] = 0.03**2 * np.eye(3)
    unscaled = replace(samples, parameter_covariance=covariance)
    calibration = calibrated_from_truth(MODEL, fitted_drop.drop.imperfections, 1)
    fall_samples = flown_of(
        motion_of(unscaled, calibration, MODEL, fitted_drop.motion.densities_rad_s_rthz, LowPass(DLPF_42_HZ))
    )
    calibrated, loose = (
        couplings(fitted_drop.fit, fitted_drop.flown),
        couplings(fit_model(fitted_drop.fit.offsets, fall_samples), fall_samples),
    )
    for before, after in zip(calibrated, loose, strict=True):
        assert after.std > before.std
        assert after.growth["gyro scale"] > before.growth["gyro scale"]
    assert int(np.argmax([trade.std for trade in loose])) == BODY_2_Z


def test_correlations_are_those_of_the_covariance() -> None:
    fitted_drop = fit_drop(1)
    names = fitted_drop.fit.offsets.names
    std = np.sqrt(np.diag(fitted_drop.fit.covariance))
    for row, trade in enumerate(couplings(fitted_drop.fit, fitted_drop.flown)):
        sizes = [abs(correlation) for _, correlation in trade.partners]
        assert sizes == sorted(sizes, reverse=True)
        assert sizes[0] <= 1.0
        for partner, correlation in trade.partners:
            if partner in names:
                column = names.index(partner)
                assert column != row
                expected = fitted_drop.fit.covariance[row, column] / (std[row] * std[column])
                assert correlation == pytest.approx(expected)
