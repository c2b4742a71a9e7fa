"""What the data tell of the offsets: of informations made by hand, and of emulated drops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.evaluation.drops import MODEL, com_offsets, fit_drop
from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.com_fit.com_fit import ModelFit, fit_model
from tfsat_host.evaluation.com_fit.identifiability import identifiability
from tfsat_host.evaluation.com_fit.momentum_residual import FallSamples
from tfsat_host.evaluation.com_fit.offsets import model_offsets

SEEDS = (1, 2, 3, 4)
PRIOR_MM = 10.0 / 3.0**0.5
BODY_2_Z = 5


def with_information(information: FloatArray) -> ModelFit:
    """Return a fit whose data have this information on nine offsets, with the resulting covariance.

    The covariance combines the information with the prior.
    """
    fit = fit_drop(1).fit
    covariance = fit.covariance.copy()
    covariance[:9, :9] = np.linalg.inv(information + np.eye(9) / PRIOR_MM**2)
    return replace(fit, equations=fit.equations._replace(information=information), covariance=covariance)


def cut(fall_samples: FallSamples, until_s: float) -> FallSamples:
    """Return the drop as if it had ended at `until_s`."""
    keep = fall_samples.t_s < until_s
    series = (
        "t_s",
        "angles_rad",
        "joint_rate_rad_s",
        "base_rate_rad_s",
        "rate_covariance",
        "attitude",
        "rate_errors",
        "angle_errors",
    )
    return replace(fall_samples, **{name: getattr(fall_samples, name)[keep] for name in series})


def test_directions_of_an_information_are_its_own() -> None:
    turn = np.eye(9)
    # Two directions of the information, at an angle to the axes.
    turn[:2, :2] = [[0.6, -0.8], [0.8, 0.6]]
    stds = np.array([0.5, 0.1, 0.2, 0.2, 0.2, 2.0, 0.2, 0.2, 0.2])
    analysis = identifiability(with_information(turn @ np.diag(stds**-2.0) @ turn.T))
    assert (analysis.unit, analysis.rank) == ("mm", 9)
    # Largest over smallest singular value, 0.1 and 2.0.
    assert analysis.condition == pytest.approx(20.0)
    singular_values = [direction.singular_value for direction in analysis.directions]
    np.testing.assert_allclose(singular_values, np.sort(1.0 / stds))
    weakest, second = analysis.directions[:2]
    assert weakest.composition == "100 % body 2 CoM z"
    # Data alone, then data and prior together.
    assert weakest.std_by_data == pytest.approx(2.0)
    assert weakest.std == pytest.approx((2.0**-2 + PRIOR_MM**-2) ** -0.5)
    assert weakest.prior_std == pytest.approx(PRIOR_MM)
    assert weakest.determined
    assert second.composition == "64 % body 1 CoM y, 36 % body 1 CoM x"
    assert analysis.sentences()[0] == "9 of 9 parameters observable; condition number 20."


def test_a_direction_that_the_prior_decides_is_not_told() -> None:
    stds = np.full(9, 0.1)
    # One direction that the data tell worse than the prior, one that they do not tell at all.
    stds[7] = 6.0
    information = np.diag(stds**-2.0)
    information[2, 2] = 0.0
    analysis = identifiability(with_information(information))
    assert analysis.rank == 8
    assert analysis.condition == np.inf
    assert [direction.composition for direction in analysis.undetermined] == [
        "100 % body 1 CoM z",
        "100 % body 3 CoM y",
    ]
    nothing = analysis.directions[0]
    assert nothing.std_by_data == np.inf
    assert nothing.std == pytest.approx(PRIOR_MM)
    sentences = analysis.sentences()
    assert sentences[0].startswith("7 of 9 parameters observable")
    assert [sentence.startswith("Not observable: 100 % body") for sentence in sentences] == [
        False,
        False,
        True,
        True,
    ]


def test_the_papers_drop_tells_all_nine_and_body_2_z_least() -> None:
    for seed in SEEDS:
        fitted_drop = fit_drop(seed)
        analysis = identifiability(fitted_drop.fit)
        assert analysis.rank == 9
        assert not analysis.undetermined
        assert 5.0 < analysis.condition < 80.0
        weakest = analysis.directions[0]
        # More than 60 % of the weakest direction is body 2 z.
        assert weakest.components[BODY_2_Z] ** 2 > 0.6
        # What it states of each direction holds for the truth.
        off = fitted_drop.fit.values - fitted_drop.drop.true_com_offsets_mm
        for direction in analysis.directions:
            assert abs(direction.components @ off) < 4.0 * direction.std
            assert direction.std <= direction.std_by_data


def test_before_the_first_stroke_next_to_nothing_is_told() -> None:
    fitted_drop = fit_drop(1)
    # The first stroke begins at 0.7 s.
    fit = fit_model(com_offsets(MODEL), cut(fitted_drop.flown, 0.69))
    analysis = identifiability(fit)
    assert len(analysis.undetermined) >= 6
    assert analysis.directions[-1].std > 1.0, "a robot that coasts tells a little by its wobble"
    assert "more directions are not observable" in analysis.sentences()[-1]


def test_after_one_stroke_of_joint_1_less_is_told_than_after_all() -> None:
    fitted_drop = fit_drop(1)
    full_analysis = identifiability(fitted_drop.fit)
    part = identifiability(fit_model(com_offsets(MODEL), cut(fitted_drop.flown, 1.04)))
    assert 1 <= len(part.undetermined) < 9
    assert part.condition > 3.0 * full_analysis.condition


def test_nuisance_parameters_are_in_what_the_offsets_are_uncertain_by() -> None:
    fitted_drop = fit_drop(1)
    fit = fit_model(model_offsets(MODEL), fitted_drop.flown)
    analysis, exact = identifiability(fit), identifiability(fitted_drop.fit)
    assert (analysis.unit, len(analysis.directions)) == ("mm", 9)
    for direction, exact_direction in zip(analysis.directions, exact.directions, strict=True):
        assert direction.std_by_data > exact_direction.std_by_data
    # What holds them is better than their prior, and the offsets are known worse than with all else exact.
    # The data tell more of the nuisances than their prior did.
    assert (fit.std[9:] <= fit.offsets.prior_std[9:] * (1.0 + 1e-9)).all()
    assert (fit.std[:9] > fitted_drop.fit.std).all()
    assert 9.0 < fit.determined_numbers < 30.0
