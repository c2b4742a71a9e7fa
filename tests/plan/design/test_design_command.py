"""`tfsat-host design` as a user has it: a maneuver file that the next command takes."""

from __future__ import annotations

import functools
import tomllib
from pathlib import Path

import pytest

from tests.cli.process import RunCli
from tfsat_host.plan import maneuver_design as planning
from tfsat_host.plan.problem import DesignSettings
from tfsat_host.robot import RobotModel, load_robot

_design = planning.design


@functools.cache
def _design_robot(path: Path, settings: DesignSettings) -> planning.Design:
    return _design(load_robot(path), settings)


@pytest.fixture(autouse=True)
def _each_design_once(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands that design the same share it, but for the test that compares two designs."""

    def design(robot: RobotModel, settings: DesignSettings, _progress: object) -> planning.Design:
        return _design_robot(robot.path, settings)

    if "same_bytes" not in request.node.name:
        monkeypatch.setattr(planning, "design", design)


def test_the_file_is_taken_by_upload_sequence(tfsat_host: RunCli) -> None:
    designed = tfsat_host.json("design")
    assert designed["sequence"] == [1, 2, -1, -2]
    assert designed["alpha_deg"] == pytest.approx([59.5, 68.0, 0.0])
    assert designed["optimum"]["reorientation_deg"] == pytest.approx(25.677, abs=0.001)
    assert designed["optimum"]["duration_s"] == pytest.approx(1.5)
    assert designed["duration_s"] == pytest.approx(1.5)
    assert [abs(s["angle_deg"]) for s in designed["schedule"]] == [59.5, 68.0, 59.5, 68.0]
    # Every check of the precheck passes at the default settings.
    assert all(check["passed"] for check in designed["checks"])
    simulation = tfsat_host.json("simulate", "--file", "maneuver.toml")
    assert simulation["reorientation_deg"] == pytest.approx(designed["reorientation_deg"], abs=1e-6)
    assert f"{simulation['reorientation_deg']:.3f} deg" in (tfsat_host.folder / "maneuver.toml").read_text()
    upload = tfsat_host.json("upload-sequence", "--file", "maneuver.toml", "--dry-run")
    # The file is the maneuver: what is uploaded is what was designed.
    assert upload["schedule"] == designed["schedule"]
    assert upload["end_s"] == designed["end_s"]


def test_a_seed_writes_the_same_bytes(tfsat_host: RunCli) -> None:
    results = [tfsat_host.json("design", "--swarm", "--seed", 7, "--out", f"{n}.toml") for n in (1, 2)]
    first, second = ((tfsat_host.folder / f"{n}.toml").read_bytes() for n in (1, 2))
    assert first == second
    assert results[0]["swarm"] == results[1]["swarm"]
    # Near a swarm that stops elsewhere the sequencer's grid may cost or gain a tenth of a degree.
    assert results[0]["reorientation_deg"] == pytest.approx(results[0]["swarm"]["reorientation_deg"], abs=0.2)
    # The swarm ends behind the optimum.
    assert results[0]["swarm_behind_optimum_deg"] > 0.0


def test_a_person_reads_both_results_and_what_to_type_next(tfsat_host: RunCli) -> None:
    process = tfsat_host("design", "--joints", "2, 1", "--time-limit", "1.518", "--out", "mine.toml")
    assert "+2 +1 -2 -1" in process.stdout or "+1 +2 -1 -2" in process.stdout
    assert "26.123" in process.stdout and "26.068" in process.stdout
    assert "tfsat-host upload-sequence --file mine.toml" in process.stdout
    assert "11 of 11 checks passed" in process.stdout


def test_it_says_why_the_papers_maneuver_turns_farther(tfsat_host: RunCli) -> None:
    """Compare with 59/70, which takes longer than the default time limit."""
    text = " ".join(tfsat_host("design").stdout.split())
    assert "paper's 59/70 59.00 70.00 0.00 +1 +2 -1 -2 26.106 1.5318" in text
    assert "it takes 1.532 s; the time limit here is 1.5 s" in text
    assert "tfsat-host design --time-limit 1.532" in text


def test_everything_can_be_set(tfsat_host: RunCli) -> None:
    settings = ("--particles", 5, "--iterations", 3, "--inertia", "0.5,0.5", "--own-best", "1,1")
    other_settings = (
        "--best-of-all",
        "2,2",
        "--penalty",
        "1e3",
        "--limit",
        "50,60",
        "--speed",
        100,
        "--alternating",
    )
    result = tfsat_host.json("design", "--joints", "1,2", *settings, *other_settings)
    assert len(result["swarm"]["best_objective_deg"]) == 4
    assert result["swarm"]["evaluations"] == 5 * 4
    assert result["optimum"]["alpha_deg"][0] <= 50.0
    # 75 deg in 1.5 s at 100 deg/s, for two joints.
    assert sum(result["optimum"]["alpha_deg"]) == pytest.approx(75.0)
    assert tomllib.loads((tfsat_host.folder / "maneuver.toml").read_text())["speed_deg_s"] == 100.0


def test_a_robot_in_orbit_has_no_sequencer_and_no_drop_tower(tfsat_host: RunCli) -> None:
    process = tfsat_host("design", "--robot", "cubesat_3u", "--time-limit", 12)
    assert "39.408" in process.stdout
    assert process.stderr.count("\n") == 1  # progress alone
    assert "upload-sequence" not in process.stdout
    command = "simulate --file maneuver.toml --robot cubesat_3u"
    assert f"Next: tfsat-host {command}" in process.stdout
    assert tfsat_host.json(*command.split())["reorientation_deg"] == pytest.approx(39.408, abs=1e-3)
    designed = tfsat_host.json("design", "--robot", "cubesat_3u", "--time-limit", 12)
    assert designed["schedule"] is None
    assert designed["checks"] == []
    assert tomllib.loads((tfsat_host.folder / "maneuver.toml").read_text())["speed_deg_s"] == 30.0


def test_what_the_sequencer_refuses_is_said(tfsat_host: RunCli) -> None:
    process = tfsat_host("design", "--time-limit", 3)
    assert "sequencer would refuse it" in process.stderr
    assert "upload-sequence" not in process.stdout


@pytest.mark.parametrize(
    ("args", "check"),
    [(("--time-limit", "1.6"), "stroke-time"), (("--joints", "1,3"), "transversal-velocity")],
)
def test_what_fails_a_check_is_not_recommended(tfsat_host: RunCli, args: tuple[str, ...], check: str) -> None:
    # Exit code 3: the maneuver was made, and must not be flown.
    process = tfsat_host("design", *args, expect=3)
    assert f"The check {check} failed" in process.stderr
    assert "Do not fly it" in process.stdout
    assert "upload-sequence" not in process.stdout
    tfsat_host("envelope", "--file", "maneuver.toml", expect=3)


def test_a_speed_that_no_servo_reaches_is_said(tfsat_host: RunCli) -> None:
    process = tfsat_host("design", "--speed", 300, expect=None)
    assert "above the greatest rate of the servos" in process.stderr


def test_a_penalty_too_small_for_the_time_is_said(tfsat_host: RunCli) -> None:
    process = tfsat_host("design", "--penalty", 1)
    assert "longer than the time limit" in process.stderr
    assert "behind the optimum" not in process.stdout
    # The swarm left the time: what it lacks cannot be told.
    assert tfsat_host.json("design", "--penalty", 1)["swarm_behind_optimum_deg"] is None


def test_somebody_elses_file_stays(tfsat_host: RunCli) -> None:
    file = tfsat_host.folder / "maneuver.toml"
    file.write_text("mine")
    process = tfsat_host("design", expect=1)
    assert "is not, or no longer, what this command made" in process.stderr
    assert file.read_text() == "mine"
    tfsat_host("design", "--force")
    tfsat_host("design")  # over its own
    designed = file.read_text()
    edited = designed.replace("angle_deg = -", "angle_deg = -0", 1)
    file.write_text(edited)
    assert "is not, or no longer" in tfsat_host("design", expect=1).stderr
    assert file.read_text() == edited


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("--joints", "1"), "two or more"),
        (("--joints", "0,1"), "no joints"),
        (("--joints", "1,4"), "joints 1 to 3"),
        (("--joints", "4"), "joints 1 to 3"),
        (("--limit", "90,90"), "3 joints move, and 2 limits"),
        (("--limit", "90,90,95"), "95 deg"),
        (("--time-limit", "0"), "time limit is 0"),
        (("--speed", "nan"), "speed is nan"),
        (("--speed", "1e-3"), "no joint turns by 0.01 deg"),
        (("--time-limit", "1e-4"), "no joint turns by 0.01 deg"),
        (("--limit", "0.005,90,90"), "below the 0.01 deg"),
        (("--inertia", "nan,0.4"), "--inertia"),
        (("--own-best", "1e300,1"), "--own-best"),
        (("--particles", "0"), "write a whole number"),
        (("--inertia", "0.9"), "two numbers"),
        (("--figure", "x.png"), "without --grid"),
        (("--robot", "sputnik"), "sputnik"),
    ],
)
def test_what_cannot_be_designed_is_said(tfsat_host: RunCli, args: tuple[str, ...], words: str) -> None:
    # A robot's name is looked up after the usage was checked.
    expected = 1 if "--robot" in args else 2
    process = tfsat_host("design", *args, expect=expected)
    assert words in process.stderr
    assert not (tfsat_host.folder / "maneuver.toml").exists()
