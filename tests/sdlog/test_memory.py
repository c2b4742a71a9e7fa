"""Decoding takes no more than 100 MB above its output, however large the input is."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tests.sdlog.encoder import SESSION, long_recording, recording, renumbered
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.sdlog import LogError, load
from tfsat_host.sdlog.load import survey
from tfsat_host.sdlog.source import LogSource

ALLOWED_BYTES = 100_000_000
GIB = 1 << 30
# In a process of its own, so that nothing else is measured: what it prints includes the interpreter.
MEASURE = """
import json, resource, sys
from tfsat_host.sdlog import LogError, load
try:
    log = load(sys.argv[1])
    # The counts are views of whole 74-byte records: times and flags stand between them.
    output = 74 * len(log) + sum(
        column.nbytes for column in (log.sample_index, log.t_us, log.imu_valid, log.angle_valid,
                                     log.switch_open, log.clipped))
    said = [log.verdict, len(log), log.set_aside.duplicate]
except LogError as error:
    output, said = 0, [error.what]
# Linux hands a parent's getrusage peak on to its child; the peak of the child's own memory is in /proc.
if sys.platform == "linux":
    peak = 1024 * int(open("/proc/self/status").read().split("VmHWM:")[1].split()[0])
else:
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(json.dumps([peak, output, said]))
"""


def above_output(path: Path) -> tuple[int, list[object]]:
    process = subprocess.run(
        [sys.executable, "-c", MEASURE, str(path)], capture_output=True, text=True, check=True
    )
    peak, output, summary = json.loads(process.stdout)
    return peak - output, summary


def test_a_sparse_card_image_of_many_gigabytes(tmp_path: Path) -> None:
    # Nine quarters of a gibibyte, most of it holes.
    path = tmp_path / "card.img"
    with path.open("wb") as file:
        file.truncate(9 * GIB // 4)
        # A recording at 2 GiB, random bytes at 1 GiB.
        for position, part in ((2 * GIB, recording(4).image()), (1 * GIB, os.urandom(1 << 20))):
            file.seek(position)
            file.write(part)
    extra_bytes, summary = above_output(path)
    assert extra_bytes < ALLOWED_BYTES
    assert summary == ["complete", 24, 0]


def test_a_long_recording_and_a_whole_copy_of_it(tmp_path: Path) -> None:
    path = tmp_path / "SD.bin"
    # 250,000 blocks twice: 1.5 million samples.
    path.write_bytes(2 * long_recording(250_000))
    extra_bytes, summary = above_output(path)
    assert extra_bytes < ALLOWED_BYTES
    assert summary == ["truncated", 1_499_994, 250_000]


def test_blocks_in_any_order(tmp_path: Path) -> None:
    blocks = np.frombuffer(long_recording(40_000), f"S{BLOCK_BYTES}")
    path = tmp_path / "SD.bin"
    # A whole recording in random order.
    path.write_bytes(np.random.default_rng(3).permutation(blocks).tobytes())
    extra_bytes, summary = above_output(path)
    assert extra_bytes < ALLOWED_BYTES
    assert summary == ["truncated", 239_994, 0]


def test_a_file_of_copies_of_one_block(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neighbours are read together, and of a number only the best block so far is kept."""
    header, data, *rest = recording(3).blocks
    path = tmp_path / "SD.bin"
    # 400,000 copies of one block in the middle of a recording.
    path.write_bytes(header + data * 400_000 + b"".join(rest))
    extra_bytes, summary = above_output(path)
    assert extra_bytes < ALLOWED_BYTES
    assert summary == ["complete", 18, 399_999]
    reads = 0
    read_into = LogSource.read_into

    def count_read(source: LogSource, target: memoryview, offset: int) -> memoryview:
        nonlocal reads
        reads += 1
        return read_into(source, target, offset)

    monkeypatch.setattr(LogSource, "read_into", count_read)
    path.write_bytes(header + data * 40_000 + b"".join(rest))
    load(path)
    # Neighbours are read together, not one read a block.
    assert reads < 30


def test_one_block_written_again_with_other_content(tmp_path: Path) -> None:
    """Count the block with the most samples, then the first; others are duplicates or in conflict."""
    recorder = recording(3)
    header, data, *rest = recorder.blocks
    # A block with fewer samples, and one with another time.
    fewer = renumbered(data, sample_count=3)
    other = renumbered(data, time_us=5_000_001)
    path = tmp_path / "SD.bin"
    # The fullest block counts, of equals the first.
    again = [fewer] * 5000 + [data] * 5000 + [other] * 5000 + [data] * 2 + [fewer]
    path.write_bytes(b"".join([header, *again, *rest]))
    log = load(path)
    assert (log.set_aside.duplicate, log.set_aside.conflicting) == (5001, 10_001)
    assert (len(log), int(log.t_us[0])) == (18, 5_000_000)


def test_old_recordings_of_a_whole_card_leave_only_their_places(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Count repeated blocks of another recording as one piece per repetition, and decode none of them."""
    path = tmp_path / "SD.bin"
    chunk = long_recording(64)
    path.write_bytes(chunk)
    block_number = 0

    def endless(source: LogSource) -> Iterator[tuple[int, memoryview]]:
        nonlocal block_number
        for block_number in range(0, 64 * 200, 64):
            # The same 64 blocks again and again, without a file of that size.
            yield block_number, memoryview(bytearray(chunk))

    with LogSource(path) as source:
        monkeypatch.setattr(LogSource, "chunks", endless)
        survey_result = survey(source, session=1)
    assert survey_result.pieces["count"].sum() == 64 * 200
    # Only where they lie is remembered, not what they hold.
    assert survey_result.pieces.nbytes < 200 * 64
    assert survey_result.early is not None
    assert not len(survey_result.early.builder.columns()["t_us"])


def test_a_jumble_of_more_pieces_than_any_card_holds_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A limit that a test can reach.
    monkeypatch.setattr("tfsat_host.sdlog.blocks.MAX_PIECES", 30)
    blocks = recording(70).blocks
    path = tmp_path / "SD.bin"
    # Every second block: each is a piece of its own.
    path.write_bytes(b"".join(blocks[::2]))
    with pytest.raises(LogError, match="more than 30 separate pieces"):
        load(path)
    path.write_bytes(b"".join(blocks[:50:2]))
    assert load(path).blocks_lost == 24


def test_what_does_not_fit_in_memory_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "SD.bin"
    path.write_bytes(recording().image())

    def refuse(*_: object) -> None:
        raise MemoryError

    # As where its arrays do not fit.
    monkeypatch.setattr(sys.modules["tfsat_host.sdlog.load"], "BlockDecoder", refuse)
    with pytest.raises(LogError, match="does not fit in this computer's memory"):
        load(path)


def test_a_file_too_large_to_decode_in_passing_gives_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "SD.bin"
    image = long_recording(5000)
    # Five blocks missing, and a part of them again at the end.
    path.write_bytes(image[: 3000 * BLOCK_BYTES] + image[3005 * BLOCK_BYTES :] + image[51_200:76_800])
    at_once = load(path)
    monkeypatch.setattr(sys.modules["tfsat_host.sdlog.load"], "DECODED_AT_ONCE_BYTES", 0)
    in_two = load(path)
    assert (at_once.session, at_once.gaps, at_once.set_aside) == (SESSION, in_two.gaps, in_two.set_aside)
    for name in ("sample_index", "t_us", "imu_counts", "angle_counts", "imu_valid", "switch_open"):
        # What is decoded at once and in two passes must be the same log.
        np.testing.assert_array_equal(getattr(at_once, name), getattr(in_two, name))
