"""An interrupted copy: what it keeps, and whose it is."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.log_transfer.bench import Bench
from tfsat_host.devices.log_copies import PartialLog, PartialLogError
from tfsat_host.devices.ports import PortError
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.protocol.messages import LogEntry


def _fetch(bench: Bench, entry: LogEntry, target: Path) -> int:
    """One attempt; how many blocks it found there."""
    with PartialLog(target, entry) as partial:
        bench.logger.fetch_blocks(entry, partial.missing, partial.put)
        present = partial.present_blocks
        partial.finish()
    return present


def _cut(bench: Bench, entry: LogEntry, target: Path, after_bytes: int) -> Path:
    """An attempt that the cable ends; what it leaves."""
    bench.cable.cut_after = bench.cable.received + after_bytes
    with pytest.raises(PortError), PartialLog(target, entry) as partial:
        bench.logger.fetch_blocks(entry, partial.missing, partial.put)
    bench.cable.cut_after = None
    return partial.path


def test_the_next_attempt_asks_for_the_rest_only(bench: Bench, tmp_path: Path) -> None:
    bench.record(5.0)
    entry, target = bench.entry(1), tmp_path / "DROP0001.BIN"
    assert entry.blocks > 200
    part = _cut(bench, entry, target, 100_000)
    assert part.stat().st_size == entry.blocks * BLOCK_BYTES
    assert not target.exists()
    before = bench.cable.received
    assert _fetch(bench, entry, target) >= 128
    assert bench.cable.received - before < entry.blocks * BLOCK_BYTES * 0.6
    assert target.read_bytes() == bench.robot.card_slot.files()[1]
    assert not part.exists()


def test_a_block_that_was_spoilt_on_this_computers_disk_is_fetched_again(
    bench: Bench, tmp_path: Path
) -> None:
    bench.record(5.0)
    entry, target = bench.entry(1), tmp_path / "DROP0001.BIN"
    part = _cut(bench, entry, target, 100_000)
    spoilt = bytearray(part.read_bytes())
    spoilt[3 * BLOCK_BYTES + 17] ^= 1
    spoilt[9 * BLOCK_BYTES : 10 * BLOCK_BYTES] = bytes(BLOCK_BYTES)
    part.write_bytes(spoilt)
    with PartialLog(target, entry) as partial:
        assert partial.missing[:2] == [(3, 1), (9, 1)]
    _fetch(bench, entry, target)
    assert target.read_bytes() == bench.robot.card_slot.files()[1]


def test_it_is_not_mixed_with_another_recording(bench: Bench, tmp_path: Path) -> None:
    bench.record(4.0)
    bench.record(5.0)
    first, second = bench.entry(1), bench.entry(2)
    target = tmp_path / "DROP.BIN"
    part = _cut(bench, first, target, 100_000)
    before = part.read_bytes()
    same_size = LogEntry(2, second.session, first.blocks, 0, 1)
    for other in (same_size, LogEntry(1, first.session, first.blocks + 1, 0, 1)):
        with pytest.raises(PartialLogError, match="another recording") as refused:
            PartialLog(target, other)
        assert str(part) in refused.value.next_step
        assert part.read_bytes() == before
    with PartialLog(target, second, replace=True) as partial:
        assert partial.missing == [(0, second.blocks)]
        bench.logger.fetch_blocks(second, partial.missing, partial.put)
        partial.finish()
    assert target.read_bytes() == bench.robot.card_slot.files()[2]


def test_a_recording_whose_first_block_tells_nothing_is_fetched_from_the_start(
    bench: Bench, tmp_path: Path
) -> None:
    bench.record(4.0)
    headless = bytes(BLOCK_BYTES) + bench.robot.card_slot.files()[1][BLOCK_BYTES:]
    bench.robot.card_slot.put(2, headless)
    entry, target = bench.entry(2), tmp_path / "DROP0002.BIN"
    assert entry.session == 0
    _cut(bench, entry, target, 100_000)
    assert _fetch(bench, entry, target) == 0
    assert target.read_bytes() == headless


def test_an_empty_file_is_a_recording_without_blocks(bench: Bench, tmp_path: Path) -> None:
    bench.robot.card_slot.put(1, b"")
    target = tmp_path / "DROP0001.BIN"
    _fetch(bench, bench.entry(1), target)
    assert target.read_bytes() == b""
