"""Turns of the whole robot by hand: the scale factor of the axis that no joint turns, and what is no such turn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.calibration.bench_day import (
    HANDS,
    MODEL,
    SWINGS,
    TRUTH,
    TURN,
    accept,
    add_angle,
    changed,
    done,
    hands_turn,
    known,
    record,
    refused,
    turn_sensor,
)
from tfsat_host.calibration.solution import solve
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.calibration.steps.step import turn

BACK_AND_FORTH = [360.0, 0.0] * 3


def turned(
    angles_deg: list[float], about: tuple[float, float, float] = (0.0, 0.0, 1.0), rest_s: float = 1.0
) -> Evidence:
    move, last_s = hands_turn(angles_deg, 3.0, rest_s, about)
    return record(TURN, motion=move, last_s=last_s)


def test_scale_factors_within_their_intervals() -> None:
    found = solve(known(done(TURN)), MODEL)
    for gyro, scale in zip(found.gyros, TRUTH.gyro_scale, strict=True):
        stated = np.sqrt(gyro.covariance[8, 8])
        assert stated < 0.003
        assert abs(gyro.scale[2] - scale[2]) < 3.5 * stated
        assert set(gyro.axes) == {"z"}


def test_a_turn_about_another_axis_as_asked() -> None:
    step = turn("x", 360.0)
    move, last_s = hands_turn(BACK_AND_FORTH, 3.0, 1.0, (1.0, 0.0, 0.0))
    accept(record(step, motion=move, last_s=last_s), known())


@pytest.mark.parametrize("angle_deg", [180.0, 270.0, 400.0])
def test_another_angle(angle_deg: float) -> None:
    error = refused(turned([angle_deg, 0.0] * 3), known())
    assert error.what.startswith("Turn ")
    assert "not of +360 deg" in error.what or "not of -360 deg" in error.what
    assert "Turn it by 360 deg, counter-clockwise" in error.next_step


def test_the_wrong_way_round() -> None:
    error = refused(turned([-360.0, 0.0] * 3), known())
    assert error.what.startswith("Turn 1 was one of -3")
    assert error.what.endswith("not of +360 deg.")


def test_on_and_on_instead_of_back() -> None:
    error = refused(turned([360.0, 720.0, 1080.0, 1440.0, 1800.0, 2160.0]), known())
    assert "not of -360 deg" in error.what
    assert "then back" in error.next_step


@pytest.mark.parametrize("about", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.5, 0.8660254)])
def test_about_another_axis(about: tuple[float, float, float]) -> None:
    error = refused(turned(BACK_AND_FORTH, about), known())
    assert error.what.startswith("The robot was turned about another axis")
    assert "its z axis is upright" in error.next_step


def test_a_robot_that_lies_a_little_wrongly_is_not_refused() -> None:
    accept(record(TURN, hands=replace(HANDS, tilt_deg=0.3, placing_deg=0.3)), known())


def test_too_few_turns() -> None:
    error = refused(turned([360.0, 0.0, 360.0, 0.0]), known())
    assert error.what == "The robot was turned 4 times; at least 5 turns are needed."
    assert "three times" in error.next_step


def test_no_rest_between_the_turns() -> None:
    error = refused(turned(BACK_AND_FORTH, rest_s=0.0), known())
    assert "at least 5 turns are needed" in error.what
    assert "resting a second at each end" in error.next_step


def test_not_brought_back_to_where_it_lay() -> None:
    error = refused(turned([360.0, 60.0] * 3), known())
    assert "from edge to edge" in error.next_step


def test_an_interrupted_turn() -> None:
    error = refused(turned([180.0, 360.0, 180.0, 0.0] * 2), known())
    assert error.what.startswith("Turn 1 was one of +1")


@pytest.mark.parametrize("body", [1, 3])
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
    rotation = np.rint(Rotation.from_rotvec(rotvec_deg, degrees=True).as_matrix())
    error = refused(changed(done(TURN), turn_sensor(body, rotation)), known())
    assert error.what.startswith(f"The sensor on body {body} looks mounted {how}")
    assert "about the body's z axis" in error.what


def test_a_joint_that_is_open() -> None:
    opened = changed(done(TURN), add_angle(3, 10.0), add_angle(4, -10.0))
    error = refused(opened, known())
    assert error.what.startswith("Joint 2 was 1")
    assert "Close all joints" in error.next_step
    accept(changed(done(TURN), add_angle(3, 1.0), add_angle(4, -1.0)), known())


def test_after_the_swings_the_turn_is_judged_by_what_they_told() -> None:
    accept(done(TURN), known(*map(done, SWINGS[:3])))
