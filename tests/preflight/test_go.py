"""A healthy robot is GO, is left as it was found, and the result is in the run's record."""

from __future__ import annotations

import json
import signal
from types import SimpleNamespace
from typing import Any

import pytest

from tests.paths import DOCS
from tests.preflight.ready_robot import CERTIFICATE, ReadyRobot, check, found_wrong, not_made
from tfsat_host.cli.main import main
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.file_hash import sha256_of
from tfsat_host.protocol.enums import LoggerState, SequencerState
from tfsat_host.run.signed_record import entries_of, verify

DOCUMENT = DOCS / "preflight.md"


def test_a_healthy_robot_is_go_and_its_result_is_signed(
    ready: ReadyRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    # As long as with a real robot; the fixture makes it shorter.
    monkeypatch.setattr("tfsat_host.preflight.logger_queries.WATCH_S", 6.0)
    result = ready.preflight(expect=0)
    assert (result["verdict"], result["reasons"], found_wrong(result), not_made(result)) == (
        "go",
        [],
        set(),
        set(),
    )
    assert all(entry["sentence"] and entry["evidence"] for entry in result["checks"])
    assert result["emulated"] is True and result["left_on_the_boards"] == ""
    assert check(result, "gyros-present")["evidence"]["samples"] == pytest.approx(1680, abs=10)

    battery = check(result, "battery")
    assert (battery["verdict"], battery["optional"], battery["blocks"]) == ("not-made", True, False)
    assert "not wired" in battery["sentence"].lower(), "never a GO that no one measured"

    pause, envelope = (check(result, name)["evidence"] for name in ("pause", "envelope"))
    # A pause may be too short, an envelope too wide.
    assert {quantity["at_most"] for quantity in pause.values()} == {False}
    assert envelope["envelope"]["at_most"] is True
    keys = ("value", "limit", "at_most", "beyond", "unit")
    assert {tuple(quantity) for quantity in envelope.values()} == {keys}, (
        "those of tfsat-host envelope --json"
    )

    # The handbook has a row for every check and no check that there is not.
    lines = DOCUMENT.read_text(encoding="utf-8").splitlines()
    rows = {line.split("|")[1].strip().strip("`") for line in lines if line.startswith("| `")}
    assert rows == {entry["name"] for entry in result["checks"]}

    file = ready.folder / "preflight.json"
    written = json.loads(file.read_text(encoding="utf-8"))
    assert written["checks"] == result["checks"] and written["verdict"] == "go"
    assert written["files"]["calibration"]["sha256"] == sha256_of(ready.folder / CERTIFICATE)
    assert written["files"]["maneuver"]["sha256"] == sha256_of(ready.folder / "maneuver.toml")
    # The signature stands for the file as it is: one word changed, and it is found.
    entry = entries_of(ready.folder)[-1]
    assert entry.by.startswith("tfsat-host preflight ") and entry.by.endswith(": GO")
    assert (entry.files[0].name, entry.files[0].sha256) == ("preflight.json", result["signed"])
    assert verify(ready.folder) == ()
    file.write_text(file.read_text(encoding="utf-8").replace('"go"', '"no-go"'), encoding="utf-8")
    assert [finding.name for finding in verify(ready.folder)] == ["preflight.json"]


def test_another_preflight_replaces_the_result_and_goes_on_in_the_record(ready: ReadyRobot) -> None:
    ready.preflight(expect=0)
    # The robot loosens in its releaser: a switch opens.
    ready.robot.set_switch(1, False)
    ready.preflight(expect=4)
    assert [entry.by.rsplit(" ", 1)[1] for entry in entries_of(ready.folder)] == ["GO", "NO-GO"]
    assert verify(ready.folder) == ()


def test_both_boards_are_left_as_they_were(ready: ReadyRobot) -> None:
    # A recording of before, which the trial must neither overwrite nor delete.
    ready.robot.card_slot.put(7, bytes(512 * 20))
    eeprom, memory = ready.robot.eeprom(), ready.robot.logger_memory()
    angles = ready.robot.joint_angles_deg()
    before, files = ready.sequencer().status(), ready.robot.card_slot.files()
    ready.preflight(expect=0)
    after, logger = ready.sequencer().status(), ready.logger().status()
    assert (after.state, after.arm_token) == (before.state, before.arm_token)
    assert (ready.robot.eeprom(), ready.robot.logger_memory()) == (eeprom, memory)
    assert ready.robot.card_slot.files() == files
    # No servo moved.
    assert ready.robot.joint_angles_deg() == pytest.approx(angles, abs=1e-9)
    assert logger.state == LoggerState.STOPPED
    # The next recording takes the number after the old one's.
    ready.robot.advance(2_000_000)
    ready.logger().start_recording(number=1)
    ready.logger().wait_for_card()
    assert set(ready.robot.card_slot.files()) == {7, 8}, "the trial's number is free again"


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
    ready: ReadyRobot, monkeypatch: pytest.MonkeyPatch, moment: str, number: signal.Signals
) -> None:
    """Interrupt a preflight by Ctrl-C, by `kill` or by closing the terminal: no recording is left."""
    original: Any = getattr(LoggerClient, moment)
    calls = []

    def interrupt_call(self: LoggerClient, *args: Any, **kwargs: Any) -> Any:
        result = original(self, *args, **kwargs)
        calls.append(moment)
        # Only the first call is interrupted: tidying up calls some of them again.
        if len(calls) == 1:
            signal.raise_signal(number)
        return result

    monkeypatch.setattr(LoggerClient, moment, interrupt_call)
    error = ready.preflight(expect=130)["error"]
    assert "no recording of this preflight left on the card" in error["meaning"]
    assert ready.robot.card_slot.files() == {}
    assert ready.logger().status().state == LoggerState.STOPPED
    assert not (ready.folder / "preflight.json").exists()


def test_an_armed_robot_is_refused_and_stays_armed(ready: ReadyRobot) -> None:
    ready.sequencer().arm()
    error = ready.preflight(expect=4)["error"]
    assert "armed" in error["what"] and "disarm" in error["next_step"]
    assert ready.sequencer().status().state == SequencerState.ARMED
    assert ready.logger().status().session == 0, "nothing was recorded"
    assert not (ready.folder / "preflight.json").exists()


def test_a_recording_that_runs_goes_on_and_is_said(ready: ReadyRobot) -> None:
    logger = ready.logger()
    # The person started it, so the preflight must not stop it.
    session = logger.start_recording().session
    logger.wait_for_card()
    result = ready.preflight(expect=0)
    assert f"runs already (session {session:08x})" in check(result, "card-writing")["sentence"]
    status = ready.logger().status()
    assert (status.state, status.session) == (LoggerState.RECORDING, session)


def test_a_file_of_somebody_else_is_not_overwritten(ready: ReadyRobot) -> None:
    # Without the marks of a preflight, it may be anything.
    (ready.folder / "preflight.json").write_text("{}", encoding="utf-8")
    assert "was not made by this command" in ready.preflight(expect=1)["error"]["what"]
    assert (ready.folder / "preflight.json").read_text(encoding="utf-8") == "{}"


def test_a_damaged_record_is_an_error_and_the_result_is_shown_all_the_same(ready: ReadyRobot) -> None:
    (ready.folder / "record.json").write_text("{", encoding="utf-8")
    result = ready.preflight(expect=1)
    assert (result["verdict"], result["signed"]) == ("go", None)


@pytest.mark.parametrize(
    ("apart_s", "words"),
    # A clock beside the computer's is said, but 1.2 s do not block a drop.
    [(-0.02, "within 0.1 s of it"), (1.2, "+1.2 s off it")],
)
def test_the_loggers_clock_beside_the_computers(
    ready: ReadyRobot, monkeypatch: pytest.MonkeyPatch, apart_s: float, words: str
) -> None:
    def computers_s() -> float:
        return ready.logger().status().unix_us / 1e6 - apart_s

    monkeypatch.setattr("tfsat_host.cli.preflight_report.time", SimpleNamespace(time=computers_s))
    assert words in check(ready.preflight(expect=0), "clock")["sentence"]


def test_a_person_reads_every_check_and_go(ready: ReadyRobot) -> None:
    assert main(["preflight", str(ready.folder)]) == 0
    text = ready.capture.readouterr().out
    verdict = text.splitlines()[0]
    # The verdict is the first line and the last: whichever a person sees, it is the same.
    assert verdict.startswith("GO: 27 of 28 checks passed") and text.splitlines()[-1] == verdict
    assert "Not checked by design: battery" in text and len(text.splitlines()) <= 30
    assert "card-writing" not in text
    assert main(["preflight", str(ready.folder), "--full"]) == 0
    assert "card-writing" in ready.capture.readouterr().out
    assert "tfsat-host arm" in text and "\x1b" not in text


def test_a_person_reads_why_not_and_what_to_type(ready: ReadyRobot) -> None:
    # The fixture would set the clock first.
    ready.set_clock = None
    assert main(["preflight", str(ready.folder)]) == 4
    text = ready.capture.readouterr().out
    assert ready.logger().status().unix_us == 0, "it was asked for, not set"
    assert text.startswith("NO-GO: clock (26 of 28 checks passed")
    assert "- clock: Logger's clock: not set since power on" in text
    assert text.splitlines()[-1] == text.splitlines()[0]
    text = " ".join(text.split())
    assert "tfsat-host logger-settings set --clock" in text


def test_a_run_is_a_folder(ready: ReadyRobot) -> None:
    assert main(["preflight", str(ready.folder / "nowhere")]) == 2
