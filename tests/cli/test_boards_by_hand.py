"""The commands of a drop by hand, as processes next to a served robot."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.cli.process import RunCli
from tests.emulated.served import Served


@pytest.fixture
def robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Served]:
    monkeypatch.chdir(tmp_path)
    with Served() as process:
        yield process


@pytest.fixture
def both(robot: Served) -> dict[str, str]:
    # Both boards by the environment, as on the day of a drop.
    return {
        "TFSAT_SEQUENCER_PORT": robot.announced["sequencer"],
        "TFSAT_LOGGER_PORT": robot.announced["logger"],
    }


def test_a_drop_is_recorded_by_hand(robot: Served, both: dict[str, str], tfsat_host: RunCli) -> None:
    tfsat_host("upload-sequence", 59, 70, environ=both)
    silent = tfsat_host("arm", "--yes", "--json", environ=both)
    # Armed without a recording: possible, but said.
    assert "is not recording" in silent.stderr
    assert '"recording": false' in silent.stdout
    tfsat_host("disarm", environ=both)

    started = tfsat_host.json("record", "start", "--yes", environ=both)
    assert started["state"] == "recording"
    assert started["blocks_written"] > 0
    assert started["device"]["port"] == both["TFSAT_LOGGER_PORT"]
    armed = tfsat_host("arm", "--yes", "--json", environ=both)
    assert "not recording" not in armed.stderr
    assert '"recording": true' in armed.stdout
    robot.control("drop", "wait still", "wait 500ms")
    stopped = tfsat_host.json("record", "stop", environ=both)
    assert (stopped["state"], stopped["session"]) == ("stopped", started["session"])
    # A drop of 2.5 s at 280 Hz at the least.
    assert stopped["samples"] > 2.5 * 280
    assert stopped["samples_dropped"] == 0
    robot.control("card drop.bin")
    decoded = tfsat_host.json("decode", "drop.bin")
    # The file has exactly the samples that the logger counted.
    assert (decoded["verdict"], decoded["samples"]) == ("complete", stopped["samples"])


def test_recording_twice_and_stopping_nothing(robot: Served, tfsat_host: RunCli) -> None:
    nothing = tfsat_host("record", "stop", "--port", robot.logger, expect=1)
    assert "no recording to stop" in nothing.stderr
    assert "waiting" not in nothing.stderr, "there is nothing to wait for"
    assert f"tfsat-host status --port {robot.logger}" in nothing.stderr
    people = tfsat_host("record", "start", "--port", robot.logger)
    assert f"tfsat-host record stop --port {robot.logger}" in people.stdout
    error = tfsat_host.json("record", "start", "--port", robot.logger, expect=4)["error"]
    assert error["code"] == "wrong_state"
    assert error["what"].startswith(
        f"The logger is recording already: session {_session(robot, tfsat_host)}, "
    )
    assert "That recording goes on" in error["meaning"]
    assert error["next_step"].startswith(f"To see its state: tfsat-host status --port {robot.logger}\n")
    assert tfsat_host.json("status", "--port", robot.logger)["logger"]["state"] == "recording"


def _session(robot: Served, tfsat_host: RunCli) -> str:
    session: str = tfsat_host.json("status", "--port", robot.logger)["logger"]["session"]
    return session


def test_a_logger_that_is_not_named_is_not_asked(robot: Served, tfsat_host: RunCli) -> None:
    tfsat_host("upload-sequence", 59, 70, "--port", robot.sequencer)
    armed = tfsat_host("arm", "--yes", "--json", "--port", robot.sequencer)
    assert "Warning: The logger was not asked whether it records" in armed.stderr
    assert "set TFSAT_LOGGER_PORT=PORT" in armed.stderr
    assert '"recording": null' in armed.stdout


def test_arming_is_refused_before_anybody_is_asked(robot: Served, tfsat_host: RunCli) -> None:
    """Without --yes and without a terminal the question itself would be a usage error, exit code 2."""
    port = ("--port", robot.sequencer)
    tfsat_host("upload-sequence", 59, 70, *port)
    # Without a terminal nobody can be asked: a usage error.
    assert tfsat_host("arm", *port, expect=2).stderr
    robot.control("release 2")
    error = tfsat_host.json("arm", *port, expect=4)["error"]
    # The open switch is told before the question.
    assert (error["code"], error["number"]) == ("switch_open", 15)
    assert error["what"] == "A release switch is open (switch 2)."
    robot.control("seat")
    device = tfsat_host.json("arm", "--yes", *port)["device"]
    assert device["port"] == str(robot.sequencer)
    error = tfsat_host.json("arm", *port, expect=4)["error"]
    assert error["code"] == "wrong_state"
    assert error["what"].startswith("The sequencer is armed;")
    assert error["next_step"] == f"tfsat-host disarm --port {robot.sequencer}, then the same command again."
    upload = tfsat_host("upload-sequence", 59, 70, *port, expect=4)
    assert "The sequencer is armed;" in upload.stderr
    disarmed = tfsat_host.json("disarm", *port)
    assert disarmed["state"] == "safe"
    assert disarmed["same_protocol"] is True
    assert disarmed["device"]["port"] == str(robot.sequencer)


@pytest.mark.parametrize(
    ("command", "port"), [("arm", "sequencer"), ("record start", "logger"), ("record stop", "logger")]
)
def test_what_would_end_with_the_process_is_refused(tfsat_host: RunCli, command: str, port: str) -> None:
    refused = tfsat_host(*command.split(), "--emulated", "--yes", expect=4)
    assert refused.stdout == ""
    assert "lives in this process only" in refused.stderr
    assert f"tfsat-host {command} --port robot/{port}" in refused.stderr


def test_status_goes_on_when_a_board_does_not_speak(
    robot: Served, both: dict[str, str], tfsat_host: RunCli
) -> None:
    robot.control("power sequencer off")
    status = tfsat_host.json("status", environ=both)
    # One board is missing: the other one is shown all the same.
    assert status["sequencer"]["error"]["code"] == "missing"
    assert status["logger"]["state"] == "idle"
    robot.control("power logger off")
    # With neither board there is nothing to show.
    assert tfsat_host.json("status", environ=both, expect=1)["error"]["code"] == "missing"


def test_status_of_swapped_and_of_equal_variables(
    robot: Served, both: dict[str, str], tfsat_host: RunCli
) -> None:
    sequencer, logger = both.values()
    swapped = {"TFSAT_SEQUENCER_PORT": logger, "TFSAT_LOGGER_PORT": sequencer}
    process = tfsat_host("status", "--json", environ=swapped)
    assert f"TFSAT_SEQUENCER_PORT={logger} is the logger's port, not the sequencer's" in process.stderr
    assert f"TFSAT_LOGGER_PORT={sequencer} is the sequencer's port, not the logger's" in process.stderr
    # Swapped variables are said, and both boards are asked nevertheless.
    status = tfsat_host.json("status", environ=swapped)
    assert (status["sequencer"]["state"], status["logger"]["state"]) == ("safe", "idle")
    equal = {"TFSAT_SEQUENCER_PORT": logger, "TFSAT_LOGGER_PORT": str(robot.logger)}
    process = tfsat_host("status", "--json", environ=equal)
    assert "name the same port" in process.stderr
    assert '"sequencer": null' in process.stdout


def test_status_and_upload_agree_when_the_maneuver_ends(tfsat_host: RunCli) -> None:
    uploaded = tfsat_host.json("upload-sequence", 59, 70, "--emulated")
    maneuver = tfsat_host.json("status", "--emulated")["sequencer"]["maneuver"]
    assert maneuver["end_s"] == uploaded["end_s"] == 2.23
    # Both round the same microseconds.
    assert maneuver["end_us"] == 2_231_765


@pytest.mark.parametrize("command", ["status", "arm", "disarm", "upload-sequence 59 70", "record start"])
def test_an_empty_port_is_a_usage_error(tfsat_host: RunCli, command: str) -> None:
    assert "port is empty" in tfsat_host(*command.split(), "--port", "", expect=2).stderr


@pytest.mark.parametrize("command", ["upload-sequence", "rehearse"])
def test_an_empty_file_name_is_a_usage_error(tfsat_host: RunCli, command: str) -> None:
    assert "file is empty" in tfsat_host(command, "--file", "", expect=2).stderr
