"""The paper's swarm on the paper's objective, next to Gauss and Newton's fit and the truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.evaluation.drops import fit_drop
from tfsat_host.evaluation.com_fit.momentum_average import averaged_momentum
from tfsat_host.evaluation.com_fit.paper_swarm import momentum_polynomial, powers, swarm_fit
from tfsat_host.plan.swarm import SwarmSettings

SEEDS = (1, 2)


def test_powers_are_those_of_a_quadratic_polynomial() -> None:
    assert powers(np.array([[2.0, 3.0]])).tolist() == [[1.0, 2.0, 3.0, 4.0, 6.0, 9.0]]
    assert powers(np.zeros((4, 9))).shape == (4, 55)


def test_55_robots_give_the_momentum_of_every_other_exactly() -> None:
    fitted_drop = fit_drop(1)
    polynomial = momentum_polynomial(fitted_drop.fit.offsets, fitted_drop.flown)
    assert len(polynomial.coefficients) == 55
    # Inside the bounds, where the swarm goes, and far outside, where an approximation would fail.
    for reach_mm in (1.0, 10.0, 100.0):
        vectors = np.random.default_rng(0).uniform(-reach_mm, reach_mm, (20, 9))
        direct = averaged_momentum(fitted_drop.fit.offsets.apply(vectors), fitted_drop.flown)
        strayed = (direct.values - direct.values[:, :1]).swapaxes(1, 2)
        np.testing.assert_allclose(polynomial.momentum_change(vectors), strayed, atol=1e-13 * reach_mm)
        np.testing.assert_allclose(polynomial.objective(vectors), direct.objective, rtol=1e-9)


def test_the_swarm_lowers_the_objective_but_gauss_newton_comes_nearer_to_truth() -> None:
    for seed in SEEDS:
        fitted_drop = fit_drop(seed)
        swarm = swarm_fit(fitted_drop.fit, fitted_drop.flown)
        truth = fitted_drop.drop.true_com_offsets_mm
        assert swarm.objective < 0.4 * swarm.objective_before
        each = momentum_polynomial(fitted_drop.fit.offsets.alone, fitted_drop.flown).objective(swarm.each)
        assert swarm.objective == pytest.approx(each.min())
        assert (np.abs(swarm.values) <= 10.0).all()
        # The paper's swarm stops far from its own objective's valley floor.
        assert swarm.objective_gauss_newton < 0.5 * swarm.objective
        assert np.linalg.norm(fitted_drop.fit.values - truth) < 1.0
        assert np.median(np.linalg.norm(swarm.each - truth, axis=1)) > 2.0
        assert int(swarm.spread.argmax()) == 5, "body 2 z is what it can tell least"
        assert not swarm.converged
        assert swarm.objective_below < swarm.objective
        searched, stopped = swarm.sentences()
        assert searched == "10 swarms of 48 particles, 50 iterations each."
        assert stopped.startswith("They did not converge: the best stopped at J = ")
        np.testing.assert_allclose(swarm.spread, np.std(swarm.each, axis=0, ddof=1))


def test_the_bottom_of_the_valley_is_what_a_swarm_is_judged_by() -> None:
    fitted_drop = fit_drop(1)
    small = SwarmSettings(particles=20, iterations=5)
    swarm = swarm_fit(fitted_drop.fit, fitted_drop.flown, seeds=(1, 2), settings=small)
    other = swarm_fit(fitted_drop.fit, fitted_drop.flown, seeds=(3, 4), settings=small)
    # One valley for all, and below Gauss and Newton's offsets, which minimize something else.
    assert swarm.objective_below == pytest.approx(other.objective_below, rel=1e-3)
    assert swarm.objective_below < swarm.objective_gauss_newton
    arrived = replace(swarm, objective=1.005 * swarm.objective_below)
    assert arrived.converged
    assert arrived.sentences() == ("2 swarms of 20 particles, 5 iterations each.",)
    assert not replace(arrived, objective=1.02 * swarm.objective_below).converged


def test_a_swarm_that_found_something_worse_than_nothing_says_so() -> None:
    fitted_drop = fit_drop(1)
    swarm = swarm_fit(
        fitted_drop.fit, fitted_drop.flown, seeds=(3,), settings=SwarmSettings(particles=2, iterations=1)
    )
    assert swarm.objective > swarm.objective_before
    sentences = swarm.sentences()
    assert sentences[0] == "1 swarm of 2 particles, 1 iterations each."
    assert sentences[1].startswith("What they found is worse than no correction: J is ")
    assert not swarm.converged


def test_what_it_reports_is_the_objective_of_what_it_found() -> None:
    fitted_drop = fit_drop(1)
    swarm = swarm_fit(
        fitted_drop.fit, fitted_drop.flown, seeds=(3,), settings=SwarmSettings(particles=20, iterations=5)
    )
    vectors = np.stack([swarm.values, np.zeros(9), fitted_drop.fit.values])
    direct = averaged_momentum(fitted_drop.fit.offsets.apply(vectors), fitted_drop.flown).objective
    stated = [swarm.objective, swarm.objective_before, swarm.objective_gauss_newton]
    np.testing.assert_allclose(stated, direct, rtol=1e-9)
    assert np.isnan(swarm.spread).all(), "one swarm has no spread"
    again = swarm_fit(
        fitted_drop.fit, fitted_drop.flown, seeds=(3,), settings=SwarmSettings(particles=20, iterations=5)
    )
    assert (swarm.values == again.values).all()
