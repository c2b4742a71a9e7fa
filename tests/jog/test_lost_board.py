"""A board that stops answering while a joint moves: what is said then."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

from tests.devices.scripted import Answer, ScriptedTransport, hello, reply
from tfsat_host.devices.jogging import Jog, JogClient, JogError
from tfsat_host.protocol.enums import ErrorCode, ResetCause, SequencerState
from tfsat_host.protocol.framing import Frame
from tfsat_host.protocol.messages import (
    DisarmReply,
    DisarmRequest,
    HelloRequest,
    JogReply,
    JogRequest,
    SequencerStatusReply,
)


class Board:
    """Jogs to 1 deg and stays there; what it does on DISARM is the test's."""

    def __init__(self) -> None:
        self.state = SequencerState.SAFE
        self.disarms = True
        self.answers_disarm = True

    def __call__(self, frame: Frame) -> Iterable[Answer]:
        if frame.type == HelloRequest.TYPE:
            return [reply(frame, hello())]
        if frame.type == JogRequest.TYPE:
            self.state = SequencerState.JOGGING
            return [reply(frame, JogReply(0, 0))]
        if frame.type == DisarmRequest.TYPE:
            if self.disarms:
                self.state = SequencerState.SAFE
            return [reply(frame, DisarmReply(self.state))] if self.answers_disarm else []
        none = ErrorCode.NONE
        status = SequencerStatusReply(
            self.state, none, none, 0, 1, ResetCause.POWER_ON, 0, 0, 0, (100, 0, 0), 1000, 0, 700, 0
        )
        return [reply(frame, status)]


def run(board: Board) -> JogError:
    sequencer = JogClient.connect(ScriptedTransport(board))
    with pytest.raises(JogError) as caught:
        sequencer.run(Jog(1, 0, 3000), 0.0, lambda: False, lambda _angle_cdeg: None)
    return caught.value


def test_a_joint_that_does_not_get_there_is_let_go() -> None:
    board = Board()
    error = run(board)
    assert error.what == "Joint 1 was commanded to 1 deg only after 4 s; 30 deg was asked for."
    assert board.state == SequencerState.SAFE


def test_a_board_that_does_not_confirm_is_told() -> None:
    board = Board()
    board.disarms = board.answers_disarm = False
    error = run(board)
    assert "did not confirm that it let joint 1 go. No answer from scripted." in error.what
    assert "20 s after the last order" in error.meaning
    assert "cut the sequencer's power" in error.next_step


def test_a_board_that_says_it_still_jogs_is_not_believed_safe() -> None:
    board = Board()
    board.disarms = False
    assert "says that it is jogging" in run(board).what
