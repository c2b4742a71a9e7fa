"""How files are read: sparse ones, ones with something before their blocks, streams, and the progress of it."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.sdlog.encoder import long_recording, recording
from tests.sdlog.test_decode_command import decode
from tests.sdlog.test_values import assert_values, write
from tfsat_host.sdlog import LogError, load
from tfsat_host.sdlog.source import LogSource

MIB = 1 << 20


@pytest.fixture
def sparse(tmp_path: Path) -> Path:
    """64 MiB that hold nothing but a recording in the middle."""
    path = tmp_path / "card.img"
    # Sparse: only the recording itself takes room on the disk.
    with path.open("wb") as file:
        file.truncate(64 * MIB + 100)
        file.seek(20 * MIB)
        file.write(recording(4).image())
    return path


def test_holes_of_a_sparse_image_are_not_read_and_count_as_never_written(
    sparse: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = []
    read_into = LogSource.read_into

    def count_read(self: LogSource, target: memoryview, offset: int) -> memoryview:
        read.append(len(target))
        return read_into(self, target, offset)

    monkeypatch.setattr(LogSource, "read_into", count_read)
    log = load(sparse)
    skipped, aside = sum(read), log.set_aside
    assert (log.verdict, len(log)) == ("complete", 24)
    # Holes are not read: 8 MiB of 64 at the most.
    assert skipped <= 8 * MIB
    read.clear()
    # Without the system's help the whole file is read.
    monkeypatch.delattr(os, "SEEK_DATA", raising=False)
    assert load(sparse).set_aside == aside
    assert sum(read) >= 64 * MIB


def test_a_hole_where_the_file_got_shorter_is_no_hole(sparse: Path) -> None:
    with LogSource(sparse) as source:
        chunks = source.chunks()
        next(chunks)
        # The file shrank while it was read.
        os.truncate(sparse, 22 * MIB)
        with pytest.raises(LogError, match="changed while"):
            list(chunks)


@pytest.mark.parametrize("shift", [1, 37, 511])
def test_blocks_behind_something_that_is_no_sector_are_found(tmp_path: Path, shift: int) -> None:
    # Blocks begin at the junk's end, not at a multiple of 512.
    junk = b"..TFS1 was here".ljust(shift + 5 * 512, b".")
    log = load(write(tmp_path / "card.img", junk + recording(400).image() + b"end"))
    assert (log.verdict, len(log)) == ("complete", 2_400)
    assert_values(log)


def test_a_lone_magic_is_no_log(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="is not a tfsat log"):
        load(write(tmp_path / "text", b"..TFS1" * 400))


def test_progress_comes_to_one(tmp_path: Path, sparse: Path) -> None:
    for path in (sparse, write(tmp_path / "SD.bin", long_recording(9000))):
        shares: list[float] = []
        load(path, progress=shares.append)
        assert len(shares) > 1
        assert sum(shares) == pytest.approx(1.0)
        # Never backwards, and the whole file once.
        assert min(shares) >= 0.0


def test_a_log_has_a_short_name(tmp_path: Path) -> None:
    path = write(tmp_path / "SD.bin", recording(4).image())
    assert repr(load(path)) == f"<DropLog 1234abcd: complete, 24 samples at 280.03 Hz, 0 lost, '{path}'>"


def test_pipes_and_endless_devices_are_refused_in_words(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    # A pipe has no end that can be waited for.
    os.mkfifo(pipe)
    for path in (pipe, Path("/dev/zero")):
        error_text = decode(path, expect=2).stderr
        assert f"{str(path)!r} is a device, pipe or socket, not a file: save it to one" in error_text
        with pytest.raises(LogError, match="is not a file that can be read from any place"):
            load(path)


def test_a_disk_that_cannot_be_written_does_not_cost_the_verdict(tmp_path: Path) -> None:
    path = write(tmp_path / "SD.bin", recording(4).image())
    # A folder below a device's file cannot be made, by root either.
    # Decoded all the same: the verdict does not depend on the disk.
    process = decode(path, "--out", "/proc/nowhere", expect=1)
    assert "complete: no samples lost" in process.stdout
    assert "No file could be written to /proc/nowhere" in process.stderr
    assert "is decoded (complete, 24 samples)" in process.stderr
    json_text = decode(path, "--out", "/proc/nowhere", "--json", expect=1).stdout
    assert '"verdict": "complete"' in json_text and '"error"' in json_text


def test_the_footer_is_shown_in_words(tmp_path: Path) -> None:
    output = decode(write(tmp_path / "SD.bin", recording(4).image())).stdout
    assert "jitter 1.5 µs rms, steps 3.569 to 3.573 ms, 0 late ticks" in output
    assert "longest stall 7 ms, max. 3 of 768 blocks buffered, 0 rewritten" in output
    assert "Ended:     stopped via USB" in output and output.splitlines()[-1].startswith("Verdict: complete")
