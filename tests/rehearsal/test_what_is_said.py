"""What a rehearsal says when something went wrong: fault, who noticed, red check, stuck switch, pose, maneuver."""

from __future__ import annotations

import json

from tests.cli.process import RunCli


def test_faults_are_named_with_who_noticed(tfsat_host: RunCli) -> None:
    typed = ("rehearse", "59", "70", "--fault", "servo-dead", "--fault", "cable-pulled-while-armed")
    shown = tfsat_host(*typed, expect=3).stdout
    assert (
        "Thrown in:            servo-dead (cables pulled, on the crane's hook): The servo of joint 1" in shown
    )
    assert "By design the robot then flies the maneuver" in shown
    assert "Noticed by the evaluation: Stroke 1 (joint 1): Joint 1 did not move" in shown
    assert "Noticed by nobody. It changes nothing that is to be noticed." in shown
    result = json.loads((tfsat_host.folder / "run" / "summary.json").read_text())
    assert (result["seed"], result["imu"]) == (1, "InvenSense MPU-6050")
    servo, cable = result["faults"]
    assert (servo["moment"], servo["outcome"]) == ("lifted", "flies the maneuver")
    assert [one["who"] for one in servo["noticed_by"]] == ["report"]
    assert cable["noticed_by"] == []
    assert servo["struck_s"] > cable["struck_s"] > 0.0


def test_no_go_names_each_check_with_what_was_found_and_what_to_do(tfsat_host: RunCli) -> None:
    """Of a fault that would have struck after that it is said that it did not."""
    faults = ("--fault", "card-full", "--fault", "servo-dead@falling")
    shown = tfsat_host("rehearse", "59", "70", *faults, "--out", "run", expect=4).stdout
    assert "Preflight:            NO-GO: card-room, card-writing." in shown
    written = json.loads((tfsat_host.folder / "run" / "preflight.json").read_text())
    red = [check for check in written["checks"] if check["blocks"]]
    assert [check["name"] for check in red] == ["card-room", "card-writing"]
    for check in red:
        assert check["name"] in shown
        assert check["sentence"] in shown
        assert f"On the day: {check['next_step']}" in shown
    assert "run/preflight.json" in shown
    assert "Noticed by the preflight's checks: card-room, card-writing" in shown
    assert "It did not strike: the day ended before." in shown
    summary = json.loads((tfsat_host.folder / "run" / "summary.json").read_text())
    assert (
        [check["name"] for check in summary["no_go_checks"]]
        == summary["no_go"]
        == ["card-room", "card-writing"]
    )
    assert [fault["struck_s"] is None for fault in summary["faults"]] == [False, True]


def test_without_a_release_it_says_what_the_switches_did(tfsat_host: RunCli) -> None:
    shown = tfsat_host(
        "rehearse", "59", "70", "--fault", "switch-stuck-closed", "--out", "run", expect=3
    ).stdout
    assert "it hung 5 minutes on the hook, was let go and fell 2.50 s; it started 0 strokes" in shown
    assert "in truth no joint moved by more than 0.0 deg" in shown
    assert "switch 1 never changed, and was closed at the end." in shown
    assert "switch 2 changed " in shown
    assert "tfsat-host decode run/SD.bin" in shown
    assert "tfsat-host disarm" in shown
    assert "REFUSED. The recording holds no release." in shown
    result = json.loads((tfsat_host.folder / "run" / "summary.json").read_text())
    (fault,) = result["faults"]
    assert [one["who"] for one in fault["noticed_by"]] == ["report refuses"]
    first, second = result["no_release"]["switches"]
    assert (first["edges_s"], first["open_at_the_end"], second["open_at_the_end"]) == ([], False, True)
    assert "tfsat-host" in result["evaluation_refused"]["next_step"]


def test_a_recording_that_breaks_off_before_the_release_is_no_fault_of_the_switches(
    tfsat_host: RunCli,
) -> None:
    """What the joints did the truth tells; the sequencer lost its power since, and knows no run."""
    faults = ("--fault", "power-cut-after-landing", "--fault", "card-gone-on-the-hook")
    shown = tfsat_host("rehearse", "59", "70", *faults, "--out", "run", expect=3).stdout
    assert "how many strokes it started no board knows" in shown and "0 strokes" not in shown
    assert "in truth its joints moved: joint 1 by up to 59." in shown
    assert "nothing of the drop: the recording breaks off 26." in shown
    assert "both switches must be open" not in shown
    assert "The logger recorded no longer: it had lost its power or its card" in shown
    result = json.loads((tfsat_host.folder / "run" / "summary.json").read_text())
    assert result["no_release"]["strokes_started"] is None
    assert 26.0 < result["no_release"]["recording_ended_before_release_s"] < 27.0
    cut, gone = result["faults"]
    assert cut["came_of_it"] is gone["came_of_it"] is True
    assert "By design the robot then flies the maneuver. It did." in shown
    assert "Noticed by nobody by its own name. What power-cut-after-landing did may hide it" in shown


def test_a_robot_that_another_fault_keeps_from_flying_is_said_to_have_been(tfsat_host: RunCli) -> None:
    faults = ("--fault", "servo-slow", "--fault", "brown-out-at-release")
    shown = tfsat_host("rehearse", "59", "70", *faults, "--out", "run", expect=3).stdout
    assert "It did not, for another fault: with that it moves no joint, and it did." in shown
    assert "By design the robot then moves no joint. It did." in shown


def test_a_recording_out_of_ram_is_not_called_the_cards(tfsat_host: RunCli) -> None:
    shown = tfsat_host("rehearse", "59", "70", "--fault", "card-pulled", "--out", "run").stdout
    assert "The logger recorded no longer" not in shown  # it says itself what happened to its card
    assert "RAM of the logger:    complete" in shown and "The card:" not in shown


def test_two_faults_of_one_part_are_refused_before_anything_is_flown(tfsat_host: RunCli) -> None:
    for one, other, part in (
        ("servo-dead", "servo-reversed", "servo of joint 1"),
        ("card-full@checked", "card-missing@checked", "card"),
        ("gyro-dead", "gyro-dead@falling", "IMU of body 4"),
        ("power-cut-at-landing", "power-cut-after-landing", "power of both boards"),
    ):
        refused = tfsat_host("rehearse", "59", "70", "--fault", one, "--fault", other, expect=2).stderr
        assert f"{one} and {other} cannot both be thrown in: both are of the same part, {part}." in refused
    twice = ("--fault", "switch-bounce", "--fault", "switch-bounce@armed")
    assert "the same fault at two moments" in tfsat_host("rehearse", "59", "70", *twice, expect=2).stderr
    assert not (tfsat_host.folder / "run").exists()


def test_a_start_pose_that_is_wrong_is_named(tfsat_host: RunCli) -> None:
    """A reversed servo holds its joint on the other side of the pulse's middle before the first stroke."""
    flown = tfsat_host.json("rehearse", "59", "70", "--fault", "servo-reversed", expect=3)
    (said,) = [one for one in flown["evaluation"]["reasons"] if "Wrong start pose" in one]
    assert "joint 1 stood at +" in said
    assert "instead of 0 ± 10 deg" in said
    checks = {one["name"]: one for one in tfsat_host.json("evaluate", "run", expect=3)["checks"]}
    assert checks["start pose"]["verdict"] == "failed"
    assert checks["start pose"]["value"] > checks["start pose"]["threshold"] == 10.0
    assert checks["start pose"]["cause"].startswith("servo of joint 1: it turns the other way")
    assert checks["maneuver as filed"]["verdict"] == "passed"


def test_another_maneuver_than_the_files_is_named(tfsat_host: RunCli) -> None:
    typed = ("rehearse", "59", "70", "--fault", "wrong-maneuver", "--despite-preflight")
    flown = tfsat_host.json(*typed, expect=3)
    said = flown["evaluation"]["reasons"][0]
    assert said.startswith(
        "Another maneuver was flown than the file says. The file: 0.700 s joint 1 by +59.00 deg;"
    )
    assert "0.810 s joint 2 by +89." in said
    checks = {one["name"]: one for one in tfsat_host.json("evaluate", "run", expect=3)["checks"]}
    assert checks["maneuver as filed"]["verdict"] == "failed"
    assert checks["start pose"]["verdict"] == "passed"
    tfsat_host("upload-sequence", "18", "90", "--dry-run", "--out", "flown.toml")
    right = tfsat_host.json("evaluate", "run", "--maneuver", "flown.toml")
    assert right["verdict"]["level"] == "good"


def test_a_file_that_differs_in_times_or_joints_alone_is_another_maneuver(tfsat_host: RunCli) -> None:
    """54/72 strokes 30 ms apart from 59/70; and the same strokes, but of another joint."""
    tfsat_host("rehearse", "59", "70", "--out", "run")
    tfsat_host("upload-sequence", "54", "72", "--dry-run", "--out", "times.toml")
    flown = (tfsat_host.folder / "run" / "maneuver.toml").read_text()
    assert "joint = 2" in flown
    (tfsat_host.folder / "joints.toml").write_text(flown.replace("joint = 2", "joint = 3"))
    for file, strokes in (("times.toml", 2), ("joints.toml", 2)):
        told = tfsat_host.json("evaluate", "run", "--maneuver", file, expect=3)
        (check,) = [one for one in told["checks"] if one["name"] == "maneuver as filed"]
        assert (check["verdict"], check["value"] >= strokes) == ("failed", True), file
        assert "1.050 s joint 2 by +6" in check["sentence"]


def test_what_servos_and_clocks_do_is_no_other_maneuver(tfsat_host: RunCli) -> None:
    for fault in ("sequencer-clock-fast", "watchdog-while-falling", "servo-dead", "servo-slow"):
        tfsat_host("rehearse", "59", "70", "--fault", fault, "--despite-preflight", expect=3)
        checks = {
            one["name"]: one["verdict"] for one in tfsat_host.json("evaluate", "run", expect=3)["checks"]
        }
        assert (checks["maneuver as filed"], checks["start pose"]) == ("passed", "passed"), fault
