"""Copies of recordings: interrupted ones, several of one, known by what they hold; and what is in their way."""

from __future__ import annotations

import errno
import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.cli.process import RunCli
from tests.devices.log_transfer.bench import Bench
from tests.devices.log_transfer.served_robot import LoggerAtPort, robot_here
from tfsat_host.cli.main import main
from tfsat_host.devices.log_copies import PartialLog, PartialLogError
from tfsat_host.devices.serial_ports import PortError
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.protocol.messages import LogEntry


@pytest.fixture
def logger(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[LoggerAtPort]:
    monkeypatch.chdir(tmp_path)
    with robot_here(monkeypatch) as robot:
        port_logger = LoggerAtPort(robot, RunCli(tmp_path))
        port_logger.record()
        yield port_logger


def test_a_second_copy_does_not_disown_the_first(logger: LoggerAtPort) -> None:
    (first,) = logger("log", "fetch", 1)["logs"]
    (second,) = logger("log", "fetch", 1, "--out", "new/deeper/")["logs"]
    assert second["file"] == "new/deeper/DROP0001.BIN"
    for place, copy in ((logger.folder, first), (logger.folder / "new" / "deeper", second)):
        assert (place / copy["name"]).exists()
    # Both copies are known, whichever is asked for.
    for options in ((), ("--out", "new/deeper")):
        (again,) = logger("log", "fetch", "all", *options)["logs"]
        assert (again["fetched"], again["sha256"]) == (False, first["sha256"])
    (logger.folder / "new/deeper/DROP0001.BIN").unlink()
    # The deeper copy is gone: the erase finds the other one.
    assert logger("log", "erase", 1, "--yes")["copy"] == str(logger.folder / "DROP0001.BIN")


def test_a_copy_is_known_by_what_it_holds(logger: LoggerAtPort) -> None:
    copied = logger.folder / "DROP0001.BIN"
    copied.write_bytes(logger.card_file(1))
    (copy,) = logger("log", "fetch", 1)["logs"]
    assert copy["fetched"] is False and len(copy["sha256"]) == 64
    (ram,) = (entry for entry in logger("log", "list")["logs"] if entry["in_ram"])
    logger("log", "erase", 1, "--yes")
    assert ram["session"] == copy["session"]
    # The next recording has the number again: what lies there is another.
    logger.hand("wait 100ms")
    logger.record()
    copied.rename(logger.folder / "DROP0002.BIN")
    refused = logger("log", "fetch", "1", "--out", "DROP0002.BIN", expect=1)["error"]
    assert "is not this recording" in refused["what"]


def test_all_includes_what_only_ram_has(logger: LoggerAtPort) -> None:
    assert [copy["in_ram"] for copy in logger("log", "fetch", "all")["logs"]] == [False]
    logger("log", "erase", 1, "--yes")
    assert [copy["in_ram"] for copy in logger("log", "fetch", "all")["logs"]] == [True]


def test_a_full_disk_keeps_what_came(
    logger: LoggerAtPort, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    put = PartialLog.put
    room = 7

    def put_until_full(partial: PartialLog, index: int, block: bytes) -> None:
        nonlocal room
        if room == 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        room -= 1
        put(partial, index, block)

    monkeypatch.chdir(logger.folder)
    with monkeypatch.context() as full:
        # Disk full after seven blocks.
        full.setattr(PartialLog, "put", put_until_full)
        assert main(["log", "fetch", "1", "--json", "--port", str(logger.robot.logger)]) == 1
    error = json.loads(capsys.readouterr().out)["error"]
    assert error["what"] == "DROP0001.BIN.part: No space left on device."
    assert error["meaning"].startswith("7 of ") and "are kept in DROP0001.BIN.part" in error["meaning"]
    assert "goes on from there" in error["next_step"]
    (copy,) = logger("log", "fetch", 1)["logs"]
    assert copy["resumed_blocks"] == 7
    assert (logger.folder / "DROP0001.BIN").stat().st_size > 7 * BLOCK_BYTES


def test_the_factory_settings_come_back(logger: LoggerAtPort) -> None:
    factory = logger("logger-settings")["settings"]
    logger("logger-settings", "set", "--rate", 500, "--dlpf", 1, "--file-mib", 16)
    assert logger("logger-settings", "set", "--factory", "--dlpf", 2)["settings"] == {
        **factory,
        "dlpf_cfg": 2,
    }
    assert logger("logger-settings", "set", "--factory")["settings"] == factory


def _fetch(bench: Bench, entry: LogEntry, target: Path) -> int:
    """Fetch the missing blocks once and return how many were present before."""
    with PartialLog(target, entry) as partial:
        bench.logger.fetch_blocks(entry, partial.missing, partial.put)
        present = partial.present_blocks
        partial.finish()
    return present


def _cut(bench: Bench, entry: LogEntry, target: Path, after_bytes: int) -> Path:
    """Cut the cable during a fetch and return the path of the partial file."""
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
    # The part file has its full size at once.
    assert part.stat().st_size == entry.blocks * BLOCK_BYTES
    assert not target.exists()
    before = bench.cable.received
    # The first fetch got at least 128 blocks.
    assert _fetch(bench, entry, target) >= 128
    # Less than 60 % of the bytes: the rest was already there.
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
    # One bit and one whole block of zeros: both are seen by their CRCs.
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
    # Same size, other session: only the content can tell.
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
    # The first block of the second file is zeros: nothing tells what it is of.
    bench.robot.card_slot.put(2, headless)
    entry, target = bench.entry(2), tmp_path / "DROP0002.BIN"
    assert entry.session == 0
    _cut(bench, entry, target, 100_000)
    # Nothing of it could be resumed: without a header no block is trusted.
    assert _fetch(bench, entry, target) == 0
    assert target.read_bytes() == headless


def test_an_empty_file_is_a_recording_without_blocks(bench: Bench, tmp_path: Path) -> None:
    bench.robot.card_slot.put(1, b"")
    target = tmp_path / "DROP0001.BIN"
    _fetch(bench, bench.entry(1), target)
    assert target.read_bytes() == b""
