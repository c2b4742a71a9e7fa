"""A serial port as the operating system gives it, over a pair of pseudo-terminals."""

from __future__ import annotations

import os
import select
import threading
import time
import tty
from collections.abc import Callable, Iterator

import pytest
import serial

from tests.devices.scripted import hello, reply
from tfsat_host.devices.board_errors import NoAnswer
from tfsat_host.devices.client import ATTEMPTS, Client
from tfsat_host.devices.serial_ports import PortError, PortProblem
from tfsat_host.devices.transport import SerialTransport
from tfsat_host.protocol.enums import Board
from tfsat_host.protocol.framing import FrameReceiver
from tfsat_host.protocol.messages import HelloRequest


class Terminal:
    """The board's end of a cable."""

    def __init__(self) -> None:
        self.master, slave = os.openpty()
        tty.setraw(slave)
        self.path = os.ttyname(slave)
        self._slave: int | None = slave

    def receive(self, byte_count: int) -> bytes:
        """Reads that many bytes, or fewer where no more come for 10 s: the system moves them on at its leisure."""
        received = b""
        while len(received) < byte_count and select.select([self.master], [], [], 10)[0]:
            received += os.read(self.master, byte_count - len(received))
        return received

    def vanish(self) -> None:
        """Close the terminal, as if the board was unplugged."""
        for descriptor in (self._slave, self.master):
            if descriptor is not None:
                os.close(descriptor)
        self._slave, self.master = None, -1

    def close(self) -> None:
        if self.master >= 0:
            self.vanish()


@pytest.fixture
def terminal() -> Iterator[Terminal]:
    pty_terminal = Terminal()
    yield pty_terminal
    pty_terminal.close()


@pytest.fixture
def port(terminal: Terminal) -> Iterator[SerialTransport]:
    transport = SerialTransport(terminal.path)
    yield transport
    transport.close()


def test_bytes_go_both_ways(terminal: Terminal, port: SerialTransport) -> None:
    everything = bytes(range(256))
    assert port.name == terminal.path
    port.write(everything)
    assert terminal.receive(256) == everything
    os.write(terminal.master, everything)
    received = b""
    while len(received) < 256:
        piece = port.read(5.0)
        assert piece, "nothing came for 5 s"
        received += piece
    assert received == everything


def test_reading_ends_when_nothing_comes(port: SerialTransport) -> None:
    assert port.read(0.0) == b""
    started_s = port.now_s()
    assert port.read(0.02) == b""
    assert port.now_s() >= started_s + 0.02


def test_a_request_over_the_port(terminal: Terminal, port: SerialTransport) -> None:
    def board() -> None:
        receiver = FrameReceiver()
        while True:
            for frame in receiver.feed(os.read(terminal.master, 100)):
                assert frame.type == HelloRequest.TYPE
                os.write(terminal.master, b"\0boot noise\0" + reply(frame, hello()))
                return

    answering = threading.Thread(target=board)
    answering.start()
    identity = Client(port).hello(Board.SEQUENCER)
    answering.join(10)
    assert identity.firmware == "1.2.3"


@pytest.mark.parametrize("use", [lambda port: port.read(1.0), lambda port: port.write(b"\0")])
def test_a_board_that_vanished_is_a_lost_connection(
    terminal: Terminal, port: SerialTransport, use: Callable[[SerialTransport], object]
) -> None:
    terminal.vanish()
    with pytest.raises(PortError, match=f"The connection on {port.name} was lost") as caught:
        use(port)
    assert caught.value.code == PortProblem.LOST
    assert "the cable was pulled" in caught.value.what
    assert "readiness" not in caught.value.what
    assert "tfsat-host status" in caught.value.next_step


def test_a_board_that_vanishes_in_the_middle_of_a_request(terminal: Terminal, port: SerialTransport) -> None:
    def board() -> None:
        os.read(terminal.master, 100)
        os.write(terminal.master, b"\x1d\x81")
        terminal.vanish()

    vanishing = threading.Thread(target=board)
    vanishing.start()
    with pytest.raises(PortError, match="was lost"):
        Client(port).hello()
    vanishing.join(10)


def test_a_board_that_takes_nothing_is_an_error_and_no_wait_for_ever(
    port: SerialTransport, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Raise PortError by a write timeout on a board that takes no bytes, instead of waiting for ever.

    A pseudo-terminal takes some thousand bytes without a reader; then the write times out.
    """
    descriptor = port._port.fileno()
    while select.select([], [descriptor], [], 0.2)[1]:  # the system moves them on at its leisure
        os.write(descriptor, bytes(1000))
    monkeypatch.setattr(port._port, "write_timeout", 0.05)
    with pytest.raises(PortError, match="was lost: a write timed out"):
        port.write(bytes(100))


def test_a_write_that_timed_out_is_an_error_even_if_the_port_takes_bytes_again(
    port: SerialTransport, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Fail a write that timed out: a part of a request may have gone out, which is no request."""
    away_s = 0.0
    write = os.write

    def write_a_part(descriptor: int, data: bytes) -> int:
        nonlocal away_s
        away_s += 60
        return write(descriptor, data[:1])

    monkeypatch.setattr(serial.serialutil.Timeout, "TIME", staticmethod(lambda: time.monotonic() + away_s))
    monkeypatch.setattr(os, "write", write_a_part)
    with pytest.raises(PortError, match="was lost: a write timed out") as caught:
        port.write(b"\x01\x02")
    assert caught.value.code == PortProblem.LOST


def test_writing_does_not_wait_until_the_board_has_taken_the_bytes(
    terminal: Terminal, port: SerialTransport, monkeypatch: pytest.MonkeyPatch
) -> None:
    """tcdrain() has no time limit: a board that hangs would hold the program."""

    def refuse_drain() -> None:
        raise AssertionError("waited for the board")

    monkeypatch.setattr(port._port, "flush", refuse_drain)
    port.write(b"\x01\x02")
    assert terminal.receive(2) == b"\x01\x02"


def test_a_silent_port_has_no_board(
    terminal: Terminal, port: SerialTransport, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tfsat_host.devices.client.ATTEMPT_TIMEOUT_S", 0.0005)
    with pytest.raises(NoAnswer, match=terminal.path):
        Client(port).hello()
    receiver = FrameReceiver()
    sent: list[int] = []
    while len(sent) < ATTEMPTS and (byte := terminal.receive(1)):
        sent += [frame.type for frame in receiver.feed(byte)]
    assert sent == [HelloRequest.TYPE] * ATTEMPTS
    assert not select.select([terminal.master], [], [], 0)[0]
