"""`arm` as a user has it: what refuses it, the joints' angles, and what the board says afterwards."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from tests.cli.board_on_pty import BoardOnPty
from tests.cli.process import RunCli
from tests.sequencer.board import Board, Reset, client, connect, release
from tests.sequencer.conftest import board, board_library, new_board
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.protocol.limits import JOG_CONFIRM
from tfsat_host.protocol.messages import ArmRequest, DisarmReply, DisarmRequest, JogReply, JogRequest

__all__ = ["board", "board_library", "new_board"]


def test_joints_at_their_start_pose_are_reported(board: Board, tfsat_host: RunCli) -> None:
    with BoardOnPty(board) as served:
        armed = tfsat_host.json(
            "arm", "--yes", "--joints", "-6.2", "9.999", 0, "--port", served.port, without_ports=True
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
        board.advance(20_000)

    with BoardOnPty(board, {ArmRequest.TYPE: after_arming}) as served:
        error = tfsat_host.json("arm", "--yes", "--port", served.port, expect=1)["error"]
    assert error["what"] == f"The sequencer took the arming, but now it is {state}."
    assert meaning in error["meaning"]
    assert f"tfsat-host status --port {served.port}" in error["next_step"]


def test_a_latched_fault_is_named(board: Board, tfsat_host: RunCli) -> None:
    connect(board).arm()
    board.switch(0, opened=True)
    board.reset(Reset.BROWN_OUT)
    board.advance(50_000)
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
