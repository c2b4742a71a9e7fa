"""`tfsat-host robot`, and which robot a name means."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.cli.process import RunCli
from tfsat_host.robot import default_robot_path, find_robot, load_robot, shipped_robots
from tfsat_host.robot.robot_summary import totals

FIVE = Path(__file__).with_name("five_bodies.toml")


def test_the_whole_robot_is_the_sum_of_point_masses() -> None:
    """Six points of mass m / 6 on a body's principal axes have its mass and inertia."""
    robot = load_robot(FIVE)
    points, masses = [], []
    for mass, origin, com, inertia in zip(
        robot.mass_kg, robot.origin_m, robot.com_m, robot.inertia_kg_m2, strict=True
    ):
        moments, axes = np.linalg.eigh(inertia)
        spread = np.sqrt(np.maximum(3 * (moments.sum() / 2 - moments) / mass, 0.0))
        for k in range(3):
            points += [origin + com + sign * spread[k] * axes[:, k] for sign in (1, -1)]
            masses += [mass / 6] * 2
    weights, at = np.array(masses), np.array(points)
    center = np.average(at, axis=0, weights=weights)
    arm = at - center
    inertia = sum(m * (r @ r * np.eye(3) - np.outer(r, r)) for m, r in zip(weights, arm, strict=True))
    mass, com, tensor = totals(robot)
    assert mass == pytest.approx(7.6)
    assert com == pytest.approx(center)
    assert tensor == pytest.approx(np.asarray(inertia))


def test_the_command_shows_the_drop_tower_robot(tfsat_host: RunCli) -> None:
    screen = tfsat_host("robot").stdout
    assert len(screen.splitlines()) <= 40 and "tfsat-host robot --full" in screen
    text = " ".join(tfsat_host("robot", "--full").stdout.split())
    for words in (
        "drop tower robot",
        "2.847 kg",
        "body 1 relative to body 2",
        "0, 0x69",
        "minus the products of inertia",
        "10.48550/arXiv.2501.17173",
        "1500 us at 45 deg, 11.1111 us/deg, 500 to 2500 us",
        "servo_speed_relative",
    ):
        assert words in text


def test_the_figures_as_json_are_those_of_the_file(tfsat_host: RunCli) -> None:
    facts = tfsat_host.json("robot")
    assert facts["file"] == str(default_robot_path())
    body, joint = facts["bodies"][0], facts["joints"][1]
    assert (body["mass_kg"], body["com_mm"]) == (1.067, [46.58, 50.93, 84.18])
    assert body["inertia_g_m2"] == [[3.97, 0.01, 0.08], [0.01, 4.1, -0.09], [0.08, -0.09, 2.27]]
    assert sum(body["principal_moments_g_m2"]) == pytest.approx(3.97 + 4.1 + 2.27)
    assert [max(axis) for axis in zip(*body["corners_mm"], strict=True)] == [100, 100, 168]
    assert (joint["inner"], joint["outer"], joint["limits_deg"]) == ("body 3", "body 2", [0, 90])
    assert joint["servo"]["average_rate_deg_s"] == 170
    assert joint["servo"]["pulses"]["pulse_us_per_deg"] == pytest.approx(100 / 9)
    assert facts["mass_kg"] == 2.847
    assert facts["uncertainty"]["stroke_deg"] == 1.0
    assert (len(facts["imus"]), len(facts["angle_sensors"])) == (4, 6)


def test_the_shown_text_and_the_json_agree_on_the_five_bodies(tfsat_host: RunCli) -> None:
    facts = tfsat_host.json("robot", FIVE)
    text = tfsat_host("robot", FIVE).stdout
    assert facts["uncertainty"]["com_mm"] == 2.0
    assert [joint["servo"]["pulses"] for joint in facts["joints"]] == [None] * 4
    for named in (*facts["bodies"], *facts["joints"]):
        assert named["name"] in text
    assert "hub relative to right wing" in text and "-100 -100 0 to 100 100 260" in text
    assert "IMUs" not in text


def test_a_name_means_a_shipped_robot_unless_a_file_has_it(tfsat_host: RunCli) -> None:
    assert shipped_robots() == ("cubesat_3u", "drop_tower")
    for name in ("cubesat_3u", "cubesat_3u.toml"):
        assert tfsat_host.json("robot", name)["name"] == "3U CubeSat"
    (tfsat_host.folder / "cubesat_3u").write_text(FIVE.read_text())
    assert tfsat_host.json("robot", "cubesat_3u")["name"] == "winged spacecraft"
    assert find_robot() == default_robot_path()


@pytest.mark.parametrize("name", ["cubesat_6u", "robots/drop_tower.toml", "."])
def test_a_robot_that_is_nowhere_is_an_error_that_lists_the_known_ones(tfsat_host: RunCli, name: str) -> None:
    error = tfsat_host.json("robot", name, expect=1)["error"]
    assert f"The robot file {name} cannot be read" in error["what"]
    assert "cubesat_3u, drop_tower" in error["next_step"]


def test_a_wrong_file_ends_with_its_line(tfsat_host: RunCli) -> None:
    (tfsat_host.folder / "wrong.toml").write_text(FIVE.read_text().replace("mass_kg = 6.0", "mass_kg = 0"))
    assert tfsat_host("robot", "wrong.toml", expect=1).stderr.startswith(
        "Error: wrong.toml:19: body 2, mass_kg:"
    )


def test_the_cubesat_is_the_drop_tower_robot_numbered_from_the_other_end() -> None:
    """Body i there is body 5 - i here, joint j joint 4 - j, and the same angles make the same pose."""
    tower, cubesat = load_robot(), load_robot("cubesat_3u")
    assert cubesat.base == 3 - tower.base
    for name in ("mass_kg", "origin_m", "com_m", "inertia_kg_m2", "joint_axis", "joint_point_m"):
        assert np.array_equal(getattr(cubesat, name), getattr(tower, name)[::-1]), name
    for name in ("joint_inner", "joint_outer"):  # the same bodies, so angles keep their sense
        assert np.array_equal(getattr(cubesat, name), 3 - getattr(tower, name)[::-1]), name
    assert [np.degrees(servo.average_rate_rad_s) for servo in cubesat.servos] == pytest.approx([30] * 3)
