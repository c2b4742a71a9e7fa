"""A robot that is not the drop tower's: a branching tree of five bodies without boards."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.cli.process import RunCli
from tfsat_host.emulated.emulated_robot import EmulatedRobot, EmulationError
from tfsat_host.errors import TfsatError
from tfsat_host.robot import RobotFileError, default_robot_path, load_robot

FILE = Path(__file__).with_name("five_bodies.toml")
TEXT = FILE.read_text(encoding="utf-8")


def load(folder: Path, old: str, new: str) -> None:
    file = folder / "five.toml"
    assert TEXT.count(old) == 1
    file.write_text(TEXT.replace(old, new), encoding="utf-8")
    load_robot(file)


def test_the_tree_is_loaded() -> None:
    robot = load_robot(FILE)
    assert (robot.n_bodies, robot.n_joints, robot.body_names[robot.base]) == (5, 4, "hub")
    assert list(zip(robot.joint_inner, robot.joint_outer, strict=True)) == [(1, 0), (2, 1), (1, 3), (3, 4)]
    assert robot.joint_axis[2:] == pytest.approx(np.array([[0.5**0.5, 0.5**0.5, 0], [0, 0, 1]]))
    assert robot.inertia_kg_m2[1, 0] == pytest.approx([34e-3, 0.2e-3, -0.3e-3])
    assert [servo.pulses for servo in robot.servos] == [None] * 4


def test_shapes_are_the_corners_of_all_boxes_in_the_body_frame() -> None:
    left_shape, hub, right, *_ = load_robot(FILE).shape_m
    assert (left_shape.shape, hub.shape, right.shape) == ((8, 3), (16, 3), (0, 3))
    assert hub.min(axis=0) == pytest.approx([-0.1, -0.1, 0.0])
    assert hub.max(axis=0) == pytest.approx([0.1, 0.1, 0.26])
    assert {tuple(corner) for corner in np.round(1e3 * left_shape)} == {
        (x, y, z) for x in (-50, 50) for y in (0, 200) for z in (-2, 2)
    }
    with pytest.raises(ValueError, match="read-only"):
        left_shape[0] = 0


def test_uncertainty_is_in_si_units_and_what_is_left_out_is_exact() -> None:
    wrong = load_robot(FILE).uncertainty
    assert wrong is not None
    assert (wrong.mass_relative, wrong.com_m) == (0.01, 0.002)
    assert wrong.joint_axis_rad == pytest.approx(np.radians(0.2))
    assert (wrong.inertia_relative, wrong.joint_point_m, wrong.stroke_rad) == (0, 0, 0)


@pytest.mark.parametrize(
    ("old", "new", "at", "problem"),
    [
        # Below an array whose rows begin with brackets, as headers do.
        ("xx = 34.0", "xx = -34.0", "inertia_g_m2", "not positive definite"),
        # A loop of three joints, found at the joint that closes it.
        ('inner = "boom"\nouter = "camera"', 'inner = "boom"\nouter = "left wing"', "outer", "closes a loop"),
        ("mass_kg = 0.5", "mass_kg = -0.5", "mass_kg", "is not a number above 0"),
        ("     [100, 100, 227]],", "     [100, 100]],", "boxes_mm", "is not boxes, each as"),
        ("zz = 0.02 }", "zz = 9.0 }", "inertia_g_m2", "exceeds the sum"),
        ("limits_deg = [-170.0, 170.0]", "limits_deg = [170.0, -170.0]", "limits_deg", "not below"),
        ("com_mm = 2.0", "com_mm = -2.0", "com_mm", "is not a number of at least 0"),
    ],
)
def test_a_mistake_in_it_is_named_with_its_line(
    tmp_path: Path, old: str, new: str, at: str, problem: str
) -> None:
    with pytest.raises(RobotFileError, match=problem) as caught:
        load(tmp_path, old, new)
    named = int(caught.value.what.removeprefix(f"{tmp_path / 'five.toml'}:").split(":")[0])
    lines = TEXT.replace(old, new).splitlines()
    assert lines[named - 1].startswith(at)
    changed = next(n for n, (a, b) in enumerate(zip(TEXT.splitlines(), lines, strict=True), 1) if a != b)
    assert changed - 2 <= named <= changed


def test_the_boards_refuse_to_be_on_it() -> None:
    with pytest.raises(
        TfsatError, match="winged spacecraft does not fit the boards: it has 5 bodies"
    ) as caught:
        EmulatedRobot(load_robot(FILE))
    assert caught.value.what.startswith(f"{FILE}: ")
    assert "robots/drop_tower.toml" in caught.value.next_step


def test_a_robot_of_the_right_size_without_pulses_cannot_be_emulated(tmp_path: Path) -> None:
    file = tmp_path / "robot.toml"
    pulses = ("pulse_range_us", "reference", "pulse_us_per_deg")
    lines = default_robot_path().read_text(encoding="utf-8").splitlines(keepends=True)
    file.write_text("".join(line for line in lines if not line.startswith(pulses)), encoding="utf-8")
    with pytest.raises(EmulationError, match="the servo of joint 1 has no pulses") as caught:
        EmulatedRobot(load_robot(file))
    assert caught.value.what.startswith(f"{file}: ")
    assert "pulse_us_per_deg" in caught.value.next_step


def test_a_logger_is_not_monitored_by_it(tfsat_host: RunCli) -> None:
    error = tfsat_host.json("monitor", "--robot", FILE, "--emulated", expect=1)["error"]
    assert error["what"] == f"{FILE}: winged spacecraft does not fit the boards: it has 5 bodies."
