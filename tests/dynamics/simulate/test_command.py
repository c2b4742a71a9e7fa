"""`tfsat-host simulate` as a process: what it prints and writes, and how it refuses."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.cli.process import RunCli
from tests.dynamics.random_robots import random_robot
from tests.dynamics.simulate.maneuvers import write
from tfsat_host.maneuver import Maneuver, Stroke, format_maneuver

FIXED_KEYS = {"reorientation_deg", "rotation_vector_deg", "euler_zyx_deg", "quaternion_xyzw"}


@pytest.fixture
def five(tmp_path: Path) -> Path:
    return random_robot(tmp_path, 5, 5).path


def columns(path: Path) -> dict[str, list[float]]:
    with path.open(encoding="ascii", newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: [float(row[name]) for row in rows] for name in rows[0]}


def test_the_papers_maneuver_for_people(tfsat_host: RunCli) -> None:
    process = tfsat_host("simulate", 58.75, 70.29)
    assert process.stderr == ""
    assert process.stdout.startswith("Reorientation:           26.112 deg\n")
    for text in (
        "drop tower robot",
        "Attitude of:             body 3",
        "no angular momentum",
        "Euler angles z, y, x / deg",
        "+58.75",
        "1.82",
    ):
        assert text in process.stdout


def test_the_papers_maneuver_in_json(tfsat_host: RunCli) -> None:
    result = tfsat_host.json("simulate", 58.75, 70.29)
    assert result["reorientation_deg"] == pytest.approx(26.1124, abs=1e-4)
    # The same rotation as vector, quaternion and Euler angles.
    turn = Rotation.from_rotvec(result["rotation_vector_deg"], degrees=True)
    assert turn.as_quat(canonical=True) == pytest.approx(result["quaternion_xyzw"], abs=1e-12)
    assert turn.as_euler("ZYX", degrees=True) == pytest.approx(result["euler_zyx_deg"], abs=1e-9)
    assert {name: result[name] for name in ("robot", "base", "closed", "duration_s", "end_s")} == {
        "robot": "drop tower robot",
        "base": "body 3",
        "closed": True,
        "duration_s": 2.5,
        "end_s": 2.23,
    }
    assert result["initial_rate_deg_s"] is None
    assert result["angular_momentum_kg_m2_s"] == [0.0, 0.0, 0.0]
    assert [stroke["joint"] for stroke in result["strokes"]] == [1, 2, 1, 2]
    assert result["strokes"][-1]["after"] == {key: result[key] for key in FIXED_KEYS}
    assert [body["body"] for body in result["bodies"]] == [f"body {i}" for i in range(1, 5)]
    assert result["files"] == {} and result["notices"] == []


def test_an_initial_rate_turns_the_robot_on_until_the_end(tfsat_host: RunCli) -> None:
    write(tfsat_host.folder / "still.toml")
    spin = ("--initial-rate", 0, 0, "-8", "--until", "1.5")
    result = tfsat_host.json("simulate", "--file", "still.toml", *spin)
    # Its z axis is nearly a principal axis.
    assert result["euler_zyx_deg"] == pytest.approx([-12.0, 0.0, 0.0], abs=0.1)
    assert result["initial_rate_deg_s"] == [0.0, 0.0, -8.0]
    assert result["duration_s"] == 1.5 and result["strokes"] == []
    assert result["angular_momentum_kg_m2_s"][2] < 0.0
    assert "joints never move" in tfsat_host("simulate", "--file", "still.toml", *spin).stdout
    with_rate, without = (tfsat_host.json("simulate", 59, 70, *args) for args in (spin[:4], ()))
    assert abs(with_rate["euler_zyx_deg"][0] - without["euler_zyx_deg"][0]) > 10.0


def test_an_open_path_says_whose_rotation_it_is(tfsat_host: RunCli) -> None:
    write(tfsat_host.folder / "open.toml", (3, 40.0))
    by_name, by_number = (
        tfsat_host.json("simulate", "--file", "open.toml", "--base", base) for base in ("body 4", "4")
    )
    assert by_name == by_number
    default = tfsat_host.json("simulate", "--file", "open.toml")
    assert not default["closed"]
    # Body 4 is carried by joint 3, which turned it by 40 deg.
    assert by_name["reorientation_deg"] - default["reorientation_deg"] == pytest.approx(40.0, abs=0.1)
    process = tfsat_host("simulate", "--file", "open.toml")
    assert "depends on the base body: this is that of body 3" in process.stderr
    assert "Reorientation / deg" in process.stdout


def test_five_bodies_move_within_their_own_limits(tfsat_host: RunCli, five: Path) -> None:
    file = write(tfsat_host.folder / "m.toml", (4, -80.0), (2, 60.0), (4, 80.0), (2, -60.0))
    result = tfsat_host.json("simulate", "--file", file, "--robot", five)
    assert len(result["bodies"]) == 5 and result["closed"]
    assert result["reorientation_deg"] > 1.0
    for strokes, code in ((((5, 10.0),), "unknown-joint"), (((4, -90.5),), "joint-range")):
        wrong = write(tfsat_host.folder / "wrong.toml", *strokes)
        error = tfsat_host.json("simulate", "--file", wrong, "--robot", five, expect=1)["error"]
        assert error["code"] == code
        assert "wrong.toml:5: Stroke 1" in error["what"]
    unknown = tfsat_host.json("simulate", "--file", file, expect=1)["error"]
    assert "joint 4; the robot has joints 1 to 3" in unknown["what"]
    assert "--robot names another robot" in unknown["next_step"]


def test_another_robot_moves_at_its_own_speed_for_as_long_as_it_takes(tfsat_host: RunCli) -> None:
    result = tfsat_host.json("simulate", 90, 90, "--robot", "cubesat_3u")
    assert result["strokes"][1]["t_s"] == 3.7  # 0.7 s and 90 deg at 30 deg/s
    assert result["duration_s"] == pytest.approx(12.7)
    assert result["notices"] == []  # no sequencer commands it


def test_what_the_sequencer_would_refuse_is_simulated_and_said(tfsat_host: RunCli) -> None:
    result = tfsat_host.json("simulate", 90, 90)
    assert result["reorientation_deg"] == pytest.approx(39.4, abs=0.05)
    assert len(result["notices"]) == 1
    assert "sequencer would refuse" in result["notices"][0] and "2.5" in result["notices"][0]


def test_the_csv_reads_back_and_flies_again(tfsat_host: RunCli) -> None:
    rate = ("--initial-rate", "3", "-4", "5")
    result = tfsat_host.json("simulate", 59, 70, *rate, "--out", "results")
    assert result["files"] == {"csv": str(Path("results/simulation.csv"))}
    table = columns(tfsat_host.folder / "results" / "simulation.csv")
    assert table["t_s"][0] == 0.0 and table["t_s"][-1] == 2.5
    assert [table[f"body3_euler_{c}_deg"][-1] for c in "zyx"] == pytest.approx(result["euler_zyx_deg"])
    assert [table[f"base_quaternion_{c}"][-1] for c in "xyzw"] == pytest.approx(result["quaternion_xyzw"])
    assert [table[f"body3_rate_{c}_deg_s"][0] for c in "xyz"] == pytest.approx([3.0, -4.0, 5.0])
    # Angular momentum is constant, in every row.
    for c, expected in zip("xyz", result["angular_momentum_kg_m2_s"], strict=True):
        assert table[f"momentum_{c}_kg_m2_s"] == pytest.approx([expected] * len(table["t_s"]), abs=1e-9)
    assert max(table["theta1_deg"]) == pytest.approx(59.0) and table["theta1_deg"][-1] == 0.0
    # A gyro on body 1 and one on body 2 differ by the rate of joint 1, about x.
    between = np.subtract(table["body1_rate_x_deg_s"], table["body2_rate_x_deg_s"])
    assert between == pytest.approx(np.array(table["theta1_rate_deg_s"]), abs=1e-6)
    # Kinetic energy changes: the servos do work.
    assert max(table["kinetic_energy_j"]) > min(table["kinetic_energy_j"]) > 0.0

    again = tfsat_host.json("simulate", "--history", "results/simulation.csv", *rate)
    assert again["euler_zyx_deg"] == pytest.approx(result["euler_zyx_deg"], abs=1e-3)
    assert again["strokes"] == [] and again["closed"]


def test_the_npz_is_in_si_units_with_its_metadata(tfsat_host: RunCli, five: Path) -> None:
    file = write(tfsat_host.folder / "m.toml", (4, 45.0), (4, -45.0))
    result = tfsat_host.json("simulate", "--file", file, "--robot", five, "--out", "m.npz")
    with np.load(tfsat_host.folder / "m.npz") as archive:
        m = len(archive["t_s"])
        assert archive["theta_deg"].shape == (m, 4)
        assert archive["theta_deg"].max() == pytest.approx(45.0)
        # SI units and the shapes of the documentation.
        assert archive["body_rate_deg_s"].shape == archive["body_euler_zyx_deg"].shape == (m, 5, 3)
        assert archive["body_quaternion_xyzw"].shape == (m, 5, 4)
        assert json.loads(str(archive["metadata"]))["robot"] == result["robot"]


def test_only_files_of_its_own_are_overwritten(tfsat_host: RunCli) -> None:
    measured = tfsat_host.folder / "measured.csv"
    measured.write_text("t_s,theta1_deg,theta2_deg,theta3_deg\n0,0,0,0\n1,0,0,0\n")
    before = measured.read_text()
    tfsat_host("simulate", 59, 70, "--out", measured, expect=1)
    # A history must not be overwritten by its own result.
    tfsat_host("simulate", "--history", measured, "--out", measured, "--force", expect=2)
    assert measured.read_text() == before
    for _ in range(2):
        tfsat_host("simulate", 59, 70, "--out", "own.csv")
        tfsat_host("simulate", 59, 70, "--out", "own.npz")
    tfsat_host("simulate", 59, 70, "--out", measured, "--force")
    assert len(columns(measured)["t_s"]) > 200


def test_measured_angles_need_not_keep_the_limits(tfsat_host: RunCli) -> None:
    (tfsat_host.folder / "h.csv").write_text(
        "theta3_deg,theta2_deg,theta1_deg,t_s,comment\r\n0,0,-0.2,0.1,start\r\n\r\n0,0,93,1.1,\r\n0,0,-0.2,3.1,end\r\n"
    )
    result = tfsat_host.json("simulate", "--history", "h.csv", "--between", "linear", "--out", "o.csv")
    assert result["notices"] == ["The history takes joint 1 3.00 deg beyond the limits of drop_tower.toml."]
    assert result["duration_s"] == result["end_s"] == 3.1
    table = columns(tfsat_host.folder / "o.csv")
    assert table["theta1_deg"][0] == -0.2 and table["theta1_rate_deg_s"][0] == 0.0


def test_a_history_that_cannot_be_understood(tfsat_host: RunCli) -> None:
    # An invalid number in the third line, and the file is named.
    (tfsat_host.folder / "h.csv").write_text("t_s,theta1_deg,theta2_deg,theta3_deg\n0,0,0,0\n1,0,x,0\n")
    process = tfsat_host("simulate", "--history", "h.csv", expect=1)
    for text in ("h.csv:3: theta2_deg is 'x'", "nothing was simulated", "Write a number there"):
        assert text in process.stderr


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ((), "Two angles are needed"),
        (("59",), "Two angles are needed"),
        (("59", "70", "--base", "body 9"), "no body 'body 9'"),
        (("59", "70", "--until", "2"), "before the joints have come to rest"),
        (("59", "70", "--step", "0"), "more than zero"),
        (("59", "70", "--step", "1e-9"), "steps"),
        (("59", "70", "--initial-rate", "0", "nan", "0"), "is no rate"),
        (("59", "70", "--initial-rate", "1e200", "0", "0"), "beyond 100000 deg/s"),
        (("59", "70", "--history", "h.csv"), "together with a maneuver"),
        (("59", "70", "--out", "motion.xlsx"), "neither in .csv nor in .npz"),
    ],
)
def test_arguments_that_make_no_sense(tfsat_host: RunCli, arguments: tuple[str, ...], says: str) -> None:
    error = tfsat_host.json("simulate", *arguments, expect=2)["error"]
    assert says in error["what"]
    assert error["next_step"]
    assert list(tfsat_host.folder.iterdir()) == []


def test_a_maneuver_through_the_gimbal_lock_warns_of_nothing(tfsat_host: RunCli) -> None:
    write(tfsat_host.folder / "still.toml")
    process = tfsat_host(
        "simulate", "--file", "still.toml", "--initial-rate", 0, 90, 0, "--until", 2, "--out", "tumble.csv"
    )
    assert process.stderr == ""
    assert max(columns(tfsat_host.folder / "tumble.csv")["body3_euler_y_deg"]) > 85.0


def test_what_the_servos_cannot_do_in_time_is_done_later_and_said(tfsat_host: RunCli) -> None:
    result = tfsat_host.json("simulate", 30, 45, "--out", "m.csv")
    assert "Strokes 1, 2, 3, 4 end later" in result["notices"][0]
    assert "propagation in time" in result["notices"][1]
    # 200 deg/s at most, reached and left at 4000 deg/s^2.
    # Reached and left at 4000 deg/s^2, and never faster than 200 deg/s.
    for stroke, duration_s in zip(result["strokes"], (0.2, 0.275) * 2, strict=True):
        assert stroke["end_s"] - stroke["t_s"] == pytest.approx(duration_s, abs=2e-6)
    table = columns(tfsat_host.folder / "m.csv")
    for joint in (1, 2):
        rate, t_s = np.array(table[f"theta{joint}_rate_deg_s"]), np.array(table["t_s"])
        assert np.abs(rate).max() <= 200.0 + 1e-6
        assert (np.abs(np.diff(rate)) <= 4000.0 * np.diff(t_s) + 1e-4).all()
    slow = tfsat_host.json("simulate", 30, 45, "--speed", 90)
    assert slow["notices"] == []
    # Slower and faster strokes end in different attitudes: the path is another one.
    assert slow["reorientation_deg"] != pytest.approx(result["reorientation_deg"], abs=1e-4)


def test_a_joint_that_is_turned_back_before_it_arrives_is_said(tfsat_host: RunCli) -> None:
    # 10 deg at 170 deg/s take longer than scheduled: a servo has to speed up and slow down.
    strokes = ((1, 10.0, 0.70), (1, -10.0, 0.76))
    hasty = Maneuver(tuple(Stroke(*stroke) for stroke in strokes))
    (tfsat_host.folder / "hasty.toml").write_text(format_maneuver(hasty))
    notices = tfsat_host.json("simulate", "--file", "hasty.toml")["notices"]
    assert any("Stroke 2 starts 40 ms before joint 1 has arrived" in notice for notice in notices)


def test_the_error_of_the_integration_is_kept_small_or_said(tfsat_host: RunCli) -> None:
    fast = ("simulate", 59, 70, "--initial-rate", 300, 200, 400)
    result = tfsat_host.json(*fast)
    assert result["integration_error_deg"] < 1e-4 and result["notices"] == []
    coarse = tfsat_host.json(*fast, "--step", 1)
    assert coarse["integration_error_deg"] > 1.0
    # A step of one second for a robot that turns at 500 deg/s.
    assert "may be wrong by" in coarse["notices"][0] and "shorter --step" in coarse["notices"][0]


def test_a_slow_maneuver_takes_as_long_as_it_takes(tfsat_host: RunCli) -> None:
    slow, fast = tfsat_host.json("simulate", 59, 70, "--speed", 0.01), tfsat_host.json("simulate", 59, 70)
    assert slow["duration_s"] > 25_000
    # The path of a closed maneuver is independent of how fast it is flown.
    assert slow["rotation_vector_deg"] == pytest.approx(fast["rotation_vector_deg"], abs=1e-6)


def test_one_rigid_body_flies_but_no_maneuver_moves_it(tfsat_host: RunCli, tmp_path: Path) -> None:
    robot_path = random_robot(tmp_path, 3, 1).path
    result = tfsat_host.json(
        "simulate", "--robot", robot_path, "--initial-rate", 10, 20, 30, "--out", "one.csv"
    )
    assert result["reorientation_deg"] > 10.0 and len(result["bodies"]) == 1
    assert "no joints" in tfsat_host.json("simulate", 5, 5, "--robot", robot_path, expect=2)["error"]["what"]


def test_what_cannot_be_simulated_was_not_to_be_sent_anywhere(tfsat_host: RunCli, tmp_path: Path) -> None:
    two = random_robot(tmp_path, 3, 2).path
    for arguments in (("--file", write(tfsat_host.folder / "m.toml", (2, 10.0)), "--robot", two), (59, 99)):
        # No board is involved: nothing can be sent.
        error = tfsat_host.json("simulate", *arguments, expect=1)["error"]
        assert error["meaning"].endswith("Nothing was simulated.") and "sent" not in error["meaning"]
    assert "has joint 1 only" in tfsat_host.json("simulate", 5, 5, "--robot", two, expect=1)["error"]["what"]


def test_a_spline_that_leaves_its_samples_is_said(tfsat_host: RunCli) -> None:
    t_s = np.arange(0.0, 1.0, 0.01)
    rows = np.column_stack([t_s, 60.0 * t_s, 0.0 * t_s, 0.0 * t_s]).tolist()
    header, path = "t_s,theta1_deg,theta2_deg,theta3_deg\n", tfsat_host.folder / "h.csv"
    path.write_text(header + "".join(f"{','.join(map(str, row))}\n" for row in rows))
    assert not any("spline" in n for n in tfsat_host.json("simulate", "--history", "h.csv")["notices"])
    # A sample two microseconds after another, and 0.3 deg away: a spline overshoots.
    rows.insert(51, [0.500002, 30.3, 0.0, 0.0])
    path.write_text(header + "".join(f"{','.join(map(str, row))}\n" for row in rows))
    notices = tfsat_host.json("simulate", "--history", "h.csv")["notices"]
    assert "the spline takes joint 1" in notices[0] and "--between linear" in notices[0]
    linear = tfsat_host.json("simulate", "--history", "h.csv", "--between", "linear")["notices"]
    assert not any("spline" in n for n in linear)
