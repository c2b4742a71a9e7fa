"""`campaign report` keeps robots apart, and leaves out what is not as it came."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from shutil import copyfile

import pytest

from tests.bundle.commands import command, result
from tests.evaluation.run_folder import on_other_logger
from tfsat_host.evaluation.model_fit import cross_validation
from tfsat_host.robot import find_robot
from tfsat_host.run.record import sign

OTHER = bytes.fromhex("00c0ffee00c0ffee")


def added(*runs: str) -> None:
    for run in runs:
        command("campaign", "add", "camp", run)


def test_robots_are_compared_by_themselves(camp: Path) -> None:
    on_other_logger(Path("run3"), OTHER)
    added("run1", "run3", "run2")
    first, other = result("campaign", "report", "camp")["comparisons"]
    assert (first["drops"], other["drops"]) == ([1, 3], [2])
    assert first["comparison"]["agreement"]["agree"] is True and other["comparison"] is None
    assert other["logger_serial"] == OTHER.hex() != first["logger_serial"]
    words = command("campaign", "report", "camp").words
    assert "2 robots or robot files: none is combined with those of another" in words
    assert f"Drop 2 is the only one of the emulated robot with logger {OTHER.hex()}" in words


def test_drops_that_contradict_each_other_end_with_3(camp: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    added("run1", "run2")
    monkeypatch.setattr(cross_validation, "CHANCE_LEAST", 1.0)
    assert "contradict each other" in command("campaign", "report", "camp", expect=3).words


def test_a_drop_with_an_edited_robot_is_named_and_left_out(camp: Path) -> None:
    for run in ("run1", "run2", "run3"):
        copyfile(find_robot(None), Path(run) / "robot.toml")
    added("run1", "run2", "run3")
    edited = camp / "drop-0002" / "robot.toml"
    edited.write_text(edited.read_text() + "# mended\n")
    said = result("campaign", "report", "camp", expect=3)
    assert [drop["evaluation"] is None for drop in said["drops"]] == [False, True, False]
    assert "robot.toml was changed" in said["drops"][1]["error"]["what"]
    assert [one["drops"] for one in said["comparisons"]] == [[1, 3]]
    edited.write_text("no TOML")
    assert "Drop 2 cannot be evaluated" in command("campaign", "report", "camp", expect=3).words


def test_another_robot_file_from_the_start_is_compared_by_itself(camp: Path) -> None:
    text = find_robot(None).read_text()
    for run in ("run1", "run2", "run3"):
        (Path(run) / "robot.toml").write_text(text + ("# measured again\n" if run == "run3" else ""))
    added("run1", "run2", "run3")
    assert [one["drops"] for one in result("campaign", "report", "camp")["comparisons"]] == [[1, 2], [3]]
    assert "robot file" in command("campaign", "report", "camp").words


def test_what_is_signed_after_the_drop_came_in_is_named(camp: Path) -> None:
    Path("run1/preflight.json").write_text('{"verdict": "go"}\n')
    added("run1", "run2")
    for number in (1, 2):
        folder = camp / f"drop-000{number}"
        (folder / "preflight.json").write_text('{"verdict": "no-go"}\n')
        sign(
            folder,
            [folder / "preflight.json"],
            "tfsat-host preflight: NO-GO",
            datetime(2026, 2, 1, tzinfo=UTC),
        )
    first, second = result("campaign", "list", "camp", expect=3)["drops"]
    assert any("preflight.json was changed" in change for change in first["changes"])
    assert any("after it was closed: tfsat-host preflight: NO-GO" in change for change in second["changes"])
