"""The robot file: what is read from it, and what is said when it is wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tfsat_host.robot import RobotFileError, default_robot_path, load_robot

TEXT = default_robot_path().read_text(encoding="utf-8")

FIFTH_BODY = """
[[body]]
name = "body 5"
mass_kg = 0.1
origin_mm = [0.0, 0.0, 400.0]
com_mm = [1.0, 2.0, 3.0]
inertia_g_m2 = { xx = 0.1, xy = 0.0, xz = 0.0, yy = 0.1, yz = 0.0, zz = 0.1 }
"""


def line_with(text: str, fragment: str) -> int:
    """Return the number of the line on which `fragment` ends."""
    assert text.count(fragment) == 1
    return text[: text.index(fragment) + len(fragment)].count("\n") + 1


def test_the_drop_tower_robot_is_the_papers() -> None:
    robot = load_robot()
    assert robot.mass_kg.sum() == pytest.approx(2.847)
    assert robot.body_names[robot.base] == "body 3"
    assert robot.com_m[1] == pytest.approx([0.04786, 0.04668, 0.05436])
    assert robot.inertia_kg_m2[0] == pytest.approx(
        1e-3 * np.array([[3.97, 0.01, 0.08], [0.01, 4.10, -0.09], [0.08, -0.09, 2.27]])
    )
    assert robot.joint_inner.tolist() == [1, 2, 3]
    assert robot.joint_outer.tolist() == [0, 1, 2]
    # Table of joint positions: the local position is in body i+1.
    local_mm = 1e3 * (robot.joint_point_m - robot.origin_m[1:])
    assert local_mm == pytest.approx(np.array([[0, 10, 112], [90, 0, 112], [0, 5, -25]]))
    assert np.degrees(robot.joint_limits_rad) == pytest.approx(np.array([[0, 90]] * 3))
    pulses = robot.servos[0].pulses
    assert pulses is not None
    assert [pulses.pulse_us(np.radians(a)) for a in (0, 45, 90)] == pytest.approx([1000, 1500, 2000])
    assert [(imu.bus, imu.address) for imu in robot.imus] == [(0, 0x68), (0, 0x69), (1, 0x68), (1, 0x69)]
    assert [(s.joint, s.direction) for s in robot.angle_sensors] == [
        (j, d) for j in range(3) for d in (1, -1)
    ]


def test_the_model_cannot_be_changed() -> None:
    robot = load_robot()
    for array in (robot.mass_kg, robot.inertia_kg_m2, robot.joint_outer, robot.imus[0].position_m):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_off_diagonals_as_tensor_entries_keep_their_sign(tmp_path: Path) -> None:
    file = tmp_path / "robot.toml"
    file.write_text(TEXT.replace('off_diagonals = "products"', 'off_diagonals = "tensor"'), encoding="utf-8")
    assert load_robot(file).inertia_kg_m2[0, 0, 1] == pytest.approx(-1e-5)


def test_a_single_body_is_a_robot(tmp_path: Path) -> None:
    alone = tmp_path / "alone.toml"
    header = 'format = 1\nname = "one"\nbase = "body 5"\ninertia_off_diagonals = "tensor"\n'
    alone.write_text(header + FIFTH_BODY, encoding="utf-8")
    robot = load_robot(str(alone))
    assert robot.joint_axis.shape == (0, 3)
    assert (robot.source, robot.uncertainty, robot.imus, robot.angle_sensors) == ("", None, (), ())
    assert robot.shape_m[0].shape == (0, 3)


MISTAKES = [
    ("mass_kg = 0.735", "mass_kg = 0  # lost", "mass_kg = 0  # lost", "0 is not a number above 0"),
    ("mass_kg = 0.735\n", "", "168]]]\n\n[[body]]", "is missing"),
    ("xx = 1.72", "xx = -1.72", "inertia_g_m2 = { xx = -1.72", "not positive definite"),
    ("xx = 1.72", "xx = 17.2", "inertia_g_m2 = { xx = 17.2", "exceeds the sum"),
    ("xx = 1.72, ", "", "inertia_g_m2 = { xy = 0.00, xz = -0.07", "inertia_g_m2.xx: is missing"),
    ('inner = "body 3"', 'inner = "body 7"', 'inner = "body 7"', "'body 7' is not 'body 1' or 'body 2'"),
    ('inner = "body 3"', 'inner = "body 2"', 'outer = "body 2"', "joins a body to itself"),
    ('inner = "body 3"', 'inner = "body 1"', 'outer = "body 2"', "closes a loop"),
    ("axis = [0, 1, 0]", "axis = [0, 0, 0]", "axis = [0, 0, 0]", "has no direction"),
    ('name = "joint 2"', 'name = "joint 1"', '111\n\n[[joint]]\nname = "joint 1"', "used twice"),
    ('base = "body 3"', 'base = "chest"', 'base = "chest"', "'chest' is not 'body 1' or 'body 2'"),
    (
        '"products"\n',
        '"either"\n',
        'inertia_off_diagonals = "either"',
        "'either' is not 'products' or 'tensor'",
    ),
    ("direction = 1\n", "direction = 2\n", "direction = 2", "2 is not -1 or 1"),
    ("[0, 0, 1]]", "[0, 0, -1]]", "[0, 1, 0], [0, 0, -1]]", "sensor_to_body: is not a rotation"),
    ("[0, 0, 1]]", "[0, 0, 2]]", "[0, 1, 0], [0, 0, 2]]", "sensor_to_body: is not a rotation"),
    ("start_deg = 0.0", "start_deg = -5.0", "start_deg = -5.0", "is outside the joint's limits"),
    ("address = 0x69", "address = 0x68", '"body 2"\nbus = 0\naddress = 0x68', "two sensors"),
    (
        "[[[0, 0, -11], [101",
        "[[[0, 0, -11]], [[101",
        "boxes_mm = [[[0, 0, -11]]",
        "is not boxes, each as",
    ),
    ("[[[0, 0, -11], [101", "[[[0, 13, -11], [101", "boxes_mm = [[[0, 13, -11]", "has no volume"),
    ("[[[0, 0, -11], [101", "[[[60, 0, -11], [101", "boxes_mm = [[[60, 0, -11]", "lies outside of the boxes"),
    ("com_mm = 3.0", "com_mm = -3.0", "com_mm = -3.0", "-3.0 is not a number of at least 0"),
    (
        "stroke_relative = 0.07",
        "stroke_relative = 7",
        "stroke_relative = 7",
        "7 is not a number of at least 0 and",
    ),
    ("stroke_relative = 0.07", "stroke = 0.07", "\nstroke = 0.07", "uncertainty.stroke: is not known here"),
]


@pytest.mark.parametrize(("old", "new", "at", "problem"), MISTAKES)
def test_a_mistake_is_named_with_file_line_entry_and_cure(
    tmp_path: Path, old: str, new: str, at: str, problem: str
) -> None:
    file = tmp_path / "robot.toml"
    text = TEXT.replace(old, new, 1)
    assert text != TEXT
    file.write_text(text, encoding="utf-8")
    with pytest.raises(RobotFileError) as caught:
        load_robot(file)
    assert problem in caught.value.what
    assert caught.value.next_step
    assert caught.value.what.startswith(f"{file}:{line_with(text, at)}: ")


def test_a_body_that_nothing_connects_is_named(tmp_path: Path) -> None:
    file = tmp_path / "robot.toml"
    file.write_text(TEXT + FIFTH_BODY, encoding="utf-8")
    line = line_with(TEXT + FIFTH_BODY, 'name = "body 5"')
    with pytest.raises(RobotFileError, match=f":{line}: body 5, name: no joint connects 'body 5'"):
        load_robot(file)


@pytest.mark.parametrize("key", ["pulse_range_us", "reference", "pulse_us_per_deg"])
def test_pulses_are_there_as_a_whole_or_not_at_all(tmp_path: Path, key: str) -> None:
    file = tmp_path / "robot.toml"
    line = next(line for line in TEXT.splitlines() if line.startswith(key))
    file.write_text(TEXT.replace(line + "\n", "", 1), encoding="utf-8")
    with pytest.raises(RobotFileError, match=f"joint 1, servo.{key}: is missing") as caught:
        load_robot(file)
    assert "leave out all three" in caught.value.next_step


def test_a_servo_mistake_is_found_in_its_own_joint(tmp_path: Path) -> None:
    file = tmp_path / "robot.toml"
    head, tail = TEXT.split('name = "joint 3"')
    file.write_text(
        head + 'name = "joint 3"' + tail.replace("max_rate_deg_s = 200.0", "max_rate_deg_s = 20.0"), "utf-8"
    )
    with pytest.raises(
        RobotFileError, match=r"joint 3, servo.average_rate_deg_s: is above max_rate"
    ) as caught:
        load_robot(file)
    line = int(caught.value.what.removeprefix(f"{file}:").split(":")[0])
    assert line > line_with(TEXT, 'name = "joint 3"')
    assert TEXT.splitlines()[line - 1].startswith("average_rate_deg_s")
