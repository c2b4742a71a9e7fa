"""The whole chain: a typed command, the firmware, the fall, the card, the decoder, and what a person reads of it."""

from __future__ import annotations

import csv
import json
import re
import shlex
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.process import RunCli
from tests.rehearsal.days import Rehearsed, Rehearsing, rehearse_drop
from tests.run.bundle.commands import result
from tfsat_host.emulated.build import sequencer_hex
from tfsat_host.evaluation.motion.samples import EvaluationError
from tfsat_host.evaluation.quick_look import disagreements, quick_look, reached_deg
from tfsat_host.json_values import jsonable
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.quantity import record
from tfsat_host.rehearsal.rehearsal import Rehearsal
from tfsat_host.rehearsal.result import REHEARSAL
from tfsat_host.robot import load_robot
from tfsat_host.sdlog import load

# The paper's times of 59/70 (tests/maneuver/test_schedule.py).
SCHEDULE_S = [0.70, 1.05, 1.47, 1.82]


def faulty(rehearsed: Rehearsing, *names: str, expect: int = 3) -> Rehearsed:
    return rehearsed("59", "70", *(word for name in names for word in ("--fault", name)), expect=expect)


def test_what_an_evaluation_withholds_is_unknown(tfsat_host: RunCli) -> None:
    # Two sensors are wrong: leaving one of them out does not make the others agree.
    faults = ("--fault", "gyro-bias-step", "--fault", "angle-sensor-crept")
    text = tfsat_host("rehearse", "59", "70", *faults, expect=3).stdout
    assert re.search(r"measured +withheld$", text, re.MULTILINE)
    assert re.search(r"nominal model +withheld", text)
    assert "results are withheld" in text
    assert not re.search(r"joint \d [+-]\d", text), "the joints' angles are of the same sensors"
    assert not re.search(r"body \d CoM . +-?\d", text), "no correction of the model"
    evaluation = tfsat_host.json("evaluate", "run", expect=3)
    (reason,) = [sentence for sentence in evaluation["verdict"]["reasons"] if sentence.startswith("Withheld")]
    assert "rates, attitudes, strokes" in reason
    assert "no greater errors of the certificate describe such a fault" in reason, "none was tried"
    withheld = {
        key: evaluation[key]
        for key in ("joints", "strokes", "standing", "offsets", "attitude_error", "momentum_kg_m2_s", "lag")
    }
    withheld |= {"com": evaluation["com_offset_mm"], "identifiability": evaluation["identifiability"]}
    # Schedule and file are not measured: they may be shown.
    stated_keys = {
        "joint",
        "stroke",
        "number",
        "scheduled_s",
        "logged_s",
        "commanded_deg",
        "prior_std",
        "bound",
    }
    assert {key: list(_numbers(value, stated_keys)) for key, value in withheld.items()} == {
        key: [] for key in withheld
    }


def _numbers(value: Any, stated_keys: set[str]) -> Iterator[float]:
    """Yield all numbers in a part of a result except those that do not come from sensors."""
    if isinstance(value, dict):
        for key, inner in value.items():
            if key not in stated_keys:
                yield from _numbers(inner, stated_keys)
    elif isinstance(value, list):
        for inner in value:
            yield from _numbers(inner, stated_keys)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield value


@pytest.mark.parametrize("sequencer", ["native", "avr"])
def test_59_70_comes_back_from_the_card(
    shared_rehearsal: Rehearsing, tfsat_host: RunCli, sequencer: str
) -> None:
    rehearsal = shared_rehearsal("59", "70", "--sequencer", sequencer, "--as-filed")
    summary = rehearsal.result
    assert summary["verified"] is True
    assert summary["refused"] is None
    assert summary["sequencer_state"] == "done"
    assert summary["knocks"] == 1
    assert summary["verdict"] == "complete"
    assert summary["samples_lost"] == 0
    # The logger's clock counts whole microseconds, and so do the release and the strokes.
    assert summary["strokes_s"] == pytest.approx(SCHEDULE_S, abs=60e-6)
    evaluation = summary["evaluation"]
    sizes = [stroke["size_deg"] for stroke in evaluation["strokes"]]
    assert sizes == pytest.approx([59.0, 70.0, -59.0, -70.0], abs=0.3)
    assert [joint["final_deg"] for joint in evaluation["joints"]] == pytest.approx([0.0, 0.0, 0.0], abs=0.3)
    assert summary["warnings"] == []
    assert summary["quick_look"] is None
    assert evaluation["reorientation_deg"] == pytest.approx(summary["reorientation_true_deg"], abs=0.1)

    shutil.copy(rehearsal.folder / "SD.bin", tfsat_host.folder)
    decoded = tfsat_host.json("decode", "SD.bin")
    assert decoded["verdict"] == "complete"
    assert decoded["samples"] == summary["samples"]
    strokes = [event for event in decoded["events"] if event["name"] == "stroke"]
    assert [event["t_s"] for event in strokes] == pytest.approx(SCHEDULE_S, abs=60e-6)
    with (tfsat_host.folder / decoded["files"]["csv"]).open() as file:
        assert sum(1 for _ in csv.reader(file)) == decoded["samples"] + 1


@pytest.mark.parametrize("angles", [(54.0, 72.0), (18.0, 90.0)])
def test_simulate_computes_the_same_drop(tfsat_host: RunCli, angles: tuple[float, float]) -> None:
    """Compute the same drop with `simulate` as with the emulator.

    The emulator's robot in C++ and the dynamics in Python are both released as the paper's robot was. The
    servos' pulses are whole microseconds: 9 deg are 100 of them.
    """
    flight = rehearse_drop(schedule_maneuver(four_stroke(*angles)), seed=1)
    # 50 ms before the landing: no shock in the comparison.
    until_s = flight.landed_s - flight.released_s - 0.05
    rows = [int(np.abs(flight.truth[:, 0] - flight.released_s - t_s).argmin()) for t_s in (0.0, until_s)]
    # Angle of the rotation between two unit quaternions; |·| as q and -q are the same attitude.
    turned_deg = 2 * np.rad2deg(np.arccos(np.abs(flight.truth[rows[0], 4:8] @ flight.truth[rows[1], 4:8])))
    # Measured of the paper's robot after its release, deg/s.
    rates = ("--initial-rate", -0.73, -0.48, -0.77)
    computed = tfsat_host.json("simulate", *angles, *rates, "--until", f"{until_s:.3f}")
    assert computed["reorientation_deg"] == pytest.approx(turned_deg, abs=0.003)
    at_rest = tfsat_host.json("simulate", *angles)
    # Without residual rates the angle differs by more than 1 deg: the comparison above is sharp.
    assert abs(at_rest["reorientation_deg"] - computed["reorientation_deg"]) > 1.0


def test_it_names_the_command_that_computes_the_same_drop(
    shared_rehearsal: Rehearsing, tfsat_host: RunCli
) -> None:
    """59 deg are rounded by 0.04 deg in whole microseconds."""
    rehearsal = shared_rehearsal("59", "70", "--sequencer", "native", "--as-filed")
    shutil.copytree(rehearsal.folder, tfsat_host.folder / "run")
    program, *command = shlex.split(rehearsal.result["simulate_command"])
    assert program == "tfsat-host"
    computed = tfsat_host.json(*command)
    assert computed["initial_rate_deg_s"] == rehearsal.result["initial_rate_deg_s"] == [-0.73, -0.48, -0.77]
    assert computed["reorientation_deg"] == pytest.approx(
        rehearsal.result["reorientation_true_deg"], abs=0.01
    )


def test_folder_of_results(shared_rehearsal: Rehearsing) -> None:
    rehearsal = shared_rehearsal("59", "70")
    files = "SD.bin SD.csv maneuver.toml truth.csv truth.json summary.json report.html"
    assert all((rehearsal.folder / name).stat().st_size > 0 for name in files.split())
    file_names = {path.name for path in rehearsal.folder.rglob("*") if path.is_file() and path.name[0] != "."}
    assert {Path(path).name for path in rehearsal.result["files"]} == file_names
    assert rehearsal.result["schedule"][0] == {"t_s": 0.7, "joint": 1, "angle_deg": 59.0}
    other = shared_rehearsal("59", "70", "--seed", "2")
    assert (other.folder / "SD.bin").read_bytes() != (rehearsal.folder / "SD.bin").read_bytes()


def test_the_first_screen_begins_and_ends_with_the_verdict(
    shared_rehearsal: Rehearsing, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    rehearsal = shared_rehearsal("59", "70", "--seed", "1")
    lines = rehearsal.out.splitlines()
    assert len(lines) <= 38 and max(map(len, lines)) <= 80
    assert lines[0].startswith("GOOD:") and lines[-1].startswith("GOOD:")
    evaluation = rehearsal.result["evaluation"]
    assert re.search(rf"measured +{evaluation['reorientation_deg']:.3f} ± 0.0", rehearsal.out)
    assert re.search(rf"truth \(emulator\) +{rehearsal.result['compared'][0]['true']:.3f}", rehearsal.out)
    words = " ".join(rehearsal.out.split())
    assert "seed 1 of drop_tower.toml, IMUs InvenSense MPU-6050" in words
    assert "complete, 2494 samples at 280.0 Hz, 0 lost (card)" in words
    assert "done, 1 false trigger rejected" in words
    largest = max((estimate["deviations"] for estimate in rehearsal.result["compared"]), key=abs)
    assert f"20 numbers, largest error {largest:+.1f} σ" in words
    assert "body 1 CoM x" not in words and "simulate" not in words


def test_full_shows_every_number(shared_rehearsal: Rehearsing) -> None:
    rehearsal = shared_rehearsal("59", "70", "--full")
    assert all(f" {estimate['name']} " in rehearsal.out for estimate in rehearsal.result["compared"])
    assert "tfsat-host simulate --file run/maneuver.toml --initial-rate " in rehearsal.out
    assert " deg/s (x, y, z of body 3, emulator)" in " ".join(rehearsal.out.split())
    assert "Joint angles" in rehearsal.out


def test_it_can_be_called_from_python(shared_rehearsal: Rehearsing, tmp_path: Path) -> None:
    rehearsal = Rehearsal.of(four_stroke(59.0, 70.0)).run(tmp_path / "run")
    command = shared_rehearsal("59", "70")
    assert rehearsal.exit_code == 0 and rehearsal.evaluated is not None and rehearsal.judged.good
    assert (rehearsal.folder / "SD.bin").read_bytes() == (command.folder / "SD.bin").read_bytes()
    assert jsonable(record(REHEARSAL, rehearsal))["compared"] == command.result["compared"]


def test_joints_that_do_not_reach_their_angles_are_a_doubt(tfsat_host: RunCli) -> None:
    """Warn of joints that do not reach their angles.

    At 400 deg/s each stroke is over before the servos, 200 deg/s at most, have completed it.
    """
    tfsat_host("upload-sequence", "59", "70", "--speed", "400", "--dry-run", "--out", "fast.toml", expect=3)
    process = tfsat_host("rehearse", "--file", "fast.toml", "--as-filed", "--despite-preflight", expect=3)
    assert "above the greatest rate of the servos, 200 deg/s" in process.stderr
    assert "Warning: Stroke 2 moved its joint by +57." in process.stderr
    for words in ("commanded / deg", "flown / deg", "+57."):
        assert words in process.stdout
    summary = json.loads((tfsat_host.folder / "run" / "summary.json").read_text())
    assert len(summary["warnings"]) >= 2
    assert summary["notices"]


def test_strokes_that_are_not_as_planned_are_named() -> None:
    scheduled, commanded = [0.70, 1.05], [59.0, -59.0]
    # Within 0.5 ms and 2 deg.
    assert disagreements(scheduled, [0.70005, 1.04995], commanded, [58.1, -59.9]) == []
    # 1 ms late, and 2.1 deg short.
    late, short = disagreements(scheduled, [0.7, 1.051], commanded, [59.0, -56.9])
    assert "Stroke 2 began at 1.0510 s instead of 1.0500 s" in late
    assert "Stroke 2 moved its joint by -56.9 deg instead of -59 deg" in short
    assert disagreements(scheduled, [0.7], commanded, commanded) == [
        "The log holds 1 starts of strokes, 2 were scheduled."
    ]
    assert "lacks the joint's angles" in disagreements(scheduled, scheduled, commanded, [59.0, np.nan])[0]


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["59", "70", "--seed", "-1"], 2, "is no seed"),
        (["59", "70", "--seed", "1.5"], 2, "is no seed"),
        (["59", "70", "--seed", str(2**63)], 2, "is no seed"),
        (["59", "70", "--seed", "x"], 2, "is no seed"),
        (["59", "70", "--runs", "0"], 2, "is no number of runs"),
        (["100", "70"], 1, "100"),
        (["59"], 2, ""),
        ([], 2, ""),
        (["--file", "missing.toml"], 1, "missing.toml"),
    ],
)
def test_what_cannot_be_flown(tfsat_host: RunCli, arguments: list[str], code: int, words: str) -> None:
    assert words in tfsat_host("rehearse", *arguments, expect=code).stderr
    assert not (tfsat_host.folder / "run").exists()


def test_reorientation_of_the_papers_maneuver() -> None:
    """Without residual rates the emulated robot turns by the paper's 26.11 deg (sec. opt)."""
    flight = rehearse_drop(schedule_maneuver(four_stroke(58.75, 70.29)), seed=3, rate_rad_s=(0, 0, 0))
    ending = flight.truth[flight.truth[:, 0] <= flight.landed_s - 0.01][-1]
    turned = 2 * np.rad2deg(np.arccos(np.abs(np.dot(ending[4:8], flight.truth[0, 4:8]))))
    assert turned == pytest.approx(26.11, abs=0.02)
    assert flight.sequencer.state == SequencerState.DONE


def test_a_recording_without_a_release_is_not_evaluated(shared_rehearsal: Rehearsing, tmp_path: Path) -> None:
    card = tmp_path / "SD.bin"
    # 60 blocks of 512 bytes: it ends while the robot still hangs.
    card.write_bytes((shared_rehearsal("59", "70").folder / "SD.bin").read_bytes()[: 60 * 512])
    log = load(card)
    assert log.verdict == "truncated"
    with pytest.raises(EvaluationError, match="no release"):
        quick_look(log, load_robot(), until_s=2.0)


def test_a_quick_look_has_the_strokes_sizes_and_signs(shared_rehearsal: Rehearsing) -> None:
    log = load(shared_rehearsal("59", "70").folder / "SD.bin")
    found_deg = reached_deg(log, load_robot(), (1, 2, 1, 2), SCHEDULE_S, 2.4)
    assert found_deg == pytest.approx([59.0, 70.0, -59.0, -70.0], abs=2.0)


def test_the_image_is_found() -> None:
    assert sequencer_hex().read_text().startswith(":")


def test_faults_are_named_with_who_detected_them(shared_rehearsal: Rehearsing) -> None:
    rehearsal = faulty(shared_rehearsal, "servo-dead", "cable-pulled-while-armed")
    words = " ".join(rehearsal.out.split())
    assert "Fault: servo-dead (cables pulled, on the crane's hook): The servo of joint 1" in words
    assert "Expected outcome: flies the maneuver" in words
    assert "Detected by: evaluation: Stroke 1 (joint 1): Joint 1 did not move" in words
    assert "Detected by: not detected (it changes nothing that is to be detected)" in words
    assert (rehearsal.result["seed"], rehearsal.result["imu"]) == (1, "InvenSense MPU-6050")
    assert rehearsal.result["preflight"] == "go"
    assert any("did not move" in reason for reason in rehearsal.result["evaluation"]["reasons"])
    servo, cable = rehearsal.result["faults"]
    assert (servo["name"], servo["moment"], servo["outcome"]) == (
        "servo-dead",
        "lifted",
        "flies the maneuver",
    )
    assert [notice["who"] for notice in servo["noticed_by"]] == ["report"]
    assert cable["noticed_by"] == []
    assert servo["struck_s"] > cable["struck_s"] > 0.0


def test_no_go_names_each_check_with_what_was_found_and_what_to_do(shared_rehearsal: Rehearsing) -> None:
    """Report each no-go check with its finding and its next step.

    A fault that would have struck after the preflight is reported as not struck.
    """
    arguments = ("--fault", "card-full", "--fault", "servo-dead@falling", "--full")
    rehearsal = shared_rehearsal("59", "70", *arguments, expect=4)
    output = " ".join(rehearsal.out.split())
    assert rehearsal.out.startswith("Preflight:      NO-GO: card-room (")
    assert rehearsal.out.endswith("Preflight: NO-GO: card-room, card-writing\n")
    written = json.loads((rehearsal.folder / "preflight.json").read_text())
    red = [check for check in written["checks"] if check["blocks"]]
    assert [check["name"] for check in red] == ["card-room", "card-writing"] == written["reasons"]
    for check in red:
        for words in (check["name"], check["sentence"], f"On the day: {check['next_step']}"):
            assert words in output
    assert "run/preflight.json" in rehearsal.out
    assert "Detected by: preflight: card-room, card-writing" in output
    assert "Actual outcome: not injected: the day ended before" in output
    assert (
        [check["name"] for check in rehearsal.result["no_go_checks"]]
        == rehearsal.result["no_go"]
        == written["reasons"]
    )
    assert [fault["struck_s"] is None for fault in rehearsal.result["faults"]] == [False, True]


def test_without_a_release_it_tells_what_the_switches_did(shared_rehearsal: Rehearsing) -> None:
    rehearsal = faulty(shared_rehearsal, "switch-stuck-closed")
    text = " ".join(rehearsal.out.split())
    assert "5 min on the hook, 2.50 s fall; strokes started: 0" in text
    assert "no joint moved by more than 0.0 deg (truth)" in text
    assert "switch 1 never changed, closed at the end" in text
    assert "switch 2 changed " in text
    assert "tfsat-host decode run/SD.bin" in text
    assert "Sequencer: armed. STILL ARMED" in text and "tfsat-host disarm" in text
    assert text.count("NOT EVALUATED: The recording has no release.") == 2
    (fault,) = rehearsal.result["faults"]
    assert [notice["who"] for notice in fault["noticed_by"]] == ["report refuses"]
    first, second = rehearsal.result["no_release"]["switches"]
    assert (first["edges_s"], first["open_at_the_end"], second["open_at_the_end"]) == ([], False, True)
    assert "tfsat-host" in rehearsal.result["evaluation_refused"]["next_step"]


def test_a_recording_that_breaks_off_before_the_release_is_no_fault_of_the_switches(
    shared_rehearsal: Rehearsing,
) -> None:
    """Do not blame the switches if the recording breaks off before the release.

    The joints' motion is in the truth; the sequencer has lost its power since, and knows no run.
    """
    rehearsal = faulty(shared_rehearsal, "power-cut-after-landing", "card-gone-on-the-hook")
    text = " ".join(rehearsal.out.split())
    assert "strokes started: unknown to both boards" in text
    assert "largest motion joint 1 59." in text
    assert "End of recording: breaks off 26." in text
    assert "both switches open" not in text and "Release switches" not in text
    assert "The logger recorded no longer: it had lost its power or its card" in text
    assert rehearsal.result["no_release"]["strokes_started"] is None
    assert 26.0 < rehearsal.result["no_release"]["recording_ended_before_release_s"] < 27.0
    cut, gone = rehearsal.result["faults"]
    assert cut["came_of_it"] is gone["came_of_it"] is True
    assert "Expected outcome: flies the maneuver Actual outcome: as expected" in text
    assert "not detected by its name (power-cut-after-landing may hide it" in text


def test_a_robot_that_another_fault_keeps_from_flying_is_called_so(shared_rehearsal: Rehearsing) -> None:
    rehearsal = faulty(shared_rehearsal, "servo-slow", "brown-out-at-release")
    text = " ".join(rehearsal.out.split())
    assert "flies the maneuver Actual outcome: moves no joint, as expected of another fault" in text
    assert "moves no joint Actual outcome: as expected" in text


def test_a_recording_out_of_ram_is_not_called_the_cards(shared_rehearsal: Rehearsing) -> None:
    text = " ".join(faulty(shared_rehearsal, "card-pulled", expect=0).out.split())
    assert "The logger recorded no longer" not in text  # its own words are what happened to its card
    assert "lost (RAM of the logger)" in text and "(card)" not in text


def test_another_maneuver_than_the_files_is_named(shared_rehearsal: Rehearsing, tfsat_host: RunCli) -> None:
    rehearsal = shared_rehearsal("59", "70", "--fault", "wrong-maneuver", "--despite-preflight", expect=3)
    (reason,) = rehearsal.result["evaluation"]["reasons"]
    assert "is not the maneuver that the sequencer held in this drop" in reason
    (note,) = rehearsal.folder.glob("maneuver-*.toml")
    # Without the sequencer's note: the recording alone must tell.
    note.rename(tfsat_host.folder / "aside.toml")
    reason = tfsat_host.json("evaluate", rehearsal.folder, expect=3)["verdict"]["reasons"][0]
    (tfsat_host.folder / "aside.toml").rename(note)
    assert reason.startswith(
        "Another maneuver was flown than the file says. The file: 0.700 s joint 1 by +59.00 deg;"
    )
    assert "0.810 s joint 2 by +89." in reason
    tfsat_host("upload-sequence", "18", "90", "--dry-run", "--out", "flown.toml")
    shutil.copytree(rehearsal.folder, tfsat_host.folder / "run")
    right = tfsat_host.json("evaluate", "run", "--maneuver", "flown.toml")
    assert right["verdict"]["level"] == "good"


@pytest.mark.parametrize("differs", ["times", "joints"])
def test_a_file_that_differs_in_times_or_joints_alone_is_another_maneuver(run: Path, differs: str) -> None:
    """54/72 strokes 30 ms apart from 59/70; and the same strokes, but of another joint."""
    file = run.parent / "other.toml"
    maneuver_text = (run / "maneuver.toml").read_text()
    assert "joint = 2" in maneuver_text
    if differs == "joints":
        file.write_text(maneuver_text.replace("joint = 2", "joint = 3"))
    else:
        result("upload-sequence", "54", "72", "--dry-run", "--out", file)
    evaluated = result("evaluate", "run", "--maneuver", file, expect=3)
    (check,) = [entry for entry in evaluated["checks"] if entry["name"] == "maneuver as filed"]
    assert check["verdict"] == "failed" and check["value"] >= 2
    assert "1.050 s joint 2 by +6" in check["sentence"]
