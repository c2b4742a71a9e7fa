"""Drops of robots and sensors that are not as filed, judged by their truth: a few of `make evaluation-report`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.evaluation.drops import few_of
from tests.validation.calibration_proof.robots import Errors
from tests.validation.evaluation_proof.figures import COVERED
from tests.validation.evaluation_proof.learning import FIRST_SEED, Lesson, compare_maneuvers, learning_csv
from tests.validation.evaluation_proof.mismatch_tables import make_mismatch_tables, summary
from tests.validation.evaluation_proof.mismatches import PROTECTED, ROWS, Judged, Row, judge_drop, seeds_of

BY_NAME = {row.name: row for row in ROWS}
FEW = ("nothing", "masses 5 %")
NOTHING, MASSES, SENSORS = BY_NAME["nothing"], BY_NAME["masses 5 %"], BY_NAME["an IMU 2 ms late"]


# One drop with one joint at a time, one with joints together.
@pytest.mark.parametrize("number", [0, 1])
@pytest.mark.parametrize("row", few_of(*(BY_NAME[name] for name in FEW), *ROWS, least=len(FEW)))
def test_what_is_called_good_holds(row: Row, number: int) -> None:
    outcome = judge_drop(row, seeds_of(row)[number])
    assert outcome.together == (number == 1)
    # GOOD with a number beyond 4.5 of its standard deviations would be a false GOOD.
    assert not (outcome.good and outcome.worst > 4.5)
    # A failed check must show in the verdict and in the worth of the correction.
    assert not (outcome.failed and (outcome.good or outcome.worth == "to be made"))
    if row.of_model:
        # Attitudes and strokes rest on sensors alone: a wrong model file must not withhold them.
        assert not {"attitudes", "strokes"} & {*outcome.withheld}
    if row.right:
        assert not outcome.withheld


def test_a_bias_that_steps_is_found_by_evidence_alone() -> None:
    """No single check sees it; by the evidence of the whole drop its gyro is named and left out."""
    row = BY_NAME["a bias steps 0.3 deg/s in the fall"]
    # The 13th drop of the row: only the evidence of the whole drop shows its step.
    outcome = judge_drop(row, seeds_of(row)[12])
    assert outcome.failed == ("as filed and certified",)
    assert not outcome.good and not outcome.withheld and outcome.worst < 4.0


def test_axes_that_lean_by_more_than_filed_widen_what_rests_on_them() -> None:
    row = BY_NAME["hinge axes 1 deg"]
    outcome = judge_drop(row, seeds_of(row)[2])
    assert "gyros of bodies 1 and 2" in outcome.failed
    assert not outcome.withheld and outcome.widening > 1.0 and outcome.worst < 4.0 and not outcome.good


def make_judged(count: int, times: float = 1.0, **changed: object) -> list[Judged]:
    """Errors so many times as wide as stated."""
    # Standard normal errors with std 1: exactly what right intervals give.
    random = np.random.default_rng(1)
    errors = [
        {name: Errors(times * random.standard_normal(3), np.ones(3)) for name in PROTECTED}
        for _ in range(count)
    ]
    judged_drops = (
        Judged(number % 2 == 1, drop_errors, (), False, "to be made", (), 1.0)
        for number, drop_errors in enumerate(errors)
    )
    return [replace(judged_drop, **changed) for judged_drop in judged_drops]  # type: ignore[arg-type]


def test_right_intervals_are_told_from_wrong_ones() -> None:
    right = summary(NOTHING, make_judged(100))
    assert right.met and all(COVERED[0] < share < COVERED[1] for share in right.hold) and not right.off
    # Twice too wide errors and a third of them: both say that stated deviations are wrong.
    for wrong in (make_judged(100, 2.0), make_judged(100, 0.3)):
        assert not summary(NOTHING, wrong).met
    assert summary(SENSORS, make_judged(100, 2.0)).off == tuple(PROTECTED)


def test_good_is_said_of_numbers_that_hold_alone() -> None:
    # An error of 5 standard deviations, in a drop that is first DOUBTFUL and then GOOD.
    off = {"CoM": Errors(np.array([5.0]), np.ones(1))}
    first, *others = make_judged(100)
    far = replace(first, errors={**first.errors, **off})
    assert summary(NOTHING, [*others, far]).met
    wrong = summary(NOTHING, [*others, replace(far, good=True)])
    assert wrong.wrong == 1 and not wrong.met


# Withholding protects from errors; the limit of 5 % keeps it from being the way out.
def test_withholding_everything_is_no_answer() -> None:
    # Of 100 drops of a right robot 5 may withhold a result, 6 may not.
    few, many = (
        make_judged(95) + make_judged(5, withheld=("offsets",)),
        make_judged(94) + make_judged(6, withheld=("offsets",)),
    )
    assert summary(NOTHING, few).met and not summary(NOTHING, many).met
    # A robot with wrong masses may withhold its offsets as often as needed, its strokes never.
    assert summary(MASSES, many).met
    assert not summary(MASSES, make_judged(99) + make_judged(1, withheld=("strokes",))).met
    nothing_given = summary(SENSORS, make_judged(30, withheld=tuple({*PROTECTED.values()}), errors={}))
    assert nothing_given.met and np.isnan(nothing_given.hold).all()


def test_lessons_are_told_maneuver_by_maneuver() -> None:
    errors = {
        "59/70": Errors(np.full(9, 2.0), np.ones(9)),
        "to learn: other": Errors(np.full(9, 0.5), np.ones(9)),
    }
    # z = 2.00 where the error is twice the stated deviation, 0.50 where it is half of it.
    compared = compare_maneuvers([Lesson(errors)] * 3).splitlines()
    rows = learning_csv([Lesson(errors)] * 3).splitlines()
    assert compared[1:] == ["59/70,2.0000,2.0000,1.0000,2.00,0.0", "other,0.5000,0.5000,1.0000,0.50,100.0"]
    assert rows[1:] == [f"{seed},2.000,1.000,0.500,1.000" for seed in range(FIRST_SEED, FIRST_SEED + 3)]


def test_tables_have_a_row_each_or_one_a_drop() -> None:
    tables = make_mismatch_tables({row.name: make_judged(3) for row in ROWS})
    verdicts = [line.replace('"', "") for line in tables["mismatch-verdicts"].splitlines()]
    # A comma in a name is quoted by CSV: compare without quotes.
    assert all(f"\n{row.name},0,3,none," in "\n" + "\n".join(verdicts) for row in ROWS)
    assert tables["mismatches"].count("\n") == 1 + len(ROWS)
    assert tables["mismatch-drops"].count("\n") == 1 + 3 * len(ROWS)
