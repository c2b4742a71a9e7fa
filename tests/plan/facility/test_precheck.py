"""The checks before a drop: the paper's maneuver passes all of them, and each fails when its matter is wrong."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

from tests.plan.facility.robots import schedule_of
from tfsat_host.maneuver import Schedule
from tfsat_host.plan.facility import load_tower, vertical_travel_mm
from tfsat_host.plan.reach_envelope import envelope_of
from tfsat_host.plan.tower_checks import Check, check_maneuver, release_velocities_mm_s
from tfsat_host.robot import load_robot

PAPER = schedule_of((1, 59.0), (2, 70.0), (1, -59.0), (2, -70.0))
ROBOT = load_robot()
NAMES = (
    "detaching-force",
    "separation",
    "slowest-release",
    "fastest-release",
    "pause",
    "clearance",
    "stroke-time",
    "landing",
    "envelope",
    "transversal-velocity",
    "vertical-travel",
)


def checks(schedule: Schedule = PAPER, *, mass_factor: float = 1.0, **changes: Any) -> dict[str, Check]:
    """Return the checks of a maneuver at COSMOTORRE, by name, with some of the tower's facts changed."""
    tower = dataclasses.replace(load_tower(), **changes)
    robot = dataclasses.replace(ROBOT, mass_kg=mass_factor * ROBOT.mass_kg)
    # The reach is computed with the same masses as the checks.
    envelope = envelope_of(robot, schedule, until_s=tower.fall_s)
    return {check.name: check for check in check_maneuver(schedule, robot, tower, envelope)}


def failed_names(checks_by_name: dict[str, Check]) -> set[str]:
    return {name for name, check in checks_by_name.items() if not check.passed}


def test_the_maneuver_that_was_flown_passes() -> None:
    checks_by_name = checks()
    assert tuple(checks_by_name) == NAMES
    assert failed_names(checks_by_name) == set()


def test_the_numbers_of_the_paper_stand_in_the_checks() -> None:
    checks_by_name = checks()
    assert (checks_by_name["detaching-force"].value, checks_by_name["detaching-force"].limit) == (11.1, 10.0)
    assert (checks_by_name["separation"].value, checks_by_name["separation"].limit) == (4.0, 1.0)
    assert (checks_by_name["slowest-release"].value, checks_by_name["slowest-release"].limit) == (30.0, 20.0)
    assert (checks_by_name["fastest-release"].value, checks_by_name["fastest-release"].limit) == (50.0, 100.0)
    assert (checks_by_name["pause"].value, checks_by_name["pause"].limit) == (0.7, 0.7)
    assert checks_by_name["stroke-time"].value == pytest.approx(1.5176, abs=1e-4)
    assert (round(checks_by_name["landing"].value, 2), checks_by_name["landing"].limit) == (2.23, 2.5)
    assert checks_by_name["envelope"].limit == 165.0
    assert checks_by_name["transversal-velocity"].limit == 7.0


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"spring_force_n": 9.9}, {"detaching-force"}),
        ({"spring_force_n": 10.0}, {"detaching-force"}),
        ({"residual_magnetism": 0.06}, {"detaching-force"}),
        ({"spring_stroke_mm": 0.9}, {"separation"}),
        ({"observed_release_velocity_mm_s": (19.0, 50.0)}, {"slowest-release", "pause", "clearance"}),
        ({"observed_release_velocity_mm_s": (30.0, 101.0)}, {"fastest-release", "vertical-travel"}),
        ({"clearance_mm": 21.1}, {"pause"}),
        ({"margin_s": 1.04}, {"stroke-time"}),
        ({"fall_s": 2.2, "margin_s": 0.6}, {"landing"}),
        ({"envelope_radius_mm": 120.0}, {"envelope", "transversal-velocity"}),
        ({"observed_transversal_velocity_mm_s": 20.0}, {"transversal-velocity"}),
        ({"usable_vertical_travel_mm": 155.0}, {"vertical-travel"}),
        ({"residual_acceleration_g": 5e-3}, {"vertical-travel"}),
    ],
    ids=lambda value: str(value) if isinstance(value, dict) else " ".join(sorted(value)),
)
def test_each_check_fails_for_its_own_reason(changes: dict[str, Any], expected: set[str]) -> None:
    checks_by_name = checks(**changes)
    assert failed_names(checks_by_name) == expected
    for name in expected:
        check = checks_by_name[name]
        short = check.limit - check.value if not check.at_most else check.value - check.limit
        assert short >= 0.0 if check.beyond else short > 0.0
        assert check.needed == ("more than" if check.beyond else "at most" if check.at_most else "at least")


def test_strokes_that_take_too_long_are_doubtful() -> None:
    checks_by_name = checks(schedule_of((1, 66.0), (2, 67.0), (1, -66.0), (2, -67.0)))
    assert failed_names(checks_by_name) == {"stroke-time"}


def test_a_robot_that_lands_open_reaches_the_bottom_earlier() -> None:
    strokes = schedule_of((1, 59.0), (2, 70.0))
    sink_mm = envelope_of(ROBOT, strokes, until_s=2.5).sink_mm[-1]
    assert sink_mm > 10.0
    travel_mm = checks(strokes)["vertical-travel"].value
    assert travel_mm == pytest.approx(vertical_travel_mm(50.0, 2.5, 1e-3) + sink_mm)
    assert failed_names(checks(strokes, usable_vertical_travel_mm=travel_mm - 1.0)) == {"vertical-travel"}


def test_a_heavier_robot_leaves_more_slowly_than_any_before() -> None:
    assert release_velocities_mm_s(load_tower(), 2.847) == (30.0, 50.0)
    slowest, fastest = release_velocities_mm_s(load_tower(), 4 * 2.847)
    # Four times the mass leaves half as fast: energies are the same.
    assert slowest == pytest.approx(40.67 / 2, abs=0.01)
    assert fastest == 50.0
    assert failed_names(checks(mass_factor=4.0)) == {"pause", "clearance"}


def test_a_lighter_robot_leaves_faster_than_any_before() -> None:
    slowest, fastest = release_velocities_mm_s(load_tower(), 2.847 / 4)
    assert slowest == 30.0
    assert fastest == pytest.approx(2 * 46.79, abs=0.01)


def test_every_sentence_says_its_number() -> None:
    for check in checks().values():
        assert check.sentence.endswith(".")
        assert any(character.isdigit() for character in check.sentence)
        assert check.unit in ("N", "mm", "mm/s", "s")
