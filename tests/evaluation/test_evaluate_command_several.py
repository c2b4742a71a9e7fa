"""Several drops in one command: each evaluated, compared, and judged by the others; never of different robots."""

from __future__ import annotations

import re
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest

from tests.evaluation.commanded import Said, evaluate, evaluate_to_json
from tests.evaluation.run_folder import cut, made_drop, on_other_logger, run_folder
from tests.run.bundle.commands import command
from tfsat_host.calibration.certificate.certificate import quantities
from tfsat_host.calibration.certificate.file import format_calibration, read_calibration
from tfsat_host.calibration.replacements import Replacement
from tfsat_host.evaluation.com_fit import cross_validation


@pytest.fixture
def drops(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Folders 1 and 2, in the current one."""
    monkeypatch.chdir(tmp_path)
    for seed in (1, 2):
        run_folder(tmp_path / str(seed), seed)
    return tmp_path


def test_two_drops_judge_each_other(drops: Path, good: Said) -> None:
    evaluation = evaluate_to_json("1", "2")
    assert [drop["drop"] for drop in evaluation["drops"]] == ["1", "2"]
    assert evaluation["drops"][0]["reorientation_deg"] == good.json["reorientation_deg"]
    for judged in evaluation["comparison"]["cross_validation"]:
        # Each is judged by the other one: neither model saw the drop that it predicts.
        assert judged["improved"] is True
        assert judged["error_after_deg"] < 0.2 * judged["error_before_deg"]
    together = evaluation["comparison"]["offsets"]
    assert [row["name"] for row in together] == [row["name"] for row in good.json["offsets"]]
    off = np.array([row["value"] for row in together[:9]]) - made_drop().true_com_offsets_mm
    assert (np.abs(off) < 4.5 * np.array([row["std"] for row in good.json["offsets"][:9]])).all()


def test_one_that_is_refused_does_not_keep_the_others(drops: Path) -> None:
    (drops / "empty").mkdir()
    result = evaluate("1", "empty", "2")
    assert result.code == 1
    assert "FAILED: empty holds no recording" in result.words
    assert "All drops" in result.out and "== 1" in result.out and "== 2" in result.out
    assert "The other drops' corrections made the model better in 2 of 2 drops." in result.words
    (row,) = [line for line in result.out.splitlines() if line.strip().startswith("body 1 CoM x")][-1:]
    assert row.count("±") == 3, "of all drops together, and each drop's own"
    # Each drop has the name that was typed, in every table.
    _, _, tables = result.out.partition("All drops")
    assert re.search(r"what +unit +all drops +1 +2\n", tables) and "deviation (σ)" in tables
    assert "drop 1" not in tables and "own off" not in tables


def test_advice_on_one_of_several_names_its_own_recording(drops: Path) -> None:
    # A recording that ends before the release, as of a power cut on the way up: its events are worth a look.
    cut(drops / "2", -0.5)
    result = evaluate("1", "2", full=False)
    first, _, second = result.words.partition("== 2")
    command = f"tfsat-host decode {Path('2/SD.bin')}"
    assert "tfsat-host decode" not in first and command in second
    error = evaluate_to_json("1", "2", expect=1)["drops"][1]["error"]
    assert command in error["next_step"]


def test_one_alone_is_compared_with_nothing(drops: Path) -> None:
    evaluation = evaluate_to_json("1", "nowhere", expect=1)
    first, second = evaluation["drops"]
    assert first["verdict"]["level"] == "good"
    assert second["verdict"]["level"] == "failed" and "nowhere" in second["error"]["what"]
    assert evaluation["comparison"] is None


@pytest.mark.parametrize("named", [("1", "copy"), ("1", "2", "copy"), ("nowhere", "1", "copy/SD.bin")])
def test_a_copy_of_a_drop_is_that_drop_named_twice(drops: Path, named: tuple[str, ...]) -> None:
    run_folder(drops / "copy")
    result = evaluate(*named)
    assert result.code == 2 and result.out == ""
    assert f"{named[-1]} holds the same recording as 1" in result.err
    assert "Nothing was evaluated" in result.err and "Name each drop once" in result.err


def test_the_same_session_in_other_bytes_is_no_other_drop(drops: Path) -> None:
    run_folder(drops / "copy")
    with (drops / "copy" / "SD.bin").open("ab") as file:
        # A block of zeros at the end: other bytes, the same recording.
        file.write(bytes(512))
    evaluation = evaluate_to_json("1", "copy", expect=1)
    assert "copy holds the same recording as 1" in evaluation["drops"][1]["error"]["what"]
    assert evaluation["comparison"] is None


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("1", "1/../1"), "1/../1 was named twice"),
        (("1", "2", "--video", "video.csv"), "--video belongs to one drop, and 2 were named."),
        (("1", "2", "--session", "12345678"), "--session belongs to one drop"),
    ],
)
def test_what_makes_no_sense_for_several(drops: Path, args: tuple[str, ...], words: str) -> None:
    result = evaluate(*args)
    assert result.code == 2 and result.out == ""
    assert words in result.err


OTHER = bytes.fromhex("00c0ffee00c0ffee")


@pytest.mark.parametrize(
    "arguments",
    [("evaluate", "1", "2"), ("report", "1", "2"), ("evaluate", "--robot", "drop_tower", "1", "2")],
)
def test_drops_of_other_loggers_are_refused(drops: Path, arguments: tuple[str, ...]) -> None:
    on_other_logger(drops / "2", OTHER)
    result = command(*arguments, expect=2)
    assert "not of one robot" in result.err and f"2: emulated robot with logger {OTHER.hex()}" in result.err
    assert result.out == "" and not Path("report.html").exists()
    command("evaluate", "2")


def test_drops_before_and_after_a_logger_was_replaced_are_of_one_robot(drops: Path) -> None:
    file = drops / "2" / "calibration-emulated.toml"
    was = read_calibration(file).subject.logger_serial
    on_other_logger(drops / "2", OTHER)
    calibration = read_calibration(file)
    taken = max(entry.measured_at for entry in quantities(calibration) if entry.measured_at)
    told = replace(calibration, replacements=(Replacement(taken - timedelta(hours=1), "logger", was),))
    file.write_text(format_calibration(told), encoding="utf-8")
    together = evaluate_to_json("1", "2")
    assert len(together["comparison"]["cross_validation"]) == 2
    # The certificate of the drop is of the new logger: none of its numbers is refused.
    assert together["drops"][1]["calibration"]["sentences"] == []
    # Where no certificate tells of it the second is another robot's.
    file.write_text(format_calibration(calibration), encoding="utf-8")
    assert "not of one robot" in command("evaluate", "1", "2", expect=2).err


def test_drops_that_contradict_each_other_end_with_3(drops: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Any chance counts as a contradiction.
    monkeypatch.setattr(cross_validation, "CHANCE_LEAST", 1.0)
    comparison = evaluate_to_json("1", "2", expect=3)["comparison"]
    assert comparison["agreement"]["agree"] is False and "contradict each other" in comparison["remarks"][0]
    assert "DOUBTFUL" in comparison["remarks"][0]
    assert "contradict each other" in command("report", "1", "2", expect=3).err
