"""`tfsat-host decode`."""

from __future__ import annotations

import json
import os
import subprocess
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.process import RunCli
from tests.sdlog.encoder import ALL_VALID, Recorder, drop_with_release, recording
from tests.sdlog.test_values import write
from tfsat_host.protocol.enums import BlockKind
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.protocol.log_layout import CRC_OFFSET, HEADER_BYTES
from tfsat_host.protocol.messages import Sample
from tfsat_host.sdlog import load


def decode(*args: object, expect: int = 0) -> subprocess.CompletedProcess[str]:
    return RunCli(Path.cwd())("decode", *args, expect=expect)


def decode_json(*args: object, expect: int = 0) -> dict[str, Any]:
    facts: dict[str, Any] = json.loads(decode(*args, "--json", expect=expect).stdout)
    return facts


@pytest.fixture
def sd(tmp_path: Path) -> Path:
    return write(tmp_path / "SD.bin", drop_with_release()[0].image())


def test_summary_and_csv_beside_the_file(sd: Path) -> None:
    output = decode(sd).stdout
    for words in (
        "1234abcd",
        "complete",
        "528 in 1.882 s",
        "280.03 Hz",
        "release switch 1 opened",
        "stroke 4",
    ):
        assert words in output
    assert {path.name for path in sd.parent.iterdir()} == {"SD.bin", "SD.csv", "SD.events.csv"}


def test_out_may_name_the_file(sd: Path, tmp_path: Path) -> None:
    decode(sd, "--out", tmp_path / "drop 3.csv")
    decode(sd, "--out", tmp_path / "drop.npz", "--format", "npz")
    assert (tmp_path / "drop 3.csv").is_file() and (tmp_path / "drop 3.events.csv").is_file()
    assert (tmp_path / "drop.npz").is_file()
    refused = decode(sd, "--out", tmp_path / "other.npz", expect=2).stderr
    assert "names a npz file, and csv is to be written" in refused and "--format npz" in refused
    assert not (tmp_path / "other.npz").exists()
    (tmp_path / "old.csv").mkdir()
    decode(sd, "--out", tmp_path / "old.csv")
    assert (tmp_path / "old.csv" / "SD.csv").is_file(), "a folder that is there is a folder"


def test_json_has_the_keys_that_others_rely_on(sd: Path, tmp_path: Path) -> None:
    facts = decode_json(sd, "--format", "csv,npz,mat", "--out", tmp_path / "out")
    assert facts["verdict"] == "complete"
    assert (facts["samples"], facts["samples_lost"], facts["blocks_lost"]) == (528, 0, 0)
    assert facts["duration_s"] == pytest.approx(1.881917)
    assert facts["rate_hz"] == pytest.approx(280.03, abs=0.01)
    assert facts["session"] == "1234abcd"
    strokes = [event["t_s"] for event in facts["events"] if event["name"] == "stroke"]
    # Seconds after the release, rounded to the microsecond.
    assert strokes == [0.70, 1.05, 1.47, 1.82]
    names = {"csv": "SD.csv", "events_csv": "SD.events.csv", "npz": "SD.npz", "mat": "SD.mat"}
    assert facts["files"] == {key: str(tmp_path / "out" / name) for key, name in names.items()}
    assert all(Path(path).stat().st_size for path in facts["files"].values())


def test_lost_data_ends_with_3_and_says_what(tmp_path: Path) -> None:
    blocks = recording(8).blocks
    damaged = write(tmp_path / "damaged.bin", b"".join(blocks[:3] + blocks[4:]))
    process = decode(damaged, expect=3)
    assert "6 of 48 samples are lost (1 block)" in process.stderr
    assert "damaged" in process.stdout
    # Without its end: truncated, not damaged.
    cut = write(tmp_path / "cut.bin", b"".join(blocks[:-1]))
    assert decode_json(cut, expect=3)["verdict"] == "truncated"
    # IMU 1 never answered: its readings stay, marked invalid.
    recorder = Recorder()
    recorder.data(flags=ALL_VALID & ~1)
    recorder.close()
    mute = write(tmp_path / "mute.bin", recorder.image())
    facts = decode_json(mute, expect=3)
    assert facts["verdict"] == "complete"
    assert facts["sensors"][0] == {"sensor": "IMU of body 1", "valid": 0, "invalid": 6, "clipped": 0}


def test_another_session_can_be_chosen(tmp_path: Path) -> None:
    image = recording(4, session=0xA).image() + recording(5, session=0xB).image()
    card = write(tmp_path / "card.img", image)
    assert decode_json(card)["session"] == "0000000a"
    # Both recordings are named, so that a user can choose.
    assert decode_json(card)["other_sessions"] == ["0000000b"]
    assert decode_json(card, "--session", "0000000B")["samples"] == 30
    error = decode_json(card, "--session", "c", expect=2)["error"]
    assert "0000000a, 0000000b" in error["next_step"]


def test_its_own_files_are_replaced_and_nobody_else_s(sd: Path) -> None:
    formats = ("--format", "csv,npz,mat")
    decode(sd, *formats)
    decode(sd, *formats)
    # Written by this command before: replaced without asking.
    for name in ("SD.csv", "SD.events.csv", "SD.npz", "SD.mat"):
        mine = write(sd.parent / name, b"my own notes")
        process = decode(sd, *formats, expect=1)
        assert f"{mine} exists" in process.stderr
        assert "--force" in process.stderr
        assert mine.read_bytes() == b"my own notes"
        decode(sd, *formats, "--force")
        assert mine.read_bytes() != b"my own notes"
    # No temporary file is left, whatever happened.
    assert not [path for path in sd.parent.iterdir() if path.name.startswith(".")]


def test_bad_input_is_told_plainly(tmp_path: Path, sd: Path) -> None:
    cases: list[tuple[Path, str]] = [
        (tmp_path / "none.bin", "There is no file"),
        (write(tmp_path / "empty", b""), "is empty"),
        (write(tmp_path / "zeros", bytes(5120)), "never began"),
        (write(tmp_path / "text", b"hello" * 300), "is not a tfsat log"),
        (write(tmp_path / "short", b"TFS1"), "is not a tfsat log"),
        (write(tmp_path / "nothing", recording(0).image()), "no samples"),
        (tmp_path, f"tfsat-host decode {sd}"),
    ]
    for path, words in cases:
        process = decode(path, expect=1)
        assert words in process.stderr
        assert process.stdout == ""
    assert {path.name for path in tmp_path.iterdir()} == {
        "SD.bin",
        "empty",
        "zeros",
        "text",
        "short",
        "nothing",
    }


@pytest.mark.parametrize(
    "args", [("--format", "xls"), ("--format", ""), ("--session", "zz"), ("--session", "1" * 9)]
)
def test_usage(sd: Path, args: tuple[str, str]) -> None:
    decode(sd, *args, expect=2)
    assert {path.name for path in sd.parent.iterdir()} == {"SD.bin"}


@pytest.mark.parametrize("age_s", [-1_000_000_000, 1_000_000_000])
@pytest.mark.parametrize("kind", ["csv", "npz", "mat", "parquet", "mcap"])
def test_files_of_another_recording_are_named_whatever_their_date(sd: Path, kind: str, age_s: int) -> None:
    """Name files of another recording whatever their dates: the card's clock may be decades off."""
    other = "npz" if kind == "csv" else "csv"
    decode(sd, "--format", f"{kind},{other}")
    file = sd.with_suffix(f".{kind}")
    # A card's clock may be decades off, in either direction.
    shifted_s = file.stat().st_mtime + age_s
    os.utime(sd, (shifted_s, shifted_s))
    assert "another recording" not in decode(sd, "--format", other).stderr
    before = file.read_bytes()
    write(sd, recording(session=0x5E550002).image())
    os.utime(sd, (shifted_s, shifted_s))
    process = decode(sd, "--format", other)
    assert f"{file} holds another recording than {sd}" in process.stderr
    assert file.read_bytes() == before, "nothing is deleted"


def test_a_file_that_decode_did_not_write_is_nobodys(sd: Path) -> None:
    foreign = sd.with_suffix(".mat")
    foreign.write_bytes(b"mine")
    assert "another recording" not in decode(sd, "--format", "csv").stderr
    assert foreign.read_bytes() == b"mine"


def clipped_at(tmp_path: Path, t_s: float) -> dict[str, Any]:
    """Return the decoded drop with one clipped sample near `t_s` after the release."""
    recorder, release_us = drop_with_release()
    log = load(write(tmp_path / "clean.bin", recorder.image()))
    row = int(np.argmin(np.abs(log.t_us - release_us - t_s * 1e6)))
    image = bytearray(recorder.image())
    clip_sample(image, row)
    # Exit code 3 where the clipped sample lies in the fall.
    return decode_json(write(tmp_path / "SD.bin", bytes(image)), expect=3 if 0 <= t_s < 2.5 else 0)


def test_clipping_says_when(tmp_path: Path, sd: Path) -> None:
    assert decode_json(sd)["clipping"] is None
    before = clipped_at(tmp_path, -0.02)
    assert before["clipping"]["in_fall"] == 0
    assert before["clipping"]["first_s"] == pytest.approx(-0.02, abs=0.005)
    inside = clipped_at(tmp_path, 1.0)
    assert inside["clipping"]["in_fall"] == 1
    assert any("in the fall are clipped" in warning for warning in inside["warnings"])


def clip_sample(image: bytearray, row: int) -> None:
    """Sets IMU 1's clip flag of the sample in `row`, counted over the data blocks, and seals the block again."""
    for start in range(0, len(image), BLOCK_BYTES):
        kind, count = image[start + 5], image[start + 6]
        if kind != BlockKind.DATA:
            continue
        if row < count:
            image[start + HEADER_BYTES + row * Sample.SIZE + 5] |= 0x10
            crc = zlib.crc32(image[start : start + CRC_OFFSET])
            image[start + CRC_OFFSET : start + BLOCK_BYTES] = crc.to_bytes(4, "little")
            return
        row -= count
