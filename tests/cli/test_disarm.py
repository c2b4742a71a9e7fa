"""Whatever answers, or does not: disarm makes safe what it can, and says what is left to do by hand."""

from __future__ import annotations

import os
import threading
import tty
from collections.abc import Iterator
from dataclasses import replace

import pytest

from tests.cli.process import RunCli
from tests.devices.scripted import hello, refusal, reply
from tfsat_host.cli import ports
from tfsat_host.cli.boards import interruptible
from tfsat_host.cli.main import main
from tfsat_host.errors import Interrupted
from tfsat_host.protocol.enums import Board, ErrorCode, SequencerState
from tfsat_host.protocol.framing import Frame, FrameReceiver
from tfsat_host.protocol.messages import DisarmReply, DisarmRequest, HelloRequest

TOGETHER = """schema = 1
strokes = [{joint = 1, angle_deg = 60, t_s = 0.7}, {joint = 2, angle_deg = 50, t_s = 0.7}]
"""
CUT = "cut the sequencer's power."


class PtyBoard:
    """A board at a pseudo-terminal: answers HELLO as `identity` and DISARM, and takes no other request."""

    def __init__(self) -> None:
        self.master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.port = os.ttyname(self._slave)
        # Another protocol's hash: such a board must still be disarmed.
        self.identity = hello(protocol_hash=bytes(range(8)))
        self.disarms = True
        self.requests: list[int] = []
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def _serve(self) -> None:
        receiver = FrameReceiver()
        while data := os.read(self.master, 1000):
            # The test's own end mark, not a frame.
            if data == b"\xffend":
                return
            for frame in receiver.feed(data):
                self.requests.append(frame.type)
                os.write(self.master, self._answer(frame))

    def _answer(self, frame: Frame) -> bytes:
        if frame.type == HelloRequest.TYPE:
            return reply(frame, self.identity)
        if frame.type == DisarmRequest.TYPE and self.disarms:
            return reply(frame, DisarmReply(SequencerState.SAFE))
        return refusal(frame, ErrorCode.UNKNOWN_MESSAGE)

    def close(self) -> None:
        os.write(self._slave, b"\xffend")
        self._thread.join(10)
        os.close(self._slave)
        os.close(self.master)


@pytest.fixture
def board() -> Iterator[PtyBoard]:
    pty_board = PtyBoard()
    yield pty_board
    pty_board.close()


def test_another_protocol_is_disarmed_all_the_same(board: PtyBoard, tfsat_host: RunCli) -> None:
    process = tfsat_host("disarm", "--port", board.port)
    assert "Disarmed" in process.stdout
    assert "speaks another protocol" in process.stderr
    # HELLO and DISARM alone: nothing else is asked of a board that speaks otherwise.
    assert board.requests == [HelloRequest.TYPE, DisarmRequest.TYPE]
    result = tfsat_host.json("disarm", "--port", board.port)
    assert (result["state"], result["same_protocol"]) == ("safe", False)


@pytest.mark.parametrize(
    "command",
    [
        ("arm", "--yes"),
        ("upload-sequence", "59", "70", "--yes"),
        ("upload-sequence", "--file", "together.toml", "--yes"),
        ("upload-servos", "--factory", "--yes"),
        ("upload-servos", "--show"),
        ("jog", "--joint", "1", "--from", "0", "--to", "10", "--yes"),
        ("status",),
    ],
    ids=" ".join,
)
def test_every_other_command_refuses_another_protocol(
    board: PtyBoard, tfsat_host: RunCli, command: tuple[str, ...]
) -> None:
    # A firmware from before joints moved together is such a board.
    board.identity = replace(board.identity, firmware_version=b"\0\1\0")
    (tfsat_host.folder / "together.toml").write_text(TOGETHER)
    printed = tfsat_host(*command, "--port", board.port, "--json", expect=None)
    assert "other-protocol" in printed.stdout
    assert "The sequencer is the older side (0.1.0): flash this checkout's firmware" in printed.stdout
    assert printed.returncode == 1
    # Nothing but its name was asked.
    assert set(board.requests) == {HelloRequest.TYPE}


def test_a_board_that_does_not_disarm_loses_its_power(board: PtyBoard, tfsat_host: RunCli) -> None:
    board.disarms = False
    assert tfsat_host("disarm", "--port", board.port, expect=1).stderr.rstrip().endswith(CUT)


def test_the_logger_is_not_disarmed(board: PtyBoard, tfsat_host: RunCli) -> None:
    board.identity = replace(board.identity, board=Board.LOGGER)
    error = tfsat_host.json("disarm", "--port", board.port, expect=1)["error"]
    assert error["code"] == "other-board"
    assert error["next_step"].endswith(CUT)
    # The logger never got the order.
    assert board.requests == [HelloRequest.TYPE]


def test_a_board_that_cannot_be_reached_loses_its_power(tfsat_host: RunCli) -> None:
    error = tfsat_host.json("disarm", expect=1, without_ports=True)["error"]
    assert error["code"] == "none-found"
    assert error["next_step"].endswith(CUT)


def test_ctrl_c_recommends_status_only_where_a_board_was_connected(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(Interrupted) as caught, interruptible("/dev/x y"):
        raise KeyboardInterrupt
    assert caught.value.exit_code == 130
    assert "tfsat-host status --port '/dev/x y'" in caught.value.next_step

    def interrupt() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(ports, "system_ports", interrupt)
    assert main(["ports"]) == 130
    # Where no board was connected there is nothing to look at.
    assert "status" not in capsys.readouterr().err


@pytest.mark.parametrize("command", ["disarm", "arm", "jog --joint 1 --from 0 --to 1", "monitor", "status"])
def test_who_looks_for_the_robot_is_not_sent_to_an_emulated_one(tfsat_host: RunCli, command: str) -> None:
    error = tfsat_host.json(*command.split(), expect=1, without_ports=True)["error"]
    assert error["code"] == "none-found"
    # Somebody stands at the robot: an emulated one would not help.
    assert "emulate" not in error["next_step"]


@pytest.mark.parametrize(
    "command", ["upload-sequence 59 70", "upload-servos --factory", "upload-servos --show"]
)
def test_who_tries_a_command_hears_of_the_emulated_robot(tfsat_host: RunCli, command: str) -> None:
    error = tfsat_host.json(*command.split(), expect=1, without_ports=True)["error"]
    assert "without the board: add --emulated" in error["next_step"]


def test_disarming_an_emulated_robot_is_not_taken_for_more(tfsat_host: RunCli) -> None:
    output = tfsat_host("disarm", "--emulated").stdout
    assert output.startswith("Disarmed: the emulated robot of this command.")
    assert tfsat_host.json("disarm", "--emulated")["emulated"] is True
