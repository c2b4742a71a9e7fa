"""Every truncation and every single flipped bit of a reference log: right values, or flagged."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sdlog.encoder import Recorder, event
from tests.sdlog.test_values import assert_values, write
from tfsat_host.protocol.enums import EventCode
from tfsat_host.sdlog import DropLog, LogError, load


@pytest.fixture(scope="module")
def reference() -> Recorder:
    """Header, data, copy of the header, partial data with an event, footer."""
    recorder = Recorder(repeat_blocks=2)
    recorder.data()
    recorder.data(3, events=[event(5_010_000, EventCode.STROKE)])
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


def test_every_truncation(reference: Recorder, tmp_path: Path) -> None:
    data = reference.image()
    verdicts = []
    for size in range(len(data)):
        path = write(tmp_path / "SD.bin", data[:size])
        try:
            log = load(path)
        except LogError as error:
            assert error.next_step
            verdicts.append("refused")
            continue
        check(log, reference)
        assert log.verdict == "truncated"
        verdicts.append(log.verdict)
    assert verdicts == ["refused"] * 1024 + ["truncated"] * (len(data) - 1024)


def test_every_flipped_bit(reference: Recorder, tmp_path: Path) -> None:
    data = bytearray(reference.image())
    path = tmp_path / "SD.bin"
    for position in range(len(data)):
        for bit in range(8):
            data[position] ^= 1 << bit
            path.write_bytes(data)
            log = load(path)
            check(log, reference)
            assert log.verdict == ("truncated" if position >= len(data) - 512 else "damaged")
            data[position] ^= 1 << bit
