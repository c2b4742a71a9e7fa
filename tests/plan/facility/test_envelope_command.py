"""`tfsat-host envelope` as a user has it."""

from __future__ import annotations

from tests.cli.process import RunCli
from tfsat_host.maneuver import Maneuver, Stroke, four_stroke, write_maneuver
from tfsat_host.plan.facility import default_facility_path
from tfsat_host.robot.path import default_robot_path


def test_the_maneuver_of_the_paper_fits(tfsat_host: RunCli) -> None:
    result = tfsat_host.json("envelope", 59, 70)
    assert result["fits"] is True
    assert all(check["passed"] for check in result["checks"])
    assert result["facility"] == "COSMOTORRE"
    assert result["end_s"] == 2.23
    assert 100.0 < result["max_radius_mm"] < 165.0
    # What is left of the radius, over the fall's seconds.
    assert result["permissible_transversal_velocity_mm_s"] * 2.5 == 165.0 - result["max_radius_mm"]


def test_a_person_reads_every_check_and_the_verdict(tfsat_host: RunCli) -> None:
    text = tfsat_host("envelope", 59, 70).stdout
    for check in tfsat_host.json("envelope", 59, 70)["checks"]:
        assert check["name"] in text
    lines = text.splitlines()
    assert lines[0] == lines[-1] == "FITS COSMOTORRE: 11 of 11 checks passed"
    assert len(lines) <= 40
    full = tfsat_host("envelope", 59, 70, "--full").stdout
    assert "opens upwards" in full and "opens upwards" not in text
    assert "at most 165.0 mm" in text


def test_a_maneuver_that_does_not_fit_ends_with_3_and_says_why(tfsat_host: RunCli) -> None:
    result = tfsat_host.json("envelope", 66, 67, expect=3)
    assert result["fits"] is False
    assert [check["name"] for check in result["checks"] if not check["passed"]] == ["stroke-time"]
    text = tfsat_host("envelope", 66, 67, expect=3).stdout
    # The check that failed is named in the verdict.
    assert text.splitlines()[-1] == "DOES NOT FIT COSMOTORRE: 1 of 11 checks failed (stroke-time)"
    assert "Joints move for 1.565 s" in text and "tfsat-host design" in text


def test_a_file_says_the_same_as_its_angles(tfsat_host: RunCli) -> None:
    write_maneuver(four_stroke(59, 70), tfsat_host.folder / "maneuver.toml")
    assert tfsat_host.json("envelope", "--file", "maneuver.toml") == tfsat_host.json("envelope", 59, 70)


def test_another_facility_has_other_walls(tfsat_host: RunCli) -> None:
    text = default_facility_path().read_text(encoding="utf-8")
    narrow = text.replace("envelope_radius_mm = 165.0", "envelope_radius_mm = 110.0")
    (tfsat_host.folder / "narrow.toml").write_text(narrow, encoding="utf-8")
    result = tfsat_host.json("envelope", 59, 70, "--facility", "narrow.toml", expect=3)
    assert [c["name"] for c in result["checks"] if not c["passed"]] == ["envelope", "transversal-velocity"]
    # A radius beyond the wall leaves no velocity at all.
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


def write_robot(tfsat_host: RunCli, name: str, old: str, new: str) -> None:
    text = default_robot_path().read_text(encoding="utf-8")
    assert old in text
    (tfsat_host.folder / name).write_text(text.replace(old, new), encoding="utf-8")


def test_the_robot_starts_from_its_own_pose(tfsat_host: RunCli) -> None:
    write_robot(tfsat_host, "open.toml", "start_deg = 0.0", "start_deg = 45.0")
    strokes = [
        Stroke(1, 45.0),
        Stroke(2, 45.0),
        Stroke(3, 37.5),
        Stroke(1, -45.0),
        Stroke(2, -45.0),
        Stroke(3, -37.5),
    ]
    write_maneuver(Maneuver(tuple(strokes)), tfsat_host.folder / "maneuver.toml")
    assert tfsat_host.json("envelope", "--file", "maneuver.toml")["fits"] is True
    result = tfsat_host.json("envelope", "--file", "maneuver.toml", "--robot", "open.toml", expect=3)
    assert [c["name"] for c in result["checks"] if not c["passed"]] == ["envelope", "transversal-velocity"]
    # The same maneuver from an open start pose reaches twice as far.
    assert result["max_radius_mm"] > 200.0


def test_a_maneuver_beyond_the_robots_own_limits_is_refused(tfsat_host: RunCli) -> None:
    write_robot(tfsat_host, "stiff.toml", "limits_deg = [0.0, 90.0]", "limits_deg = [0.0, 45.0]")
    assert tfsat_host.json("envelope", 40, 40, "--robot", "stiff.toml")["fits"] is True
    error = tfsat_host.json("envelope", 70, 57, "--robot", "stiff.toml", expect=1)["error"]
    assert error["code"] == "joint-range"
    assert "from 0 to 45 deg" in error["what"]


def test_a_maneuver_that_the_sequencer_refuses_is_refused_for_the_robot_that_it_commands(
    tfsat_host: RunCli,
) -> None:
    write_robot(tfsat_host, "open.toml", "start_deg = 0.0", "start_deg = 45.0")
    error = tfsat_host.json("envelope", -30, 30, "--robot", "open.toml", expect=1)["error"]
    assert (error["code"], "to -30.00 deg" in error["what"]) == ("joint-range", True)


def test_a_robot_of_studies_is_checked_by_its_own_limits(tfsat_host: RunCli) -> None:
    result = tfsat_host.json("envelope", 30, 40, "--robot", "cubesat_3u", expect=3)
    assert [c["name"] for c in result["checks"] if not c["passed"]] == ["stroke-time", "landing"]
    (tfsat_host.folder / "none.toml").write_text("schema = 1\nstrokes = []\n", encoding="utf-8")
    error = tfsat_host.json("envelope", "--file", "none.toml", "--robot", "cubesat_3u", expect=1)["error"]
    assert error["code"] == "no-strokes"


def test_a_robot_that_turns_at_the_release_reaches_further(tfsat_host: RunCli) -> None:
    result = tfsat_host.json("envelope", 59, 70, "--initial-rate", 20, 0, 0, expect=3)
    assert result["initial_rate_deg_s"] == [20.0, 0.0, 0.0]
    assert result["max_radius_mm"] > 200.0
    error = tfsat_host.json("envelope", 59, 70, "--initial-rate", 0, "nan", 0, expect=2)["error"]
    assert "is no rate" in error["what"]


def test_robots_without_joints_or_outlines_are_refused_in_words(tfsat_host: RunCli) -> None:
    text = default_robot_path().read_text(encoding="utf-8")
    head, body = text.split("[[joint]]")[0].rsplit("[[body]]", 1)
    alone = head.split("[[body]]")[0].replace('base = "body 3"', 'base = "body 4"') + "[[body]]" + body
    (tfsat_host.folder / "alone.toml").write_text(alone, encoding="utf-8")
    error = tfsat_host.json("envelope", 59, 70, "--robot", "alone.toml", expect=1)["error"]
    assert "the robot has no joints" in error["what"]
    bare = "\n".join(line for line in text.splitlines() if not line.startswith("boxes_mm"))
    (tfsat_host.folder / "bare.toml").write_text(bare, encoding="utf-8")
    error = tfsat_host.json("envelope", 59, 70, "--robot", "bare.toml", expect=1)["error"]
    assert "no shape is given for body 1, body 2, body 3, body 4" in error["what"]


def test_a_spring_that_only_balances_the_magnet_does_not_detach(tfsat_host: RunCli) -> None:
    text = default_facility_path().read_text(encoding="utf-8")
    weak = text.replace("spring_force_n = 11.1", "spring_force_n = 10.0")
    (tfsat_host.folder / "weak.toml").write_text(weak, encoding="utf-8")
    result = tfsat_host.json("envelope", 59, 70, "--facility", "weak.toml", expect=3)
    assert [c["name"] for c in result["checks"] if not c["passed"]] == ["detaching-force"]
    # Exactly as strong as the magnet: nothing detaches.
    assert "more than 10.0 N" in tfsat_host("envelope", 59, 70, "--facility", "weak.toml", expect=3).stdout
