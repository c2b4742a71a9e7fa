"""`tfsat-host plan` as a user has it."""

from __future__ import annotations

import functools
import json
import math
from pathlib import Path

import pytest

from tests.cli.process import RunCli
from tfsat_host.plan.orbit import primitives
from tfsat_host.robot import RobotModel, load_robot
from tfsat_host.robot.path import find_robot

_primitive_table = primitives.primitive_table


@functools.cache
def _table(path: Path, step_deg: float) -> primitives.PrimitiveTable:
    return _primitive_table(load_robot(path), step_deg)


@pytest.fixture(autouse=True)
def _each_table_once(monkeypatch: pytest.MonkeyPatch) -> None:
    def table(robot: RobotModel, step_deg: float) -> primitives.PrimitiveTable:
        return _table(robot.path, step_deg)

    monkeypatch.setattr(primitives, "primitive_table", table)


def test_a_quarter_turn(tfsat_host: RunCli) -> None:
    plan = tfsat_host.json("plan", "--target", "z:90")
    assert plan["reached"] and plan["error_deg"] <= plan["tolerance_deg"] == 1.0
    assert plan["primitives"] == len(plan["steps"])
    assert plan["axis_time_s"] == pytest.approx(27.4, abs=0.3)
    assert plan["axis_time_s"] <= plan["duration_s"] < 40.0
    assert plan["target_euler_zyx_deg"] == pytest.approx([90.0, 0.0, 0.0])
    assert plan["robot"] == "3U CubeSat"
    assert plan["open_loop_error_deg"] is None


def test_text_tells_error_time_and_number(tfsat_host: RunCli) -> None:
    process = tfsat_host("plan", "--target", "z:-30", "--method", "greedy")
    lines = process.stdout.splitlines()
    assert lines[0] == lines[-1] and lines[0].startswith("REACHED: ") and lines[0].endswith(" s")
    assert any(line.startswith("Primitives: ") and "in the table" in line for line in lines)
    text = " ".join(process.stdout.split())
    assert "3U CubeSat (cubesat_3u, the default on orbit; of other commands: drop_tower)" in text


def test_the_whole_chain_is_as_short_as_it_can_be_and_an_estimate_says_how_short(tfsat_host: RunCli) -> None:
    """Optimize the whole chain of loops, and state an estimate of its least duration.

    With only the last loop solved for it took 38.9 s; SLSQP over the same three loops finds 34.08 s.
    """
    plan = tfsat_host.json("plan", "--target", "z:90")
    assert plan["reached"] and plan["duration_s"] <= 34.1
    assert plan["primitives"] == 3
    assert 31.0 < plan["least_time_s"] < plan["duration_s"]
    text = " ".join(tfsat_host("plan", "--target", "z:90").stdout.split())
    assert f"Estimated least time: {plan['least_time_s']:.1f} s (tilt of body direction" in text
    assert f"by any loop at most {plan['least_time_rate_deg_s']:.3g} deg/s" in text


def test_euler_angles_are_z_y_x_in_whatever_order_they_are_written(tfsat_host: RunCli) -> None:
    plan = tfsat_host.json("plan", "--target", "x:3,z:40,y:-2", "--method", "greedy")
    assert plan["target_euler_zyx_deg"] == pytest.approx([40.0, -2.0, 3.0])
    other = tfsat_host.json(
        "plan", "--method", "greedy", "--target-quaternion", *plan["target_quaternion_xyzw"]
    )
    assert other["target_quaternion_xyzw"] == pytest.approx(plan["target_quaternion_xyzw"])
    assert other["error_deg"] == pytest.approx(plan["error_deg"])


def test_a_tolerance_out_of_reach_ends_with_3_and_a_possible_one(tfsat_host: RunCli) -> None:
    arguments = ("plan", "--target", "z:30", "--method", "greedy", "--table-only", "--tolerance")
    process = tfsat_host(*arguments, "1e-6", expect=3)
    assert "NOT REACHED" in process.stdout
    assert "no single loop brings it nearer" in " ".join(process.stdout.split())
    possible = process.stdout.split("--tolerance ")[1].split()[0]
    assert tfsat_host.json(*arguments, possible)["reached"]
    assert tfsat_host.json(*arguments, "1e-6", expect=3)["outcome"] == "no progress"


def test_a_wrong_model_and_noise_are_reproducible(tfsat_host: RunCli) -> None:
    arguments = [
        "plan",
        "--target",
        "z:60",
        "--model-error",
        "2",
        "--noise",
        "0.05",
        "--method",
        "greedy",
        "--seed",
    ]
    first, again, other = (tfsat_host.json(*arguments, seed) for seed in (7, 7, 8))
    assert first == again != other
    assert first["open_loop_error_deg"] > first["error_deg"]


def test_the_plan_is_written_and_nobody_s_file_is_lost(tfsat_host: RunCli) -> None:
    arguments = ("plan", "--target", "z:20", "--method", "greedy", "--out", "plan.json")
    plan = tfsat_host.json(*arguments)
    written = json.loads((tfsat_host.folder / "plan.json").read_text())
    assert {**written, "file": "plan.json", "history": None} == plan
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
        ("--target", "z:90", "--max-primitives", "0"),
    ],
)
def test_what_cannot_be_meant_is_refused(tfsat_host: RunCli, arguments: tuple[object, ...]) -> None:
    assert "Error:" in tfsat_host("plan", *arguments, expect=2).stderr


def test_a_robot_that_states_no_uncertainty_has_no_wrong_model(tfsat_host: RunCli, tmp_path: Path) -> None:
    text = find_robot("cubesat_3u").read_text(encoding="utf-8").split("[uncertainty]")[0]
    (tmp_path / "exact.toml").write_text(text, encoding="utf-8")
    process = tfsat_host(
        "plan", "--target", "z:5", "--robot", tmp_path / "exact.toml", "--model-error", "1", expect=1
    )
    assert "[uncertainty]" in process.stderr


def test_a_grid_without_loops_is_refused(tfsat_host: RunCli) -> None:
    assert "smaller step" in tfsat_host("plan", "--target", "z:5", "--grid", "91", expect=1).stderr


@pytest.mark.parametrize(("tolerance", "seed"), [pytest.param(0.2, 1, marks=pytest.mark.prove), (0.5, 2)])
def test_noise_above_the_tolerance_does_not_lead_away_and_promises_nothing(
    tfsat_host: RunCli, tolerance: float, seed: int
) -> None:
    arguments = ("plan", "--target", "z:90", "--noise", "1", "--tolerance", tolerance, "--seed", seed)
    plan = tfsat_host.json(*arguments, expect=3)
    assert plan["outcome"] == "given up"
    measured = [step["measured_error_deg"] for step in plan["steps"]]
    # Four deviations about three axes; the end is where it had been measured nearest.
    assert plan["error_deg"] < 4.0
    attitudes = {tuple(round(value, 9) for value in step["attitude_xyzw"]) for step in plan["steps"]}
    nearest = plan["steps"][measured.index(min(measured))]["attitude_xyzw"]
    assert plan["steps"][-1]["attitude_xyzw"] == pytest.approx(nearest, abs=1e-6)
    assert len(attitudes) > 1
    assert plan["possible_tolerance_deg"] is None and plan["measured_to_deg"] == pytest.approx(3.0**0.5)


def test_noise_above_the_tolerance_is_named(tfsat_host: RunCli) -> None:
    arguments = "plan --target z:90 --method greedy --noise 1 --tolerance 0.5 --seed 2 --max-primitives 4"
    text = " ".join(tfsat_host(*arguments.split(), expect=3).stdout.split())
    assert "--tolerance" not in text and "no single loop" not in text
    assert "Attitude noise: 1.7 deg, above the tolerance" in text


def test_a_turn_and_its_inverse_take_as_long(tfsat_host: RunCli) -> None:
    forth, back = (tfsat_host.json("plan", "--target", f"z:{sign}90") for sign in ("", "-"))
    assert forth["duration_s"] == pytest.approx(back["duration_s"])


def test_the_rate_is_that_about_the_axis_needed(tfsat_host: RunCli) -> None:
    about_z, about_y = (
        tfsat_host.json("plan", "--target", target, "--tolerance", "89") for target in ("z:90", "y:90")
    )
    assert about_z["axis_rate_deg_s"] == pytest.approx(3.28, abs=0.02)
    assert about_y["axis_rate_deg_s"] < 0.3
    text = tfsat_host("plan", "--target", "y:90", "--tolerance", "89").stdout
    assert f"{about_y['axis_rate_deg_s']:.2f} deg/s" in text and "3.29" not in text


def test_at_the_target_rounding_is_not_shown(tfsat_host: RunCli) -> None:
    text = tfsat_host("plan", "--target", "z:360").stdout
    assert "at the start" in text and "e-" not in text


@pytest.mark.parametrize("target", ["x:2,z:-40", "z:0"])
def test_simulate_arrives_where_the_plan_does(tfsat_host: RunCli, target: str) -> None:
    plan = tfsat_host.json("plan", "--target", target, "--history", "plan.csv")
    simulation = tfsat_host.json("simulate", "--robot", "cubesat_3u", "--history", "plan.csv")
    end = plan["steps"][-1]["attitude_xyzw"] if plan["steps"] else [0.0, 0.0, 0.0, 1.0]
    cosine = abs(sum(a * b for a, b in zip(simulation["quaternion_xyzw"], end, strict=True)))
    assert math.degrees(2.0 * math.acos(min(cosine, 1.0))) < 0.01


def test_a_history_is_no_plan_and_nobody_s_measurement_is_lost(tfsat_host: RunCli) -> None:
    arguments = ("plan", "--target", "z:20", "--method", "greedy", "--history", "h.csv")
    for _ in range(2):  # the second time over its own
        tfsat_host(*arguments)
    tfsat_host(*arguments, "--out", "h.csv", expect=2)
    (tfsat_host.folder / "h.csv").write_text("t_s,theta1_deg,theta2_deg,theta3_deg\n0,0,0,0\n")
    tfsat_host(*arguments, expect=1)
    assert (tfsat_host.folder / "h.csv").read_text().endswith("0,0,0,0\n")
