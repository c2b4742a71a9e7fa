"""A healthy robot is GO, is left as it was found, and the result is in the run's record."""

from __future__ import annotations

import json
import signal
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from tests.preflight.morning import CERTIFICATE, Morning, check, found_wrong, not_made
from tfsat_host.cli.main import main
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.file_hash import sha256_of
from tfsat_host.protocol.enums import LoggerState, SequencerState
from tfsat_host.run.record import entries_of, verify

DOCUMENT = Path(__file__).resolve().parents[2] / "docs" / "preflight.md"


def test_a_healthy_robot_is_go(morning: Morning) -> None:
    result = morning.preflight(expect=0)
    assert result["verdict"] == "go"
    assert (result["reasons"], found_wrong(result), not_made(result)) == ([], set(), set())
    assert all(one["sentence"] and one["evidence"] for one in result["checks"])
    assert result["emulated"] is True and result["left_on_the_boards"] == ""


def test_the_battery_is_never_a_fake_go(morning: Morning) -> None:
    battery = check(morning.preflight(expect=0), "battery")
    assert (battery["verdict"], battery["optional"], battery["blocks"]) == ("not-made", True, False)
    assert "not wired" in battery["sentence"].lower()


def test_the_result_is_in_the_runs_folder_and_signed(morning: Morning) -> None:
    shown = morning.preflight(expect=0)
    file = morning.folder / "preflight.json"
    written = json.loads(file.read_text(encoding="utf-8"))
    assert written["checks"] == shown["checks"] and written["verdict"] == "go"
    assert written["files"]["calibration"]["sha256"] == sha256_of(morning.folder / CERTIFICATE)
    assert written["files"]["maneuver"]["sha256"] == sha256_of(morning.folder / "maneuver.toml")
    entry = entries_of(morning.folder)[-1]
    assert entry.by.startswith("tfsat-host preflight ") and entry.by.endswith(": GO")
    assert (entry.files[0].name, entry.files[0].sha256) == ("preflight.json", shown["signed"])
    assert verify(morning.folder) == ()
    file.write_text(file.read_text(encoding="utf-8").replace('"go"', '"no-go"'), encoding="utf-8")
    assert [finding.name for finding in verify(morning.folder)] == ["preflight.json"]


def test_another_preflight_replaces_the_result_and_goes_on_in_the_record(morning: Morning) -> None:
    morning.preflight(expect=0)
    morning.robot.set_switch(1, False)
    morning.preflight(expect=4)
    assert [entry.by.rsplit(" ", 1)[1] for entry in entries_of(morning.folder)] == ["GO", "NO-GO"]
    assert verify(morning.folder) == ()


def test_both_boards_are_left_as_they_were(morning: Morning) -> None:
    morning.robot.card_slot.put(7, bytes(512 * 20))
    eeprom, memory = morning.robot.eeprom(), morning.robot.logger_memory()
    angles = morning.robot.joint_angles_deg()
    before, files = morning.sequencer().status(), morning.robot.card_slot.files()
    morning.preflight(expect=0)
    after, logger = morning.sequencer().status(), morning.logger().status()
    assert (after.state, after.arm_token) == (before.state, before.arm_token)
    assert (morning.robot.eeprom(), morning.robot.logger_memory()) == (eeprom, memory)
    assert morning.robot.card_slot.files() == files
    assert morning.robot.joint_angles_deg() == pytest.approx(angles, abs=1e-9)
    assert logger.state == LoggerState.STOPPED
    morning.robot.advance(2_000_000)
    morning.logger().start_recording(number=1)
    morning.logger().wait_for_card()
    assert set(morning.robot.card_slot.files()) == {7, 8}, "the trial's number is free again"


@pytest.mark.parametrize(
    ("moment", "number"),
    [
        ("start_recording", signal.SIGINT),
        ("wait_for_card", signal.SIGTERM),
        ("samples_of", signal.SIGINT),
        ("samples_of", signal.SIGHUP),
        ("stop_recording", signal.SIGINT),
        ("fetch_blocks", signal.SIGTERM),
    ],
)
def test_an_interrupted_preflight_leaves_no_recording_behind(
    morning: Morning, monkeypatch: pytest.MonkeyPatch, moment: str, number: signal.Signals
) -> None:
    """By Ctrl-C, by `kill`, by a terminal that is closed."""
    done: Any = getattr(LoggerClient, moment)
    calls = []

    def interrupted(self: LoggerClient, *args: Any, **kwargs: Any) -> Any:
        result = done(self, *args, **kwargs)
        calls.append(moment)
        if len(calls) == 1:
            signal.raise_signal(number)
        return result

    monkeypatch.setattr(LoggerClient, moment, interrupted)
    error = morning.preflight(expect=130)["error"]
    assert "no recording of this preflight is left" in error["meaning"]
    assert morning.robot.card_slot.files() == {}
    assert morning.logger().status().state == LoggerState.STOPPED
    assert not (morning.folder / "preflight.json").exists()


def test_an_armed_robot_is_refused_and_stays_armed(morning: Morning) -> None:
    morning.sequencer().arm()
    error = morning.preflight(expect=4)["error"]
    assert "armed" in error["what"] and "disarm" in error["next_step"]
    assert morning.sequencer().status().state == SequencerState.ARMED
    assert morning.logger().status().session == 0, "nothing was recorded"
    assert not (morning.folder / "preflight.json").exists()


def test_a_recording_that_runs_goes_on_and_is_said(morning: Morning) -> None:
    logger = morning.logger()
    session = logger.start_recording().session
    logger.wait_for_card()
    result = morning.preflight(expect=0)
    assert f"runs already (session {session:08x})" in check(result, "card-writing")["sentence"]
    status = morning.logger().status()
    assert (status.state, status.session) == (LoggerState.RECORDING, session)


def test_a_file_of_somebody_else_is_not_overwritten(morning: Morning) -> None:
    (morning.folder / "preflight.json").write_text("{}", encoding="utf-8")
    assert "was not made by this command" in morning.preflight(expect=1)["error"]["what"]
    assert (morning.folder / "preflight.json").read_text(encoding="utf-8") == "{}"


def test_a_damaged_record_is_an_error_and_the_result_is_shown_all_the_same(morning: Morning) -> None:
    (morning.folder / "record.json").write_text("{", encoding="utf-8")
    result = morning.preflight(expect=1)
    assert (result["verdict"], result["signed"]) == ("go", None)


def test_limits_say_which_way_they_go(morning: Morning) -> None:
    """With the keys of `tfsat-host envelope --json`."""
    pause, envelope = (check(morning.preflight(expect=0), name)["evidence"] for name in ("pause", "envelope"))
    assert {one["at_most"] for one in pause.values()} == {False}
    assert envelope["envelope"]["at_most"] is True
    assert {tuple(one) for one in envelope.values()} == {("value", "limit", "at_most", "beyond", "unit")}


@pytest.mark.parametrize(
    ("apart_s", "words"),
    [(-0.02, "within 0.1 s of it"), (0.08, "within 0.1 s of it"), (1.2, "+1.2 s off it")],
)
def test_the_loggers_clock_beside_the_computers(
    morning: Morning, monkeypatch: pytest.MonkeyPatch, apart_s: float, words: str
) -> None:
    def computers_s() -> float:
        return morning.logger().status().unix_us / 1e6 - apart_s

    monkeypatch.setattr("tfsat_host.cli.preflight_boards.time", SimpleNamespace(time=computers_s))
    assert words in check(morning.preflight(expect=0), "clock")["sentence"]


def test_a_person_reads_every_check_and_go(morning: Morning) -> None:
    assert main(["preflight", str(morning.folder)]) == 0
    said = morning.capture.readouterr().out
    assert "\nGO: " in said and "tfsat-host arm" in said and "\x1b" not in said


def test_a_person_reads_why_not_and_what_to_type(morning: Morning) -> None:
    morning.set_clock = None
    assert main(["preflight", str(morning.folder)]) == 4
    said = morning.capture.readouterr().out
    assert morning.logger().status().unix_us == 0, "it was asked for, not set"
    assert "\nNO-GO: clock." in said and "tfsat-host logger-settings set --clock" in said


def test_a_run_is_a_folder(morning: Morning) -> None:
    assert main(["preflight", str(morning.folder / "nowhere")]) == 2


def test_the_document_has_a_row_for_every_check_and_no_other(morning: Morning) -> None:
    rows = {
        line.split("|")[1].strip().strip("`")
        for line in DOCUMENT.read_text(encoding="utf-8").splitlines()
        if line.startswith("| `")
    }
    assert rows == {one["name"] for one in morning.preflight(expect=0)["checks"]}
