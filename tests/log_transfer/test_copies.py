"""Copies of recordings: several of one, known by what they hold, and what stands in their way."""

from __future__ import annotations

import errno
import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.cli.process import RunCli
from tests.emulate.served import Served
from tests.log_transfer.served_robot import LoggerAtPort
from tfsat_host.cli.main import main
from tfsat_host.devices.log_copies import PartialLog
from tfsat_host.protocol.limits import BLOCK_BYTES


@pytest.fixture
def logger(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[LoggerAtPort]:
    monkeypatch.chdir(tmp_path)
    with Served() as served:
        made = LoggerAtPort(served, RunCli(tmp_path))
        made.record()
        yield made


def test_a_second_copy_does_not_disown_the_first(logger: LoggerAtPort) -> None:
    (first,) = logger("log", "fetch", 1)["logs"]
    (second,) = logger("log", "fetch", 1, "--out", "new/deeper/")["logs"]
    assert second["file"] == "new/deeper/DROP0001.BIN"
    for place, copy in ((logger.folder, first), (logger.folder / "new" / "deeper", second)):
        assert (place / copy["name"]).exists()
    for options in ((), ("--out", "new/deeper")):
        (again,) = logger("log", "fetch", "all", *options)["logs"]
        assert (again["fetched"], again["sha256"]) == (False, first["sha256"])
    (logger.folder / "new/deeper/DROP0001.BIN").unlink()
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
        full.setattr(PartialLog, "put", put_until_full)
        assert main(["log", "fetch", "1", "--json", "--port", str(logger.served.logger)]) == 1
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
