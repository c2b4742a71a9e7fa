"""An independent decoder, compiled by Kaitai Struct from the grammar, reads what ours reads."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compile_kaitai import compiled_hash, grammar_hash
from tests.rehearsal.days import rehearse_drop
from tests.sdlog.encoder import ALL_VALID, Recorder, drop_with_release, event
from tests.sdlog.kaitai.tfsat_log import TfsatLog
from tests.sdlog.test_values import write
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.protocol.enums import EventCode
from tfsat_host.protocol.limits import BLOCK_BYTES, BLOCK_MAGIC
from tfsat_host.sdlog import DropLog, load


def encoded_log() -> bytes:
    """Build a log with a release, strokes and every flag, value and event that the grammar distinguishes."""
    recorder, _ = drop_with_release(closed=False)
    for bit in range(16):
        recorder.data(3, flags=ALL_VALID ^ 1 << bit)
    for code in EventCode:
        # The smallest value: the field is signed.
        recorder.data(events=[event(recorder.time_us(recorder.samples), code, 3, 0xFFFE, -(2**31) + code)])
    recorder.close()
    return recorder.image()


def flown_log() -> bytes:
    """Return the log that the logger's own core wrote in a rehearsed drop."""
    return rehearse_drop(schedule_maneuver(four_stroke(59.0, 70.0)), seed=7).card


@pytest.fixture(scope="module", params=[encoded_log, flown_log], ids=["encoder", "logger"])
def image(request: pytest.FixtureRequest) -> bytes:
    data: bytes = request.param()
    return data


@pytest.fixture
def log(image: bytes, tmp_path: Path) -> DropLog:
    return load(write(tmp_path / "SD.bin", image))


@pytest.fixture(scope="module")
def blocks(image: bytes) -> list[Any]:
    """Kaitai's blocks of the recording, each once, by number. It does not know which of them are empty."""
    # The grammar reads every block, empty ones too.
    parsed = TfsatLog.from_bytes(image).blocks
    assert len(parsed) == len(image) // BLOCK_BYTES
    return sorted(
        # A repeated block counts once, as in our decoder.
        {block.head.block_number: block for block in parsed if block.head.magic == BLOCK_MAGIC}.values(),
        key=lambda block: block.head.block_number,
    )


def of_kind(blocks: list[Any], kind: TfsatLog.BlockKind) -> list[Any]:
    return [block for block in blocks if block.head.kind == kind]


def test_the_compiled_decoder_is_of_this_grammar() -> None:
    assert compiled_hash() == grammar_hash(), "protocol/tfsat_log.ksy has changed: run make kaitai"


def test_every_field_of_every_sample(log: DropLog, blocks: list[Any]) -> None:
    times, indices, imu, angles, flags = [], [], [], [], []
    for block in of_kind(blocks, TfsatLog.BlockKind.data):
        for slot, sample in enumerate(block.body.sample_slots[: block.head.sample_count]):
            times.append(block.head.time_us + sample.time_offset_us)
            indices.append(block.head.first_sample + slot)
            imu.append([[*reading.accel, reading.temperature, *reading.gyro] for reading in sample.imu])
            angles.append(sample.angle)
            # Two decoders, one meaning: every flag bit by bit.
            flags.append([bool(sample.flags >> bit & 1) for bit in range(16)])
    assert times == log.t_us.tolist()
    assert indices == log.sample_index.tolist()
    assert imu == log.imu_counts.tolist()
    assert angles == log.angle_counts.tolist()
    ours = np.hstack((log.imu_valid, log.angle_valid, log.switch_open, log.clipped))
    assert flags == ours.tolist()


def test_every_event(log: DropLog, blocks: list[Any]) -> None:
    events = [
        (e.time_us, e.code.name, e.index, e.arg, e.value)
        for block in of_kind(blocks, TfsatLog.BlockKind.data)
        for e in block.body.event_slots[: block.head.event_count]
    ]
    assert events
    assert sorted(events) == sorted((e.t_us, e.name, e.index, e.arg, e.value) for e in log.events)


def test_header_and_footer(log: DropLog, blocks: list[Any]) -> None:
    (footer,) = of_kind(blocks, TfsatLog.BlockKind.footer)
    header = of_kind(blocks, TfsatLog.BlockKind.header)[0]
    assert log.footer is not None
    for theirs, ours in ((header.body, log.header), (footer.body, log.footer)):
        for name, value in asdict(ours).items():
            read = getattr(theirs, name)
            # Bytes and tuples differ in type only: the values are compared.
            assert (type(value)(read) if isinstance(value, bytes | tuple) else read) == value, name
    assert {block.head.session for block in blocks} == {log.session}


def test_the_grammar_knows_a_block_that_is_none() -> None:
    recorder = Recorder()
    recorder.data()
    parsed = TfsatLog.from_bytes(recorder.image() + bytes(BLOCK_BYTES)).blocks
    assert [int(block.head.kind) for block in parsed] == [1, 2, 0]
    # An empty block decodes to zeros of its size.
    assert parsed[2].body == bytes(len(parsed[2].body))
