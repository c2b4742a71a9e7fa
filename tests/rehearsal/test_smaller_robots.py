"""Robots of fewer bodies or IMUs go through the whole day: what is absent is flagged, and all numbers hold."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import pytest

from tests.cli.process import RunCli
from tests.robot.fewer_parts import robot_text, smaller_robot
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.session import fit_steps
from tfsat_host.calibration.steps.step import swings, task
from tfsat_host.robot.absent_parts import bodies_of, fill_places
from tfsat_host.run.prepared_run import PreparedRun

KINDS = {
    "three-bodies": partial(robot_text, bodies=3),
    "without-imu-1": partial(robot_text, without_imu=[1]),
    "without-imu-4": partial(robot_text, without_imu=[4]),
    "two-imus": partial(robot_text, without_imu=[2, 4]),
}
MOVES_JOINT_3 = "schema = 1\nspeed_deg_s = 170.0\npause_s = 0.7\n[[strokes]]\njoint = 3\nangle_deg = 20.0\n"


def write_robot(folder: Path, kind: str) -> None:
    (folder / "small.toml").write_text(KINDS[kind](), encoding="utf-8")


@pytest.mark.parametrize("kind", KINDS)
def test_a_drop_is_rehearsed_and_all_numbers_hold(kind: str, tfsat_host: RunCli) -> None:
    """Without an IMU the model's correction holds, too: noise of the angle sensors is no motion of the body."""
    write_robot(tfsat_host.folder, kind)
    result = tfsat_host.json("rehearse", "59", "70", "--robot", "small.toml", "--out", "run")
    assert max(abs(row["deviations"]) for row in result["compared"]) < 3.5
    evaluated = tfsat_host.json("evaluate", "run")
    assert evaluated["verdict"]["level"] == "good"
    (flag,) = (note for note in evaluated["notes"] if note.startswith("Absent by the robot file: "))
    absent = {"three-bodies": "body 4, joint 3.", "without-imu-1": "IMU of body 1."}
    assert flag.endswith(absent.get(kind, "IMU of body 4."))
    bodies, joints = (4, 3) if kind != "three-bodies" else (3, 2)
    assert [row["body"] for row in evaluated["bodies"]] == list(range(1, bodies + 1))
    assert [row["joint"] for row in evaluated["joints"]] == list(range(1, joints + 1))
    assert {row["joint"] for row in evaluated["standing"]} == set(range(1, joints + 1))
    assert not [
        note for note in evaluated["notes"] if "too few to judge" in note or "gave too little" in note
    ]
    # Every check is of sensors that are there.
    between = {"three-bodies": "bodies 3 and 4", "without-imu-1": "bodies 1 and 2"}.get(
        kind, "bodies 3 and 4"
    )
    checks = {row["name"]: row for row in evaluated["checks"]}
    assert not [name for name in checks if between in name]
    assert checks["sensors as stated"]["verdict"] == checks["as filed and certified"]["verdict"] == "passed"
    if kind == "three-bodies":
        assert "joint 3" not in " ".join(row["sentence"] for row in evaluated["checks"])
    names = {row["name"] for row in evaluated["offsets"]}
    assert any(name.startswith("body 4") for name in names) == (kind != "three-bodies")


def test_parts_that_were_taken_off_are_not_used(tfsat_host: RunCli) -> None:
    """A drop of the whole robot, evaluated without one of its IMUs; and the certificate of the whole one."""
    write_robot(tfsat_host.folder, "without-imu-4")
    tfsat_host("rehearse", "59", "70", "--out", "run")
    fewer = tfsat_host.json("evaluate", "run", "--robot", "small.toml")
    assert fewer["verdict"]["level"] == "good"
    whole = tfsat_host.json("evaluate", "run")
    assert fewer["reorientation_deg"] == pytest.approx(
        whole["reorientation_deg"], abs=3.0 * fewer["reorientation_deg_std"]
    )
    assert fewer["reorientation_deg_std"] > whole["reorientation_deg_std"]
    certificate = "run/calibration-emulated.toml"
    for robot, count in (("small.toml", 18), ("drop_tower", 24)):
        shown = ("calibrate", "show", "--emulated", "--out", certificate, "--robot", robot)
        rows = tfsat_host.json(*shown)["quantities"]
        assert sum("body" in row["quantity"] for row in rows) == count
    command = ("calibrate", "replaced", "imu-4", "--emulated", "--out", certificate, "--robot", "small.toml")
    assert "smaller robot has no imu-4." in tfsat_host(*command, expect=2).stderr
    here = tfsat_host.folder
    (here / "next").mkdir()
    prepared = PreparedRun.open(here / "next", certificate=here / certificate, robot=here / "small.toml")
    calibration, _ = prepared.calibration(emulated=True)
    assert isinstance(calibration, Calibration)
    assert [gyro.body for gyro in calibration.present_gyros] == [1, 2, 3]


def test_what_an_absent_part_would_do_is_refused(tfsat_host: RunCli) -> None:
    write_robot(tfsat_host.folder, "three-bodies")
    (tfsat_host.folder / "third.toml").write_text(MOVES_JOINT_3, encoding="utf-8")
    refused = tfsat_host("rehearse", "--file", "third.toml", "--robot", "small.toml", expect=None)
    assert "The maneuver moves joint 3; small.toml has 2." in refused.stderr
    refused = tfsat_host("rehearse", "59", "70", "--robot", "small.toml", "--fault", "gyro-dead", expect=2)
    assert "Faults are emulated on a robot that has all parts." in refused.stderr
    replaced = ("calibrate", "replaced", "servo-3", "--emulated", "--robot", "small.toml")
    assert "smaller robot has no joint 3" in tfsat_host(*replaced, expect=2).stderr
    for quantity in ("zero", "misalignment", "servo"):
        command = ("calibrate", quantity, "--joint", "3", "--emulated", "--yes", "--robot", "small.toml")
        assert "smaller robot has no joint 3" in tfsat_host(*command, expect=2).stderr
    assert not (tfsat_host.folder / "run").exists()


def test_it_is_calibrated_by_what_is_there(tfsat_host: RunCli) -> None:
    """Without the IMU of body 1: joint 1 is known by bodies 2 and 3, and nothing of body 1's gyro is missed."""
    write_robot(tfsat_host.folder, "without-imu-1")

    def calibrate(*words: str) -> str:
        return tfsat_host("calibrate", *words, "--emulated", "--yes", "--robot", "small.toml").stdout

    assert "body 1" not in calibrate("bias")
    calibrate("zero", "--all")
    moved = calibrate("misalignment", "--joint", "1")
    assert "body 2" in moved
    assert "body 1" not in moved
    shown = tfsat_host("calibrate", "show", "--emulated", "--robot", "small.toml", "--json")
    assert "Absent by the robot file: IMU of body 1" in shown.stderr
    rows = json.loads(shown.stdout)["quantities"]
    assert not [row["quantity"] for row in rows if "body 1" in row["quantity"]]
    assert [row["state"] for row in rows if row["quantity"].startswith("bias")] == ["valid"] * 3
    assert [row["state"] for row in rows if row["quantity"].startswith("zero")] == ["valid"] * 3
    # An IMU that is there and silent is missed all the same.
    certificate = tfsat_host.folder / "calibration-emulated.toml"
    assert certificate.read_text(encoding="utf-8").count("absent = true") == 1


def test_its_turn_by_hand_needs_no_absent_part(tfsat_host: RunCli) -> None:
    """The pins of joint 3's sensors read anything, and no IMU is on body 4."""
    write_robot(tfsat_host.folder, "three-bodies")
    robot = ("--emulated", "--yes", "--robot", "small.toml")
    tfsat_host("calibrate", "zero", "--all", *robot)
    turned = tfsat_host("calibrate", "scale", "--turn", "z", "360", *robot).stdout
    assert "body 3" in turned
    assert "body 4" not in turned


def test_a_person_is_told_of_what_is_there(tmp_path: Path) -> None:
    robot = fill_places(smaller_robot(tmp_path, bodies=2))
    first, second = fit_steps(swings(1), robot)
    assert [(step.moved, step.held) for step in (first, second)] == [((1,), (2,)), ((2,), (1,))]
    lines = " ".join(task(first, bodies_of(robot)))
    assert lines.startswith(
        "Take the holding attachment off joint 1 and close that by hand. Hold body 2 on the bench. Swing body 1 about"
    )
