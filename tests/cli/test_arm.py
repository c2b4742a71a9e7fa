"""`arm` as a user has it: what refuses it, the joints' angles, and what the board says afterwards."""

from __future__ import annotations

import io
import json
import sys
from collections.abc import Callable
from typing import NoReturn

import pytest

from tests.arduino_sequencer.conftest import board, board_library, fresh_board, new_board
from tests.cli.board_on_pty import BoardOnPty
from tests.cli.process import RunCli
from tests.fixtures.sequencer.board import Board, ResetCause
from tests.fixtures.sequencer.cable import client, connect
from tests.fixtures.sequencer.pulses import release
from tfsat_host.cli.main import main
from tfsat_host.maneuver import Maneuver, Stroke, schedule_maneuver
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.protocol.limits import JOG_CONFIRM
from tfsat_host.protocol.messages import ArmRequest, DisarmReply, DisarmRequest, JogReply, JogRequest

__all__ = ["board", "board_library", "fresh_board", "new_board"]


def test_joints_at_their_start_pose_are_reported(board: Board, tfsat_host: RunCli) -> None:
    with BoardOnPty(board) as served:
        armed = tfsat_host.json(
            # Within 10 deg of the start pose: the tolerance of the protocol.
            "arm",
            "--yes",
            "--joints",
            "-6.2",
            "9.999",
            0,
            "--port",
            served.port,
            without_ports=True,
        )
    assert (armed["state"], armed["at_start_pose"]) == ("armed", True)
    assert connect(board).status().state == SequencerState.ARMED


def test_nobody_measured(board: Board, tfsat_host: RunCli) -> None:
    with BoardOnPty(board) as served:
        armed = tfsat_host.json("arm", "--yes", "--port", served.port, without_ports=True)
    assert (armed["state"], armed["at_start_pose"]) == ("armed", None)


def test_a_joint_off_its_start_pose_is_not_armed(board: Board, tfsat_host: RunCli) -> None:
    with BoardOnPty(board) as served:
        where = ("--port", served.port)
        error = tfsat_host.json("arm", "--joints", 0, "34.01", 0, *where, expect=4)["error"]
        assert error["code"] == "not_at_start_pose"
        assert "joint 2 is at 34.01 deg" in error["what"]
        assert "tfsat-host jog" in error["next_step"]
    assert connect(board).status().state == SequencerState.SAFE
    # Told by somebody else, the board itself refuses.
    # Another program has told the board of a joint beyond the tolerance.
    connect(board).report_joints((0, 0, 1001))
    with BoardOnPty(board) as served:
        error = tfsat_host.json("arm", "--yes", "--port", served.port, expect=4)["error"]
        assert error["code"] == "not_at_start_pose"
        status = tfsat_host.json("status", "--port", served.port)["sequencer"]
        assert status["last_refusal"] == "not_at_start_pose"
        assert "start pose" in status["last_refusal_explained"]["what"]


@pytest.mark.parametrize("angles", [("0", "0"), ("0", "0", "nan"), ("0", "0", "181"), ("0", "0", "x")])
def test_angles_that_are_none(tfsat_host: RunCli, angles: tuple[str, ...]) -> None:
    assert tfsat_host("arm", "--yes", "--port", "nowhere", "--joints", *angles, expect=2).stderr


def test_disarm_knows_no_joints(tfsat_host: RunCli) -> None:
    assert tfsat_host("disarm", "--joints", 0, 0, 0, "--port", "nowhere", expect=2).stderr


@pytest.mark.parametrize(
    ("happens", "state", "meaning"),
    [
        (release, "running", "the maneuver runs now"),
        (lambda board: client(board).request(DisarmRequest(), DisarmReply), "safe", "would fly nothing"),
    ],
)
def test_the_state_afterwards_is_read_back(
    board: Board, tfsat_host: RunCli, happens: Callable[[Board], object], state: str, meaning: str
) -> None:
    def after_arming() -> None:
        happens(board)
        board.run(20_000)

    with BoardOnPty(board, {ArmRequest.TYPE: after_arming}) as served:
        error = tfsat_host.json("arm", "--yes", "--port", served.port, expect=1)["error"]
    assert error["what"] == f"The sequencer took the arming, but now it is {state}."
    assert meaning in error["meaning"]
    assert f"tfsat-host status --port {served.port}" in error["next_step"]


def test_a_latched_fault_is_named(board: Board, tfsat_host: RunCli) -> None:
    connect(board).arm()
    # A switch opens, and the supply dips: the board cannot know whether it was released.
    board.switch(0, closed=False)
    board.reset(ResetCause.BROWN_OUT)
    board.run(50_000)
    with BoardOnPty(board) as served:
        error = tfsat_host.json("arm", "--port", served.port, expect=4)["error"]
    assert error["code"] == "fault_latched"
    assert "restarted while it was armed" in error["what"]
    assert f"tfsat-host disarm --port {served.port}" in error["next_step"]


def test_a_jogging_board_is_not_armed(board: Board, tfsat_host: RunCli) -> None:
    client(board).request(JogRequest(2, 0, 3000, JOG_CONFIRM), JogReply)
    with BoardOnPty(board) as served:
        error = tfsat_host.json("arm", "--port", served.port, expect=4)["error"]
    assert error["code"] == "wrong_state"
    assert "moving a joint" in error["what"]


def test_a_board_with_the_factory_maneuver_is_not_armed(fresh_board: Board, tfsat_host: RunCli) -> None:
    with BoardOnPty(fresh_board) as served:
        where = ("--port", served.port)
        error = tfsat_host.json("arm", "--yes", *where, expect=4)["error"]
        # The number is the protocol's.
        assert (error["code"], error["number"]) == ("no_maneuver", 16)
        assert error["next_step"].startswith(f"tfsat-host upload-sequence 59 70 --port {served.port}")
        assert "(refusal 16, no_maneuver)\n" in tfsat_host("arm", "--yes", *where, expect=4).stderr
    assert connect(fresh_board).status().state == SequencerState.SAFE


def test_in_fault_the_cause_is_looked_at_before_it_is_cleared(board: Board, tfsat_host: RunCli) -> None:
    connect(board).arm()
    board.switch(0, closed=False)
    board.reset(ResetCause.BROWN_OUT)
    board.run(50_000)
    with BoardOnPty(board) as served:
        where = f"--port {served.port}"
        error = tfsat_host.json("upload-sequence", 59, 70, "--port", served.port, expect=4)["error"]
    assert error["code"] == "wrong_state"
    assert error["next_step"].startswith(
        f"tfsat-host status {where} to see why and tfsat-host disarm {where} to"
    )


class Person(io.StringIO):
    def isatty(self) -> bool:
        return True


class PersonWhoTypesCtrlC(Person):
    def readline(self, _size: int | None = -1, /) -> NoReturn:
        raise KeyboardInterrupt


Capture = pytest.CaptureFixture[str]


def test_the_question_names_what_will_fly_and_what_will_move(
    board: Board, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    stored = connect(board).read_back()
    monkeypatch.setattr(sys, "stdin", Person("no\n"))
    with BoardOnPty(board) as served:
        assert main(["arm", "--port", served.port]) == 4
    error_text = capsys.readouterr().err
    for words in (
        # The stored maneuver is named by its CRC: what flies is what was uploaded.
        f"Maneuver to fly: 4 strokes, uploaded, CRC {stored.crc:04x}, over 2.23 s after the release.",
        "\n  0.70 s joint 1 +59 deg\n  1.05 s joint 2 +70 deg\n  1.47 s joint 1 -59 deg\n  1.82 s joint 2 -70 deg\n",
        "The servos are limp now.",
        "they take joints 1, 2 and 3 to the start pose, 0 deg",
        "jumps there at the servo's full speed",
        "Type ARM to arm: ",
        "Nothing was armed.",
    ):
        assert words in error_text
    assert connect(board).status().state == SequencerState.SAFE


def test_one_stroke_in_words_and_as_json(board: Board, tfsat_host: RunCli) -> None:
    stored = (
        connect(board).upload(schedule_maneuver(Maneuver((Stroke(joint=3, angle_deg=40.0),), 170.0))).stored
    )
    with BoardOnPty(board) as served:
        process = tfsat_host("arm", "--yes", "--json", "--port", served.port)
    assert "to fly: 1 stroke, uploaded" in process.stderr
    armed = json.loads(process.stdout)["maneuver"]
    assert armed["strokes"] == [{"t_s": 0.7, "joint": 3, "angle_deg": 40.0}]
    assert (armed["origin"], armed["crc"], armed["end_us"]) == (
        "uploaded",
        f"{stored.crc:04x}",
        stored.end_us,
    )


def test_after_a_run_the_servos_hold_its_end_pose(
    board: Board, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    connect(board).arm()
    board.run(10_000)
    release(board)
    # The whole maneuver, and half a second more.
    board.run(3_000_000)
    for switch in (0, 1):
        board.switch(switch, closed=True)
    board.run(10_000)
    monkeypatch.setattr(sys, "stdin", Person("ARM\n"))
    with BoardOnPty(board) as served:
        assert main(["arm", "--port", served.port]) == 0
    error_text = capsys.readouterr().err
    assert "The servos hold the end pose now, each within 10 deg of its start pose" in error_text
    assert "further away, ARM is refused" in error_text
    assert connect(board).status().state == SequencerState.ARMED


def test_ctrl_c_at_the_question(board: Board, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    monkeypatch.setattr(sys, "stdin", PersonWhoTypesCtrlC())
    with BoardOnPty(board) as served:
        assert main(["arm", "--port", served.port]) == 130
    error_text = capsys.readouterr().err
    assert "Nothing was armed." in error_text
    assert "goes on in its own state" not in error_text
    assert connect(board).status().state == SequencerState.SAFE
