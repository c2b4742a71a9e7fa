"""The facility file: COSMOTORRE as the paper has it, and mistakes found where they stand."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from tfsat_host.plan.facility import DropTower, FacilityFileError, default_facility_path, load_tower
from tfsat_host.robot.path import default_robot_path, shipped_robots

TEXT = default_facility_path().read_text(encoding="utf-8")


def load(folder: Path, text: str) -> DropTower:
    file = folder / "tower.toml"
    file.write_text(text, encoding="utf-8")
    return load_tower(file)


def test_the_table_of_cosmotorre() -> None:
    tower = load_tower()
    assert tower.name == "COSMOTORRE"
    assert (tower.drop_height_m, tower.fall_s, tower.residual_acceleration_g) == (45.0, 2.5, 1e-3)
    assert (tower.payload_diameter_mm, tower.payload_height_mm) == (500.0, 1050.0)
    assert (tower.space_diameter_mm, tower.space_height_mm) == (500.0, 830.0)
    assert tower.envelope_radius_mm == 165.0
    assert tower.maneuver_time_max_s == 1.5
    assert tower.release_velocity_window_mm_s == (20.0, 100.0)
    assert tower.observed_release_velocity_mm_s == (30.0, 50.0)
    assert tower.observed_transversal_velocity_mm_s == 7.0
    switch = tower.switch
    assert (switch.operating_force_n, switch.releasing_force_n) == (0.49, 0.06)
    assert (switch.overtravel_mm, switch.movement_differential_mm) == (1.2, 0.8)
    assert (switch.free_position_mm, switch.operating_position_mm) == (13.6, (8.0, 9.6))


def test_robots_and_facilities_are_not_taken_for_one_another() -> None:
    assert "cosmotorre" not in shipped_robots() and "drop_tower" in shipped_robots()
    with pytest.raises(FacilityFileError, match="is a robot file, no facility file"):
        load_tower(default_robot_path())


@pytest.mark.parametrize("key", tomllib.loads(TEXT))
def test_every_entry_is_needed(tmp_path: Path, key: str) -> None:
    # Every key of the file is needed: none has a silent default.
    with pytest.raises(FacilityFileError, match=rf"tower.toml(:\d+)?: {key}: is missing"):
        load(tmp_path, TEXT.replace(f"\n{key} = ", "\n# "))


@pytest.mark.parametrize(
    ("entry", "wrong", "problem"),
    [
        ('kind = "drop tower"', 'kind = "parabolic flight"', "kind: 'parabolic flight' is not 'drop tower'"),
        ("fall_s = 2.5", "fall_s = 0", "fall_s: 0 is not a number above 0"),
        ("fall_s = 2.5", "fall_s = 4.0", "fall_s: is more than 3.03 s"),
        ("margin_s = 1.0", "margin_s = 2.5", "margin_s: leaves nothing"),
        ("margin_s = 1.0", "margin_s = -1", "margin_s: -1 is not a number of at least 0"),
        ("[20.0, 100.0]", "[100.0, 20.0]", "release_velocity_window_mm_s: .* no range"),
        ("[20.0, 100.0]", "[0, 100.0]", "release_velocity_window_mm_s: .* no range"),
        ("space_diameter_mm = 500.0", "space_diameter_mm = 501", "space_diameter_mm: .* inner capsule"),
        ("space_height_mm = 830.0", "space_height_mm = 1051", "space_height_mm: .* inner capsule"),
        ("envelope_radius_mm = 165.0", "envelope_radius_mm = 251", "envelope_radius_mm: .* half"),
        ("travel_mm = 250.0", "travel_mm = 831", "usable_vertical_travel_mm: is more than"),
        ("differential_mm = 0.8", "differential_mm = 4.0", "switch_operating_position_mm: leaves"),
        ("switch_count = 2", "switch_count = 0", "switch_count: 0 is not a whole number from 1 to 8"),
    ],
)
def test_a_mistake_is_named_with_its_line_and_cure(
    tmp_path: Path, entry: str, wrong: str, problem: str
) -> None:
    # The entry stands once in the file, so that the line can be named.
    assert TEXT.count(entry) == 1
    with pytest.raises(FacilityFileError, match=problem) as caught:
        load(tmp_path, TEXT.replace(entry, wrong))
    line_number = next(n for n, line in enumerate(TEXT.splitlines(), 1) if entry in line)
    if "pre-travel" in caught.value.what:  # a matter of two lines: the other one is named
        line_number = next(n for n, line in enumerate(TEXT.splitlines(), 1) if "operating_position" in line)
    assert f"tower.toml:{line_number}: " in caught.value.what
    assert "drop tower" in caught.value.meaning
    assert caught.value.next_step


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(FacilityFileError, match="cannot be read: No such file"):
        load_tower(tmp_path / "none.toml")
