"""A recording that does not reach its card: the arming, status, monitor and log say what it means for the drop."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.cli.process import RunCli
from tests.devices.log_transfer.served_robot import LoggerAtPort, robot_here


class Tower(LoggerAtPort):
    """Both boards, as the environment names them."""

    def __call__(self, *words: object, expect: int = 0) -> Any:
        return self.run.json(*words, expect=expect)

    def read_output(self, *words: object, expect: int = 0) -> str:
        process = self.run(*words, expect=expect)
        return " ".join((process.stdout + process.stderr).split())


@pytest.fixture
def tower(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Tower]:
    monkeypatch.chdir(tmp_path)
    with robot_here(monkeypatch) as robot:
        monkeypatch.setenv("TFSAT_SEQUENCER_PORT", str(robot.sequencer))
        monkeypatch.setenv("TFSAT_LOGGER_PORT", str(robot.logger))
        drop_tower = Tower(robot, RunCli(tmp_path))
        drop_tower("upload-sequence", 59, 70)
        yield drop_tower


def test_a_card_that_goes_in_the_lift_refuses_the_arming(tower: Tower) -> None:
    tower("record", "start")
    # Recording and ready: the arming takes it.
    assert tower("arm", "--yes")["recording"] is True
    tower("disarm")
    # The card goes while the robot hangs in the lift.
    tower.hand("card remove", "wait 1")

    refused = tower("arm", "--yes", expect=4)["error"]
    assert refused["what"] == "The logger records, but its card is missing."
    assert "RAM keeps the newest 19 s" in refused["meaning"] and "log fetch ram" in refused["meaning"]
    assert "tfsat-host arm --unrecorded" in refused["next_step"]
    assert tower("status")["sequencer"]["state"] == "safe"

    status_text = tower.read_output("status")
    assert "- Logger: The logger records, but its card is missing." in status_text
    assert "READY TO ARM" not in status_text
    assert status_text.startswith("BLOCKED: 1 item blocks a drop")
    assert tower("status")["sequencer"]["arm_refusal"]["what"] == refused["what"]
    monitored = tower.read_output("monitor", "--for", "0.5")
    assert "The logger records, but its card is missing. A drop now would not be on the card" in monitored

    # With --unrecorded the releaser has decided.
    armed = tower.read_output("arm", "--yes", "--unrecorded")
    assert "Warning: The logger records, but its card is missing." in armed and "Armed" in armed
    tower("disarm")
    tower.hand("card insert", "wait 1")
    assert tower("arm", "--yes")["recording"] is True
    assert tower("status")["logger"]["attention"] == []


def test_a_failed_recording_refuses_the_arming(tower: Tower) -> None:
    tower("logger-settings", "set", "--rate", 1000, "--file-mib", 16)
    tower.hand("card remove")
    tower("record", "start", expect=1)
    refused = tower("arm", "--yes", expect=4)["error"]
    assert refused["what"].startswith("The recording has failed: no SD card answers.")
    # 5 s at 1 kHz: RAM keeps as many samples, but not as much time.
    assert "RAM keeps the newest 5 s" in refused["meaning"], "at the rate in force"
    assert "leave no data" not in refused["meaning"]
    tower("record", "stop", expect=1)
    # After `record stop` RAM records no drop either.
    assert "would leave no data" in tower("arm", "--yes", expect=4)["error"]["meaning"]
    assert tower("arm", "--yes", "--unrecorded")["recording"] is False


def test_a_card_that_is_pulled_in_the_fall_is_shouted_about_at_once(tower: Tower) -> None:
    tower("record", "start")
    tower.hand("wait 1", "drop", "wait 500ms", "card remove", "wait 300ms")
    shout = "THE CARD IS MISSING AND THE DROP IS IN RAM ONLY"
    status_text = tower.read_output("status")
    assert status_text.startswith("DROP IN DANGER: it is in the logger's RAM only")
    assert f"- {shout}" in status_text and "keep it on" in status_text
    listed = tower("log", "list", expect=4)["error"]
    assert shout in listed["meaning"]
    # In the fall nobody must be told to stop the recording.
    assert "Wait a second" not in json.dumps(listed)
    assert shout in tower.read_output("monitor", "--for", "0.5")
    tower.hand("wait 5")
    assert tower("status")["logger"]["state"] in ("recording", "stopping")
    assert shout in tower.read_output("status")
    tower("record", "stop", expect=1)
    fetched = tower("log", "fetch", "all", expect=3)
    (copy,) = fetched["logs"]
    assert copy["in_ram"] and copy["samples_lost"] == 0
    assert fetched["ram_released"]
    listed = tower.read_output("log", "list")
    assert "Card: MISSING." in listed and "MiB free" not in listed
    assert "RAM is free for the next recording; what it held is safe: " in tower.read_output(
        "log", "erase", "ram", "--yes"
    )
