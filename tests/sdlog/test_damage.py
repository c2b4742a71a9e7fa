"""Every truncation and every single flipped bit of a reference log: right values, or flagged."""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from tests.sdlog.encoder import Recorder, event
from tests.sdlog.test_values import assert_values, write
from tfsat_host.protocol.enums import EventCode
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.sdlog import DropLog, LogError, load
from tfsat_host.sdlog.blocks import look


@pytest.fixture(scope="module")
def reference() -> Recorder:
    """Header, data, copy of the header, partial data with an event, footer."""
    recorder = Recorder(repeat_blocks=2)
    recorder.data()
    recorder.data(3, events=[event(5_010_000, EventCode.STROKE)])
    # Without the copy of the header that the second data block made due.
    recorder.blocks.pop()
    recorder.close()
    return recorder


def test_the_reference_is_complete(reference: Recorder, tmp_path: Path) -> None:
    log = load(write(tmp_path / "SD.bin", reference.image()))
    assert (log.verdict, len(log), len(log.events)) == ("complete", 9, 1)


def check(log: DropLog, recorder: Recorder) -> None:
    assert_values(log)
    assert log.t_us.tolist() == [recorder.time_us(index) for index in log.sample_index.tolist()]
    if log.verdict == "complete":
        assert (len(log), len(log.events)) == (9, 1)
    if log.verdict == "truncated":
        assert log.sample_index.tolist() == list(range(len(log)))


@pytest.mark.parametrize("step", [29, pytest.param(1, marks=pytest.mark.prove)])
def test_every_truncation(reference: Recorder, tmp_path: Path, step: int) -> None:
    """Truncate a log at every byte under `make prove`, else at some sizes in and around each block's end."""
    data = reference.image()
    ends = {end + i for end in range(0, len(data), BLOCK_BYTES) for i in (-1, 0, 1)}
    sizes = sorted({*range(0, len(data), step), *ends} & {*range(len(data))}, reverse=True)
    # From the largest size down: the file is only shortened.
    path = write(tmp_path / "SD.bin", data)
    verdicts = []
    for size in sizes:
        os.truncate(path, size)
        try:
            log = load(path)
        except LogError as error:
            assert error.next_step
            verdicts.append("refused")
            continue
        check(log, reference)
        assert log.verdict == "truncated"
        verdicts.append(log.verdict)
    # With the header and one block, the log can be read.
    assert verdicts == ["truncated" if size >= 2 * BLOCK_BYTES else "refused" for size in sizes]


def test_every_flipped_bit(reference: Recorder, tmp_path: Path) -> None:
    """Whichever bit it is, its block is not used; and without that block the log is right and flagged."""
    bits = np.arange(8 * BLOCK_BYTES)
    for number, block in enumerate(reference.blocks):
        flipped = np.tile(np.frombuffer(block, np.uint8), (len(bits), 1))
        flipped[bits, bits // 8] ^= (1 << bits % 8).astype(np.uint8)
        looked = look(flipped.data.cast("B"))
        # Not a single flipped bit may go unnoticed.
        assert not looked.usable.any()
        assert looked.unusable == Counter(foreign=32, torn=len(bits) - 32), "magic number, all else"
        # Some bits of every kind are decoded; all of them would take minutes.
        for bit in (0, 31, 32, *range(100, len(bits), 333)):
            blocks = [*reference.blocks[:number], flipped[bit].tobytes(), *reference.blocks[number + 1 :]]
            log = load(write(tmp_path / "SD.bin", b"".join(blocks)))
            check(log, reference)
            assert log.verdict == ("truncated" if number == len(reference.blocks) - 1 else "damaged")
