"""The model's correction and its comparison with the measured attitude, next to the emulated robot's truth."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.evaluation.drops import DROPPED, certificate, few_of, flown, motion, moved
from tests.fixtures.emulated_drop import DLPF_5_HZ, DLPF_42_HZ, Drop
from tfsat_host.dynamics.history import history_from_samples
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.propagate import propagate
from tfsat_host.evaluation.com_fit.com_fit import ModelFit, fit_model
from tfsat_host.evaluation.com_fit.momentum import Derivatives, FallSamples, derivatives, flown_of
from tfsat_host.evaluation.com_fit.offsets import COM_BOUND_M, Offsets, com_offsets, model_offsets
from tfsat_host.evaluation.com_fit.prediction import (
    EXPECTED_DISTANCE,
    UNEXPLAINED,
    ModelComparison,
    compare_model,
    predict,
)
from tfsat_host.evaluation.fallback_calibration import with_fallbacks
from tfsat_host.evaluation.rest import rest_before_release
from tfsat_host.robot import load_robot

FILTERS = pytest.mark.parametrize("dlpf_cfg", [DLPF_42_HZ, DLPF_5_HZ])
SEEDS = (1, 2, 3)
COM_BOUND_MM = 1e3 * COM_BOUND_M


@cache
def explained(seed: int, dlpf_cfg: int = DLPF_42_HZ) -> tuple[Drop, ModelComparison]:
    one = flown(seed, dlpf_cfg)
    return one, compare_model(motion(seed, dlpf_cfg), com_offsets(one.model), 0.7)


@FILTERS
@pytest.mark.parametrize("seeds", few_of(((1,),), (SEEDS,)))
def test_the_offsets_are_found_within_what_they_are_said_to_be_uncertain(
    seeds: tuple[int, ...], dlpf_cfg: int
) -> None:
    z_scores = []
    for seed in seeds:
        one, found = explained(seed, dlpf_cfg)
        error = found.fit.values - one.true_com_offsets_mm
        assert np.abs(error).max() < 1.0
        assert (found.fit.std < 0.4).all()
        z_scores.append(error / found.fit.std)
    assert 0.5 < np.sqrt(np.mean(np.square(z_scores))) < 1.6


@FILTERS
@pytest.mark.parametrize("seed", few_of(*SEEDS))
def test_the_corrected_model_predicts_the_attitude(seed: int, dlpf_cfg: int) -> None:
    one, found = explained(seed, dlpf_cfg)
    before, after = found.before.error, found.after.error
    assert np.rad2deg(before.final_norm_rad) > 0.3, "this robot's model is millimetres off"
    assert np.rad2deg(after.final_norm_rad) < 0.05
    assert after.rms_rad < 0.1 * before.rms_rad
    assert before.mahalanobis > 10.0 > 4.0 > after.mahalanobis
    truth = found.driven.with_offsets(one.true_com_offsets_mm)
    assert np.rad2deg(truth.error.final_norm_rad) < 0.06
    assert truth.error.mahalanobis < 4.0


def test_a_model_that_is_right_needs_no_correction() -> None:
    one = flown(4)
    right = one.flown
    found = compare_model(moved(one.log, certificate(one, 4), right), com_offsets(right), 0.7)
    assert (np.abs(found.fit.values) < 3.5 * found.fit.std).all()
    assert found.before.error.mahalanobis < 4.0


def test_nuisance_parameters_cost_certainty_and_no_truth() -> None:
    one, alone = explained(1)
    more = compare_model(motion(1), model_offsets(one.model), 0.7)
    assert (more.fit.std[:9] >= 0.99 * alone.fit.std).all()
    assert more.fit.std[:9].max() > 1.5 * alone.fit.std.max()
    assert (np.abs(more.fit.values[:9] - one.true_com_offsets_mm) < 4.0 * more.fit.std[:9]).all()


def test_an_offset_beyond_its_bound_stops_there_and_is_named() -> None:
    one, _ = explained(1)
    offsets = model_offsets(one.model)
    sought = within(offsets.alone, 5.0).parameters
    tight = replace(offsets, parameters=(*sought, *offsets.parameters[offsets.sought :]))
    found = compare_model(motion(1), tight, 0.7).fit
    assert np.abs(found.values[:9]).max() <= 5.0 + 1e-9
    assert found.bounded and np.abs(one.true_com_offsets_mm[found.at_bound[:9]]).max() > 5.0


@cache
def uncalibrated(seed: int) -> tuple[Drop, FallSamples]:
    one = flown(seed)
    used = with_fallbacks(None, one.log, one.model, rest_before_release(one.log), DROPPED).calibration
    return one, flown_of(moved(one.log, used, one.model))


def within(offsets: Offsets, bound_mm: float, std_mm: float = COM_BOUND_MM / 3.0**0.5) -> Offsets:
    """Return the offsets with other bounds and priors."""
    moved = (one._replace(bound=bound_mm, prior_std=std_mm) for one in offsets.parameters)
    return replace(offsets, parameters=tuple(moved))


def gradient(fit: ModelFit) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """(p,) where the data and the prior together would still pull the offsets, in what the prior allows."""
    pull = fit.right_hand_side - (fit.information + np.diag(fit.offsets.prior_std**-2.0)) @ fit.values
    return np.asarray(fit.offsets.prior_std * pull)


@pytest.mark.parametrize(("seed", "bound_mm"), few_of((1, 5.0), (3, 1.0), (5, 2.0)))
def test_the_fit_ends_at_its_optimum_also_within_narrow_bounds(seed: int, bound_mm: float) -> None:
    one, driven = uncalibrated(seed)
    fit = fit_model(within(com_offsets(one.model), bound_mm), driven)
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
    _, found = explained(1)

    def half_as_steep(*known: Any) -> Derivatives:
        true = derivatives(*known)
        return replace(true, by_offsets=0.5 * true.by_offsets)

    monkeypatch.setattr("tfsat_host.evaluation.com_fit.com_fit.derivatives", half_as_steep)
    fit = fit_model(found.fit.offsets, found.driven.flown)
    assert fit.converged
    np.testing.assert_allclose(fit.values, found.fit.values, atol=0.01)


def test_a_fit_that_was_widened_is_solved_anew_with_what_it_is_widened_by() -> None:
    one, driven = uncalibrated(1)
    com = com_offsets(one.model).body.com_m + 0.02 * np.eye(4)[:, :3]
    wrong = com_offsets(replace(one.model, com_m=com))
    fit = fit_model(within(wrong, 100.0, std_mm=2.0), driven)
    assert fit.excess > 1.2
    assert fit.widening == fit.excess
    assert (np.abs(gradient(fit)) < 0.01).all()


def test_a_fit_without_an_end_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    (one, driven), (_, whole) = uncalibrated(1), explained(1)
    monkeypatch.setattr("tfsat_host.evaluation.com_fit.com_fit._STEPS", 2)
    fit = fit_model(com_offsets(one.model), driven)
    assert not fit.converged
    found = replace(whole, fit=fit)
    assert not found.offered
    assert any("found no end in" in reason for reason in found.withheld)


def test_a_correction_that_explains_is_offered() -> None:
    for seed in SEEDS:
        _, found = explained(seed)
        assert found.fit.converged
        assert (found.offered, found.withheld) == (True, ())
        assert found.explains_after and not found.explains_before


def test_a_wrong_correction_of_a_right_model_is_not_held_against_the_model() -> None:
    one, found = explained(4)
    right = one.flown
    good = compare_model(moved(one.log, certificate(one, 4), right), com_offsets(right), 0.7)
    assert good.explains_before and good.offered
    wrong = good.driven.with_offsets(np.full(9, 5.0))
    assert wrong.error.mahalanobis > UNEXPLAINED
    (reason,) = replace(good, after=wrong).withheld
    assert "the correction is wrong, and nothing is said against the model" in reason
    (reason,) = replace(found, after=found.before).withheld
    assert reason.startswith("Even the corrected model misses")


def test_a_correction_that_was_not_thought_possible_is_withheld() -> None:
    _, found = explained(1)
    far = found.fit.values.copy()
    far[4] = -5.1 * found.fit.offsets.prior_std[4]
    (reason,) = replace(found, fit=replace(found.fit, values=far)).withheld
    assert reason.startswith("The correction is more than 5 times what was allowed for body 2 CoM y:")


def test_what_the_stated_errors_do_not_explain_widens_the_fit_and_not_its_judgement() -> None:
    """Gyros that are said to be far more exact than they are."""
    one, _ = explained(1)
    calibration = certificate(one, 1)
    off = np.random.default_rng(1).standard_normal((4, 9)) * [*[0.0] * 3, *[np.deg2rad(2.0)] * 3, *[0.01] * 3]
    wrong = [gyro.add_errors(by) for gyro, by in zip(calibration.gyros, off, strict=True)]
    found = compare_model(
        moved(one.log, replace(calibration, gyros=tuple(wrong)), one.model), com_offsets(one.model), 0.7
    )
    assert found.fit.widening > found.fit.excess
    assert found.after.error.mahalanobis > EXPECTED_DISTANCE
    assert found.after.values is found.fit.values
    assert not found.explains_before and not found.explains_after


def test_scale_factors_that_nobody_calibrated_cost_little() -> None:
    """Uncalibrated scale factors increase the standard deviations little.

    The drop determines them: neighbors contradict each other, and angle sensors constrain the scale next to a
    joint.
    """
    one, known = explained(1, DLPF_5_HZ)
    calibration = certificate(one, 1)
    gyros = []
    for gyro in calibration.gyros:
        covariance = gyro.covariance.copy()
        covariance[6:, 6:] = (0.03 / 3**0.5) ** 2 * np.eye(3)
        gyros.append(replace(gyro, scale=np.ones(3), covariance=covariance))
    found = compare_model(
        moved(one.log, replace(calibration, gyros=tuple(gyros)), one.model), com_offsets(one.model), 0.7
    ).fit
    assert found.std.argmax() == 5
    assert known.fit.std[5] < found.std[5] < 2.0 * known.fit.std[5]
    assert (np.abs(found.values - one.true_com_offsets_mm) < 3.5 * found.std).all()


def test_the_prediction_is_that_of_the_simulator() -> None:
    """Prediction matches `dynamics.propagate` for the same joint history and momentum."""
    _, found = explained(2)
    driven, body = found.driven.flown, Multibody.of(load_robot())
    history = history_from_samples(driven.t_s, driven.angles_rad)
    exact = replace(driven, joint_rate_rad_s=history.rates_rad_s(driven.t_s))
    flight = propagate(
        body, history, initial_rate_rad_s=np.array([0.01, -0.02, 0.015]), step_s=0.002, order=6
    )
    ours = predict(body, exact, flight.momentum()[0])
    off = Rotation.from_matrix(flight.attitude()[-1].T @ ours.attitude[-1]).magnitude()
    assert np.rad2deg(off) < 0.005


@pytest.mark.parametrize("seed", few_of(*SEEDS[:2]))
def test_without_a_calibration_the_offsets_are_said_to_be_as_uncertain_as_they_are(seed: int) -> None:
    """Mountings 5 deg off, scale factors 3 %, joints that hang anywhere within 6 deg: the drop tells most of it."""
    one, calibrated = explained(seed)
    used = with_fallbacks(None, one.log, one.model, rest_before_release(one.log), DROPPED).calibration
    found = compare_model(moved(one.log, used, one.model), com_offsets(one.model), 0.7)
    assert (found.fit.std > 1.2 * calibrated.fit.std).all()
    assert (found.fit.std < 0.3 * found.fit.offsets.prior_std).all()
    z_scores = (found.fit.values - one.true_com_offsets_mm) / found.fit.std
    assert np.sqrt(np.mean(z_scores**2)) < 2.2
    assert found.after.error.rms_rad < found.before.error.rms_rad
    assert found.offered


@pytest.mark.parametrize("seed", few_of(*SEEDS[:2]))
def test_masses_and_inertias_of_a_right_model_stay_where_they_are(seed: int) -> None:
    """Keep a correct model's masses and inertias: noise must not move them.

    Scaling all of them by one factor explains a motion as well: only their prior constrains them.
    """
    one = flown(seed)
    offsets = model_offsets(one.flown)
    found = compare_model(moved(one.log, certificate(one, seed), one.flown), offsets, 0.7).fit
    assert (np.abs(found.values) < 3.5 * found.std).all()
    assert (np.abs(found.values[9:]) < 1.5 * offsets.prior_std[9:]).all()
