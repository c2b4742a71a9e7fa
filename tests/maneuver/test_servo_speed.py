"""The speed that a schedule assumes against the servos of the robot file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.cli.process import RunCli
from tfsat_host.maneuver import Maneuver, Stroke, four_stroke, schedule_maneuver
from tfsat_host.maneuver.schedule import servo_speed_notices
from tfsat_host.robot import default_robot_path, load_robot


@pytest.mark.parametrize(
    ("speed_deg_s", "words"),
    [
        # 170 deg/s is the servos' average rate, 200 their greatest: above either the joints lag the schedule.
        (100, None),
        (170, None),
        (170.01, "above the average rate"),
        (200, "above the average"),
        (201, "greatest"),
    ],
)
def test_speeds_against_the_drop_tower_robot(speed_deg_s: float, words: str | None) -> None:
    notices = servo_speed_notices(schedule_maneuver(four_stroke(30, 30, speed_deg_s=speed_deg_s)))
    assert len(notices) == (0 if words is None else 1)
    if words:
        assert words in notices[0]


def test_the_rates_are_those_of_the_model() -> None:
    for servo in load_robot().servos:
        assert np.rad2deg(servo.average_rate_rad_s) == pytest.approx(170)
        assert np.rad2deg(servo.max_rate_rad_s) == pytest.approx(200)


def test_only_joints_that_move_count(tmp_path: Path) -> None:
    slow_joint_3 = tmp_path / "robot.toml"
    head, joint_3 = default_robot_path().read_text().split('name = "joint 3"')
    # The panel's servo alone is slow.
    slow = joint_3.replace("average_rate_deg_s = 170.0", "average_rate_deg_s = 90.0")
    slow_joint_3.write_text(f'{head}name = "joint 3"{slow}')
    assert servo_speed_notices(schedule_maneuver(four_stroke(59, 70)), slow_joint_3) == ()
    panel = schedule_maneuver(Maneuver((Stroke(3, 20), Stroke(3, -20))))
    assert "average rate of the servos, 90 deg/s" in servo_speed_notices(panel, slow_joint_3)[0]


# Missing, no TOML, and joints that have no servo with rates: the upload must not fail by it.
@pytest.mark.parametrize("text", [None, "=", "joint = 3", "[[joint]]\nservo = 1\n", "joint = []"])
def test_a_robot_file_without_rates_is_said(tmp_path: Path, text: str | None) -> None:
    file = tmp_path / "robot.toml"
    if text is not None:
        file.write_text(text)
    assert "was not compared" in servo_speed_notices(schedule_maneuver(four_stroke(59, 70)), file)[0]


def test_the_command_warns_and_does_not_say_that_it_may_fly(tfsat_host: RunCli) -> None:
    process = tfsat_host("upload-sequence", 59, 70, "--speed", 400, "--dry-run", expect=3)
    assert "above the greatest rate of the servos" in process.stderr
    assert "may fly" not in process.stdout
    assert tfsat_host.json("upload-sequence", 59, 70, "--speed", 400, "--dry-run", expect=3)["notices"]
