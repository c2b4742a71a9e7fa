"""How long a calibration holds: what a landing ends, what is missing, and what to type then."""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime, timedelta

import numpy as np
import pytest

from tests.calibration.bench_day import MODEL, SWINGS, later, prepend_rest_zero, record_good_step
from tests.calibration.some_calibration import MEASURED, whole_calibration
from tfsat_host.calibration.certificate.certificate import (
    Calibration,
    Landing,
    commands_of,
    quantities,
    summarize_shortcomings,
    with_landing,
)
from tfsat_host.calibration.sensors.gyro import by_design
from tfsat_host.calibration.solution import solve

HOUR = timedelta(hours=1)


def calibration_with_landing(at: datetime) -> Calibration:
    return with_landing(whole_calibration(), Landing(at, "a test"))


def names(calibration: Calibration, reason: str, before: datetime | None = None) -> list[str]:
    return [gap.name for gap in calibration.shortcomings(before) if gap.state == reason]


def test_a_whole_calibration_lacks_nothing() -> None:
    all_quantities = quantities(whole_calibration())
    assert len(all_quantities) == 4 + 3 + 8 + 12 + 3
    assert len({quantity.name for quantity in all_quantities}) == len(all_quantities)
    assert whole_calibration().shortcomings() == ()
    assert whole_calibration().last_landing is None
    assert summarize_shortcomings(()) == ""


def test_a_landing_ends_all_but_the_scale_factors() -> None:
    calibration = calibration_with_landing(MEASURED + HOUR)
    stale = names(calibration, "stale")
    assert len(stale) == 18
    assert not [name for name in stale if "scale" in name]
    for quantity_name in (
        "bias of body 4",
        "zero point of joint 2",
        "misalignment of body 1 about y",
        "servo of joint 3",
    ):
        assert quantity_name in stale
    assert names(calibration, "missing") == []


def test_what_was_measured_after_the_landing_holds() -> None:
    calibration = calibration_with_landing(MEASURED - HOUR)
    assert calibration.shortcomings() == ()
    later = MEASURED + 2 * HOUR
    fresh = tuple(replace(gyro, bias_recorded_at=later) for gyro in calibration.gyros)
    partly = with_landing(replace(calibration, gyros=fresh), Landing(MEASURED + HOUR, "a test"))
    assert len(names(partly, "stale")) == 14
    assert "bias of body 1" not in names(partly, "stale")


def test_of_two_directions_only_the_one_from_before_the_landing_is_stale() -> None:
    calibration = whole_calibration()
    swung = replace(calibration.gyros[0], axes={"x": MEASURED + 2 * HOUR, "y": MEASURED})
    calibration = replace(calibration, gyros=(swung, *calibration.gyros[1:]))
    assert calibration.shortcomings() == ()
    calibration = with_landing(calibration, Landing(MEASURED + HOUR, "a test"))
    assert names(calibration, "missing") == []
    of_body = [gap for gap in calibration.shortcomings() if gap.name.startswith("misalignment of body 1")]
    assert [(gap.name, gap.state, gap.measured_at) for gap in of_body] == [
        ("misalignment of body 1 about y", "stale", MEASURED)
    ]
    assert [*map(str, commands_of(of_body))] == ["tfsat-host calibrate misalignment --joint 2"]


def test_what_a_landing_makes_stale_comes_out_of_the_recordings_and_is_not_forgotten() -> None:
    swung = [*prepend_rest_zero(*map(record_good_step, SWINGS)), later(record_good_step(SWINGS[0]), 600)]
    landing = later(record_good_step(SWINGS[0]), 300).recorded_at
    gyros = solve(swung, MODEL, landing).gyros
    calibration = with_landing(replace(whole_calibration(), gyros=gyros), Landing(landing, "a test"))
    of_body = [gap for gap in calibration.shortcomings() if gap.name.startswith("misalignment of body")]
    assert {gap.state for gap in of_body} == {"stale"}
    assert len(of_body) == 7
    assert "misalignment of body 1 about x" not in [gap.name for gap in of_body]


def test_only_landings_before_a_recording_count_for_it() -> None:
    calibration = calibration_with_landing(MEASURED + HOUR)
    assert names(calibration, "stale", before=MEASURED + HOUR / 2) == []
    assert len(names(calibration, "stale", before=MEASURED + 2 * HOUR)) == 18
    # Its own landing does not count, nor does one at the very moment.
    assert names(calibration, "stale", before=MEASURED + HOUR) == []


def test_a_landing_is_added_once_and_in_order() -> None:
    calibration = calibration_with_landing(MEASURED + HOUR)
    assert (
        with_landing(calibration, Landing(MEASURED + HOUR + timedelta(seconds=119), "it again"))
        is calibration
    )
    assert (
        with_landing(calibration, Landing(MEASURED + HOUR - timedelta(seconds=119), "it again"))
        is calibration
    )
    twice = with_landing(calibration, Landing(MEASURED + HOUR + timedelta(seconds=121), "another"))
    thrice = with_landing(twice, Landing(MEASURED - HOUR, "an earlier one"))
    assert [landing.told_by for landing in thrice.landings] == ["an earlier one", "a test", "another"]
    assert thrice.last_landing == MEASURED + HOUR + timedelta(seconds=121)


def test_what_is_missing_and_how_to_measure_it() -> None:
    calibration = whole_calibration()
    bare = replace(
        calibration,
        gyros=(by_design(1, np.eye(3)), *calibration.gyros[1:]),
        servo_maps=calibration.servo_maps[:1],
    )
    assert names(bare, "missing") == [
        "bias of body 1",
        "misalignment of body 1 about x",
        "misalignment of body 1 about y",
        "scale factor x of body 1",
        "scale factor y of body 1",
        "scale factor z of body 1",
        "servo of joint 2",
        "servo of joint 3",
    ]
    assert tuple(map(str, commands_of(bare.shortcomings()))) == (
        "tfsat-host calibrate bias",
        "tfsat-host calibrate misalignment --joint 1",
        "tfsat-host calibrate misalignment --joint 2",
        "tfsat-host calibrate scale --joint 1",
        "tfsat-host calibrate scale --joint 2",
        "tfsat-host calibrate scale --turn z 360",
        "tfsat-host calibrate servo --joint 2",
        "tfsat-host calibrate servo --joint 3",
    )
    assert summarize_shortcomings(bare.shortcomings()) == ("8 calibrations missing")
    assert (
        summarize_shortcomings(calibration_with_landing(MEASURED + HOUR).shortcomings())
        == "18 calibrations older than the last landing"
    )


@pytest.mark.parametrize(("body", "joint"), [(1, 1), (2, 1), (3, 1), (4, 3)])
def test_each_body_is_turned_about_x_by_a_joint_that_moves_it(body: int, joint: int) -> None:
    calibration = whole_calibration()
    gyros = tuple(
        replace(gyro, axes={"y": MEASURED}, scaled=dict.fromkeys("yz", MEASURED))
        if gyro.body == body
        else gyro
        for gyro in calibration.gyros
    )
    assert tuple(map(str, commands_of(replace(calibration, gyros=gyros).shortcomings()))) == (
        f"tfsat-host calibrate misalignment --joint {joint}",
        f"tfsat-host calibrate scale --joint {joint}",
    )
