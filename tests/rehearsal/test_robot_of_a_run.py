"""A run keeps the robot that flew: every command that reads it later uses that one, and says so."""

from __future__ import annotations

import json
import shlex
import zipfile
from pathlib import Path
from shutil import copyfile, copytree

import pytest

from tests.cli.process import RunCli
from tests.rehearsal.days import Rehearsing
from tfsat_host.robot import default_robot_path

SHIFTED = ("com_mm = [46.58, 50.93, 84.18]", "com_mm = [46.58, 50.93, 104.18]")
"""20 mm at body 1: evaluated with the wrong file a drop would be doubtful, or its correction absurd."""


@pytest.fixture
def other_robot_file(tfsat_host: RunCli) -> Path:
    """Write a robot file unlike the shipped one into the current folder."""
    file = tfsat_host.folder / "other.toml"
    text = default_robot_path().read_text(encoding="utf-8")
    assert SHIFTED[0] in text
    file.write_text(text.replace(*SHIFTED), encoding="utf-8")
    return file


def test_it_is_evaluated_with_the_robot_that_flew(tfsat_host: RunCli, other_robot_file: Path) -> None:
    arguments = ("rehearse", "54", "72", "--robot", "other.toml", "--as-filed", "--out", "run")
    rehearsal = tfsat_host.json(*arguments)
    assert (tfsat_host.folder / "run" / "robot.toml").read_bytes() == other_robot_file.read_bytes()
    program, *command = shlex.split(rehearsal["simulate_command"])
    assert program == "tfsat-host"
    computed = tfsat_host.json(*command)
    assert computed["reorientation_deg"] == pytest.approx(rehearsal["reorientation_true_deg"], abs=0.003)
    # Nothing else is known of it later than the folder; the file may have gone.
    other_robot_file.unlink()
    again = tfsat_host("evaluate", "run", "--json")
    assert "Robot: run/robot.toml (the run's)" in again.stderr
    evaluation = json.loads(again.stdout)
    assert evaluation["reorientation_deg"] == pytest.approx(
        rehearsal["evaluation"]["reorientation_deg"], abs=1e-9
    )
    # A person may insist on another robot, and is told so.
    named = tfsat_host("evaluate", "run", "--robot", "drop_tower", expect=None)
    assert "(--robot; not the run's run/robot.toml)" in named.stderr

    tfsat_host("bundle", "run", "--out", "run.tfsat.zip")
    with zipfile.ZipFile(tfsat_host.folder / "run.tfsat.zip") as bundle:
        assert json.loads(bundle.read("manifest.json"))["evaluated"]["robot"] == "run/robot.toml"
        bundled = json.loads(bundle.read("evaluation.json"))
    assert bundled["com_offset_mm"] == evaluation["com_offset_mm"]
    tfsat_host("campaign", "init", "campaign")
    tfsat_host("campaign", "add", "campaign", "run")
    (drop,) = tfsat_host.json("campaign", "report", "campaign")["drops"]
    assert drop["evaluation"]["com_offset_mm"] == evaluation["com_offset_mm"]


def test_drops_of_different_robots_are_not_compared(
    shared_rehearsal: Rehearsing, tfsat_host: RunCli, other_robot_file: Path
) -> None:
    for name, options in (("one", ()), ("two", ("--seed", "2")), ("three", ())):
        copytree(shared_rehearsal("59", "70", *options).folder, tfsat_host.folder / name)
    for named in ((), ("--robot", "drop_tower")):
        refused = tfsat_host("evaluate", "one", "two", *named, expect=2)
        assert "These drops are not of one robot. one: emulated robot with logger" in refused.stderr
    # The same logger next to another robot file.
    copyfile(other_robot_file, tfsat_host.folder / "three" / "robot.toml")
    refused = tfsat_host("evaluate", "one", "three", expect=2)
    assert "one and three were not dropped with the same robot" in refused.stderr
    assert "--robot FILE" in refused.stderr


def test_a_robot_that_cannot_be_dropped(tfsat_host: RunCli) -> None:
    # The robot for orbit has no IMUs in its file: nothing could be recorded.
    for options in ((), ("--runs", "2")):
        refused = tfsat_host("rehearse", "59", "70", "--robot", "cubesat_3u", *options, expect=1)
        assert "3U CubeSat does not fit the boards: it has fewer than two IMUs" in refused.stderr
        assert "Nothing was done." in refused.stderr
    assert not (tfsat_host.folder / "run").exists()
