"""`tfsat-host plan` as a user has it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.process import RunCli
from tfsat_host.robot.path import find_robot


def test_a_quarter_turn(tfsat_host: RunCli) -> None:
    found = tfsat_host.json("plan", "--target", "z:90")
    assert found["reached"] and found["error_deg"] <= found["tolerance_deg"] == 1.0
    assert found["primitives"] == len(found["steps"])
    assert found["least_time_s"] == pytest.approx(27.4, abs=0.3)
    assert found["least_time_s"] <= found["duration_s"] < 50.0
    assert found["target_euler_zyx_deg"] == pytest.approx([90.0, 0.0, 0.0])
    assert found["robot"] == "3U CubeSat"
    assert found["open_loop_error_deg"] is None


def test_text_tells_error_time_and_number(tfsat_host: RunCli) -> None:
    done = tfsat_host("plan", "--target", "z:-30", "--method", "greedy")
    last = done.stdout.splitlines()[-2]
    assert last.startswith("Reached: ") and "primitives" in last and " s by " in last


def test_euler_angles_are_z_y_x_in_whatever_order_they_are_written(tfsat_host: RunCli) -> None:
    one = tfsat_host.json("plan", "--target", "x:3,z:40,y:-2", "--method", "greedy")
    assert one["target_euler_zyx_deg"] == pytest.approx([40.0, -2.0, 3.0])
    other = tfsat_host.json(
        "plan", "--method", "greedy", "--target-quaternion", *one["target_quaternion_xyzw"]
    )
    assert other["target_quaternion_xyzw"] == pytest.approx(one["target_quaternion_xyzw"])
    assert other["error_deg"] == pytest.approx(one["error_deg"])


def test_a_tolerance_out_of_reach_ends_with_3_and_a_possible_one(tfsat_host: RunCli) -> None:
    arguments = ("plan", "--target", "z:30", "--method", "greedy", "--table-only", "--tolerance")
    done = tfsat_host(*arguments, "1e-6", expect=3)
    assert "NOT REACHED" in done.stdout
    possible = done.stdout.split("--tolerance ")[1].split(" ")[0]
    assert tfsat_host.json(*arguments, possible)["reached"]
    assert tfsat_host.json(*arguments, "1e-6", expect=3)["outcome"] == "no progress"


def test_a_wrong_model_and_noise_are_reproducible(tfsat_host: RunCli) -> None:
    arguments = ("plan", "--target", "z:60", "--model-error", "2", "--noise", "0.05", "--seed")
    first, again, other = (tfsat_host.json(*arguments, seed) for seed in (7, 7, 8))
    assert first == again != other
    assert first["open_loop_error_deg"] > first["error_deg"]


def test_the_plan_is_written_and_nobody_s_file_is_lost(tfsat_host: RunCli) -> None:
    arguments = ("plan", "--target", "z:20", "--method", "greedy", "--out", "plan.json")
    shown = tfsat_host.json(*arguments)
    written = json.loads((tfsat_host.folder / "plan.json").read_text())
    assert {**written, "file": "plan.json"} == shown
    tfsat_host(*arguments)  # its own file may be written again
    (tfsat_host.folder / "plan.json").write_text("mine\n")
    tfsat_host(*arguments, expect=1)
    assert (tfsat_host.folder / "plan.json").read_text() == "mine\n"
    tfsat_host(*arguments, "--force")


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        ("--target", "90"),
        ("--target", "z:90,z:10"),
        ("--target", "z:nan"),
        ("--target", "q:1"),
        ("--target", "z:90", "--target-quaternion", 0, 0, 0, 1),
        ("--target-quaternion", 0, 0, 0, 0),
        ("--target", "z:90", "--tolerance", "0"),
        ("--target", "z:90", "--noise", "-1"),
        ("--target", "z:90", "--grid", "0"),
        ("--target", "z:90", "--most", "0"),
    ],
)
def test_what_cannot_be_meant_is_refused(tfsat_host: RunCli, arguments: tuple[object, ...]) -> None:
    assert "Error:" in tfsat_host("plan", *arguments, expect=2).stderr


def test_a_robot_that_states_no_uncertainty_has_no_wrong_model(tfsat_host: RunCli, tmp_path: Path) -> None:
    text = find_robot("cubesat_3u").read_text(encoding="utf-8").split("[uncertainty]")[0]
    (tmp_path / "exact.toml").write_text(text, encoding="utf-8")
    done = tfsat_host(
        "plan", "--target", "z:5", "--robot", tmp_path / "exact.toml", "--model-error", "1", expect=1
    )
    assert "[uncertainty]" in done.stderr


def test_a_grid_without_loops_is_refused(tfsat_host: RunCli) -> None:
    assert "smaller step" in tfsat_host("plan", "--target", "z:5", "--grid", "91", expect=1).stderr
