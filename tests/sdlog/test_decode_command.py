"""`tfsat-host decode` as a process."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.sdlog.encoder import ALL_VALID, Recorder, drop_with_release, recording
from tests.sdlog.test_values import write


def decode(*args: object, expect: int = 0) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "tfsat_host", "decode", *map(str, args)]
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, env={**os.environ, "NO_COLOR": "1"}
    )
    assert "Traceback" not in done.stderr
    assert done.returncode == expect, (done.stdout, done.stderr)
    return done


def decode_json(*args: object, expect: int = 0) -> dict[str, Any]:
    facts: dict[str, Any] = json.loads(decode(*args, "--json", expect=expect).stdout)
    return facts


@pytest.fixture
def sd(tmp_path: Path) -> Path:
    return write(tmp_path / "SD.bin", drop_with_release()[0].image())


def test_summary_and_csv_beside_the_file(sd: Path) -> None:
    shown = decode(sd).stdout
    for words in (
        "1234abcd",
        "complete",
        "528 in 1.882 s",
        "280.03 Hz",
        "release switch 1 opened",
        "stroke 4",
    ):
        assert words in shown
    assert {path.name for path in sd.parent.iterdir()} == {"SD.bin", "SD.csv", "SD.events.csv"}


def test_json_has_the_keys_that_others_rely_on(sd: Path, tmp_path: Path) -> None:
    facts = decode_json(sd, "--format", "csv,npz,mat", "--out", tmp_path / "out")
    assert facts["verdict"] == "complete"
    assert (facts["samples"], facts["samples_lost"], facts["blocks_lost"]) == (528, 0, 0)
    assert facts["duration_s"] == pytest.approx(1.881917)
    assert facts["rate_hz"] == pytest.approx(280.03, abs=0.01)
    assert facts["session"] == "1234abcd"
    strokes = [event["t_s"] for event in facts["events"] if event["name"] == "stroke"]
    assert strokes == [0.70, 1.05, 1.47, 1.82]
    names = {"csv": "SD.csv", "events_csv": "SD.events.csv", "npz": "SD.npz", "mat": "SD.mat"}
    assert facts["files"] == {key: str(tmp_path / "out" / name) for key, name in names.items()}
    assert all(Path(path).stat().st_size for path in facts["files"].values())


def test_lost_data_ends_with_3_and_says_what(tmp_path: Path) -> None:
    blocks = recording(8).blocks
    damaged = write(tmp_path / "damaged.bin", b"".join(blocks[:3] + blocks[4:]))
    done = decode(damaged, expect=3)
    assert "6 of 48 samples are lost (1 blocks)" in done.stderr
    assert "damaged" in done.stdout
    cut = write(tmp_path / "cut.bin", b"".join(blocks[:-1]))
    assert decode_json(cut, expect=3)["verdict"] == "truncated"
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
    assert decode_json(card)["other_sessions"] == ["0000000b"]
    assert decode_json(card, "--session", "0000000B")["samples"] == 30
    error = decode_json(card, "--session", "c", expect=2)["error"]
    assert "0000000a, 0000000b" in error["next_step"]


def test_its_own_files_are_replaced_and_nobody_else_s(sd: Path) -> None:
    formats = ("--format", "csv,npz,mat")
    decode(sd, *formats)
    decode(sd, *formats)
    for name in ("SD.csv", "SD.events.csv", "SD.npz", "SD.mat"):
        mine = write(sd.parent / name, b"my own notes")
        done = decode(sd, *formats, expect=1)
        assert f"{mine} exists" in done.stderr
        assert "--force" in done.stderr
        assert mine.read_bytes() == b"my own notes"
        decode(sd, *formats, "--force")
        assert mine.read_bytes() != b"my own notes"
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
        done = decode(path, expect=1)
        assert words in done.stderr
        assert done.stdout == ""
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
