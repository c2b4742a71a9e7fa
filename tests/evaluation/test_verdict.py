"""What makes an evaluation doubtful, and how it says so."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.evaluation.run_folder import CERTIFICATE, made_drop, made_folder
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.checks.check import Kind
from tfsat_host.evaluation.com_fit.model_comparison import UNEXPLAINED
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.evaluation.laser_velocity import ReleaseVelocity, Velocity
from tfsat_host.evaluation.verdict import OFF_SHARE, refusal_verdict, verdict_of
from tfsat_host.robot import load_robot


@cache
def good() -> Evaluation:
    drop = made_drop()
    return evaluate(drop.log, load_robot(), read_calibration(made_folder() / CERTIFICATE), drop.schedule)


def reason(evaluation: Evaluation, sentence: str) -> str:
    """Return the verdict's only reason, asserting the verdict's sentence."""
    verdict = verdict_of(evaluation)
    assert verdict.level == "doubtful"
    assert verdict.sentence == f"EMULATED robot. {sentence}"
    (only,) = verdict.reasons
    return only


def test_a_good_drop_has_no_reasons() -> None:
    verdict = verdict_of(good())
    assert (verdict.level, verdict.reasons) == ("good", ())
    passed = sum(check.verdict == "passed" for check in good().checks)
    assert verdict.sentence.startswith(f"EMULATED robot. {passed} of {passed} checks passed")


def test_a_drop_that_a_flashed_image_recorded_is_not_called_emulated() -> None:
    evaluation = good()
    header = replace(evaluation.log.header, image_crc=0xC0FFEE)
    verdict = verdict_of(replace(evaluation, log=replace(evaluation.log, header=header)))
    assert verdict.sentence.startswith("28 of 28 checks passed")


def test_failed_checks_are_counted() -> None:
    failed = [Kind(f"check {n}", "deg", ()).judge(2.0, 1.0, f"It is {n}.") for n in (1, 2)]
    verdict = verdict_of(replace(good(), checks=(*good().checks, *failed)))
    assert verdict.level == "doubtful" and verdict.sentence == "EMULATED robot. 2 checks failed."
    assert verdict.reasons == ("It is 1.", "It is 2.")


def test_what_stands_against_the_calibration() -> None:
    verdict = verdict_of(good(), ["It is of another robot."])
    assert verdict.sentence == "EMULATED robot. The calibration is not valid for this drop."
    assert verdict.reasons == ("It is of another robot.",)


def test_a_note_is_a_doubt() -> None:
    evaluation = replace(good(), notes=("The gyro of body 2 lacks 5 of 700 samples.",))
    assert reason(evaluation, "Default values are used for missing data.").startswith("The gyro of body 2")


@pytest.mark.parametrize("share", [1.0 - 1.1 * OFF_SHARE, 1.0 + 1.1 * OFF_SHARE])
def test_a_stroke_that_is_not_the_one_commanded(share: float) -> None:
    first, *others = good().strokes
    off = replace(first, size_rad=share * first.commanded_rad)
    words = reason(replace(good(), strokes=(off, *others)), "Not every stroke was flown as commanded.")
    assert words.startswith(
        f"Stroke 1 (joint 1) went {math.degrees(off.size_rad):+.1f} deg instead of +59.0 deg"
    )


def test_a_servo_as_the_papers_is_no_doubt() -> None:
    first, *others = good().strokes
    assert (
        verdict_of(
            replace(good(), strokes=(replace(first, size_rad=0.93 * first.commanded_rad), *others))
        ).level
        == "good"
    )


def test_what_a_stroke_remarks() -> None:
    first, *others = good().strokes
    evaluation = replace(good(), strokes=(replace(first, remark="It went the wrong way."), *others))
    assert (
        reason(evaluation, "Not every stroke was flown as commanded.")
        == "Stroke 1 (joint 1): It went the wrong way."
    )


def test_the_fall() -> None:
    evaluation = replace(good(), instants=replace(good().instants, findings=("It hung on.",)))
    assert reason(evaluation, "The fall differs from a free fall with this maneuver.") == "It hung on."


def test_a_release_that_is_not_permitted() -> None:
    fast = Velocity(140.0, 2.0, 136.0, 144.0)
    velocity = ReleaseVelocity(
        fast,
        None,
        None,
        None,
        "outside",
        None,
        samples=40,
        samples_left_out=0,
        scatter_mm=0.4,
        from_s=0.15,
        until_s=0.7,
        notes=(),
    )
    evaluation = replace(good(), release_velocity=velocity)
    assert "Release velocity, downwards: 140 ± 2 mm/s, outside" in reason(
        evaluation, "The fall differs from a free fall with this maneuver."
    )
    perhaps = replace(velocity, downward_judged="uncertain")
    assert verdict_of(replace(good(), release_velocity=perhaps)).level == "good"


def test_a_correction_at_its_bound() -> None:
    explained = good().explained
    at_bound = np.zeros_like(explained.fit.at_bound)
    at_bound[5] = True
    evaluation = replace(good(), explained=replace(explained, fit=replace(explained.fit, at_bound=at_bound)))
    assert "its bound: body 2 CoM z." in reason(evaluation, "The correction of the model cannot be used.")


def test_a_correction_that_found_no_end() -> None:
    explained = good().explained
    evaluation = replace(good(), explained=replace(explained, fit=replace(explained.fit, converged=False)))
    assert "did not converge" in reason(evaluation, "The correction of the model cannot be used.")


def test_a_model_that_even_its_correction_does_not_mend() -> None:
    explained = good().explained
    error = explained.fitted.error
    tight = replace(error, covariance=error.covariance * (error.mahalanobis / (2 * UNEXPLAINED)) ** 2)
    evaluation = replace(good(), explained=replace(explained, fitted=replace(explained.fitted, error=tight)))
    words = reason(evaluation, "The model does not explain the motion, corrected or not.")
    assert f"{2 * UNEXPLAINED:.1f} times what" in words


def test_a_correction_that_only_spoils_a_good_model() -> None:
    explained = good().explained
    evaluation = replace(
        good(), explained=replace(explained, nominal=explained.fitted, fitted=explained.nominal)
    )
    words = reason(evaluation, "The correction of the model cannot be used.")
    assert "nothing is said against the model" in words


def test_reasons_of_several_kinds_are_all_named_once() -> None:
    evaluation = replace(
        good(), notes=("One.", "One."), checks=(Kind("check", "deg", ()).judge(2.0, 1.0, "One."),)
    )
    verdict = verdict_of(evaluation)
    assert verdict.sentence == "EMULATED robot. 1 check failed; default values are used for missing data."
    assert verdict.reasons == ("One.",)


def test_a_drop_that_was_refused() -> None:
    verdict = refusal_verdict(TfsatError(what="No release.", meaning="No drop.", next_step="Look."))
    assert (verdict.level, verdict.sentence, verdict.reasons) == (
        "failed",
        "No release.",
        ("No drop.", "Look."),
    )
