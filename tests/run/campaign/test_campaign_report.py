"""`campaign report` lays drops over each other, keeps robots apart, and leaves out what was modified."""

from __future__ import annotations

import re
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from shutil import copyfile, rmtree

import pytest

from tests.evaluation.commanded import evaluate
from tests.evaluation.run_folder import CERTIFICATE, change_headers, on_other_logger, run_folder
from tests.run.bundle.commands import command, result
from tfsat_host.calibration.certificate.file import format_calibration, read_calibration
from tfsat_host.evaluation.com_fit import cross_validation
from tfsat_host.present.output import Output
from tfsat_host.robot import RobotModel, find_robot
from tfsat_host.run import drop_evaluation as one_run
from tfsat_host.run.drop_evaluation import EvaluatedRun
from tfsat_host.run.files import EvaluationOptions
from tfsat_host.run.signed_record import sign

OTHER = bytes.fromhex("00c0ffee00c0ffee")


def add_runs(*runs: str) -> None:
    for run in runs:
        command("campaign", "add", "camp", run)


def test_robots_are_compared_by_themselves(camp: Path) -> None:
    # A robot is told apart by its logger's serial number.
    on_other_logger(Path("run3"), OTHER)
    add_runs("run1", "run3", "run2")
    output = command("campaign", "report", "camp")
    first, other = output.result["comparisons"]
    assert (first["drops"], other["drops"]) == ([1, 3], [2])
    assert first["comparison"]["agreement"]["agree"] is True and other["comparison"] is None
    assert other["logger_serial"] == OTHER.hex() != first["logger_serial"]
    assert "2 robots or robot files: none is combined with those of another" in output.words
    assert f"drop-0002 is the only one of the emulated robot with logger {OTHER.hex()}" in output.words


def test_drops_that_contradict_each_other_end_with_3(camp: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    add_runs("run1", "run2")
    # No probability reaches 1: any disagreement of the two counts as contradiction.
    monkeypatch.setattr(cross_validation, "CHANCE_LEAST", 1.0)
    words = command("campaign", "report", "camp", expect=3).words
    verdict = "DOUBTFUL: 2 drops (2 good), drops contradict each other"
    assert words.startswith(verdict) and verdict in words[-200:]


def test_a_drop_with_an_edited_robot_is_named_and_left_out(camp: Path) -> None:
    for run in ("run1", "run2", "run3"):
        copyfile(find_robot(None), Path(run) / "robot.toml")
    add_runs("run1", "run2", "run3")
    edited = camp / "drop-0002" / "robot.toml"
    # A comment alone: no value differs, but the file is not the one that was signed.
    edited.write_text(edited.read_text() + "# mended\n")
    summary = result("campaign", "report", "camp", expect=3)
    assert [drop["evaluation"] is None for drop in summary["drops"]] == [False, True, False]
    assert "robot.toml was changed" in summary["drops"][1]["error"]["what"]
    assert [comparison["drops"] for comparison in summary["comparisons"]] == [[1, 3]]
    edited.write_text("no TOML")
    assert "drop-0002 cannot be evaluated" in command("campaign", "report", "camp", expect=3).words


def test_another_robot_file_from_the_start_is_compared_by_itself(camp: Path) -> None:
    text = find_robot(None).read_text()
    for run in ("run1", "run2", "run3"):
        (Path(run) / "robot.toml").write_text(text + ("# measured again\n" if run == "run3" else ""))
    add_runs("run1", "run2", "run3")
    output = command("campaign", "report", "camp")
    assert [comparison["drops"] for comparison in output.result["comparisons"]] == [[1, 2], [3]]
    assert "robot file" in output.words


def test_what_is_signed_after_the_drop_came_in_is_named(camp: Path) -> None:
    Path("run1/preflight.json").write_text('{"verdict": "go"}\n')
    add_runs("run1", "run2")
    for number in (1, 2):
        folder = camp / f"drop-000{number}"
        (folder / "preflight.json").write_text('{"verdict": "no-go"}\n')
        # A NO-GO signed weeks later must not pass for the check before the drop.
        sign(
            folder,
            [folder / "preflight.json"],
            "tfsat-host preflight: NO-GO",
            datetime(2026, 2, 1, tzinfo=UTC),
        )
    first, second = result("campaign", "list", "camp", expect=3)["drops"]
    assert any("preflight.json was changed" in change for change in first["changes"])
    assert any("after it was closed: tfsat-host preflight: NO-GO" in change for change in second["changes"])


def test_the_report_lays_all_drops_over_each_other(camp: Path) -> None:
    command("campaign", "add", "camp", "run1")
    command("campaign", "add", "camp", "run2", "--note", "the second")
    output = command("campaign", "report", "camp")
    summary, words = output.result, output.words
    assert summary["report"] == "camp/report.html"
    assert [drop["number"] for drop in summary["drops"]] == [1, 2]
    turned_deg = [drop["evaluation"]["reorientation_deg"] for drop in summary["drops"]]
    # One robot, one maneuver: only noise lies between the two.
    assert turned_deg == pytest.approx([25.7, 25.7], abs=0.3)
    (compared,) = summary["comparisons"]
    assert (compared["robot"], compared["drops"]) == ("emulated", [1, 2]), "no robot fell"
    assert (
        len(compared["comparison"]["cross_validation"]) == 2 and compared["comparison"]["agreement"]["agree"]
    )
    page = (camp / "report.html").read_text()
    assert '"name":"drop-0001 (emulated)"' in page and '"name":"drop-0002 (emulated)"' in page
    assert words.startswith("GOOD: 2 drops (2 good) ") and "GOOD: 2 drops (2 good)" in words[-200:]
    assert (
        "the second" in words
        and "Correction of the model, by all drops together" in words
        and "camp/report.html" in words
    )
    assert result("campaign", "list", "camp")["findings"] == []
    assert all(drop["changes"] == [] for drop in result("campaign", "list", "camp")["drops"])
    # A page without the program's mark may be a person's work.
    (camp / "report.html").write_text("somebody's own")
    assert "was not made by this command" in command("campaign", "report", "camp", expect=1).err


def test_a_drop_that_is_gone_is_missed_on_screen_and_page(camp: Path) -> None:
    """The page is what is sent on: it must not read as a whole campaign."""
    add_runs("run1", "run2")
    rmtree(camp / "drop-0002")
    words = command("campaign", "report", "camp", expect=3).words
    assert words.startswith("DOUBTFUL: 2 drops (1 failed, 1 good)")
    page = (camp / "report.html").read_text(encoding="utf-8")
    assert "drop-0002/SD.bin is gone." in page


def test_each_drops_own_laser_spots_are_read(camp: Path) -> None:
    """A file of that name that lies in a drop's folder counts; a drop without one is evaluated without."""
    add_runs("run1", "run2")
    (camp / "drop-0001" / "spots.csv").write_text("t_s,spot,along_mm\n", encoding="utf-8")
    report = result("campaign", "report", "camp", "--laser", "spots.csv", expect=3)
    first, second = report["drops"]
    assert "no column up_mm" in first["error"]["what"]
    assert "t_s,spot,along_mm,up_mm" in first["error"]["next_step"]
    assert second["evaluation"]["release_velocity"] is None
    err = command("campaign", "report", "camp", "--laser", "spots.csv", expect=3).err
    assert "Without spots.csv, and so without a measured release velocity: drop-0002." in err
    misspelt = command("campaign", "report", "camp", "--laser", "spot.csv", expect=1).err
    assert "No drop in camp has a file spot.csv." in misspelt
    assert result("campaign", "report", "camp", "--force", "--facility", "x.toml", expect=2)["error"]


def test_real_and_emulated_drops_are_never_taken_together(camp: Path) -> None:
    run_folder(Path("run4"), 4)
    for seed in (1, 2):
        relabel_as_real(Path(f"run{seed}"))
    # Real and emulated in turn, so that neither order nor neighbours can sort them by accident.
    for number, seed in enumerate((1, 3, 2, 4), 1):
        output = command("campaign", "add", "camp", f"run{seed}")
        assert (", emulated robot" in output.words) == (seed > 2), number
    listed = result("campaign", "list", "camp")["drops"]
    assert [drop["robot"] for drop in listed] == ["real", "emulated", "real", "emulated"]
    output = command("campaign", "report", "camp")
    assert [comparison["robot"] for comparison in output.result["comparisons"]] == ["real", "emulated"]
    for comparison, numbers in zip(output.result["comparisons"], ((1, 3), (2, 4)), strict=True):
        assert comparison["drops"] == list(numbers)
        drops = [row["drop"] for row in comparison["comparison"]["cross_validation"]]
        assert [f"drop-000{number}" in drop for number, drop in zip(numbers, drops, strict=True)] == [
            True,
            True,
        ]
    page = (camp / "report.html").read_text()
    assert '"name":"drop-0001"' in page and '"name":"drop-0002 (emulated)"' in page
    for title in (
        "Correction of the model, by all drops together",
        "Cross-validation: each drop with the corrections of the others",
    ):
        assert f"{title} (real robot)" in page and f"{title} (emulated robot)" in page
    assert "All drops of the real robot" in output.words
    assert "All drops of the emulated robot" in output.words
    mixed = evaluate("run1", "run3")
    assert mixed.code == 2 and "These drops are not of one robot." in mixed.err
    assert re.search(r"all drops +drop-0001 +drop-0003\s", output.out) and re.search(
        r"all drops +drop-0002 +drop-0004\s", output.out
    )


def relabel_as_real(run: Path) -> None:
    """Change an emulated run as if a real robot had recorded it."""
    # Image CRC 0 marks the native core: any other is a flashed board's.
    change_headers(run / "SD.bin", image_crc=0xC0FFEE)
    certificate = run / CERTIFICATE
    emulated = read_calibration(certificate)
    real = replace(emulated, subject=replace(emulated.subject, emulated=False), simulated_quantities=())
    (run / "calibration.toml").write_text(format_calibration(real), encoding="utf-8")
    certificate.unlink()


def test_a_drop_that_breaks_the_evaluation_does_not_break_the_report(
    camp: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    command("campaign", "add", "camp", "run1")
    command("campaign", "add", "camp", "run2")
    evaluate_run = one_run.evaluate_run

    def fail_at_drop_1(
        place: Path, options: EvaluationOptions, robot: RobotModel, out: Output
    ) -> EvaluatedRun:
        # A defect of the program, not of the data: the other drops must still be reported.
        if "drop-0001" in str(place):
            raise IndexError("index 3 is out of bounds")
        return evaluate_run(place, options, robot, out)

    monkeypatch.setattr(one_run, "evaluate_run", fail_at_drop_1)
    monkeypatch.setenv("XDG_STATE_HOME", str(camp.parent / "state"))
    output = command("campaign", "report", "camp", expect=3)
    assert "drop-0001 cannot be evaluated: IndexError" in output.words
    page = (camp / "report.html").read_text()
    assert "drop-0001 could not be evaluated" in page and '"name":"drop-0002 (emulated)"' in page
    (crash_file,) = (camp.parent / "state" / "tfsat" / "crashes").iterdir()
    assert "index 3 is out of bounds" in crash_file.read_text() and crash_file.name in output.words


def test_a_recording_that_ends_at_the_release_is_left_out_by_name(camp: Path) -> None:
    data = Path("run1/SD.bin").read_bytes()
    # From the middle backwards, block by block, until no sample after the release is left.
    cut = next(
        at for at in range(len(data) // 1024 * 512, 512, -512) if _samples_after_release(data[:at]) == 0
    )
    Path("run1/SD.bin").write_bytes(data[:cut])
    command("campaign", "add", "camp", "run1", expect=3)
    command("campaign", "add", "camp", "run2")
    summary = result("campaign", "report", "camp", expect=3)
    assert [drop["evaluation"] is None for drop in summary["drops"]] == [True, False]
    assert "drop-0001 could not be evaluated" in (camp / "report.html").read_text()


def _samples_after_release(data: bytes) -> int:
    from tfsat_host.sdlog.load import load

    Path("cut.bin").write_bytes(data)
    log = load("cut.bin")
    return 0 if log.release_us is None else int((log.t_us > log.release_us).sum())
