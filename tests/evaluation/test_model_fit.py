"""The model's correction and its comparison with the measured attitude, next to the emulated robot's truth."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.evaluation.drops import (
    DROPPED,
    certificate,
    com_offsets,
    estimate_motion,
    few_of,
    fly_drop,
    motion,
)
from tests.fixtures.emulated_drop import DLPF_5_HZ, DLPF_42_HZ, Drop
from tfsat_host.dynamics.history import history_from_samples
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.propagate import propagate
from tfsat_host.evaluation.com_fit.com_fit import ModelFit, fit_model
from tfsat_host.evaluation.com_fit.model_comparison import (
    EXPECTED_DISTANCE,
    UNEXPLAINED,
    ModelComparison,
    compare_model,
)
from tfsat_host.evaluation.com_fit.momentum_residual import Derivatives, FallSamples, derivatives, flown_of
from tfsat_host.evaluation.com_fit.offsets import COM_BOUND_M, Offsets, model_offsets
from tfsat_host.evaluation.com_fit.prediction import predict
from tfsat_host.evaluation.fallback_calibration import with_fallbacks
from tfsat_host.evaluation.rest import rest_before_release
from tfsat_host.robot import load_robot

FILTERS = pytest.mark.parametrize("dlpf_cfg", [DLPF_42_HZ, DLPF_5_HZ])
SEEDS = (1, 2, 3)
COM_BOUND_MM = 1e3 * COM_BOUND_M


@cache
def explain_drop(seed: int, dlpf_cfg: int = DLPF_42_HZ) -> tuple[Drop, ModelComparison]:
    drop = fly_drop(seed, dlpf_cfg)
    return drop, compare_model(motion(seed, dlpf_cfg), com_offsets(drop.model), 0.7)


@FILTERS
@pytest.mark.parametrize("seeds", few_of(((1,),), (SEEDS,)))
def test_the_offsets_are_found_within_what_they_are_said_to_be_uncertain(
    seeds: tuple[int, ...], dlpf_cfg: int
) -> None:
    z_scores = []
    for seed in seeds:
        drop, comparison = explain_drop(seed, dlpf_cfg)
        error = comparison.fit.values - drop.true_com_offsets_mm
        assert np.abs(error).max() < 1.0
        assert (comparison.fit.std < 0.4).all()
        z_scores.append(error / comparison.fit.std)
    # Nine numbers a drop: beyond these once in a thousand by chance.
    assert 0.35 < np.sqrt(np.mean(np.square(z_scores))) < 1.76


@FILTERS
@pytest.mark.parametrize("seed", few_of(*SEEDS))
def test_the_corrected_model_predicts_the_attitude(seed: int, dlpf_cfg: int) -> None:
    drop, comparison = explain_drop(seed, dlpf_cfg)
    before, after = comparison.nominal.error, comparison.fitted.error
    assert np.rad2deg(before.final_norm_rad) > 0.3, "this robot's model is millimetres off"
    assert np.rad2deg(after.final_norm_rad) < 0.05
    assert after.rms_rad < 0.1 * before.rms_rad
    assert before.mahalanobis > 10.0 > 4.0 > after.mahalanobis
    truth = comparison.driven.with_offsets(drop.true_com_offsets_mm)
    assert np.rad2deg(truth.error.final_norm_rad) < 0.06
    assert truth.error.mahalanobis < 4.0


def test_a_model_that_is_right_needs_no_correction() -> None:
    drop = fly_drop(4)
    right = drop.flown
    comparison = compare_model(
        estimate_motion(drop.log, certificate(drop, 4), right), com_offsets(right), 0.7
    )
    assert (np.abs(comparison.fit.values) < 3.5 * comparison.fit.std).all()
    assert comparison.nominal.error.mahalanobis < 4.0


def test_nuisance_parameters_cost_certainty_and_no_truth() -> None:
    drop, alone = explain_drop(1)
    comparison = compare_model(motion(1), model_offsets(drop.model), 0.7)
    assert (comparison.fit.std[:9] >= 0.99 * alone.fit.std).all()
    assert comparison.fit.std[:9].max() > 1.5 * alone.fit.std.max()
    assert (np.abs(comparison.fit.values[:9] - drop.true_com_offsets_mm) < 4.0 * comparison.fit.std[:9]).all()


def test_an_offset_beyond_its_bound_stops_there_and_is_named() -> None:
    drop, _ = explain_drop(1)
    offsets = model_offsets(drop.model)
    sought = within(offsets.alone, 5.0).parameters
    tight = replace(offsets, parameters=(*sought, *offsets.parameters[offsets.sought :]))
    fit = compare_model(motion(1), tight, 0.7).fit
    assert np.abs(fit.values[:9]).max() <= 5.0 + 1e-9
    assert fit.bounded and np.abs(drop.true_com_offsets_mm[fit.at_bound[:9]]).max() > 5.0


@cache
def fly_uncalibrated(seed: int) -> tuple[Drop, FallSamples]:
    drop = fly_drop(seed)
    calibration = with_fallbacks(
        None, drop.log, drop.model, rest_before_release(drop.log), DROPPED
    ).calibration
    return drop, flown_of(estimate_motion(drop.log, calibration, drop.model))


def within(offsets: Offsets, bound_mm: float, std_mm: float = COM_BOUND_MM / 3.0**0.5) -> Offsets:
    """Return the offsets with other bounds and priors."""
    moved = (parameter._replace(bound=bound_mm, prior_std=std_mm) for parameter in offsets.parameters)
    return replace(offsets, parameters=tuple(moved))


def gradient(fit: ModelFit) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """(p,) where the data and the prior together would still pull the offsets, in what the prior allows."""
    pull = (
        fit.equations.right_hand_side - (fit.information + np.diag(fit.offsets.prior_std**-2.0)) @ fit.values
    )
    return np.asarray(fit.offsets.prior_std * pull)


@pytest.mark.parametrize(("seed", "bound_mm"), few_of((1, 5.0), (3, 1.0), (5, 2.0)))
def test_the_fit_ends_at_its_optimum_also_within_narrow_bounds(seed: int, bound_mm: float) -> None:
    drop, driven = fly_uncalibrated(seed)
    fit = fit_model(within(com_offsets(drop.model), bound_mm), driven)
    assert fit.converged
    assert (np.abs(fit.values) <= bound_mm + 1e-9).all()
    assert len(fit.bounded) == fit.at_bound.sum() > 0
    pull = gradient(fit)
    assert (np.abs(pull[~fit.at_bound]) < 0.05).all()
    assert (pull[fit.at_bound] * fit.values[fit.at_bound] > 0.0).all(), "outwards"


def test_steps_that_lead_to_and_fro_are_halved_until_they_do_not(monkeypatch: pytest.MonkeyPatch) -> None:
    """Halve steps that oscillate until the fit converges.

    With half the slope, a whole step overshoots the optimum by as much as it was short of it, for ever.
    """
    _, comparison = explain_drop(1)

    def half_as_steep(*arguments: Any) -> Derivatives:
        true = derivatives(*arguments)
        return replace(true, by_offsets=0.5 * true.by_offsets)

    monkeypatch.setattr("tfsat_host.evaluation.com_fit.com_fit.derivatives", half_as_steep)
    fit = fit_model(comparison.fit.offsets, comparison.driven.flown)
    assert fit.converged
    np.testing.assert_allclose(fit.values, comparison.fit.values, atol=0.01)


def test_a_fit_that_was_widened_is_solved_anew_with_what_it_is_widened_by() -> None:
    drop, driven = fly_uncalibrated(1)
    com = com_offsets(drop.model).body.com_m + 0.02 * np.eye(4)[:, :3]
    wrong = com_offsets(replace(drop.model, com_m=com))
    fit = fit_model(within(wrong, 100.0, std_mm=2.0), driven)
    assert fit.excess > 1.2
    assert fit.widening == fit.excess
    assert (np.abs(gradient(fit)) < 0.01).all()


def test_a_fit_without_an_end_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    (drop, driven), (_, reference) = fly_uncalibrated(1), explain_drop(1)
    monkeypatch.setattr("tfsat_host.evaluation.com_fit.com_fit._STEPS", 2)
    fit = fit_model(com_offsets(drop.model), driven)
    assert not fit.converged
    comparison = replace(reference, fit=fit)
    assert not comparison.offered
    assert any("did not converge in" in reason for reason in comparison.withheld)


def test_a_correction_that_explains_is_offered() -> None:
    for seed in SEEDS:
        _, comparison = explain_drop(seed)
        assert comparison.fit.converged
        assert (comparison.offered, comparison.withheld) == (True, ())
        assert comparison.fitted_explains and not comparison.nominal_explains


def test_a_wrong_correction_of_a_right_model_is_not_held_against_the_model() -> None:
    drop, comparison = explain_drop(4)
    right = drop.flown
    good = compare_model(estimate_motion(drop.log, certificate(drop, 4), right), com_offsets(right), 0.7)
    assert good.nominal_explains and good.offered
    wrong = good.driven.with_offsets(np.full(9, 5.0))
    assert wrong.error.mahalanobis > UNEXPLAINED
    (reason,) = replace(good, fitted=wrong).withheld
    assert "the correction is wrong, and nothing is said against the model" in reason
    (reason,) = replace(comparison, fitted=comparison.nominal).withheld
    assert reason.startswith("Even the corrected model misses")


def test_a_correction_that_was_not_thought_possible_is_withheld() -> None:
    _, comparison = explain_drop(1)
    far = comparison.fit.values.copy()
    far[4] = -5.1 * comparison.fit.offsets.prior_std[4]
    (reason,) = replace(comparison, fit=replace(comparison.fit, values=far)).withheld
    assert reason.startswith("The correction is more than 5 times what was allowed for body 2 CoM y:")


def test_what_the_stated_errors_do_not_explain_widens_the_fit_and_not_its_judgement() -> None:
    """Gyros that are said to be far more exact than they are."""
    drop, _ = explain_drop(1)
    calibration = certificate(drop, 1)
    off = np.random.default_rng(1).standard_normal((4, 12)) * [
        *[0.0] * 3,
        *[np.deg2rad(2.0)] * 3,
        *[0.01] * 3,
        *[0.0] * 3,
    ]
    wrong = [gyro.add_errors(by) for gyro, by in zip(calibration.gyros, off, strict=True)]
    comparison = compare_model(
        estimate_motion(drop.log, replace(calibration, gyros=tuple(wrong)), drop.model),
        com_offsets(drop.model),
        0.7,
    )
    assert comparison.fit.widening > comparison.fit.excess
    assert comparison.fitted.error.mahalanobis > EXPECTED_DISTANCE
    assert comparison.fitted.values is comparison.fit.values
    assert not comparison.nominal_explains and not comparison.fitted_explains


def test_scale_factors_that_nobody_calibrated_cost_little() -> None:
    """Uncalibrated scale factors increase the standard deviations little.

    The drop determines them: neighbors contradict each other, and angle sensors constrain the scale next to a
    joint.
    """
    drop, reference = explain_drop(1, DLPF_5_HZ)
    calibration = certificate(drop, 1)
    gyros = []
    for gyro in calibration.gyros:
        covariance = gyro.covariance.copy()
        covariance[6:9, 6:9] = (0.03 / 3**0.5) ** 2 * np.eye(3)
        gyros.append(replace(gyro, scale=np.ones(3), covariance=covariance))
    fit = compare_model(
        estimate_motion(drop.log, replace(calibration, gyros=tuple(gyros)), drop.model),
        com_offsets(drop.model),
        0.7,
    ).fit
    assert fit.std.argmax() == 5
    assert reference.fit.std[5] < fit.std[5] < 2.0 * reference.fit.std[5]
    assert (np.abs(fit.values - drop.true_com_offsets_mm) < 3.5 * fit.std).all()


def test_the_prediction_is_that_of_the_simulator() -> None:
    """Prediction matches `dynamics.propagate` for the same joint history and momentum."""
    _, comparison = explain_drop(2)
    driven, body = comparison.driven.flown, Multibody.of(load_robot())
    history = history_from_samples(driven.t_s, driven.angles_rad)
    # The simulator's hinges are square: so must be those of the prediction.
    exact = replace(
        driven, joint_rate_rad_s=history.rates_rad_s(driven.t_s), tilt_rad=np.zeros_like(driven.tilt_rad)
    )
    flight = propagate(
        body, history, initial_rate_rad_s=np.array([0.01, -0.02, 0.015]), step_s=0.002, order=6
    )
    ours = predict(body, exact, flight.momentum()[0])
    off = Rotation.from_matrix(flight.attitude()[-1].T @ ours.attitude[-1]).magnitude()
    assert np.rad2deg(off) < 0.005


@pytest.mark.parametrize("seed", few_of(*SEEDS[:2]))
def test_without_a_calibration_the_offsets_are_said_to_be_as_uncertain_as_they_are(seed: int) -> None:
    """Mountings 5 deg off, scale factors 3 %, joints that hang anywhere within 6 deg: the drop tells most of it."""
    drop, calibrated = explain_drop(seed)
    calibration = with_fallbacks(
        None, drop.log, drop.model, rest_before_release(drop.log), DROPPED
    ).calibration
    comparison = compare_model(
        estimate_motion(drop.log, calibration, drop.model), com_offsets(drop.model), 0.7
    )
    assert (comparison.fit.std > 1.2 * calibrated.fit.std).all()
    assert (comparison.fit.std < 0.3 * comparison.fit.offsets.prior_std).all()
    z_scores = (comparison.fit.values - drop.true_com_offsets_mm) / comparison.fit.std
    assert np.sqrt(np.mean(z_scores**2)) < 2.2
    assert comparison.fitted.error.rms_rad < comparison.nominal.error.rms_rad
    assert comparison.offered


@pytest.mark.parametrize("seed", few_of(*SEEDS[:2]))
def test_masses_and_inertias_of_a_right_model_stay_where_they_are(seed: int) -> None:
    """Keep a correct model's masses and inertias: noise must not move them.

    Scaling all of them by one factor explains a motion as well: only their prior constrains them.
    """
    drop = fly_drop(seed)
    offsets = model_offsets(drop.flown)
    fit = compare_model(estimate_motion(drop.log, certificate(drop, seed), drop.flown), offsets, 0.7).fit
    assert (np.abs(fit.values) < 3.5 * fit.std).all()
    assert (np.abs(fit.values[9:]) < 1.5 * offsets.prior_std[9:]).all()
