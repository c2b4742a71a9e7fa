"""`campaign`: drops get numbers, nothing is overwritten or lost, and a damaged index is rebuilt from the folders."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.evaluation.run_folder import CERTIFICATE
from tests.run.bundle.commands import command, result
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
    summary = result("campaign", "add", "camp", "run1", "--note", "wind: west, ±3 m/s")
    assert (summary["number"], summary["path"], summary["moved"]) == (1, "camp/drop-0001", False)
    assert contents(Path("run1")) == before
    drop = contents(camp / "drop-0001")
    certificates = {name for name in drop if name.startswith(f"{RECORDINGS}/")}
    assert drop.keys() - before.keys() == {"drop.json", "record.json", *certificates}
    # The certificate alone changes: whatever else differed would be evidence lost in the copy.
    assert {name for name in before if drop[name] != before[name]} == {CERTIFICATE}
    assert b"[[landing]]" in drop[CERTIFICATE], "it learns of the drop's landing, once"
    assert result("campaign", "next", "camp") == {"number": 2, "folder": "drop-0002", "findings": []}
    # The recording begins at 09:00 and is released 7 s later: 6 s of rest and 1 s armed.
    assert summary["released"] == "2026-01-05T09:00:07.000Z" and len(summary["session"]) == 8
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
    # To move a recording alone would tear it from its maneuver and certificate.
    assert command("campaign", "add", "camp", "run1/SD.bin", "--move", expect=1).err
    assert Path("run1/SD.bin").is_file()


def test_a_recording_brings_what_lies_beside_it_and_the_certificate_from_here(camp: Path) -> None:
    shutil.move(f"run1/{CERTIFICATE}", CERTIFICATE)
    Path("run1/SD.bin").rename("run1/DROP0003.BIN")
    # No part of a drop that anything names: a recording by itself does not bring it.
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
    output = command("campaign", "add", "camp", "run1", "--move", expect=1)
    assert "is drop 1 of camp already" in output.err
    # Counted twice, a drop would halve the variance of the combined estimate without a new measurement.
    assert contents(camp) == before and Path("run1").is_dir()
    assert not list(camp.glob(".adding-*"))


def test_a_recording_that_cannot_be_decoded_is_kept(camp: Path) -> None:
    # Only data blocks are left: without a header no sample has a scale.
    blocks = np.frombuffer(Path("run1/SD.bin").read_bytes(), DATA_BLOCK_DTYPE)
    Path("run1/SD.bin").write_bytes(blocks[blocks["kind"] == BlockKind.DATA].tobytes())
    output = command("campaign", "add", "camp", "run1", expect=3)
    assert "cannot be decoded" in output.err and "lost its header" in output.err
    # The number stays taken: the drop was flown, whatever became of its recording.
    assert index_of(camp)[0]["session"] is None
    command("campaign", "add", "camp", "run2")
    report = result("campaign", "report", "camp", expect=3)
    assert [drop["evaluation"] is None for drop in report["drops"]] == [True, False]
    assert "drop-0001 could not be evaluated" in (camp / "report.html").read_text()


def test_notes_are_added_and_none_is_lost(camp: Path) -> None:
    command("campaign", "add", "camp", "run1", "--note", "one")
    command("campaign", "note", "camp", "1", "two")
    # A note may begin with a minus: it must not be read as an option.
    command("campaign", "note", "camp", "drop-0001", "-3 deg outside")
    (drop,) = result("campaign", "list", "camp")["drops"]
    assert [note["text"] for note in drop["notes"]] == ["one", "two", "-3 deg outside"]
    assert json.loads((camp / "drop-0001" / "drop.json").read_text())["notes"] == drop["notes"]
    words = command("campaign", "list", "camp").words
    assert words.startswith("Campaign: camp (1 drop, all files as added)")
    assert "one; two; -3 deg outside" in words
    assert "has no drop 2; there are: 1" in command("campaign", "note", "camp", "2", "x", expect=1).err
    # An escape sequence would reach every terminal that lists the campaign.
    for wrong in ("", "two\nlines", "\x1b[31m"):
        command("campaign", "note", "camp", "1", wrong, expect=1)
    for wrong in ("0", "-1", "x", "1.5"):
        command("campaign", "note", "camp", wrong, "text", expect=2)
    assert len(index_of(camp)[0]["notes"]) == 3


def test_a_changed_or_missing_file_is_told(camp: Path) -> None:
    command("campaign", "add", "camp", "run1")
    command("campaign", "add", "camp", "run2")
    recording = camp / "drop-0001" / "SD.bin"
    # One block less at the end, as an interrupted copy leaves it.
    recording.write_bytes(recording.read_bytes()[:-512])
    (camp / "drop-0002" / "maneuver.toml").unlink()
    first, second = result("campaign", "list", "camp", expect=3)["drops"]
    assert len(first["changes"]) == 1 and "was changed" in first["changes"][0]
    assert len(second["changes"]) == 1 and "maneuver.toml is missing" in second["changes"][0]
    recording.unlink()
    words = command("campaign", "list", "camp", expect=3).words
    assert (
        words.startswith("Campaign: camp (2 drops, 2 CHANGED since added)") and "SD.bin is missing" in words
    )


def test_a_number_is_never_given_again(camp: Path) -> None:
    command("campaign", "add", "camp", "run1")
    command("campaign", "add", "camp", "run2")
    shutil.rmtree(camp / "drop-0002")
    output = command("campaign", "list", "camp", expect=3)
    assert "drop-0002 is gone; the index still has it. Copy it back" in output.err
    assert "tfsat-host campaign void camp 2 REASON" in output.err
    assert output.words.startswith("Campaign: camp (2 drops, 1 GONE, index or folders MODIFIED")
    assert [line.split()[-1] for line in output.out.splitlines() if "SD.bin" in line] == ["yes", "GONE"]
    output = command("campaign", "next", "camp", expect=3)
    assert output.out == "3\n" and "is gone" in output.err
    # Logbook and videos name drops by number: a number given again would mix two drops.
    assert result("campaign", "add", "camp", "run3")["number"] == 3
    command("campaign", "note", "camp", "2", "it burned")
    assert [drop["number"] for drop in index_of(camp)] == [1, 2, 3]


# Empty, cut, another type, another program's, no UTF-8; None: gone.
@pytest.mark.parametrize(
    "damage", [b"", b"{", b"[]", b'{"made_by": "x", "format": 1, "drops": []}', b"\xff\xfe", None]
)
def test_a_damaged_index_is_rebuilt_from_the_folders(camp: Path, damage: bytes | None) -> None:
    command("campaign", "add", "camp", "run1", "--note", "one")
    command("campaign", "add", "camp", "run2")
    entries = index_of(camp)
    if damage is None:
        (camp / "campaign.json").unlink()
    else:
        (camp / "campaign.json").write_bytes(damage)
    summary = result("campaign", "list", "camp", expect=3)
    assert [{**drop, "changes": None, "gone": False} for drop in entries] == [
        {**drop, "changes": None} for drop in summary["drops"]
    ]
    assert "rebuilt from the drops' folders" in summary["findings"][0]
    assert result("campaign", "add", "camp", "run3")["number"] == 3
    assert index_of(camp)[:2] == entries and len(index_of(camp)) == 3
    # The damaged text is kept: a person may still read a note in it.
    backups = list(camp.glob("campaign.damaged-*.json"))
    assert [path.read_bytes() for path in backups] == ([] if damage is None else [damage])
    assert result("campaign", "list", "camp")["findings"] == []


def test_a_drop_whose_entry_was_not_written_any_more_is_found(camp: Path) -> None:
    """Power went between the two: the folder is in its place, the index does not know."""
    command("campaign", "add", "camp", "run1")
    before = (camp / "campaign.json").read_bytes()
    command("campaign", "add", "camp", "run2", "--note", "two")
    # The folder is renamed before the index is written: this is the state between the two.
    (camp / "campaign.json").write_bytes(before)
    summary = result("campaign", "list", "camp", expect=3)
    assert [drop["number"] for drop in summary["drops"]] == [1, 2]
    assert "drop-0002 was not in the index" in summary["findings"][0]
    assert "is drop 2 of camp already" in command("campaign", "add", "camp", "run2", expect=1).err


def test_a_folder_that_says_nothing_of_itself_is_named_and_keeps_its_number(camp: Path) -> None:
    command("campaign", "add", "camp", "run1")
    # Without its own entry, and with another drop's: neither counts, both numbers stay taken.
    (camp / "drop-0005").mkdir()
    shutil.copytree(camp / "drop-0001", camp / "drop-0006")
    summary = result("campaign", "list", "camp", expect=3)
    assert len(summary["drops"]) == 1 and summary["next"] == 7
    assert "its own drop.json cannot be read" in summary["findings"][0]
    assert "renamed or copied by hand" in summary["findings"][1]


def test_what_is_no_campaign_is_refused(camp: Path) -> None:
    Path("empty").mkdir()
    for words in (("list",), ("next",), ("report",)):
        assert "tfsat-host campaign init empty" in command("campaign", *words, "empty", expect=1).err
    assert "tfsat-host campaign init absent" in command("campaign", "add", "absent", "run1", expect=1).err
    assert "is a campaign already" in command("campaign", "init", "camp", expect=1).err
    assert "has no drops" in command("campaign", "report", "camp", expect=1).err
    assert command("campaign", "list", "camp").out == "Campaign: camp (no drops)\n"
    assert "lies in the other" in command("campaign", "add", "camp", ".", expect=1).err
    assert "no file or folder gone" in command("campaign", "add", "camp", "gone", expect=1).err


def test_two_terminals_at_once_lose_no_drop(camp: Path) -> None:
    add = [sys.executable, "-m", "tfsat_host", "campaign", "add", "camp"]
    # Processes, not threads: the lock is a file's.
    programs = [
        subprocess.Popen(
            [*add, f"run{n}", "--note", str(n)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
        )
        for n in (1, 2, 3)
    ]
    for program in programs:
        _, stderr = program.communicate()
        assert program.returncode == 0, stderr
    drops = result("campaign", "list", "camp")["drops"]
    # The order of arrival is open; that each has a number of its own is not.
    assert [drop["number"] for drop in drops] == [1, 2, 3]
    assert {drop["origin"]: drop["notes"][0]["text"] for drop in drops} == {
        f"run{seed}": str(seed) for seed in (1, 2, 3)
    }


def test_every_command_says_that_index_and_drops_are_damaged(camp: Path) -> None:
    command("campaign", "add", "camp", "run1")
    command("campaign", "add", "camp", "run2")
    (camp / "campaign.json").write_text("[1]")
    (camp / "drop-0001" / "drop.json").write_text("[2]")
    (camp / "drop-0002" / "drop.json").unlink()
    # A report has nothing to show here (1); list and next answer with doubt (3).
    for action, code in (("list", 3), ("next", 3), ("report", 1)):
        err = " ".join(command("campaign", action, "camp", expect=code).err.split())
        assert "campaign.json is damaged" in err
        assert "drop-0001 is not in the index" in err and "drop-0002 is not in the index" in err
    assert command("campaign", "next", "camp", expect=3).out == "3\n"


@pytest.mark.parametrize(("damage", "words"), [(None, "is gone"), ("[2]", "cannot be read")])
def test_a_drop_that_lost_its_own_entry_is_named_until_it_has_it_again(
    camp: Path, damage: str | None, words: str
) -> None:
    command("campaign", "add", "camp", "run1")
    own = camp / "drop-0001" / "drop.json"
    own.unlink() if damage is None else own.write_text(damage)
    for action in ("list", "next"):
        assert words in command("campaign", action, "camp", expect=3).err
    assert words in result("campaign", "report", "camp", expect=3)["findings"][0]
    # The advice of the finding: a note writes the drop's own entry again from the index.
    command("campaign", "note", "camp", "1", "found without its entry")
    assert result("campaign", "list", "camp")["findings"] == []


def test_an_entry_that_is_not_the_index_s_is_named(camp: Path) -> None:
    command("campaign", "add", "camp", "run1")
    own = camp / "drop-0001" / "drop.json"
    own.write_text(own.read_text().replace('"emulated"', '"real"'))
    assert "not as the index has this drop" in command("campaign", "list", "camp", expect=3).err


@pytest.mark.parametrize(
    "file_name", ["SD.bin", "DROP0001.BIN", "preflight.json", "record.json", ".tfsat-rehearsal"]
)
def test_a_run_is_no_campaign(camp: Path, file_name: str) -> None:
    del camp
    Path("place").mkdir()
    (Path("place") / file_name).write_bytes(b"")
    output = command("campaign", "init", "place", expect=1)
    assert f"it holds {file_name}" in output.err and not Path("place/campaign.json").exists()


def test_hints_can_be_typed_as_they_are(camp: Path) -> None:
    # Blanks, an umlaut and a command substitution: a pasted hint must not run anything else.
    camp.rename("camp ü $(x)")
    command("campaign", "add", "camp ü $(x)", "run1")
    for words in (
        ("add", "camp ü $(x)", "run1"),
        ("note", "camp ü $(x)", "7", "text"),
        ("init", "camp ü $(x)"),
    ):
        assert "'camp ü $(x)'" in command("campaign", *words, expect=1).err
