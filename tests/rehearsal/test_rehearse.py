"""The whole chain: a typed command, the firmware, the fall, the card, the decoder."""

from __future__ import annotations

import csv
import json
import shlex
from pathlib import Path

import numpy as np
import pytest

from tests.cli.process import RunCli
from tests.rehearsal.as_filed import dropped
from tfsat_host.emulated.sequencer_image import sequencer_hex
from tfsat_host.evaluation.motion.samples import EvaluationError
from tfsat_host.evaluation.quick_look import disagreements, quick_look
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.robot import load_robot
from tfsat_host.sdlog import load

SCHEDULE_S = [0.70, 1.05, 1.47, 1.82]


@pytest.mark.parametrize("sequencer", ["native", "avr"])
def test_59_70_comes_back_from_the_card(tfsat_host: RunCli, sequencer: str) -> None:
    flown = tfsat_host.json("rehearse", "59", "70", "--sequencer", sequencer, "--as-filed", "--out", "run")
    assert flown["verified"] is True
    assert flown["refused"] is None
    assert flown["sequencer_state"] == "done"
    assert flown["knocks"] == 1
    assert flown["verdict"] == "complete"
    assert flown["samples_lost"] == 0
    # The logger's clock counts whole microseconds, and so do the release and the strokes.
    assert flown["strokes_s"] == pytest.approx(SCHEDULE_S, abs=60e-6)
    evaluation = flown["evaluation"]
    sizes = [stroke["size_deg"] for stroke in evaluation["strokes"]]
    assert sizes == pytest.approx([59.0, 70.0, -59.0, -70.0], abs=0.3)
    assert [joint["final_deg"] for joint in evaluation["joints"]] == pytest.approx([0.0, 0.0, 0.0], abs=0.3)
    assert flown["warnings"] == []
    assert flown["quick_look"] is None
    assert evaluation["reorientation_deg"] == pytest.approx(flown["reorientation_true_deg"], abs=0.1)

    decoded = tfsat_host.json("decode", "run/SD.bin")
    assert decoded["verdict"] == "complete"
    assert decoded["samples"] == flown["samples"]
    strokes = [event for event in decoded["events"] if event["name"] == "stroke"]
    assert [event["t_s"] for event in strokes] == pytest.approx(SCHEDULE_S, abs=60e-6)
    with (tfsat_host.folder / decoded["files"]["csv"]).open() as file:
        assert sum(1 for _ in csv.reader(file)) == decoded["samples"] + 1


@pytest.mark.parametrize(
    ("angles", "agree_deg"), [(("54", "72"), 0.003), (("18", "90"), 0.003), (("59", "70"), 0.01)]
)
def test_simulate_computes_the_same_drop(
    tfsat_host: RunCli, angles: tuple[str, str], agree_deg: float
) -> None:
    """The emulator's robot in C++ and the dynamics in Python, both released as the paper's robot was.

    The servos' pulses are whole microseconds: 9 deg are 100 of them, but 59 deg are rounded by 0.04 deg.
    """
    flown = tfsat_host.json("rehearse", *angles, "--as-filed", "--out", "a run")
    assert flown["initial_rate_deg_s"] == [-0.73, -0.48, -0.77]
    program, *command = shlex.split(flown["simulate_command"])
    assert program == "tfsat-host"
    computed = tfsat_host.json(*command)
    assert computed["initial_rate_deg_s"] == flown["initial_rate_deg_s"]
    assert computed["reorientation_deg"] == pytest.approx(flown["reorientation_true_deg"], abs=agree_deg)
    at_rest = tfsat_host.json("simulate", *angles)
    assert abs(at_rest["reorientation_deg"] - computed["reorientation_deg"]) > 1.0


def test_folder_of_results(tfsat_host: RunCli) -> None:
    shown = tfsat_host("rehearse", "59", "70", "--out", "drop")
    folder = tfsat_host.folder / "drop"
    for name in (
        "SD.bin",
        "SD.csv",
        "maneuver.toml",
        "truth.csv",
        "truth.json",
        "summary.json",
        "report.html",
    ):
        assert (folder / name).stat().st_size > 0
    assert "The robot:            seed 1 of " in shown.stdout
    assert "drop_tower.toml, IMUs InvenSense MPU-6050." in shown.stdout
    assert "tfsat-host simulate --file drop/maneuver.toml --initial-rate " in shown.stdout
    assert " deg/s, body 3 about its own axes x, y, z" in shown.stdout
    assert "The evaluation:       GOOD." in shown.stdout
    assert "it ignored 1 knock (during the lift a blow is simulated" in shown.stdout
    summary = json.loads((folder / "summary.json").read_text())
    left = {path.name for path in folder.rglob("*") if path.is_file() and not path.name.startswith(".")}
    assert {Path(path).name for path in summary["files"]} == left
    assert f"Body 1 turned by:     {summary['evaluation']['reorientation_deg']:.3f} ± 0.0" in shown.stdout
    assert summary["schedule"][0] == {"t_s": 0.7, "joint": 1, "angle_deg": 59.0}
    # The same seed gives the same card, byte for byte; its own folder may be made again.
    card = (folder / "SD.bin").read_bytes()
    tfsat_host("rehearse", "--file", "drop/maneuver.toml", "--out", "drop")
    assert (folder / "SD.bin").read_bytes() == card
    tfsat_host("rehearse", "59", "70", "--seed", "2", "--out", "drop")
    assert (folder / "SD.bin").read_bytes() != card


def test_joints_that_do_not_reach_their_angles_are_a_doubt(tfsat_host: RunCli) -> None:
    """At 400 deg/s each stroke is over before the servos, 200 deg/s at most, have done it."""
    tfsat_host("upload-sequence", "59", "70", "--speed", "400", "--dry-run", "--out", "fast.toml")
    shown = tfsat_host("rehearse", "--file", "fast.toml", "--as-filed", "--despite-preflight", expect=3)
    assert "above the greatest rate of the servos, 200 deg/s" in shown.stderr
    assert "Warning: Stroke 2 moved its joint by +57." in shown.stderr
    for words in ("commanded / deg", "flown / deg", "+57."):
        assert words in shown.stdout
    summary = json.loads((tfsat_host.folder / "run" / "summary.json").read_text())
    assert len(summary["warnings"]) >= 2
    assert summary["notices"]


def test_strokes_that_are_not_as_planned_are_said() -> None:
    scheduled, commanded = [0.70, 1.05], [59.0, -59.0]
    assert disagreements(scheduled, [0.70005, 1.04995], commanded, [58.1, -59.9]) == []
    late, short = disagreements(scheduled, [0.7, 1.051], commanded, [59.0, -56.9])
    assert "Stroke 2 began at 1.0510 s instead of 1.0500 s" in late
    assert "Stroke 2 moved its joint by -56.9 deg instead of -59 deg" in short
    assert disagreements(scheduled, [0.7], commanded, commanded) == [
        "The log holds 1 strokes, 2 were scheduled."
    ]
    assert "lacks the joint's angles" in disagreements(scheduled, scheduled, commanded, [59.0, np.nan])[0]


@pytest.mark.parametrize("seed", ["-1", "1.5", str(2**63), "x"])
def test_a_seed_that_is_none(tfsat_host: RunCli, seed: str) -> None:
    assert "is no seed" in tfsat_host("rehearse", "59", "70", "--seed", seed, expect=2).stderr


def test_somebody_elses_folder_is_left_alone(tfsat_host: RunCli) -> None:
    (tfsat_host.folder / "precious").mkdir()
    note = tfsat_host.folder / "precious" / "note.txt"
    note.write_text("keep")
    result = tfsat_host("rehearse", "59", "70", "--out", "precious", expect=2)
    assert "holds files that no rehearsal made" in result.stderr
    assert [path.name for path in (tfsat_host.folder / "precious").iterdir()] == ["note.txt"]


def test_a_file_in_place_of_the_folder_is_not_cured_by_force(tfsat_host: RunCli) -> None:
    (tfsat_host.folder / "ok.toml").write_text("mine")
    result = tfsat_host("rehearse", "59", "70", "--out", "ok.toml", "--force", expect=2)
    assert "Give the name of a folder" in result.stderr
    assert "--force" not in result.stderr


def test_bad_maneuvers_are_not_flown(tfsat_host: RunCli) -> None:
    assert "100" in tfsat_host("rehearse", "100", "70", expect=1).stderr
    tfsat_host("rehearse", "59", expect=2)
    tfsat_host("rehearse", expect=2)
    tfsat_host("rehearse", "--file", "missing.toml", expect=1)
    assert not (tfsat_host.folder / "run").exists()


def test_reorientation_of_the_papers_maneuver() -> None:
    """Without residual rates the emulated robot turns by the paper's 26.11 deg (sec. opt)."""
    flight = dropped(schedule_maneuver(four_stroke(58.75, 70.29)), seed=3, rate_rad_s=(0, 0, 0))
    ending = flight.truth[flight.truth[:, 0] <= flight.landed_s - 0.01][-1]
    turned = 2 * np.rad2deg(np.arccos(np.abs(np.dot(ending[4:8], flight.truth[0, 4:8]))))
    assert turned == pytest.approx(26.11, abs=0.02)
    assert flight.sequencer.state == SequencerState.DONE


def test_a_recording_without_a_release_is_not_evaluated(tmp_path: Path) -> None:
    flight = dropped(schedule_maneuver(four_stroke(59, 70)), seed=1)
    card = tmp_path / "SD.bin"
    card.write_bytes(flight.card[: 60 * 512])  # ends before the release
    log = load(card)
    assert log.verdict == "truncated"
    with pytest.raises(EvaluationError, match="no release"):
        quick_look(log, load_robot(), until_s=2.0)


def test_the_image_is_found() -> None:
    assert sequencer_hex().read_text().startswith(":")
