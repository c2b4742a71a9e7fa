"""Offsets of some drops, judged by another one: three emulated drops of one robot, and one of another."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from tests.evaluation.drops import (
    MODEL,
    RATE_RAD_S,
    Fitted,
    certificate,
    com_offsets,
    estimate_motion,
    fit_drop,
    moved_centers,
    with_com_offsets,
)
from tests.fixtures.emulated_drop import DLPF_42_HZ, drop
from tfsat_host.arrays import FloatArray
from tfsat_host.emulated.imperfections import draw_as_built
from tfsat_host.evaluation.com_fit.com_fit import fit_model, widen_fit
from tfsat_host.evaluation.com_fit.cross_validation import FittedDrop, combine, cross_validate, left_aside
from tfsat_host.evaluation.com_fit.momentum_residual import (
    derivatives,
    flown_of,
    inertial_momentum,
    residual_rate,
)
from tfsat_host.evaluation.com_fit.offsets import model_offsets
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.rehearsal.hidden import draw_hidden, hidden_drop
from tfsat_host.robot import load_robot

ROBOT, OTHER_ROBOT = 7, 3
UNIT = 1e-3
SEEDS = (11, 12, 13)
FIRST_STROKE_S = 0.69


def final_error_deg(drop: Fitted, values: FloatArray) -> float:
    """Compute the final attitude error of the model's prediction to first order.

    It is the integrated residual rate.
    """
    body = drop.fit.offsets.correct(values)
    # Momentum from before the first stroke, when the joints are at rest.
    calm = drop.flown.t_s < FIRST_STROKE_S
    momentum = inertial_momentum(body, drop.flown)[calm].mean(axis=0)
    rate = np.einsum("nij,nj->ni", drop.flown.attitude, residual_rate(body, drop.flown, momentum))
    return float(np.rad2deg(np.linalg.norm(np.trapezoid(rate, drop.flown.t_s, axis=0))))


@cache
def moved_robot() -> Fitted:
    """Return a drop of the robot after its body 2's center of mass moved by 2 mm along z.

    A loose battery does this.
    """
    offsets_m = np.zeros((3, 3))
    offsets_m[1, 2] = 2e-3
    robot = with_com_offsets(moved_centers(ROBOT), offsets_m)
    fallen = drop(
        robot, draw_as_built(ROBOT), model=MODEL, seed=12, dlpf_cfg=DLPF_42_HZ, rate_rad_s=RATE_RAD_S
    )
    motion = estimate_motion(fallen.log, certificate(fallen, ROBOT))
    driven = flown_of(motion)
    return Fitted(fallen, motion, driven, fit_model(com_offsets(MODEL), driven))


def make_fitted_drop(name: str, drop: Fitted) -> FittedDrop:
    return FittedDrop(name, drop.flown, drop.fit, lambda values: final_error_deg(drop, values))


def test_offsets_of_two_drops_correct_the_third() -> None:
    drops = [fit_drop(seed, robot=ROBOT) for seed in SEEDS]
    judgements = cross_validate(
        [make_fitted_drop(f"drop {seed}", drop) for seed, drop in zip(SEEDS, drops, strict=True)]
    )
    assert [judgement.name for judgement in judgements] == ["drop 11", "drop 12", "drop 13"]
    truth = drops[0].drop.true_com_offsets_mm
    for judgement, fitted_drop in zip(judgements, drops, strict=True):
        # Judged by the other two drops: the correction must help a drop it has not seen.
        assert judgement.improved
        assert judgement.error_before == final_error_deg(fitted_drop, np.zeros(9)) > 1.0
        # From more than 1 deg to less than 0.05 deg.
        assert judgement.error_after == final_error_deg(fitted_drop, judgement.others.values) < 0.05
        assert judgement.error_own == final_error_deg(fitted_drop, fitted_drop.fit.values) < 0.05
        assert judgement.objective_after < 0.05 * judgement.objective_before
        assert judgement.own_off_std < 2.0
        assert (np.abs(judgement.others.values - truth) < 4.0 * judgement.others.std + 0.02).all()
        others = combine([other.fit for other in drops if other is not fitted_drop])
        # Exactly the combination of the others' fits: the drop itself is not in it.
        np.testing.assert_array_equal(judgement.others.values, others.values)
        np.testing.assert_array_equal(judgement.others.covariance, others.covariance)


def test_a_drop_of_another_robot_is_found_out() -> None:
    drops = [fit_drop(11, robot=ROBOT), fit_drop(12, robot=ROBOT), fit_drop(OTHER_ROBOT)]
    judgements = cross_validate(
        [make_fitted_drop(name, drop) for name, drop in zip("abc", drops, strict=True)]
    )
    # Offsets of another robot: twenty standard deviations away.
    assert judgements[2].own_off_std > 20.0
    assert judgements[2].error_after > 10.0 * judgements[2].error_own
    assert judgements[2].objective_after > 5.0 * judgements[0].objective_before / 100.0


def test_drops_of_one_robot_agree_and_are_not_widened() -> None:
    combined_offsets = combine([fit_drop(seed, robot=ROBOT).fit for seed in SEEDS])
    assert (
        combined_offsets.agree
        and combined_offsets.contradiction() == ""
        and combined_offsets.widened_by == 1.0
    )
    assert combined_offsets.degrees_of_freedom == pytest.approx(18.0, abs=0.1), "nine of each drop, less nine"
    assert 0.01 < combined_offsets.chance < 0.999


def test_a_center_of_mass_that_moved_between_drops_is_found_and_the_deviations_cover_both() -> None:
    first, same, other = fit_drop(11, robot=ROBOT).fit, fit_drop(12, robot=ROBOT).fit, moved_robot().fit
    combined_offsets, before = combine([first, other]), combine([first, same])
    assert not combined_offsets.agree and combined_offsets.chance < 1e-6
    assert combined_offsets.widened_by == pytest.approx(
        np.sqrt(combined_offsets.chi_square / combined_offsets.degrees_of_freedom)
    )
    assert combined_offsets.widened_by > 2.0
    np.testing.assert_allclose(combined_offsets.std, combined_offsets.widened_by * before.std, rtol=0.02)
    assert (
        "contradict each other" in combined_offsets.contradiction()
        and "DOUBTFUL" in combined_offsets.contradiction()
    )
    # A drop that tells nothing contradicts nobody.
    assert combine([first, widen_fit(other, 1e4)]).agree and combine([first]).agree


def test_one_fit_alone_is_itself_and_twice_the_data_halve_the_variance() -> None:
    fit = fit_drop(11, robot=ROBOT).fit
    alone = combine([fit])
    np.testing.assert_allclose(alone.values, fit.values, atol=1e-4)
    np.testing.assert_allclose(alone.std, fit.std, rtol=1e-6)
    twice = combine([fit, fit])
    # The prior counts once, so that two equal drops move a little farther from it.
    assert np.abs(twice.values - fit.values).max() < 0.02
    np.testing.assert_allclose(twice.std, fit.std / np.sqrt(2.0), rtol=0.01)


def test_a_drop_weighs_by_what_it_tells() -> None:
    # A fit widened a hundred times has a ten-thousandth of the weight.
    fit = fit_drop(11, robot=ROBOT).fit
    together = combine([fit, widen_fit(moved_robot().fit, 100.0)])
    assert np.abs(together.values - fit.values).max() < 0.02


def test_the_prior_counts_once_however_many_drops_say_nothing() -> None:
    fit = fit_drop(11, robot=ROBOT).fit
    nothing = widen_fit(fit, 1e6)
    together = combine([nothing, nothing, fit])
    np.testing.assert_allclose(together.values, fit.values, atol=1e-3)
    # Drops that tell nothing leave the prior unchanged, not halved.
    np.testing.assert_allclose(combine([nothing, nothing]).std, fit.offsets.prior_std, rtol=1e-5)


def test_drops_with_all_that_is_uncertain_agree_and_know_no_more_than_they_tell() -> None:
    """Added up where each drop's own fit ended, three of them contradicted each other with chi-square 163 of 51."""
    filed = load_robot()
    fits = []
    for day, (a_deg, b_deg) in enumerate([(59.0, 70.0), (60.0, 50.0), (50.0, 65.0)]):
        truth, other = draw_hidden(filed, 3), draw_hidden(filed, 1000 + day)
        hidden = hidden_drop(
            schedule_maneuver(four_stroke(a_deg, b_deg)),
            filed,
            replace(truth, rate_rad_s=other.rate_rad_s, seed=other.seed),
        )
        fits.append(evaluate(hidden.log, filed, hidden.calibration, hidden.schedule).explained.fit)
    offsets_mm = 1e3 * (draw_hidden(filed, 3).model.com_m - filed.com_m)[:3].ravel()
    alone, together = combine(fits[:1]), combine(fits)
    assert together.agree
    assert (together.std < alone.std).all()
    assert np.sqrt(np.mean(((together.values[:9] - offsets_mm) / together.std[:9]) ** 2)) < 1.6
    # What the data do not tell, three drops do not know either: no deviation falls as the root of three.
    assert (together.std[:9] > 0.8 * alone.std[:9]).all()


def rows(
    drop: Fitted, values: FloatArray, momentum: FloatArray, errors: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return a drop's whitened equations for offsets, momentum and sensor errors, linearized at these."""
    fit, driven = drop.fit, drop.flown.correct(errors)
    linearization = derivatives(fit.offsets, values, driven, momentum)
    residual = residual_rate(fit.offsets.correct(values), driven, momentum)
    # Whitened by the noise's Cholesky factor: all rows have variance one.
    whitening = np.linalg.inv(np.linalg.cholesky(fit.widening * linearization.noise))
    # The momentum in small units, else the system is numerically singular.
    columns = np.concatenate(
        [linearization.by_offsets, UNIT * linearization.by_momentum, linearization.by_errors], axis=2
    )
    target = columns @ np.concatenate([values, momentum / UNIT, errors]) - residual
    white = np.einsum("nij,nj->ni", whitening, target)
    return (whitening @ columns).reshape(-1, columns.shape[2]), white.ravel()


def at_once(drops: list[Fitted]) -> tuple[FloatArray, FloatArray]:
    """Offsets and their standard deviations by one fit to all drops, with momentum and errors of each: Gauss-Newton."""
    p = len(drops[0].fit.offsets)
    values = drops[0].fit.values
    own = [np.concatenate([drop.fit.momentum_kg_m2_s / UNIT, drop.fit.errors]) for drop in drops]
    # Unknowns: shared offsets first, then momentum and sensor errors of each drop.
    places = np.cumsum([p, *map(len, own)])
    normal = np.empty((0, 0))
    for _ in range(6):
        normal, right = np.zeros((places[-1], places[-1])), np.zeros(places[-1])
        # The prior of the offsets enters once, that of the sensor errors in every drop.
        normal[:p, :p] = np.diag(drops[0].fit.offsets.prior_std ** -2.0)
        for fitted_drop, numbers, start, end in zip(drops, own, places, places[1:], strict=False):
            design, target = rows(fitted_drop, values, UNIT * numbers[:3], numbers[3:])
            at = np.r_[0:p, start:end]
            normal[np.ix_(at, at)] += design.T @ design
            right[at] += design.T @ target
            errors = np.arange(start + 3, end)
            normal[errors, errors] += 1.0
        solved = np.asarray(np.linalg.solve(normal, right), dtype=np.float64)
        values, own = solved[:p], [solved[start:end] for start, end in pairwise(places)]
    return values, np.sqrt(np.diag(np.linalg.inv(normal))[:p])


@pytest.mark.parametrize(("seed", "robot", "misfit"), [(12, ROBOT, 1.0), (OTHER_ROBOT, OTHER_ROBOT, 200.0)])
def test_drops_together_are_one_fit_to_all_data_also_if_one_was_widened(
    seed: int, robot: int, misfit: float
) -> None:
    """Widened by much the prior weighs in its own fit, and must not be counted once a drop."""
    sharp, other = fit_drop(11, robot=ROBOT), fit_drop(seed, robot=robot)
    vague = replace(other, fit=widen_fit(other.fit, misfit))
    values, std = at_once([sharp, vague])
    assert (np.abs(values) < 10.0).all(), "no bound is in the way"
    together = combine([sharp.fit, vague.fit])
    np.testing.assert_allclose(together.values, values, atol=1e-3)
    np.testing.assert_allclose(together.std / together.widened_by, std, rtol=2e-3)


def test_a_drop_with_something_against_it_corrects_no_other() -> None:
    first, second = fit_drop(11, robot=ROBOT), fit_drop(12, robot=ROBOT)
    wrong = replace(make_fitted_drop("c", fit_drop(OTHER_ROBOT)), against=("Two checks failed.",))
    drops = [make_fitted_drop("a", first), make_fitted_drop("b", second), wrong]
    judgements = {judgement.name: judgement for judgement in cross_validate(drops)}
    # The drop with failed checks is in nobody's combination, but is judged itself.
    assert judgements["a"].others.values.tolist() == combine([second.fit]).values.tolist()
    assert judgements["b"].others.values.tolist() == combine([first.fit]).values.tolist()
    assert judgements["c"].others.values.tolist() == combine([first.fit, second.fit]).values.tolist()
    assert left_aside(drops) == ("Not combined: c. Two checks failed.",)
    # With nobody left to be judged by, a drop is not judged.
    assert [judgement.name for judgement in cross_validate([drops[0], wrong])] == ["c"]


def test_what_cannot_be_combined_is_refused() -> None:
    drop = fit_drop(11, robot=ROBOT)
    with pytest.raises(ValueError, match="two drops or more"):
        cross_validate([make_fitted_drop("a", drop)])
    with pytest.raises(ValueError, match="no fit"):
        combine([])
    other = replace(drop, fit=fit_model(model_offsets(MODEL), drop.flown))
    with pytest.raises(ValueError, match="not of the same offsets"):
        cross_validate(
            [make_fitted_drop("a", drop), make_fitted_drop("b", other), make_fitted_drop("c", drop)]
        )
