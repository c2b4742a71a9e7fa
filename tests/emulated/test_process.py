"""`tfsat-host emulate` and other commands next to it, as processes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.cli.process import RunCli
from tests.emulated.served import TIMEOUT_S, Served
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.serial_ports import PortError, open_serial
from tfsat_host.devices.transport import SerialTransport
from tfsat_host.emulated.imperfections import Imperfections, draw, draw_as_built
from tfsat_host.emulated.state import served_by_dead_process

PAPER = [(0.70, 1, 59.0), (1.05, 2, 70.0), (1.47, 1, -59.0), (1.82, 2, -70.0)]


def left_in_folder() -> list[str]:
    return sorted(path.name for path in Path("robot").iterdir())


def test_the_whole_chain_through_the_ports(served_robot: Served, tfsat_host: RunCli) -> None:
    uploaded = tfsat_host.json("upload-sequence", 59, 70, "--port", served_robot.sequencer)
    assert uploaded["verified"] is True
    # Times of the paper's experiment sequence.
    assert [(s["t_s"], s["joint"], s["angle_deg"]) for s in uploaded["schedule"]] == PAPER

    armed = tfsat_host.json("arm", "--yes", "--port", served_robot.sequencer)
    assert armed["state"] == "armed"
    logger = LoggerClient.connect(SerialTransport(str(served_robot.logger)))
    logger.start_recording()
    # Drop by the control line: no person is at the tower.
    assert served_robot.control("wait 500ms", "drop", "wait still", "wait 500ms") == [
        "ok", "ok falls for 2.5 s", "ok", "ok",
    ]  # fmt: skip
    logger.stop_recording()
    logger.close()
    assert tfsat_host.json("status", "--port", served_robot.sequencer)["sequencer"]["state"] == "done"
    (copied,) = served_robot.control("card flight.bin")
    assert copied.startswith("ok ")
    served_robot.end()

    # The file that an end leaves is the one that the control line copied.
    assert Path("robot/SD.bin").read_bytes() == Path("flight.bin").read_bytes()
    decoded = tfsat_host.json("decode", "robot/SD.bin")
    assert decoded["verdict"] == "complete"
    # Three seconds at 280 Hz at the least.
    assert decoded["samples"] > 3.0 * 280


def test_the_eeprom_outlives_the_process(served_robot: Served, tfsat_host: RunCli) -> None:
    tfsat_host("upload-sequence", 40, 50, "--port", served_robot.sequencer)
    served_robot.end()
    # Ports and socket go with the process, the EEPROM stays.
    assert left_in_folder() == ["sequencer.eeprom"]
    with Served("--sequencer", served_robot.announced["image"]) as again:
        state = tfsat_host.json("status", "--port", again.sequencer)["sequencer"]
        again.end(signal.SIGINT)
    assert state["maneuver"]["origin"] == "uploaded"
    assert [stroke["angle_deg"] for stroke in state["maneuver"]["strokes"]] == [40.0, 50.0, -40.0, -50.0]


def test_power_off_forgets_the_arming(served_robot: Served, tfsat_host: RunCli) -> None:
    tfsat_host("upload-sequence", 59, 70, "--port", served_robot.sequencer)
    tfsat_host("arm", "--yes", "--port", served_robot.sequencer)
    # RAM goes with the power: an armed board must not arm itself again.
    served_robot.control("power sequencer off", "wait 100ms", "power sequencer on")
    assert tfsat_host.json("status", "--port", served_robot.sequencer)["sequencer"]["state"] != "armed"


def test_a_command_for_the_other_board_is_refused_by_name(native: Served, tfsat_host: RunCli) -> None:
    refused = tfsat_host("upload-sequence", 59, 70, "--port", native.logger, expect=1)
    assert "is the logger; this command is for the sequencer" in refused.stderr


def test_a_port_that_another_program_has_is_busy(native: Served, tfsat_host: RunCli) -> None:
    # Opened exclusively, as every tfsat program opens a port.
    other = open_serial(str(native.sequencer))
    refused = tfsat_host("upload-sequence", 59, 70, "--port", native.sequencer, expect=1)
    assert "in use by another program" in refused.stderr
    other.close()
    tfsat_host("upload-sequence", 59, 70, "--port", native.sequencer)


def test_a_cable_pulled_under_a_client_is_a_clear_error(native: Served, tfsat_host: RunCli) -> None:
    # The port is open when the cable goes.
    logger = LoggerClient.connect(SerialTransport(str(native.logger)))
    assert native.control("cable logger pull") == ["ok"]
    with pytest.raises(PortError) as caught:
        logger.status()
    assert "was lost" in caught.value.what
    assert "Check the cable" in caught.value.next_step
    logger.close()
    missing = tfsat_host("status", "--port", native.logger, expect=1)
    assert "does not exist" in missing.stderr
    native.control("cable logger plug")
    assert tfsat_host.json("status", "--port", native.logger)["logger"]["device"]["board"] == "logger"


def test_the_environment_names_both_ports(native: Served, tfsat_host: RunCli) -> None:
    environ = {
        "TFSAT_SEQUENCER_PORT": native.announced["sequencer"],
        "TFSAT_LOGGER_PORT": native.announced["logger"],
    }
    # Both ports from the environment: no port option is given.
    assert set(tfsat_host.json("status", environ=environ)) == {"sequencer", "logger"}


def test_commands_find_its_ports_and_ports_lists_them(native: Served, tfsat_host: RunCli) -> None:
    listed = {row["board"]: row["port"] for row in tfsat_host.json("ports")["ports"] if row["board"]}
    assert listed == {board: native.announced[board] for board in ("sequencer", "logger")}
    assert "emulated robot" in tfsat_host("ports").stdout
    assert set(tfsat_host.json("status")) == {"sequencer", "logger"}
    assert "No sequencer is plugged in: this is the emulated robot in" in tfsat_host("status").stderr
    assert "plugged in" not in tfsat_host("status", "--port", native.sequencer).stderr
    # A pulled cable has no port.
    native.control("cable logger pull")
    assert "No logger found" in tfsat_host("record", "start", expect=1).stderr
    native.control("cable logger plug")


def test_a_second_server_is_refused_and_the_first_goes_on(native: Served, tfsat_host: RunCli) -> None:
    refused = tfsat_host("emulate", expect=1)
    assert f"process {native.process.pid}" in refused.stderr
    # The first server did not notice the second one.
    assert native.control("angles") == ["ok 0.00 0.00 0.00"]


def test_an_upload_that_was_read_back_outlives_a_kill(served_robot: Served, tfsat_host: RunCli) -> None:
    assert tfsat_host.json("upload-sequence", 40, 50, "--port", served_robot.sequencer)["verified"] is True
    # What was read back must be on disk before the reply, even if the process dies.
    served_robot.process.kill()
    served_robot.process.wait(timeout=TIMEOUT_S)
    with Served("--sequencer", served_robot.announced["image"]) as again:
        maneuver = tfsat_host.json("status", "--port", again.sequencer)["sequencer"]["maneuver"]
        again.end()
    assert [stroke["angle_deg"] for stroke in maneuver["strokes"]] == [40.0, 50.0, -40.0, -50.0]


def test_the_ports_of_a_killed_run_lead_nowhere(native: Served) -> None:
    """Detect the dangling ports of a killed server, even after other programs took new pseudo-terminals.

    The pseudo-terminal's number goes to the next program that asks for one.
    """
    assert native.sequencer.is_char_device()
    assert not served_by_dead_process(native.sequencer)
    native.process.kill()
    native.process.wait(timeout=TIMEOUT_S)
    # New pseudo-terminals take the free numbers: the links could lead to one of them.
    terminals = [os.openpty() for _ in range(4)]
    assert native.sequencer.is_symlink() and not native.sequencer.exists()
    assert served_by_dead_process(native.sequencer) and served_by_dead_process(native.logger)
    for pair in terminals:
        for descriptor in pair:
            os.close(descriptor)


def test_a_robot_file_that_is_not_there_leaves_no_folder(tfsat_host: RunCli) -> None:
    assert "none.toml" in tfsat_host("emulate", "--robot", "none.toml", expect=1).stderr
    # Nothing is created before the robot file is read.
    assert list(tfsat_host.folder.iterdir()) == []


def test_each_start_gives_other_sessions_unless_a_seed_is_given(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    def session(*options: str) -> int:
        with Served(*options) as process:
            logger = LoggerClient.connect(SerialTransport(str(process.logger)))
            started = logger.start_recording()
            logger.close()
            process.end()
        Path("robot/SD.bin").unlink()
        return started.session

    # Each start draws a seed of its own.
    assert session() != session()
    assert session("--seed", "3") == session("--seed", "3")


@pytest.mark.parametrize(("options", "draw_imperfections"), [((), draw_as_built), (("--exact",), draw)])
def test_the_robot_as_built_is_served_unless_an_exact_one_is_asked_for(
    options: tuple[str, ...],
    draw_imperfections: Callable[[int], Imperfections],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    with Served("--seed", "3", *options) as process:
        assert process.announced["as_built"] is not bool(options)
        assert process.control("wait 500ms") == ["ok"]  # the gyros' low-pass settles
        logger = LoggerClient.connect(SerialTransport(str(process.logger)))
        with logger.live() as scales:
            (first, *_) = logger.live_samples()
        logger.close()
        process.end()
    bias_deg_s = np.rad2deg(draw_imperfections(3).gyro_bias_rad_s)
    readings_deg_s = np.array([imu.gyro for imu in first.decode().sample.imu]) / scales.gyro_lsb_per_deg_s
    # 0.3 deg/s: far above one reading's noise, far below most drawn biases.
    assert np.abs(readings_deg_s - bias_deg_s).max() < 0.3


def test_a_calibration_made_with_emulated_is_of_the_served_robot(native: Served, tfsat_host: RunCli) -> None:
    tfsat_host("calibrate", "bias", "--emulated", "--yes")
    certificate = read_calibration(tfsat_host.folder / "calibration-emulated.toml")
    identity = tfsat_host.json("status", "--port", native.logger)["logger"]["device"]
    assert identity["serial"] == certificate.subject.logger_serial


def test_a_killed_run_leaves_nothing_in_the_way(native: Served, tfsat_host: RunCli) -> None:
    native.process.kill()
    native.process.wait(timeout=TIMEOUT_S)
    # The link still stands there, and leads nowhere.
    assert native.sequencer.is_symlink()
    with Served() as again:
        assert tfsat_host.json("status", "--port", again.sequencer)["sequencer"]["state"] == "safe"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signals_end_it_in_order(native: Served, number: signal.Signals) -> None:
    native.end(number)
    assert left_in_folder() == ["sequencer.eeprom"]


def test_quit_over_the_socket_ends_it(native: Served) -> None:
    assert native.control("quit") == ["ok"]
    assert native.process.wait(timeout=TIMEOUT_S) == 0


def test_typed_lines_are_answered_and_their_end_ends_nothing(native: Served) -> None:
    assert native.process.stdin is not None and native.process.stderr is not None
    native.process.stdin.write("angles\nhold 9\n")
    native.process.stdin.close()
    # Popen would flush the closed pipe once more.
    native.process.stdin = None
    assert native.process.stderr.readline() == "ok 0.00 0.00 0.00\n"
    assert native.process.stderr.readline().startswith("error Bodies [9]")
    assert native.control("wait 20ms") == ["ok"]
    native.end()


# A closed descriptor is not the same as an empty one.
@pytest.mark.parametrize("closed", ["</dev/null", "<&-"])
def test_without_standard_input_it_runs_until_its_time_is_over(tfsat_host: RunCli, closed: str) -> None:
    script = f'"{sys.executable}" -m tfsat_host emulate --for 0.05 {closed}'
    process = subprocess.run(
        ["sh", "-c", script],
        cwd=tfsat_host.folder,
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
    )
    assert process.returncode == 0, process.stderr
    assert "upload-sequence 59 70" in process.stdout


def test_a_running_card_file_is_never_written_over_a_file_of_the_user(native: Served) -> None:
    Path("mine.bin").write_text("mine")
    logger = LoggerClient.connect(SerialTransport(str(native.logger)))
    logger.start_recording()
    replies = native.control("wait 200ms", "card mine.bin", "card", "card", "card no/such/folder.bin")
    logger.close()
    # A file of the user is never replaced by the card's.
    assert replies[1].startswith("error") and "mine.bin exists" in replies[1]
    assert replies[2].endswith("robot/SD.bin") and replies[3].endswith("robot/SD.bin")
    assert replies[4].startswith("error") and "No such file" in replies[4]
    assert Path("mine.bin").read_text() == "mine"


@pytest.mark.parametrize(
    ("arguments", "expected_text"),
    [
        (("--seed", "-1"), "no seed"),
        (("--for", "0"), "no duration"),
        (("--for", "nan"), "no duration"),
        (("--sequencer", "pic"), "there is no --sequencer 'pic'"),
    ],
)
def test_bad_options_are_usage_errors(
    tfsat_host: RunCli, arguments: tuple[str, str], expected_text: str
) -> None:
    assert expected_text in tfsat_host("emulate", *arguments, expect=2).stderr
    # Nothing is created for a usage error.
    assert list(tfsat_host.folder.iterdir()) == []


def test_a_damaged_eeprom_file_is_said_and_kept(tfsat_host: RunCli) -> None:
    image = tfsat_host.folder / "robot" / "sequencer.eeprom"
    image.parent.mkdir()
    image.write_bytes(b"short")
    assert "5 bytes" in tfsat_host("emulate", expect=1).stderr
    # The damaged image stays: it may be the only copy.
    assert image.read_bytes() == b"short"
