"""`tfsat-host envelope` as a user has it."""

from __future__ import annotations

from tests.cli.process import RunCli
from tfsat_host.facility.tower import default_facility_path
from tfsat_host.maneuver import four_stroke, write_maneuver


def test_the_maneuver_of_the_paper_fits(tfsat_host: RunCli) -> None:
    result = tfsat_host.json("envelope", 59, 70)
    assert result["fits"] is True
    assert all(check["passed"] for check in result["checks"])
    assert result["facility"] == "COSMOTORRE"
    assert result["end_s"] == 2.23
    assert 100.0 < result["max_radius_mm"] < 165.0
    assert result["permissible_transversal_velocity_mm_s"] * 2.5 == 165.0 - result["max_radius_mm"]


def test_a_person_reads_every_check_and_the_verdict(tfsat_host: RunCli) -> None:
    text = tfsat_host("envelope", 59, 70).stdout
    for check in tfsat_host.json("envelope", 59, 70)["checks"]:
        assert check["name"] in text
    assert "The maneuver fits COSMOTORRE: all 11 checks passed." in text
    assert "at most 165.0 mm" in text


def test_a_maneuver_that_does_not_fit_ends_with_3_and_says_why(tfsat_host: RunCli) -> None:
    result = tfsat_host.json("envelope", 66, 67, expect=3)
    assert result["fits"] is False
    assert [check["name"] for check in result["checks"] if not check["passed"]] == ["stroke-time"]
    assert "Doubtful at COSMOTORRE: stroke-time." in tfsat_host("envelope", 66, 67, expect=3).stdout


def test_a_file_says_the_same_as_its_angles(tfsat_host: RunCli) -> None:
    write_maneuver(four_stroke(59, 70), tfsat_host.folder / "maneuver.toml")
    assert tfsat_host.json("envelope", "--file", "maneuver.toml") == tfsat_host.json("envelope", 59, 70)


def test_another_facility_has_other_walls(tfsat_host: RunCli) -> None:
    text = default_facility_path().read_text(encoding="utf-8")
    narrow = text.replace("envelope_radius_mm = 165.0", "envelope_radius_mm = 110.0")
    (tfsat_host.folder / "narrow.toml").write_text(narrow, encoding="utf-8")
    result = tfsat_host.json("envelope", 59, 70, "--facility", "narrow.toml", expect=3)
    assert [c["name"] for c in result["checks"] if not c["passed"]] == ["envelope", "transversal-velocity"]
    assert result["permissible_transversal_velocity_mm_s"] < 0.0


def test_mistakes_are_named(tfsat_host: RunCli) -> None:
    for args in ((), (59,), (59, 70, "--file", "m.toml")):
        assert "tfsat-host envelope" in tfsat_host.json("envelope", *args, expect=2)["error"]["next_step"]
    (tfsat_host.folder / "long.toml").write_text(
        "schema = 1\n[[strokes]]\njoint = 1\nangle_deg = 95\n", encoding="utf-8"
    )
    error = tfsat_host.json("envelope", "--file", "long.toml", expect=1)["error"]
    assert (error["code"], error["what"].count("long.toml")) == ("joint-range", 1)
    error = tfsat_host.json("envelope", 59, 70, "--facility", "drop_tower.toml", expect=1)["error"]
    assert "drop_tower.toml cannot be read" in error["what"]
    error = tfsat_host.json("envelope", 59, 70, "--robot", "none.toml", expect=1)["error"]
    assert "none.toml" in error["what"]
