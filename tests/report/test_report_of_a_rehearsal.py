"""A rehearsal in the same folder leaves nothing behind that was made of the recording before."""

from __future__ import annotations

from pathlib import Path

from tests.cli.process import RunCli


def test_results_of_the_recording_that_is_replaced_are_removed(tfsat_host: RunCli) -> None:
    run = tfsat_host.folder / "run"
    tfsat_host.json("rehearse", "59", "70", "--out", "run")
    tfsat_host.json("report", "run", "--mcap", "--figures", "run/figures")
    tfsat_host.json("evaluate", "run", "--out", "run/evaluation.json")
    (run / "notes.txt").write_text("mine", encoding="utf-8")
    again = tfsat_host("rehearse", "59", "70", "--seed", "2", "--out", "run")
    assert again.returncode == 0, again.stderr
    left = {path.name for path in run.iterdir()}
    assert not left & {"evaluation.json", "SD.evaluated.mcap"}, "the page is the new recording's own"
    assert "figures" not in left, "a folder that this leaves empty goes, too"
    assert {"notes.txt", "SD.bin", "summary.json"} <= left
    assert "evaluation.json: it was made of the recording that this one replaces" in again.stderr


def test_a_first_rehearsal_removes_nothing(tfsat_host: RunCli) -> None:
    first = tfsat_host("rehearse", "59", "70", "--out", "run")
    assert first.returncode == 0 and "Removed" not in first.stderr
    assert (Path(tfsat_host.folder) / "run" / "SD.bin").exists()
