"""`campaign`: drops get numbers, nothing is overwritten or lost, and a damaged index is rebuilt from the folders."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.bundle.commands import command, result
from tests.evaluation.commanded import evaluate
from tests.evaluation.run_folder import CERTIFICATE, change_headers, run_folder
from tfsat_host.calibration.certificate.file import format_calibration, read_calibration
from tfsat_host.protocol.enums import BlockKind
from tfsat_host.protocol.log_layout import DATA_BLOCK_DTYPE

RECORDINGS = CERTIFICATE.replace(".toml", "-recordings")


def contents(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and not path.name.startswith(".")
    }


def index_of(camp: Path) -> list[Any]:
    drops = json.loads((camp / "campaign.json").read_text())["drops"]
    assert isinstance(drops, list)
    return drops


def test_drops_get_the_next_number_and_are_copied_whole(camp: Path) -> None:
    before = contents(Path("run1"))
    assert command("campaign", "next", "camp").out == "1\n"
    said = result("campaign", "add", "camp", "run1", "--note", "wind: west, ±3 m/s")
    assert (said["number"], said["path"], said["moved"]) == (1, "camp/drop-0001", False)
    assert contents(Path("run1")) == before
    drop = contents(camp / "drop-0001")
    taught = {name for name in drop if name.startswith(f"{RECORDINGS}/")}
    assert drop.keys() - before.keys() == {"drop.json", "record.json", *taught}
    assert {name for name in before if drop[name] != before[name]} == {CERTIFICATE}
    assert b"[[landing]]" in drop[CERTIFICATE], "it learns of the drop's landing, once"
    assert result("campaign", "next", "camp") == {"number": 2, "folder": "drop-0002", "findings": []}
    assert said["released"] == "2026-01-05T09:00:07.000Z" and len(said["session"]) == 8
    (entry,) = index_of(camp)
    assert entry == json.loads(drop["drop.json"])
    assert [note["text"] for note in entry["notes"]] == ["wind: west, ±3 m/s"]
    assert sorted(path.name for path in camp.iterdir()) == ["campaign.json", "drop-0001"]


def test_a_folder_can_be_moved(camp: Path) -> None:
    before = contents(Path("run2"))
    result("campaign", "add", "camp", "run2", "--move")
    assert not Path("run2").exists()
    drop = contents(camp / "drop-0001")
    assert all(drop[name] == data for name, data in before.items() if name != CERTIFICATE)
    assert command("campaign", "add", "camp", "run1/SD.bin", "--move", expect=1).err
    assert Path("run1/SD.bin").is_file()


def test_a_recording_brings_what_lies_beside_it_and_the_certificate_from_here(camp: Path) -> None:
    shutil.move(f"run1/{CERTIFICATE}", CERTIFICATE)
    Path("run1/SD.bin").rename("run1/DROP0003.BIN")
    Path("run1/other.mp4").write_bytes(b"video")
    result("campaign", "add", "camp", "run1/DROP0003.BIN")
    names = contents(camp / "drop-0001").keys()
    assert {name for name in names if not name.startswith(f"{RECORDINGS}/")} == {
        "DROP0003.BIN",
        "maneuver.toml",
        CERTIFICATE,
        "drop.json",
        "record.json",
    }
    (drop,) = result("campaign", "list", "camp")["drops"]
    assert drop["recording"] == "DROP0003.BIN" and drop["changes"] == []


def test_the_same_recording_comes_in_once(camp: Path) -> None:
    command("campaign", "add", "camp", "run1")
    before = contents(camp)
    said = command("campaign", "add", "camp", "run1", "--move", expect=1)
    assert "is drop 1 of camp already" in said.err
    assert contents(camp) == before and Path("run1").is_dir()
    assert not list(camp.glob(".adding-*"))


def test_a_recording_that_cannot_be_decoded_is_kept(camp: Path) -> None:
    blocks = np.frombuffer(Path("run1/SD.bin").read_bytes(), DATA_BLOCK_DTYPE)
    Path("run1/SD.bin").write_bytes(blocks[blocks["kind"] == BlockKind.DATA].tobytes())
    said = command("campaign", "add", "camp", "run1", expect=3)
    assert "cannot be decoded" in said.err and "lost its header" in said.err
    assert index_of(camp)[0]["session"] is None
    command("campaign", "add", "camp", "run2")
    report = result("campaign", "report", "camp", expect=3)
    assert [drop["evaluation"] is None for drop in report["drops"]] == [True, False]
    assert "drop-0001 could not be evaluated" in (camp / "report.html").read_text()


def test_notes_are_added_and_none_is_lost(camp: Path) -> None:
    command("campaign", "add", "camp", "run1", "--note", "one")
    command("campaign", "note", "camp", "1", "two")
    command("campaign", "note", "camp", "drop-0001", "-3 deg outside")
    (drop,) = result("campaign", "list", "camp")["drops"]
    assert [note["text"] for note in drop["notes"]] == ["one", "two", "-3 deg outside"]
    assert json.loads((camp / "drop-0001" / "drop.json").read_text())["notes"] == drop["notes"]
    assert "one; two; -3 deg outside" in command("campaign", "list", "camp").words
    assert "has no drop 2; there are: 1" in command("campaign", "note", "camp", "2", "x", expect=1).err
    for wrong in ("", "two\nlines", "\x1b[31m"):
        command("campaign", "note", "camp", "1", wrong, expect=1)
    for wrong in ("0", "-1", "x", "1.5"):
        command("campaign", "note", "camp", wrong, "text", expect=2)
    assert len(index_of(camp)[0]["notes"]) == 3


def test_a_changed_or_missing_file_is_told(camp: Path) -> None:
    command("campaign", "add", "camp", "run1")
    command("campaign", "add", "camp", "run2")
    recording = camp / "drop-0001" / "SD.bin"
    recording.write_bytes(recording.read_bytes()[:-512])
    (camp / "drop-0002" / "maneuver.toml").unlink()
    first, second = result("campaign", "list", "camp", expect=3)["drops"]
    assert len(first["changes"]) == 1 and "was changed" in first["changes"][0]
    assert len(second["changes"]) == 1 and "maneuver.toml is missing" in second["changes"][0]
    recording.unlink()
    assert "SD.bin is missing" in command("campaign", "list", "camp", expect=3).words


def test_a_number_is_never_given_again(camp: Path) -> None:
    command("campaign", "add", "camp", "run1")
    command("campaign", "add", "camp", "run2")
    shutil.rmtree(camp / "drop-0002")
    said = command("campaign", "list", "camp", expect=3)
    assert "drop-0002 is in the index and not there any more" in said.err
    said = command("campaign", "next", "camp", expect=3)
    assert said.out == "3\n" and "not there any more" in said.err
    assert result("campaign", "add", "camp", "run3")["number"] == 3
    command("campaign", "note", "camp", "2", "it burned")
    assert [drop["number"] for drop in index_of(camp)] == [1, 2, 3]


@pytest.mark.parametrize(
    "damage", [b"", b"{", b"[]", b'{"made_by": "x", "format": 1, "drops": []}', b"\xff\xfe", None]
)
def test_a_damaged_index_is_rebuilt_from_the_folders(camp: Path, damage: bytes | None) -> None:
    command("campaign", "add", "camp", "run1", "--note", "one")
    command("campaign", "add", "camp", "run2")
    whole = index_of(camp)
    if damage is None:
        (camp / "campaign.json").unlink()
    else:
        (camp / "campaign.json").write_bytes(damage)
    said = result("campaign", "list", "camp", expect=3)
    assert [{**drop, "changes": None} for drop in said["drops"]] == [
        {**drop, "changes": None} for drop in whole
    ]
    assert "rebuilt from the drops' folders" in said["findings"][0]
    assert result("campaign", "add", "camp", "run3")["number"] == 3
    assert index_of(camp)[:2] == whole and len(index_of(camp)) == 3
    kept = list(camp.glob("campaign.damaged-*.json"))
    assert [path.read_bytes() for path in kept] == ([] if damage is None else [damage])
    assert result("campaign", "list", "camp")["findings"] == []


def test_a_drop_whose_entry_was_not_written_any_more_is_found(camp: Path) -> None:
    """Power went between the two: the folder is in its place, the index does not know."""
    command("campaign", "add", "camp", "run1")
    before = (camp / "campaign.json").read_bytes()
    command("campaign", "add", "camp", "run2", "--note", "two")
    (camp / "campaign.json").write_bytes(before)
    said = result("campaign", "list", "camp", expect=3)
    assert [drop["number"] for drop in said["drops"]] == [1, 2]
    assert "drop-0002 was not in the index" in said["findings"][0]
    assert "is drop 2 of camp already" in command("campaign", "add", "camp", "run2", expect=1).err


def test_a_folder_that_says_nothing_of_itself_is_named_and_keeps_its_number(camp: Path) -> None:
    command("campaign", "add", "camp", "run1")
    (camp / "drop-0005").mkdir()
    shutil.copytree(camp / "drop-0001", camp / "drop-0006")
    said = result("campaign", "list", "camp", expect=3)
    assert len(said["drops"]) == 1 and said["next"] == 7
    assert "its own drop.json cannot be read" in said["findings"][0]
    assert "renamed or copied by hand" in said["findings"][1]


def test_what_is_no_campaign_is_refused(camp: Path) -> None:
    Path("empty").mkdir()
    for words in (("list",), ("next",), ("report",)):
        assert "tfsat-host campaign init empty" in command("campaign", *words, "empty", expect=1).err
    assert "tfsat-host campaign init absent" in command("campaign", "add", "absent", "run1", expect=1).err
    assert "is a campaign already" in command("campaign", "init", "camp", expect=1).err
    assert "has no drops" in command("campaign", "report", "camp", expect=1).err
    assert command("campaign", "list", "camp").out == "No drops yet.\n"
    assert "lies in the other" in command("campaign", "add", "camp", ".", expect=1).err
    assert "no file or folder gone" in command("campaign", "add", "camp", "gone", expect=1).err


def test_two_terminals_at_once_lose_no_drop(camp: Path) -> None:
    programs = [
        subprocess.Popen(
            [
                sys.executable,
                "-m",
                "tfsat_host",
                "campaign",
                "add",
                "camp",
                f"run{seed}",
                "--note",
                str(seed),
            ],
            env=os.environ,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
        )
        for seed in (1, 2, 3)
    ]
    for program in programs:
        _, said = program.communicate()
        assert program.returncode == 0, said
    drops = result("campaign", "list", "camp")["drops"]
    assert [drop["number"] for drop in drops] == [1, 2, 3]
    assert {drop["origin"]: drop["notes"][0]["text"] for drop in drops} == {
        f"run{seed}": str(seed) for seed in (1, 2, 3)
    }


def test_the_report_lays_all_drops_over_each_other(camp: Path) -> None:
    command("campaign", "add", "camp", "run1")
    command("campaign", "add", "camp", "run2", "--note", "the second")
    said = result("campaign", "report", "camp")
    assert said["report"] == "camp/report.html"
    assert [drop["number"] for drop in said["drops"]] == [1, 2]
    turned_deg = [drop["evaluation"]["reorientation_deg"] for drop in said["drops"]]
    assert turned_deg == pytest.approx([25.7, 25.7], abs=0.3)
    (compared,) = said["comparisons"]
    assert (compared["robot"], compared["drops"]) == ("emulated", [1, 2]), "no robot fell"
    assert (
        len(compared["comparison"]["cross_validation"]) == 2 and compared["comparison"]["agreement"]["agree"]
    )
    page = (camp / "report.html").read_text()
    assert '"name":"drop-0001 (emulated)"' in page and '"name":"drop-0002 (emulated)"' in page
    words = command("campaign", "report", "camp").words
    assert (
        "the second" in words
        and "Correction of the model, by all drops together" in words
        and "camp/report.html" in words
    )
    assert result("campaign", "list", "camp")["findings"] == []
    assert all(drop["changes"] == [] for drop in result("campaign", "list", "camp")["drops"])
    (camp / "report.html").write_text("somebody's own")
    assert "was not made by this command" in command("campaign", "report", "camp", expect=1).err


def test_real_and_emulated_drops_are_never_taken_together(camp: Path) -> None:
    run_folder(Path("run4"), 4)
    for seed in (1, 2):
        fell(Path(f"run{seed}"))
    for number, seed in enumerate((1, 3, 2, 4), 1):
        said = command("campaign", "add", "camp", f"run{seed}")
        assert ("EMULATED: no robot fell" in said.words) == (seed > 2), number
    listed = result("campaign", "list", "camp")["drops"]
    assert [drop["robot"] for drop in listed] == ["real", "emulated", "real", "emulated"]
    told = result("campaign", "report", "camp")
    assert [one["robot"] for one in told["comparisons"]] == ["real", "emulated"]
    for one, numbers in zip(told["comparisons"], ((1, 3), (2, 4)), strict=True):
        assert one["drops"] == list(numbers)
        drops = [left["drop"] for left in one["comparison"]["cross_validation"]]
        assert [f"drop-000{number}" in drop for number, drop in zip(numbers, drops, strict=True)] == [
            True,
            True,
        ]
    page = (camp / "report.html").read_text()
    assert '"name":"drop-0001"' in page and '"name":"drop-0002 (emulated)"' in page
    for title in (
        "Correction of the model, by all drops together",
        "Each drop by the corrections of the others",
    ):
        assert f"{title} (real robot)" in page and f"{title} (emulated robot)" in page
    said = command("campaign", "report", "camp")
    assert "The drops of the real robot together:" in said.words
    assert "The drops of the emulated robot together:" in said.words
    mixed = evaluate("run1", "run3")
    assert mixed.code == 2 and "These drops are not of one robot." in mixed.err
    assert re.search(r"all drops +drop 1 +drop 3 ", said.out) and re.search(
        r"all drops +drop 2 +drop 4 ", said.out
    )


def fell(run: Path) -> None:
    """The same as if a robot had recorded it."""
    change_headers(run / "SD.bin", image_crc=0xC0FFEE)
    certificate = run / CERTIFICATE
    emulated = read_calibration(certificate)
    real = replace(emulated, subject=replace(emulated.subject, emulated=False), drawn=())
    (run / "calibration.toml").write_text(format_calibration(real), encoding="utf-8")
    certificate.unlink()
