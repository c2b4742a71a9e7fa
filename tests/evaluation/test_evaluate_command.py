"""`tfsat-host evaluate` as a user has it: what it says, prints as JSON and writes, of one drop and of several."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.cli.process import RunCli
from tests.evaluation.commanded import Said, evaluate, evaluate_to_json
from tests.evaluation.run_folder import CERTIFICATE, made_drop, run_folder
from tests.paths import DOCS
from tfsat_host.evaluation.camera import LaserTracks
from tfsat_host.evaluation.laser_spots import AS_FILED, LASERS, BodyRotation, Reading, equations_of
from tfsat_host.evaluation.stages import com_in_bodies_m
from tfsat_host.maneuver import format_maneuver, four_stroke
from tfsat_host.present.terminal import printable
from tfsat_host.robot import load_robot

FALL_END_S = 2.45


def test_a_good_drop_as_a_process(tfsat_host: RunCli) -> None:
    run_folder(tfsat_host.folder / "run")
    process = tfsat_host("evaluate", "run", "--full")
    assert process.stdout.startswith("GOOD: 28 of 28 checks passed")
    words = " ".join(process.stdout.split())
    assert "of body 1, from the release to 2.45 s" in words
    assert "complete" in words and "0 lost" in words and "failed" not in words
    assert f"{Path('run') / CERTIFICATE} (valid)" in words
    for title in ("Strokes", "Joints", "Attitude error", "Correction of the model", "Integrity checks"):
        assert f"\n{title}" in process.stdout
    assert "Reading run/SD.bin …" in process.stderr and "Evaluating run …" in process.stderr
    assert not (tfsat_host.folder / "run" / "evaluation.json").exists(), "nothing is written unless asked"


def test_json_holds_the_truth(good: Said) -> None:
    truth, evaluation = made_drop(), good.json
    assert good.code == 0
    assert evaluation["verdict"]["level"] == "good" and evaluation["verdict"]["reasons"] == []
    assert evaluation["until_s"] == pytest.approx(FALL_END_S, abs=0.01)
    true_deg = math.degrees(truth.true_turn(1, 0.0, evaluation["until_s"]).magnitude())
    # Four standard deviations of the stated ±, and the ± itself is small.
    assert abs(evaluation["reorientation_deg"] - true_deg) < 4 * evaluation["reorientation_deg_std"] < 0.15
    off = np.array(evaluation["com_offset_mm"]).ravel() - truth.true_com_offsets_mm
    assert (np.abs(off) < 4.5 * np.array(evaluation["com_offset_mm_std"]).ravel()).all()
    # Fitted model: a tenth of a degree; nominal model: more than that.
    errors = evaluation["attitude_error_deg"]
    assert errors.keys() == {"before", "after"} and errors["after"] < 0.1 < errors["before"]
    assert [stroke["commanded_deg"] for stroke in evaluation["strokes"]] == pytest.approx([59, 70, -59, -70])
    assert all(stroke["moved"] and abs(stroke["short_deg"]) < 3.0 for stroke in evaluation["strokes"])
    # The norm of the rates with which the drop was released.
    assert np.linalg.norm(evaluation["initial_rate_deg_s"]) == pytest.approx(1.17, abs=0.05)
    # Joint 3 does not move: some checks are not possible, none failed.
    assert {check["verdict"] for check in evaluation["checks"]} <= {"passed", "not possible"}
    assert evaluation["recording"]["verdict"] == "complete"
    assert evaluation["calibration"] == {
        "file": str(Path("run") / CERTIFICATE),
        "usable": True,
        "shortcomings": [],
        "sentences": [],
    }


def test_nothing_in_the_json_is_nan(good: Said) -> None:
    def constant(text: str) -> Any:
        raise AssertionError(text)

    json.loads(good.out, parse_constant=constant)


def test_what_is_written_is_what_is_printed(run: Path) -> None:
    mine = run.parent / "mine.json"
    mine.write_text("{}")
    refused = evaluate("run", "--out", "mine.json")
    # The file is somebody's own, and nothing is printed of an evaluation that is not written.
    assert refused.code == 1 and refused.out == "" and mine.read_text() == "{}"
    assert "mine.json exists and was not made by this command." in refused.err
    printed = evaluate_to_json("run", "--out", "mine.json", "--force")
    assert json.loads(mine.read_text(encoding="utf-8")) == printed
    assert evaluate("run", "--out", "mine.json").code == 0, "its own file is written again"


def test_a_folder_with_one_recording_of_another_name(run: Path, good: Said) -> None:
    (run / "SD.bin").rename(run / "DROP0007.BIN")
    evaluation = evaluate_to_json("run")
    assert evaluation["recording"]["file"] == str(Path("run/DROP0007.BIN"))
    assert evaluation["reorientation_deg"] == good.json["reorientation_deg"]


def test_a_file_instead_of_a_folder(run: Path, good: Said) -> None:
    evaluation = evaluate_to_json("run/SD.bin")
    assert evaluation["reorientation_deg"] == good.json["reorientation_deg"]
    # The maneuver beside the recording is found, whichever of the two is named.
    assert evaluation["maneuver"] == str(Path("run/maneuver.toml"))


def test_without_a_maneuver_it_says_what_is_not_known(run: Path) -> None:
    (run / "maneuver.toml").unlink()
    evaluation = evaluate_to_json("run")
    assert evaluation["strokes"] == [] and evaluation["clocks"] == {"sequencer": None, "video": None}
    assert evaluation["maneuver"] is None
    assert any("No maneuver is known" in note and "--maneuver" in note for note in evaluation["notes"])


def test_a_maneuver_that_was_not_flown(run: Path) -> None:
    # The strokes of the log fit another maneuver than the file's.
    (run.parent / "other.toml").write_text(format_maneuver(four_stroke(30.0, 40.0)))
    result = evaluate("run", "--maneuver", "other.toml")
    assert result.code == 3
    assert result.out.startswith("DOUBTFUL:")
    assert "instead of +30.0 deg" in result.words and "another maneuver was flown" in result.words


def test_what_the_robot_file_calls_uncertain_is_in_the_fit(run: Path, good: Said) -> None:
    kinds = [row["name"].split()[2] for row in good.json["offsets"]]
    assert [kinds.count(kind) for kind in ("CoM", "mass", "inertia", "point")] == [12, 4, 24, 6]
    # Exact masses: their four offsets are no unknowns any more.
    exact = load_robot().path.read_text().replace("mass_relative = 0.02", "mass_relative = 0.0")
    (run.parent / "weighed.toml").write_text(exact)
    weighed = evaluate_to_json("run", "--robot", "weighed.toml")
    assert len(weighed["offsets"]) == len(kinds) - 4
    # Fewer unknowns: the centers of mass are known better.
    assert (np.array(weighed["com_offset_mm_std"]) < np.array(good.json["com_offset_mm_std"])).all()


def test_a_hinge_that_trades_with_a_center_of_mass_is_said(run: Path) -> None:
    words = evaluate("run").words
    assert "centers of mass trade exactly" in words and "body 1 CoM y - joint 1 point y: " in words


def test_the_papers_swarm_beside_the_fit(run: Path, good: Said) -> None:
    """It minimizes the paper's sum and finds less of it than Gauss and Newton do, who minimize something else."""
    assert good.json["swarm"] is None
    words = evaluate("run", "--swarm").words
    assert "swarm ± its spread" in words and "10 swarms of 48 particles" in words
    assert "Swarm objective, sum of |h - h0|" in words
    assert "They did not converge" in words


def test_video_and_lasers(run: Path) -> None:
    write_witnesses(run.parent)
    result = evaluate("run", "--video", "video.csv", "--laser", "laser.csv")
    assert result.code == 0, result.out
    assert re.search(r"video [+-]\d+ ± \d+ ", result.words)
    assert "mm/s, downwards; within the facility's window" in result.words


def write_witnesses(folder: Path, reading: Reading = AS_FILED) -> None:
    """Write a camera's record of the drop as the robot turned and sank at 50 mm/s.

    Positions are read to 0.3 mm, spots as in `reading`.
    """
    (folder / "video.csv").write_text("event,t_s\nrelease,12.4\nlanding,14.9\n")
    drop = made_drop()
    fall = drop.truth[(drop.truth[:, 0] >= 0.0) & (drop.truth[:, 0] <= 2.4)]
    # The second of the four quaternions: lasers sit on body 2.
    attitude = Rotation.from_quat(fall[:, 8:12])
    # The center of mass as it lies in body 2 with the joints as they are.
    com_m = np.array([com_in_bodies_m(drop.flown, angles)[1] for angles in fall[:, 1:4]])
    turning = BodyRotation(fall[:, 0], (attitude[0].inv() * attitude).as_matrix(), np.zeros(3), com_m)
    t_s = np.repeat(np.arange(0.16, 2.39, 0.02), 2)
    spot = np.tile([1, 2], len(t_s) // 2)
    none = np.zeros(len(t_s))
    # Positions for which the evaluation's own equations give 50 mm/s downwards.
    equations = equations_of(LaserTracks(folder, t_s, spot, none, none, none + 5e-4, False), turning, LASERS)
    place_mm = 1e3 * (equations.toward @ [0.0, 0.0, -0.05] * equations.t_s - equations.place_m).reshape(2, -1)
    # Read to 0.3 mm.
    along, up = place_mm + np.random.default_rng(3).normal(0.0, 0.3, place_mm.shape)
    read = reading.of(LaserTracks(folder, t_s, spot, along, up, none, False))
    there = turning.at(t_s)[:, 2, 2] > 0.8  # a ray that meets its wall
    rows = [
        f"{t:.3f},{n},{a:.2f},{u:.2f}"
        for t, n, a, u in zip(t_s[there], read.spot[there], read.along_m[there], up[there], strict=True)
    ]
    (folder / "laser.csv").write_text("\n".join(["t_s,spot,along_mm,up_mm", *rows]))


@pytest.mark.parametrize("reading", [Reading(True, (False, False)), Reading(False, (True, False))])
def test_laser_spots_that_are_not_what_the_file_says_give_no_velocity(run: Path, reading: Reading) -> None:
    write_witnesses(run.parent, reading)
    result = evaluate("run", "--video", "video.csv", "--laser", "laser.csv")
    assert result.code == 3 and "Release velocity" not in result.words
    assert f"the spots move as body 2 turned only if {reading.words()}." in result.words


def test_a_video_of_one_event_needs_its_rate(run: Path) -> None:
    write_witnesses(run.parent)
    laser = run.parent / "laser.csv"
    header, *rows = laser.read_text().splitlines()
    # Slow motion by 4, and its time counts from another zero.
    later = [f"{4 * float(row.split(',')[0]) + 7:.3f},{row.split(',', 1)[1]}" for row in rows]
    laser.write_text("\n".join([header.replace("t_s", "video_t_s"), *later]))
    (run.parent / "video.csv").write_text("event,t_s\nrelease,7.0\n")
    without = evaluate("run", "--video", "video.csv", "--laser", "laser.csv")
    assert without.code == 3 and "Release velocity" not in without.words
    assert "of one event, release, no rate follows" in without.words and "--video-rate" in without.words
    stated = evaluate_to_json("run", "--video", "video.csv", "--laser", "laser.csv", "--video-rate", "4")
    down = stated["release_velocity"]["downward"]
    # The laser was cast with the robot sinking at 50 mm/s.
    assert down["mm_s"] == pytest.approx(50.0, abs=4 * down["mm_s_std"])
    for args in (("--video-rate", "4"), ("--video", "video.csv", "--video-rate", "0")):
        assert evaluate("run", *args).code == 2


@pytest.mark.parametrize("columns", [80, 50, 44])
def test_prose_keeps_to_the_terminal(run: Path, monkeypatch: pytest.MonkeyPatch, columns: int) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    for maneuver in run.glob("maneuver*.toml"):  # so that all until the joints is prose
        maneuver.unlink()
    result = evaluate("run")
    prose = result.out[: result.out.index("\nJoints\n")].splitlines()
    assert len(prose) > 10
    # Not a line is longer than the terminal.
    assert max(map(len, prose)) <= columns


def test_names_that_would_paint_the_terminal(run: Path) -> None:
    evil = "[red]\x1b[2J\nGOOD: rm -rf ~"
    run.rename(run.parent / evil)
    # A folder name may hold escape sequences and line ends: the verdict must not be faked by it.
    result = evaluate(evil)
    assert result.code == 0
    assert "\x1b" not in result.out and "\nGOOD: rm" not in result.out
    assert "[red]\\x1b[2J\\n" in result.words


def test_names_are_shown_as_they_can_be() -> None:
    # A right-to-left override and an escape sequence are shown, not obeyed.
    assert printable("a\x1b[1m\u202eb\nü") == "a\\x1b[1m\\u202eb\\nü"


DOCUMENT = (DOCS / "evaluation.md").read_text(encoding="utf-8")
BY_GROUP = "trades[].growth"
"""Its keys are the names of groups."""


def tables(after: str) -> list[str]:
    """Return the keys in the first column of the table that follows the line `after`."""
    lines = DOCUMENT[DOCUMENT.index(after) :].splitlines()
    start = next(number for number, line in enumerate(lines) if line.startswith("| key |"))
    rows = []
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            break
        rows.append(line.split(" | ")[0])
    return [key for row in rows for key in re.findall(r"`([^`]+)`", row)]


def paths(value: Any, place: str = "") -> Iterator[str]:
    if isinstance(value, dict) and place != BY_GROUP:
        for key, item in value.items():
            yield from paths(item, f"{place}.{key}" if place else key)
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for item in value:
            yield from paths(item, f"{place}[]")
    else:
        yield place


def check(documented: list[str], printed: set[str]) -> None:
    # A star in the document stands for any name.
    patterns = [re.compile(re.escape(key).replace(r"\*", "[a-z_]+")) for key in documented]
    assert len(set(documented)) == len(documented)
    assert [path for path in printed if not any(pattern.fullmatch(path) for pattern in patterns)] == []
    unused = [
        key
        for key, pattern in zip(documented, patterns, strict=True)
        if not any(map(pattern.fullmatch, printed))
    ]
    # A documented key that is never printed misleads as much as a missing one.
    assert unused == []


def test_every_key_is_documented_and_every_documented_key_is_there(run: Path) -> None:
    write_witnesses(run.parent)
    evaluation = evaluate("run", "--video", "video.csv", "--laser", "laser.csv", "--swarm", "--json").json
    check(tables("## The object of `--json`"), set(paths(evaluation)))
    assert evaluation["swarm"]["searches"] == 10
    assert (
        np.shape(evaluation["swarm"]["com_offset_mm"]) == np.shape(evaluation["swarm"]["spread_mm"]) == (3, 3)
    )
    objective = evaluation["swarm"]["objective_kg_m2_s"]
    # Gauss-Newton minimizes something else and finds less of the swarm's own objective: the swarm did not converge.
    assert objective["gauss_newton"] < objective["swarm"]


def test_every_key_of_several_drops(run: Path) -> None:
    run_folder(run.parent / "second", seed=2)
    evaluation = evaluate("run", "second", "--json").json
    assert evaluation.keys() == {"made_by", "drops", "comparison"}
    check(tables("Of several drops:"), set(paths({"comparison": evaluation["comparison"]})))
