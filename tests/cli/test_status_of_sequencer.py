"""What `status` tells of the sequencer: all of its self-report, for people and as JSON."""

from __future__ import annotations

import re
from typing import Any

import pytest

from tests.arduino_sequencer.conftest import board, board_library, fresh_board, new_board
from tests.cli.board_on_pty import BoardOnPty
from tests.cli.process import RunCli
from tests.fixtures.sequencer.board import Board, PinHold, ResetCause
from tests.fixtures.sequencer.cable import NEW, client, connect
from tests.fixtures.sequencer.pulses import release
from tfsat_host.devices.board_errors import BoardRefusal
from tfsat_host.present.boards_status import BOARDS, BoardsStatus
from tfsat_host.present.sequencer_state import SEQUENCER_DETAILS, SEQUENCER_FACTS, SequencerReport
from tfsat_host.protocol.limits import JOG_CONFIRM
from tfsat_host.protocol.messages import JogReply, JogRequest
from tfsat_host.quantity import Quantity, record

__all__ = ["board", "board_library", "fresh_board", "new_board"]


class Told:
    """Both voices of the command about the same board."""

    def __init__(self, board: Board, tfsat_host: RunCli) -> None:
        with BoardOnPty(board) as served:
            self.json = tfsat_host.json("status", "--port", served.port)["sequencer"]
            text = tfsat_host("status", "--full", "--port", served.port).stdout
        self.verdict = text.splitlines()[0]
        assert text.splitlines()[-1] == self.verdict, "first and last"
        self.lines = " ".join(text.split())
        # A label begins a line, a bullet is indented by two, and what goes on by more.
        joined = re.sub(r"\n {2,}(?!- )", " ", text)
        self.bullets = [line[4:] for line in joined.splitlines() if line.startswith("  - ")]
        facts = (line.partition(": ") for line in joined.splitlines() if ": " in line)
        self.rows = {name: words.strip() for name, _, words in facts}


def test_a_board_at_rest(board: Board, tfsat_host: RunCli) -> None:
    status = Told(board, tfsat_host)
    assert (status.json["state"], status.json["fault"], status.json["last_refusal"]) == (
        "safe",
        "none",
        "none",
    )
    assert (status.json["attention"], status.json["run"]) == ([], None)
    assert status.json["joint_angle_deg"] == [None, None, None]
    assert status.json["image_crc"] is status.json["device"]["image_crc"] is None
    assert (status.json["fault_explained"], status.json["arm_refusal"]) == (None, None)
    assert status.json["settings"]["origin"] == "factory"
    assert status.json["reset_cause"] == "power_on"
    assert status.rows["Sequencer"] == "safe, release switches: 1 closed, 2 closed"
    assert status.verdict == "READY TO ARM: logger not read"
    assert status.rows["Servos"] == "limp; factory settings, a pulse each 20 ms"
    assert status.rows["Servo of joint 3"] == "1000 us at 0 deg, +11.111 us/deg, limits 0 to 90 deg"
    assert status.rows["Last run"] == "none since power was switched on"
    assert status.bullets == []


def test_a_run_with_its_onsets(board: Board, tfsat_host: RunCli) -> None:
    connect(board).arm()
    board.run(100_000)
    release(board)
    board.run(3_000_000)
    status = Told(board, tfsat_host)
    assert status.json["state"] == "done"
    assert status.rows["Sequencer"].startswith("done, ")
    run = status.json["run"]
    assert [stroke["scheduled_us"] for stroke in run["strokes"]] == [700_000, 1_050_000, 1_470_000, 1_820_000]
    for number, stroke in enumerate(run["strokes"], 1):
        assert stroke["error_us"] == stroke["start_us"] - stroke["scheduled_us"]
        assert abs(stroke["error_us"]) <= 50
        expected_text = (
            f"began at {stroke['start_us'] / 1e6:.6f} s, {stroke['error_us']:+d} us from the schedule"
        )
        assert status.rows[f"Stroke {number}"] == expected_text
    assert status.rows["Last run"].endswith(f"{run['bounces']} edges of bounce")
    assert run["since_release_s"] >= 3.0
    assert status.json["joint_angle_deg"] == [0.0, 0.0, 0.0]
    assert "holding 0 deg, 0 deg, 0 deg (commanded)" in status.rows["Servos"]
    (blocked,) = status.bullets
    expected_text = "Sequencer: A release switch is open (switches 1 and 2). (refusal 15, switch_open) Seat"
    assert blocked.startswith(expected_text)
    assert status.verdict == "BLOCKED: 1 item blocks a drop"
    assert status.json["arm_refusal"]["number"] == 15


@pytest.mark.parametrize(
    ("cause", "cause_text"), [(ResetCause.WATCHDOG, "watchdog"), (ResetCause.BROWN_OUT, "brown out")]
)
def test_armed_again_after_a_reset(
    board: Board, tfsat_host: RunCli, cause: ResetCause, cause_text: str
) -> None:
    connect(board).arm()
    for _ in range(2):
        board.reset(cause)
        board.run(200_000)
    status = Told(board, tfsat_host)
    assert status.json["state"] == "armed"
    assert status.json["resets_while_armed"] == 2
    assert status.json["reset_cause"] == cause_text.replace(" ", "_")
    (attention,) = status.json["attention"]
    assert f"restarted 2 times while armed and is ARMED again; the last cause: {cause_text}." in attention
    assert status.bullets == [attention]
    assert status.verdict == "ARMED: the release starts the maneuver"


def test_a_fault_with_its_meaning_and_cure(board: Board, tfsat_host: RunCli) -> None:
    connect(board).arm()
    board.switch(0, closed=False)
    board.reset(ResetCause.WATCHDOG)
    board.run(200_000)
    status = Told(board, tfsat_host)
    assert (status.json["state"], status.json["fault"]) == ("fault", "reset_while_armed")
    explained = status.json["fault_explained"]
    assert status.rows["Sequencer"].startswith("fault: reset while armed, ")
    assert status.rows["Fault"] == f"{explained['what']} {explained['meaning']}"
    blocked, restarted = status.bullets
    assert " ".join(explained["next_step"].split()) in blocked
    assert explained["number"] == 22
    assert "(refusal 18, fault_latched)" in blocked and "clears the fault" in blocked
    assert "tfsat-host status" not in str(status.json) + status.lines  # whoever reads it has typed that
    assert "The moment of the release is lost" in explained["meaning"]
    assert status.json["arm_refusal"]["code"] == "fault_latched"
    assert "restarted 1 time while armed; the last cause: watchdog" in restarted


def test_a_refusal_is_told_in_words(board: Board, tfsat_host: RunCli) -> None:
    board.switch(1, closed=False)
    with pytest.raises(BoardRefusal):
        connect(board).arm()
    board.switch(1, closed=True)
    status = Told(board, tfsat_host)
    assert status.json["last_refusal"] == "switch_open"
    assert set(status.json["last_refusal_explained"]) == {"number", "what", "meaning", "next_step"}
    refusal_text = (
        "at the last ARM that the board itself refused: a release switch is open (refusal 15, switch_open)"
    )
    assert status.rows["Last refusal"] == refusal_text
    assert status.verdict == "READY TO ARM: logger not read"


def test_false_triggers_and_damaged_frames_are_counted(board: Board, tfsat_host: RunCli) -> None:
    connect(board).arm()
    for _ in range(3):
        board.switch(0, closed=False)
        board.run(20_000)
        board.switch(0, closed=True)
        board.run(100_000)
    board.write(b"\0\x05\x01\x02\x03\x04\0")
    board.run(10_000)
    status = Told(board, tfsat_host)
    assert (status.json["knocks"], status.rows["False triggers"]) == (3, "3; false releases: 0")
    assert status.json["frames_rejected"] == connect(board).status().frames_rejected >= 1
    assert status.rows["Link"].startswith(f"{status.json['frames_rejected']} damaged frame")


def test_a_jolt_that_was_taken_back_is_told_while_it_is_armed(board: Board) -> None:
    connect(board).arm()
    for opened in (True, False):
        for index in (0, 1):
            board.switch(index, closed=not opened)
        board.run(250_000 if not opened else 8_000)
    state, rows = told_directly(board)
    assert (state["state"], state["false_releases"]) == ("armed", 1)
    assert "closed again for good 1 time: no release, nothing moved" in rows["bullets"]


def told_directly(board: Board) -> tuple[dict[str, Any], dict[str, str]]:
    """Return the status as JSON and as text rows without a process.

    Its start would take longer than the board's actions.
    """
    report = SequencerReport.ask(connect(board))
    status = BoardsStatus(report, None, {})
    rows: dict[str, str] = {}
    for column in (*SEQUENCER_FACTS, *SEQUENCER_DETAILS):
        cell = column.cell(report)
        assert not isinstance(cell, Quantity)
        rows[column.label] = cell
    state: dict[str, Any] = record(BOARDS, status)["sequencer"]
    return state, {
        **rows,
        "verdict": status.verdict[0],
        "bullets": " ".join((*status.blocks, *status.warnings)),
    }


def test_a_joint_that_is_moved(board: Board) -> None:
    client(board).request(JogRequest(2, 0, 0, JOG_CONFIRM), JogReply)
    state, rows = told_directly(board)
    assert state["joint_angle_deg"] == [None, 0.0, None]
    assert rows["Servos"].startswith("joint 2 moving, commanded to 0 deg; others limp")
    client(board).request(JogRequest(2, 0, 1000, JOG_CONFIRM), JogReply)
    board.run(700_000)
    state, rows = told_directly(board)
    assert state["state"] == "jogging" and rows["verdict"] == "JOGGING: one joint is moved"
    assert state["joint_angle_deg"] == [None, 10.0, None]
    assert rows["Servos"].startswith("joint 2 moving, commanded to 10 deg; others limp")


def test_nothing_was_uploaded(fresh_board: Board) -> None:
    state, rows = told_directly(fresh_board)
    assert (state["arm_refusal"]["code"], state["arm_refusal"]["number"]) == ("no_maneuver", 16)
    assert state["maneuver"]["origin"] == "factory"
    assert "(refusal 16, no_maneuver)" in rows["bullets"]
    assert "tfsat-host upload-sequence" in rows["bullets"]


def test_an_armed_board_stands_against_nothing_but_an_open_switch(board: Board) -> None:
    connect(board).arm()
    board.run(10_000)
    state, _ = told_directly(board)
    assert (state["state"], state["arm_refusal"], state["attention"]) == ("armed", None, [])
    board.switch(1, closed=False)
    board.run(10_000)
    state, rows = told_directly(board)
    assert (state["state"], state["arm_refusal"]) == ("armed", None)
    (attention,) = state["attention"]
    assert "ARMED with release switch 2 open" in attention
    assert rows["bullets"] == attention
    board.switch(0, closed=False)
    board.run(100_000)
    state, _ = told_directly(board)
    assert (state["state"], state["arm_refusal"], state["attention"]) == ("running", None, [])


def test_a_run_that_was_disarmed_midway(board: Board) -> None:
    connect(board).arm()
    board.run(100_000)
    release(board)
    board.run(1_200_000)
    state, rows = told_directly(board)
    assert "; 2 of 4 strokes so far; " in rows["Last run"]
    connect(board).disarm()
    state, rows = told_directly(board)
    assert state["state"] == "safe"
    assert "; it ended after 2 of 4 strokes; " in rows["Last run"]
    assert state["run"]["strokes_planned"] == 4
    assert [stroke["state"] for stroke in state["run"]["strokes"]] == ["begun"] * 2 + ["not_begun"] * 2
    assert rows["Stroke 2"].endswith(" us from the schedule")
    assert rows["Stroke 3"] == "did not begin: the run ended before"
    connect(board).upload(NEW)
    state, rows = told_directly(board)
    assert rows["Stroke 2"].endswith("no stroke of the maneuver on the board is known to be this one")
    assert "; it ended after 2 of 4 strokes; " in rows["Last run"]


def test_a_run_that_was_disarmed_before_its_first_stroke(board: Board) -> None:
    connect(board).arm()
    board.run(100_000)
    release(board)
    board.run(300_000)
    connect(board).disarm()
    _, rows = told_directly(board)
    assert "; it ended before its first stroke; " in rows["Last run"]


def test_a_stroke_that_a_held_pin_missed(board: Board) -> None:
    board.hold_pin(1, PinHold.LOW)
    connect(board).arm()
    board.run(100_000)
    release(board)
    board.run(1_200_000)
    state, rows = told_directly(board)
    assert "; 1 of 4 strokes so far; " in rows["Last run"]
    assert rows["Stroke 3"] == "not yet"
    board.run(2_000_000)
    state, rows = told_directly(board)
    assert (state["fault"], state["run"]["strokes_missed"]) == ("stroke_missed", 2)
    assert [stroke["state"] for stroke in state["run"]["strokes"]] == ["missed", "begun"] * 2
    assert "; 2 of 4 strokes MISSED; " in rows["Last run"]
    assert rows["Stroke 1"].startswith("MISSED: no pulse of it came out")
    assert state["joint_angle_deg"] == [0.0, 0.0, 0.0]
