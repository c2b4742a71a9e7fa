"""Turns of the whole robot by hand: the scale factor of the axis that no joint turns, and what is no such turn."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.calibration.bench_day import (
    HANDS,
    MODEL,
    SWINGS,
    TRUTH,
    TURN,
    Change,
    accept,
    add_angle,
    change_counts,
    expect_refusal,
    prepend_rest_zero,
    record,
    record_good_step,
    turn_sensor,
)
from tests.calibration.cases import case, check_refused, record_turn
from tfsat_host.calibration.solution import solve
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.calibration.steps.step import turn

BACK_AND_FORTH = [360.0, 0.0] * 3
BY = partial(partial, record_turn, TURN)


def open_joints(deg: float) -> Evidence:
    return change_counts(record_good_step(TURN), add_angle(3, deg), add_angle(4, -deg))


def test_scale_factors_within_their_intervals() -> None:
    solution = solve(prepend_rest_zero(record_good_step(TURN)), MODEL)
    for gyro, scale in zip(solution.gyros, TRUTH.gyro_scale, strict=True):
        stated = np.sqrt(gyro.covariance[8, 8])
        assert stated < 0.003
        assert abs(gyro.scale[2] - scale[2]) < 3.5 * stated
        assert set(gyro.axes) == {"z"}


def test_turns_that_are_taken() -> None:
    accept(record_turn(turn("x", 360.0), BACK_AND_FORTH, (1.0, 0.0, 0.0)), prepend_rest_zero())
    accept(record(TURN, hands=replace(HANDS, tilt_deg=0.3, placing_deg=0.3)), prepend_rest_zero())
    accept(open_joints(1.0), prepend_rest_zero())
    accept(
        record_good_step(TURN), prepend_rest_zero(*map(record_good_step, SWINGS[:3]))
    )  # judged by what the swings say


ABOUT = "The robot was turned about another axis"


@pytest.mark.parametrize(
    "row",
    [
        case(
            "180 deg",
            BY([180.0, 0.0] * 3),
            " deg, not of +360 deg",
            "Turn it by 360 deg, counter-clockwise",
            quick=False,
        ),
        case("270 deg", BY([270.0, 0.0] * 3), "Turn 1 was one of +2", "counter-clockwise"),
        case("400 deg", BY([400.0, 0.0] * 3), "Turn 1 was one of +", "Turn it by 360 deg", quick=False),
        case("the wrong way round", BY([-360.0, 0.0] * 3), "Turn 1 was one of -3", "counter-clockwise"),
        case("on and on", BY(list(360.0 * np.arange(1, 7))), "not of -360 deg", "then back"),
        case("about x", BY(BACK_AND_FORTH, (1.0, 0.0, 0.0)), ABOUT, "its z axis is upright", quick=False),
        case("about y", BY(BACK_AND_FORTH, (0.0, 1.0, 0.0)), ABOUT, "its z axis is upright", quick=False),
        case("askew", BY(BACK_AND_FORTH, (0.0, 0.5, 0.8660254)), ABOUT, "its z axis is upright"),
        case("too few", BY([360.0, 0.0] * 2), "turned 4 times; at least 5 turns are needed", "three times"),
        case("no rests", BY(BACK_AND_FORTH, rest_s=0.0), "at least 5 turns", "resting a second at each end"),
        case("not brought back", BY([360.0, 60.0] * 3), "Turn ", "from edge to edge"),
        case("interrupted", BY([180.0, 360.0, 180.0, 0.0] * 2), "Turn 1 was one of +1", quick=False),
        case("a joint is open", lambda: open_joints(10.0), "Joint 2 was 1", "Close all joints"),
    ],
)
def test_what_is_no_turn_is_refused(row: Any) -> None:
    check_refused(row)


def mount_sensor(body: int, *rotvec_deg: float) -> Change:
    return turn_sensor(body, np.rint(Rotation.from_rotvec(rotvec_deg, degrees=True).as_matrix()))


@pytest.mark.parametrize("body", [1, pytest.param(3, marks=pytest.mark.prove)])
@pytest.mark.parametrize(
    ("rotvec_deg", "how"),
    [
        ((90, 0, 0), "with y and z exchanged"),
        ((0, 90, 0), "with x and z exchanged"),
        ((180, 0, 0), "the other way round"),
    ],
)
def test_one_sensor_that_is_mounted_otherwise_is_named(
    body: int, rotvec_deg: tuple[int, ...], how: str
) -> None:
    error = expect_refusal(
        change_counts(record_good_step(TURN), mount_sensor(body, *rotvec_deg)), prepend_rest_zero()
    )
    assert error.what.startswith(f"The sensor on body {body} looks mounted {how}")
    assert "about the body's z axis" in error.what
