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
    fitted,
    moved,
    moved_centers,
    with_com_offsets,
)
from tests.fixtures.emulated_drop import DLPF_42_HZ, drop
from tfsat_host.arrays import FloatArray
from tfsat_host.emulated.imperfections import draw_as_built
from tfsat_host.evaluation.com_fit.com_fit import fit_model, widen_fit
from tfsat_host.evaluation.com_fit.cross_validation import FittedDrop, combine, cross_validate, left_aside
from tfsat_host.evaluation.com_fit.momentum import derivatives, flown_of, inertial_momentum, residual_rate
from tfsat_host.evaluation.com_fit.offsets import com_offsets, model_offsets
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.rehearsal.hidden import draw_hidden, hidden_drop
from tfsat_host.robot import load_robot

ROBOT, OTHER_ROBOT = 7, 3
UNIT = 1e-3
SEEDS = (11, 12, 13)
FIRST_STROKE_S = 0.69


def final_error_deg(one: Fitted, values: FloatArray) -> float:
    """Compute the final attitude error of the model's prediction to first order.

    It is the integrated residual rate.
    """
    body = one.fit.offsets.correct(values)
    calm = one.flown.t_s < FIRST_STROKE_S
    momentum = inertial_momentum(body, one.flown)[calm].mean(axis=0)
    rate = np.einsum("nij,nj->ni", one.flown.attitude, residual_rate(body, one.flown, momentum))
    return float(np.rad2deg(np.linalg.norm(np.trapezoid(rate, one.flown.t_s, axis=0))))


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
    motion = moved(fallen.log, certificate(fallen, ROBOT))
    driven = flown_of(motion)
    return Fitted(fallen, motion, driven, fit_model(com_offsets(MODEL), driven))


def judged(name: str, one: Fitted) -> FittedDrop:
    return FittedDrop(name, one.flown, one.fit, lambda values: final_error_deg(one, values))


def test_offsets_of_two_drops_correct_the_third() -> None:
    drops = [fitted(seed, robot=ROBOT) for seed in SEEDS]
    found = cross_validate([judged(f"drop {seed}", one) for seed, one in zip(SEEDS, drops, strict=True)])
    assert [left.name for left in found] == ["drop 11", "drop 12", "drop 13"]
    truth = drops[0].drop.true_com_offsets_mm
    for left, one in zip(found, drops, strict=True):
        assert left.improved
        assert left.error_before == final_error_deg(one, np.zeros(9)) > 1.0
        assert left.error_after == final_error_deg(one, left.others.values) < 0.05
        assert left.error_own == final_error_deg(one, one.fit.values) < 0.05
        assert left.objective_after < 0.05 * left.objective_before
        assert left.own_off_std < 2.0
        assert (np.abs(left.others.values - truth) < 4.0 * left.others.std + 0.02).all()
        others = combine([other.fit for other in drops if other is not one])
        np.testing.assert_array_equal(left.others.values, others.values)
        np.testing.assert_array_equal(left.others.covariance, others.covariance)


def test_a_drop_of_another_robot_is_found_out() -> None:
    drops = [fitted(11, robot=ROBOT), fitted(12, robot=ROBOT), fitted(OTHER_ROBOT)]
    found = cross_validate([judged(name, one) for name, one in zip("abc", drops, strict=True)])
    assert found[2].own_off_std > 20.0
    assert found[2].error_after > 10.0 * found[2].error_own
    assert found[2].objective_after > 5.0 * found[0].objective_before / 100.0


def test_drops_of_one_robot_agree_and_are_not_widened() -> None:
    found = combine([fitted(seed, robot=ROBOT).fit for seed in SEEDS])
    assert found.agree and found.contradiction() == "" and found.widened_by == 1.0
    assert found.degrees_of_freedom == pytest.approx(18.0, abs=0.1), "nine of each drop, less nine"
    assert 0.01 < found.chance < 0.999


def test_a_center_of_mass_that_moved_between_drops_is_found_and_the_deviations_cover_both() -> None:
    first, same, other = fitted(11, robot=ROBOT).fit, fitted(12, robot=ROBOT).fit, moved_robot().fit
    found, before = combine([first, other]), combine([first, same])
    assert not found.agree and found.chance < 1e-6
    assert found.widened_by == pytest.approx(np.sqrt(found.chi_square / found.degrees_of_freedom))
    assert found.widened_by > 2.0
    np.testing.assert_allclose(found.std, found.widened_by * before.std, rtol=0.02)
    assert "contradict each other" in found.contradiction() and "DOUBTFUL" in found.contradiction()
    # A drop that tells nothing contradicts nobody.
    assert combine([first, widen_fit(other, 1e4)]).agree and combine([first]).agree


def test_one_fit_alone_is_itself_and_twice_the_data_halve_the_variance() -> None:
    fit = fitted(11, robot=ROBOT).fit
    alone = combine([fit])
    np.testing.assert_allclose(alone.values, fit.values, atol=1e-4)
    np.testing.assert_allclose(alone.std, fit.std, rtol=1e-6)
    twice = combine([fit, fit])
    # The prior counts once, so that two equal drops move a little farther from it.
    assert np.abs(twice.values - fit.values).max() < 0.02
    np.testing.assert_allclose(twice.std, fit.std / np.sqrt(2.0), rtol=0.01)


def test_a_drop_weighs_by_what_it_tells() -> None:
    fit = fitted(11, robot=ROBOT).fit
    together = combine([fit, widen_fit(moved_robot().fit, 100.0)])
    assert np.abs(together.values - fit.values).max() < 0.02


def test_the_prior_counts_once_however_many_drops_say_nothing() -> None:
    fit = fitted(11, robot=ROBOT).fit
    nothing = widen_fit(fit, 1e6)
    together = combine([nothing, nothing, fit])
    np.testing.assert_allclose(together.values, fit.values, atol=1e-3)
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
    one: Fitted, values: FloatArray, momentum: FloatArray, errors: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return a drop's whitened equations for offsets, momentum and sensor errors, linearized at these."""
    fit, driven = one.fit, one.flown.correct(errors)
    found = derivatives(fit.offsets, values, driven, momentum)
    residual = residual_rate(fit.offsets.correct(values), driven, momentum)
    whitening = np.linalg.inv(np.linalg.cholesky(fit.widening * found.noise))
    # The momentum in small units, else the system is numerically singular.
    columns = np.concatenate([found.by_offsets, UNIT * found.by_momentum, found.by_errors], axis=2)
    target = columns @ np.concatenate([values, momentum / UNIT, errors]) - residual
    white = np.einsum("nij,nj->ni", whitening, target)
    return (whitening @ columns).reshape(-1, columns.shape[2]), white.ravel()


def at_once(drops: list[Fitted]) -> tuple[FloatArray, FloatArray]:
    """Offsets and their standard deviations by one fit to all drops, with momentum and errors of each: Gauss-Newton."""
    p = len(drops[0].fit.offsets)
    values = drops[0].fit.values
    own = [np.concatenate([one.fit.momentum_kg_m2_s / UNIT, one.fit.errors]) for one in drops]
    places = np.cumsum([p, *map(len, own)])
    normal = np.empty((0, 0))
    for _ in range(6):
        normal, right = np.zeros((places[-1], places[-1])), np.zeros(places[-1])
        normal[:p, :p] = np.diag(drops[0].fit.offsets.prior_std ** -2.0)
        for one, numbers, start, end in zip(drops, own, places, places[1:], strict=False):
            design, target = rows(one, values, UNIT * numbers[:3], numbers[3:])
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
    sharp, other = fitted(11, robot=ROBOT), fitted(seed, robot=robot)
    vague = replace(other, fit=widen_fit(other.fit, misfit))
    values, std = at_once([sharp, vague])
    assert (np.abs(values) < 10.0).all(), "no bound is in the way"
    together = combine([sharp.fit, vague.fit])
    np.testing.assert_allclose(together.values, values, atol=1e-3)
    np.testing.assert_allclose(together.std / together.widened_by, std, rtol=2e-3)


def test_a_drop_with_something_against_it_corrects_no_other() -> None:
    first, second = fitted(11, robot=ROBOT), fitted(12, robot=ROBOT)
    wrong = replace(judged("c", fitted(OTHER_ROBOT)), against=("Two checks failed.",))
    drops = [judged("a", first), judged("b", second), wrong]
    found = {left.name: left for left in cross_validate(drops)}
    assert found["a"].others.values.tolist() == combine([second.fit]).values.tolist()
    assert found["b"].others.values.tolist() == combine([first.fit]).values.tolist()
    assert found["c"].others.values.tolist() == combine([first.fit, second.fit]).values.tolist()
    assert left_aside(drops) == ("The offsets of c are in no combination: Two checks failed.",)
    # With nobody left to be judged by, a drop is not judged.
    assert [left.name for left in cross_validate([drops[0], wrong])] == ["c"]


def test_what_cannot_be_combined_is_refused() -> None:
    one = fitted(11, robot=ROBOT)
    with pytest.raises(ValueError, match="two drops or more"):
        cross_validate([judged("a", one)])
    with pytest.raises(ValueError, match="no fit"):
        combine([])
    other = replace(one, fit=fit_model(model_offsets(MODEL), one.flown))
    with pytest.raises(ValueError, match="not of the same offsets"):
        cross_validate([judged("a", one), judged("b", other), judged("c", one)])
