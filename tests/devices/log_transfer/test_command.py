"""`tfsat-host log`, `record` and `logger-settings` at a port: what a person at the tower types."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from tests.cli.process import RunCli
from tests.devices.log_transfer.served_robot import LoggerAtPort, robot_here
from tests.emulated.served import TIMEOUT_S, Served
from tests.sdlog.encoder import recording
from tfsat_host.protocol.limits import BLOCK_BYTES


@pytest.fixture
def logger(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[LoggerAtPort]:
    monkeypatch.chdir(tmp_path)
    with robot_here(monkeypatch) as robot:
        yield LoggerAtPort(robot, RunCli(tmp_path))


@pytest.fixture
def served_logger(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[LoggerAtPort]:
    """Behind a true port, in real time."""
    monkeypatch.chdir(tmp_path)
    with Served() as served:
        yield LoggerAtPort(served, RunCli(tmp_path))


def test_from_a_recording_to_an_erased_card(logger: LoggerAtPort) -> None:
    assert logger("log", "list")["logs"] == []
    stopped = logger.record()
    assert (stopped["state"], stopped["number"]) == ("stopped", 1)
    ram, entry = logger("log", "list")["logs"]
    assert (ram["in_ram"], ram["session"]) == (True, stopped["session"])
    assert (entry["number"], entry["name"], entry["closed"]) == (1, "DROP0001.BIN", True)
    assert abs(datetime.fromisoformat(entry["start"]) - datetime.now().astimezone()) < timedelta(hours=1)
    assert entry["fetched_to"] is None

    # A copy first: an erase without one needs --force.
    refused = logger("log", "erase", 1, "--yes", expect=4)["error"]
    assert "tfsat-host log fetch 1 --port" in refused["next_step"]

    (copy,) = logger("log", "fetch", 1)["logs"]
    path = logger.folder / "DROP0001.BIN"
    # Byte by byte what lies on the card.
    assert path.read_bytes() == logger.card_file(1)
    assert (copy["verdict"], copy["samples"], copy["fetched"]) == ("complete", stopped["samples"], True)
    assert logger("log", "list")["logs"][1]["fetched_to"] == str(path)
    assert logger("log", "fetch", "all")["logs"][0]["fetched"] is False, "it is there already"

    assert "Erase DROP0001.BIN" in logger.read_output("log", "erase", 1, expect=2), "it asks"
    assert logger("log", "erase", 1, "--yes")["copy"] == str(path)
    # RAM's own copy of the last recording is left.
    assert [each["number"] for each in logger("log", "list")["logs"]] == [0]
    assert logger("log", "fetch", 1, expect=1)["error"]["code"] == "no_such_log"


def test_a_copy_that_changed_is_no_copy(logger: LoggerAtPort) -> None:
    logger.record()
    logger("log", "fetch", 1)
    path = logger.folder / "DROP0001.BIN"
    # The last byte is another, the size is the same: the hash tells.
    path.write_bytes(path.read_bytes()[:-1] + b"\0")
    # A copy that differs is no reason to erase.
    logger("log", "erase", 1, "--yes", expect=4)
    refused = logger("log", "fetch", 1, expect=1)["error"]
    assert "--force" in refused["next_step"]
    logger("log", "fetch", 1, "--force")
    path.unlink()
    assert logger("log", "list")["logs"][1]["fetched_to"] is None
    logger("log", "erase", 1, "--yes", expect=4)
    # With --force the user knows that there is no copy.
    assert logger("log", "erase", 1, "--yes", "--force")["copy"] is None


def test_the_table_for_people(logger: LoggerAtPort) -> None:
    assert "No recordings." in logger.read_output("log", "list")
    logger.record()
    output = logger.read_output("log", "list")
    assert "(in RAM)" in output and "DROP0001.BIN" in output and "MiB free" in output
    # --out makes the folder that it names.
    fetched = logger.read_output("log", "fetch", 1, "--out", "a folder/drop.bin")
    assert "every block checked" in fetched and "complete: " in fetched
    assert (logger.folder / "a folder" / "drop.bin").exists()


def test_a_fetch_goes_on_where_its_cable_was_pulled(served_logger: LoggerAtPort) -> None:
    """Resume a fetch after its cable was pulled, during the 32 MiB that a power cut left behind."""
    served_logger("record", "start")
    # A power cut in the recording leaves the preallocated 32 MiB.
    served_logger.hand("wait 3", "power logger off", "power logger on", "wait 1")
    part = served_logger.folder / "DROP0001.BIN.part"
    # The cable goes while the first blocks arrive.
    error = fetch_and_pull(served_logger, part)
    assert str(part.name) in error["meaning"] and "are kept in" in error["meaning"]
    assert "goes on from there" in error["next_step"]
    part_bytes = part.read_bytes()
    assert len(part_bytes) == 32 * 2**20
    served_logger.hand("cable logger plug")
    (copy,) = served_logger("log", "fetch", 1, expect=3)["logs"]
    assert copy["verdict"] == "truncated"
    # Blocks that were there are not fetched again.
    assert copy["resumed_blocks"] * BLOCK_BYTES <= len(part_bytes)
    assert copy["resumed_blocks"] > 100
    assert (served_logger.folder / "DROP0001.BIN").read_bytes() == served_logger.card_file(1)
    assert not part.exists()


def test_no_recording_begins_with_a_bad_card(logger: LoggerAtPort) -> None:
    for line, card, code in (
        ("card remove", "missing", "no_card"),
        ("card fill", "full", "card_full"),
        ("card write-protect", "write_protected", "card_write_protected"),
        ("card unformat", "unreadable", "card_unreadable"),
        ("card fail", "failing", "card_write_failed"),
    ):
        logger.hand(line, "wait 2.5")
        assert logger("status")["logger"]["card"] == card
        error = logger("record", "start", expect=1)["error"]
        assert error["code"] == code
        assert "Do not drop" in error["meaning"] and "RAM keeps the newest 19 s" in error["meaning"]
        assert logger("status")["logger"]["state"] == "failed"
        logger.hand("card insert", "wait 2.5")
        assert logger("status")["logger"]["card"] == "ready"


def test_a_drop_without_a_card_is_kept_until_it_is_fetched(logger: LoggerAtPort) -> None:
    logger.hand("card remove")
    logger("record", "start", expect=1)
    question = logger.read_output("log", "fetch", "ram", expect=2)
    assert "a drop after it would not be recorded" in question
    logger.hand("wait 1.5", "drop", "wait 300ms")
    # In the middle of the fall: the command waits, and ends nothing.
    refused = logger("log", "list", expect=4)["error"]
    assert "RAM" in refused["what"]
    fetched = logger("log", "fetch", "ram", expect=3)
    (copy,) = fetched["logs"]
    assert fetched["ram_released"] and not fetched["ram_holds_drop"]
    assert copy["name"] == f"RAM-{copy['session']}.BIN"
    assert copy["duration_s"] > 5.0 and copy["samples_lost"] == 0
    logger.hand("card insert", "seat", "wait 2.5")
    logger.record()


def test_ram_is_not_overwritten_and_not_given_up_by_accident(logger: LoggerAtPort) -> None:
    logger.hand("card remove")
    logger("record", "start", expect=1)
    logger.hand("wait 1", "drop", "wait 6", "card insert", "seat", "wait 2.5")
    status = logger.read_output("status")
    assert "RAM HOLDS A DROP" in status and "tfsat-host log fetch ram --port" in status
    assert logger("status")["logger"]["ram_holds_drop"] is True
    refused = logger("record", "start", expect=4)["error"]
    # A recording would overwrite the only copy of the drop.
    assert refused["code"] == "ram_holds_drop"
    assert "tfsat-host log fetch ram --port" in refused["next_step"]
    assert "RAM HOLDS A DROP" in logger.read_output("log", "list")
    # --yes alone is not enough for a drop.
    logger("log", "erase", "ram", "--yes", expect=4)
    assert logger("status")["logger"]["ram_holds_drop"] is True
    logger("log", "erase", "ram", "--yes", "--force")
    assert logger("status")["logger"]["ram_holds_drop"] is False
    logger.record()


def test_settings_change_what_is_named_and_nothing_else(logger: LoggerAtPort) -> None:
    assert logger("logger-settings")["origin"] == "factory"
    result = logger("logger-settings", "set", "--rate", 1000, "--dlpf", 2, "--clock")
    assert result["before"]["rate_hz"] == 280
    # Only the two that were named are changed.
    assert result["settings"] == {**result["before"], "rate_hz": 1000, "dlpf_cfg": 2}
    assert (result["origin"], result["clock_set"]) == ("uploaded", True)
    status = logger("status")["logger"]
    assert (status["rate_hz"], status["settings_origin"]) == (1000, "uploaded")
    # The host's own clock against the logger's.
    assert abs(status["clock_error_s"]) < 60
    refused = logger("logger-settings", "set", "--bus-khz", 100, expect=2)["error"]
    # At 100 kHz two bursts take 3.5 ms: more than a sample at 1 kHz.
    assert "3530 us, so at most 283 Hz" in refused["what"]
    refused = logger("logger-settings", "set", "--gyro-range", 300, expect=2)["error"]
    assert "250, 500, 1000, 2000 deg/s" in refused["what"]
    assert "No setting" in logger("logger-settings", "set", expect=2)["error"]["what"]
    assert logger("logger-settings", "show")["settings"] == result["settings"]
    output = logger.read_output("logger-settings")
    assert "Max. rate: 1000 Hz (I2C bus at 400 kHz)" in output


def test_the_monitor_shows_the_true_rate(served_logger: LoggerAtPort) -> None:
    served_logger("logger-settings", "set", "--rate", 1000)
    process = served_logger.run("monitor", "--for", 3, "--json", "--port", served_logger.robot.logger)
    last = json.loads(process.stdout.splitlines()[-1])["logger"]
    # A thousandth: the meter measures, it does not repeat the setting.
    assert last["measured_rate_hz"] == pytest.approx(1000.0, rel=0.001)
    assert last["rate_hz"] == 1000
    assert (last["card"], last["ram_holds_drop"]) == ("ready", False)


def test_what_a_served_robot_stores_is_there_at_the_next_start(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with Served() as served:
        first = LoggerAtPort(served, RunCli(tmp_path))
        first("logger-settings", "set", "--rate", 500)
        session = first.record()["session"]
        served.end()
    assert (tmp_path / "robot" / "card" / "DROP0001.BIN").read_bytes() == (
        tmp_path / "robot" / "SD.bin"
    ).read_bytes()
    with Served() as served:
        again = LoggerAtPort(served, RunCli(tmp_path))
        assert again("status")["logger"]["rate_hz"] == 500
        assert [entry["session"] for entry in again("log", "list")["logs"]] == [session]


def test_the_emulated_robots_card_and_settings_last(tfsat_host: RunCli) -> None:
    card = Path(os.environ["XDG_STATE_HOME"]) / "tfsat" / "emulated" / "card"
    assert tfsat_host.json("log", "list", "--emulated")["logs"] == []
    image = recording(4).image()
    card.mkdir(parents=True, exist_ok=True)
    # A file put onto the emulated card by hand.
    (card / "DROP0003.BIN").write_bytes(image)
    (entry,) = tfsat_host.json("log", "list", "--emulated")["logs"]
    assert entry["number"] == 3
    tfsat_host.json("log", "fetch", "3", "--emulated")
    assert (tfsat_host.folder / "DROP0003.BIN").read_bytes() == image
    tfsat_host.json("log", "erase", "3", "--emulated", "--yes")
    assert not list(card.iterdir())
    tfsat_host.json("logger-settings", "--emulated", "set", "--rate", "100")
    assert tfsat_host.json("logger-settings", "show", "--emulated")["settings"]["rate_hz"] == 100


def fetch_and_pull(logger: LoggerAtPort, part: Path) -> dict[str, Any]:
    """Starts to fetch recording 1 and pulls the cable once something of it is there; the error."""
    command = [sys.executable, "-m", "tfsat_host", "log", "fetch", "1", "--json"]
    with subprocess.Popen(
        [*command, "--port", str(logger.robot.logger)],
        cwd=logger.folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as fetching:
        # Until the first block has reached the disk.
        while fetching.poll() is None and not _has_begun(part):
            pass
        logger.hand("cable logger pull")
        output, _ = fetching.communicate(timeout=TIMEOUT_S)
    assert fetching.returncode == 1, output
    error: dict[str, Any] = json.loads(output)["error"]
    return error


def _has_begun(part: Path) -> bool:
    """Return whether a block of our format is on the disk."""
    try:
        with part.open("rb") as file:
            return file.read(4) == b"TFS1"
    # The file is there before its first block.
    except FileNotFoundError:
        return False
