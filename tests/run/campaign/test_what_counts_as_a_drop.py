"""`campaign add`: what counts as a drop, and counts once; `void`: what does not count any more."""

from __future__ import annotations

import json
import os
from datetime import UTC, datetime
from pathlib import Path
from shutil import copyfile

import pytest

from tests.evaluation.run_folder import CERTIFICATE
from tests.run.bundle.commands import command, result
from tests.run.campaign.test_campaign import contents, index_of
from tfsat_host.run.signed_record import sign, verify


def words(text: str) -> str:
    return " ".join(text.split())


def test_another_copy_of_the_same_recording_is_the_same_drop(camp: Path) -> None:
    recording_bytes = Path("run1/SD.bin").read_bytes()
    # Three quarters, in whole blocks: a copy that was pulled off the card too early.
    Path("run1/SD.bin").write_bytes(recording_bytes[: len(recording_bytes) * 3 // 4 // 512 * 512])
    command("campaign", "add", "camp", "run1", expect=3)
    before = contents(camp)
    err = ""
    # Half of it has less than the campaign's copy, the whole has more: only that is worth the exchange.
    for name, length in (("cut", len(recording_bytes) // 2), ("whole", len(recording_bytes))):
        Path(f"{name}.bin").write_bytes(recording_bytes[: length // 512 * 512])
        err = words(command("campaign", "add", "camp", f"{name}.bin", expect=1).err)
        assert f"recording {index_of(camp)[0]['session']} is drop 1 of camp already (drop-0001)" in err
        assert ("has more samples" in err) == (name == "whole")
    assert 'tfsat-host campaign void camp 1 "' in err and contents(camp) == before
    # The way to replace it: void the shorter copy, then add the fuller one.
    command("campaign", "void", "camp", "1", "a fuller copy came off the card")
    assert result("campaign", "add", "camp", "whole.bin")["number"] == 2


@pytest.mark.parametrize("data", [b"", bytes(4096), b"no recording" * 100, b"TOML = 1\n"])
def test_what_holds_no_block_is_no_drop(camp: Path, data: bytes) -> None:
    Path("run1/SD.bin").write_bytes(data)
    before = contents(camp)
    # Given as a folder, as a recording, and as another file: none may use up a number.
    for place in ("run1", "run1/SD.bin", "run1/maneuver.toml"):
        err = words(command("campaign", "add", "camp", place, expect=1).err)
        assert "Nothing was added." in err and "Nothing was decoded" not in err
    assert contents(camp) == before and not list(camp.glob(".adding-*"))
    assert command("campaign", "next", "camp").out == "1\n"


def test_a_damaged_recording_is_a_drop_and_doubtful(camp: Path) -> None:
    data = bytearray(Path("run1/SD.bin").read_bytes())
    # One block of zeros: a drop all the same, as it cannot be flown again.
    middle = len(data) // 1024 * 512
    data[middle : middle + 512] = bytes(512)
    Path("run1/SD.bin").write_bytes(data)
    output = command("campaign", "add", "camp", "run1", expect=3)
    assert "damaged" in output.err and len(index_of(camp)) == 1


def test_a_void_drop_keeps_its_number_and_does_not_count(camp: Path) -> None:
    command("campaign", "add", "camp", "run1")
    command("campaign", "add", "camp", "run2")
    summary = result("campaign", "void", "camp", "1", "the hook was caught")
    assert summary["void"]["text"] == "the hook was caught"
    assert json.loads((camp / "drop-0001" / "drop.json").read_text()) == index_of(camp)[0]
    listed = command("campaign", "list", "camp").words
    assert "VOID: the hook was caught" in listed
    assert command("campaign", "next", "camp").out == "3\n"
    assert (
        "drop-0001 is void and not counted: the hook was caught"
        in command("campaign", "report", "camp").words
    )
    page = (camp / "report.html").read_text()
    assert '"name":"drop-0002 (emulated)"' in page and "drop-0001" not in page
    assert "is void already" in command("campaign", "void", "camp", "1", "again", expect=1).err
    assert "has no drop 9" in command("campaign", "void", "camp", "9", "why", expect=1).err
    assert 'void camp 2 "' in words(command("campaign", "void", "camp", "2", " ", expect=1).err)
    command("campaign", "void", "camp", "2", "no wind was noted")
    assert "has no drops" in command("campaign", "report", "camp", expect=1).err
    # Both copies of the entry carry the void: a rebuilt index must not count the drops again.
    (camp / "campaign.json").unlink()
    assert [bool(drop["void"]) for drop in result("campaign", "list", "camp", expect=3)["drops"]] == [
        True,
        True,
    ]


def test_the_advice_for_a_note_is_what_the_command_takes(camp: Path) -> None:
    command("campaign", "add", "camp", "run1")
    err = command("campaign", "note", "camp", "1", "", expect=1).err
    assert 'tfsat-host campaign note camp 1 "' in words(err) and "--note" not in err
    assert '--note "' in command("campaign", "add", "camp", "run2", "--note", "", expect=1).err


def test_refusals_speak_of_adding(camp: Path) -> None:
    Path("empty").mkdir()
    for place in ("gone", "empty"):
        err = words(command("campaign", "add", "camp", place, expect=1).err)
        assert "Nothing was added." in err and "evaluate" not in err
    assert "tfsat-host campaign add camp SD.bin" in words(
        command("campaign", "add", "camp", "gone", expect=1).err
    )
    # Two recordings in one folder: which one is the drop is for a person to say.
    copyfile("run1/SD.bin", "empty/A.BIN")
    copyfile("run2/SD.bin", "empty/B.BIN")
    assert "tfsat-host campaign add camp empty/A.BIN" in words(
        command("campaign", "add", "camp", "empty", expect=1).err
    )


def test_certificate_recordings_and_preflight_are_signed(camp: Path) -> None:
    recordings = Path("run1") / CERTIFICATE.replace(".toml", "-recordings")
    recordings.mkdir()
    (recordings / "rest.npz").write_bytes(b"raw")
    Path("run1/preflight.json").write_text('{"go": true}\n')
    command("campaign", "add", "camp", "run1")
    command("evaluate", "camp/drop-0001")
    command("campaign", "report", "camp")
    assert result("campaign", "list", "camp")["drops"][0]["changes"] == [], "evaluating changes nothing"
    for name in (CERTIFICATE, f"{recordings.name}/rest.npz", "preflight.json"):
        path = camp / "drop-0001" / name
        data = path.read_bytes()
        # A line feed more, in each file that the drop's numbers rest on.
        path.write_bytes(data + b"\n")
        (change,) = result("campaign", "list", "camp", expect=3)["drops"][0]["changes"]
        assert f"{name} was changed" in change
        path.write_bytes(data)


def test_what_was_changed_before_is_not_signed_as_if_it_were_not(camp: Path) -> None:
    run = Path("run1")
    (run / "preflight.json").write_text('{"go": false}\n')
    sign(run, [run / "preflight.json"], "tfsat-host preflight: NO-GO", datetime(2026, 1, 5, tzinfo=UTC))
    # A NO-GO turned into a GO: adding the run must not sign the forgery.
    (run / "preflight.json").write_text('{"go": true}\n')
    output = command("campaign", "add", "camp", "run1", expect=3)
    assert "preflight.json was changed since it was signed" in words(output.err)
    assert [record_finding.name for record_finding in verify(camp / "drop-0001")] == ["preflight.json"]
    assert "preflight.json was changed" in command("campaign", "list", "camp", expect=3).words


def test_links_and_pipes_stay_outside(camp: Path, tmp_path: Path) -> None:
    run = Path("run1")
    (tmp_path / "secret.txt").write_text("of somebody else")
    (run / "outside.txt").symlink_to(tmp_path / "secret.txt")
    (run / "loop").symlink_to(".")
    (run / "photos").mkdir()
    (run / "photos" / "hook.jpg").write_bytes(b"jpg")
    (run / "photos" / "again.jpg").symlink_to("hook.jpg")
    os.mkfifo(run / "photos" / "pipe")
    output = command("campaign", "add", "camp", "run1", "--move", "--json")
    names = contents(camp / "drop-0001").keys()
    assert {"photos/hook.jpg", "photos/again.jpg"} <= names
    assert not [name for name in names if "outside" in name or "loop" in name or "pipe" in name]
    assert output.json["left_out"] == {
        "loop": "is a link to a folder",
        "outside.txt": f"is a link that leads out of the folder, to {tmp_path / 'secret.txt'}",
        "photos/pipe": "is a pipe",
    }
    # Not all of it came along: removing the run would lose what was left out.
    assert run.is_dir() and output.json["moved"] is False
    assert "photos/pipe is a pipe" in words(output.err) and "run1 was not removed" in words(output.err)
    Path("run2/SD.bin").unlink()
    Path("run2/SD.bin").symlink_to("../run3/SD.bin")
    assert "leads out of the folder" in words(command("campaign", "add", "camp", "run2", expect=1).err)
