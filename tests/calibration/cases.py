"""Tables of steps that a campaign refuses, with the words of the reason, and of those that it takes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import pytest

from tests.calibration.bench_day import (
    MODEL,
    expect_refusal,
    hands_move,
    hands_turn,
    prepend_rest_zero,
    record,
)
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.calibration.steps.step import Step
from tfsat_host.robot import RobotModel

Make = Callable[[], Evidence]


def case(
    name: str,
    make: Make,
    what: str,
    cure: str = "",
    *,
    earlier: Callable[[], Sequence[Evidence]] = prepend_rest_zero,
    model: RobotModel = MODEL,
    quick: bool = True,
) -> Any:
    """Build a row for `check_refused`: the error's expected finding and next step.

    Without `quick` it runs under `make prove`.
    """
    # Each case needs a recording of its own, half a second to two.
    marks = () if quick else pytest.mark.prove
    return pytest.param((make, what, cure, earlier, model), id=name, marks=marks)


def check_refused(row: tuple[Make, str, str, Callable[[], Sequence[Evidence]], RobotModel]) -> None:
    """Check that the step is refused in these words."""
    make, what, cure, earlier, model = row
    error = expect_refusal(make(), earlier(), model)
    assert what in error.what
    # A person reads the meaning and the next step as one text.
    assert cure in f"{error.meaning} {error.next_step}"


def record_move(
    step: Step,
    stops_deg: Sequence[float],
    leg_s: float = 1.0,
    rest_s: float = 0.0,
    held_bodies: Sequence[int] | None = None,
) -> Evidence:
    """Record the step's joint moved through these stops by steady hands.

    They hold the bodies that the step says, or `held_bodies`.
    """
    hands = hands_move(
        step.moving_joint, step.held if held_bodies is None else held_bodies, stops_deg, leg_s, rest_s
    )
    return record(step, motion=hands[0], last_s=hands[1])


def record_turn(
    step: Step,
    angles_deg: Sequence[float],
    about: tuple[float, float, float] = (0.0, 0.0, 1.0),
    leg_s: float = 3.0,
    rest_s: float = 1.0,
) -> Evidence:
    """Record the closed robot turned through these angles about a body axis by steady hands."""
    hands = hands_turn(angles_deg, leg_s, rest_s, about)
    return record(step, motion=hands[0], last_s=hands[1])
