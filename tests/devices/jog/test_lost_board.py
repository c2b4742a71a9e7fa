"""A board that stops answering while a joint moves: what is said then."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from itertools import pairwise

import pytest

from tests.devices.scripted import Answer, ScriptedTransport, hello, reply
from tfsat_host.devices.jog_path import Jog, JogError
from tfsat_host.devices.jogging import JogClient
from tfsat_host.protocol import messages as msg
from tfsat_host.protocol.enums import ResetCause, SequencerState
from tfsat_host.protocol.framing import Frame
from tfsat_host.protocol.limits import JOG_IDLE_MS
from tfsat_host.quantity import record


class Board:
    """Jogs to 1 deg and stays there; what it does on DISARM is the test's."""

    def __init__(self) -> None:
        self.state = SequencerState.SAFE
        self.disarms = True
        self.answers_disarm = True
        self.uptime_ms = 1000
        self.after_polls: dict[int, Callable[[], None]] = {}
        """What befalls the board before it answers the poll of this number."""
        self.polls = 0
        self.ignores_orders = 0
        self.orders = 0

    def __call__(self, frame: Frame) -> Iterable[Answer]:
        if frame.type == msg.HelloRequest.TYPE:
            return [reply(frame, hello())]
        if frame.type == msg.JogRequest.TYPE:
            self.orders += 1
            # An order that gets lost: the board keeps silent and changes nothing.
            if self.orders > 1 and self.ignores_orders:
                self.ignores_orders -= 1
                return []
            self.state = SequencerState.JOGGING
            return [reply(frame, msg.JogReply(100, 0))]
        if frame.type == msg.DisarmRequest.TYPE:
            if self.disarms:
                self.state = SequencerState.SAFE
            return [reply(frame, msg.DisarmReply(self.state))] if self.answers_disarm else []
        self.polls += 1
        # What befalls it happens between two polls.
        self.after_polls.get(self.polls, lambda: None)()
        status = replace(
            msg.SequencerStatusReply.decode(bytes(msg.SequencerStatusReply.SIZE)),
            state=self.state,
            reset_cause=ResetCause.BROWN_OUT,
            joint_angle_cdeg=(100, 0, 0),
            uptime_ms=self.uptime_ms,
            servos_driven=1,
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
    # Four seconds for 30 deg at 15 deg/s: twice the time of the way.
    assert error.what == "Joint 1 was commanded to 1 deg only after 4 s; 30 deg was asked for."
    assert board.state == SequencerState.SAFE


def test_a_board_that_does_not_confirm_is_told() -> None:
    board = Board()
    board.disarms = board.answers_disarm = False
    error = run(board)
    assert "did not confirm that it let joint 1 go. No answer from scripted." in error.what
    # Nobody knows: the board's own limit is what the user can rely on.
    assert f"{JOG_IDLE_MS / 1000:g} s after the last order" in error.meaning
    assert error.meaning.startswith("Joint 1 was last commanded to 1 deg.")
    assert "cut the sequencer's power" in error.next_step


def test_a_board_that_says_it_still_jogs_is_not_believed_safe() -> None:
    board = Board()
    board.disarms = False
    # A confirmation with the wrong state is none.
    assert "says that it is jogging" in run(board).what


@pytest.mark.parametrize(
    ("uptime_ms", "what", "meaning"),
    [
        (300, "restarted 0.3 s ago (brown out)", "pull the supply down"),
        (
            60_000,
            "ended the jog automatically. It did not restart: up for 60 s",
            "no order reached it for 1 s",
        ),
        (60_100 + 5000, "This computer was away for 5.1 s", "The board did not restart"),
    ],
)
def test_why_the_board_ended_the_jog_is_told_by_its_uptime(uptime_ms: int, what: str, meaning: str) -> None:
    board = Board()
    board.uptime_ms = 60_000

    def end() -> None:
        board.state, board.uptime_ms = SequencerState.SAFE, uptime_ms

    board.after_polls[5] = end
    error = run(board)
    assert what in error.what and error.what.endswith("It is safe.")
    assert error.meaning.startswith("Joint 1 was last commanded to 1 deg and was let go.")
    assert meaning in error.meaning
    assert record(error.columns, error) == {"joint": 1, "last_angle_deg": 1.0}
    # The next command is from where the joint is now.
    assert "--from 1 goes on" in error.next_step


def test_an_uptime_that_begins_anew_after_49_days_is_no_restart() -> None:
    board = Board()
    board.uptime_ms = 2**32 - 50

    def end() -> None:
        # 2**32 ms are 49.7 days: the uptime wraps.
        board.state, board.uptime_ms = SequencerState.SAFE, 50

    board.after_polls[3] = end
    assert "did not restart" in run(board).what


def test_a_lost_order_is_repeated_only_after_asking_whether_the_joint_is_still_held() -> None:
    board = Board()
    board.ignores_orders = 1
    transport = ScriptedTransport(board)
    with pytest.raises(JogError, match="only after"):
        JogClient.connect(transport).run(Jog(1, 0, 3000), 0.0, lambda: False, lambda _angle_cdeg: None)
    types = [frame.type for frame in transport.requests]
    pairs = set(pairwise(types))
    assert types.count(msg.JogRequest.TYPE) > 10
    # No order twice in a row: a poll must lie between them.
    assert (msg.JogRequest.TYPE, msg.JogRequest.TYPE) not in pairs
