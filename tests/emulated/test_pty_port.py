"""A port that comes and goes under its clients."""

from __future__ import annotations

import os
import pty
import termios
from collections.abc import Iterator
from pathlib import Path

import pytest

from tfsat_host.devices.serial_ports import PortError, PortProblem, open_serial
from tfsat_host.devices.transport import SerialTransport
from tfsat_host.emulated.server import PtyPort


@pytest.fixture
def port(tmp_path: Path) -> Iterator[PtyPort]:
    pty_port = PtyPort(tmp_path / "board")
    pty_port.plug()
    yield pty_port
    pty_port.pull()


def _attach(port: PtyPort) -> SerialTransport:
    client = SerialTransport(str(port.link))
    # The first read lets the server see that somebody opened the port.
    assert port.read() == b""
    return client


def _receive(client: SerialTransport, n_bytes: int) -> bytes:
    """Receive exactly `n_bytes`, although the kernel may deliver them in pieces."""
    data = b""
    while len(data) < n_bytes:
        piece = client.read(1.0)
        assert piece, data
        data += piece
    return data


def test_bytes_pass_both_ways_unchanged(port: PtyPort) -> None:
    # All byte values: no terminal setting may eat or change one.
    everything = bytes(range(256))
    client = _attach(port)
    client.write(everything)
    assert port.read() == everything
    port.write(everything)
    assert _receive(client, 256) == everything
    client.close()


def test_one_client_after_another(port: PtyPort) -> None:
    for number in range(5):
        client = SerialTransport(str(port.link))
        client.write(bytes([number]))
        assert port.read() == bytes([number])
        port.write(bytes([number, number]))
        assert _receive(client, 2) == bytes([number, number])
        client.close()
        # The client's close is seen here, so that the next one finds an empty port.
        assert port.read() == b""


def test_what_a_client_wrote_before_it_went_arrives(port: PtyPort) -> None:
    client = SerialTransport(str(port.link))
    client.write(b"last words")
    client.close()
    assert port.read() == b"last words"
    assert port.read() == b""


def test_a_client_finds_nothing_of_the_one_before(port: PtyPort) -> None:
    first = os.open(port.link, os.O_RDWR | os.O_NOCTTY)
    assert port.read() == b""
    port.write(b"unread")
    # Echo and canonical mode, as a terminal program would set them.
    settings = termios.tcgetattr(first)
    settings[3] |= termios.ECHO | termios.ICANON
    termios.tcsetattr(first, termios.TCSANOW, settings)
    os.close(first)
    assert port.read() == b""
    second = os.open(port.link, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    # Nothing is there to read: what the last client left unread is gone.
    with pytest.raises(BlockingIOError):
        os.read(second, 100)
    # The settings are the board's again, not those of the last client.
    assert not termios.tcgetattr(second)[3] & (termios.ECHO | termios.ICANON)
    os.close(second)


def test_a_claim_that_cannot_be_lifted_gives_a_new_terminal(
    port: PtyPort, monkeypatch: pytest.MonkeyPatch
) -> None:
    client = _attach(port)
    before = port.device
    client.close()
    opened = os.open

    def open_or_refuse(path: str, flags: int, mode: int = 0o777) -> int:
        # As another process's exclusive claim would be refused.
        if path == before:
            raise OSError(16, "Device or resource busy")
        return opened(path, flags, mode)

    monkeypatch.setattr(os, "open", open_or_refuse)
    # Held, so that the system does not hand out the same number again.
    descriptors = pty.openpty()
    assert port.read() == b""
    monkeypatch.undo()
    for descriptor in descriptors:
        os.close(descriptor)
    client = SerialTransport(str(port.link))
    client.write(b"x")
    assert port.read() == b"x"
    client.close()


def test_what_nobody_hears_is_lost(port: PtyPort) -> None:
    # Written before anybody opened: nobody hears it.
    port.write(b"nobody is there")
    client = _attach(port)
    port.write(b"now")
    assert _receive(client, 3) == b"now"
    client.close()


def test_a_client_that_does_not_read_holds_the_board_back_and_loses_nothing(port: PtyPort) -> None:
    client = _attach(port)
    sent = 0
    # Until the kernel's buffer is full.
    while sent < 1_000_000 and port.has_room:
        port.write(bytes(1000))
        sent += 1000
    assert sent < 1_000_000
    received = 0
    while received < sent:
        piece = client.read(1.0)
        assert piece, received
        received += len(piece)
        # The server goes on writing as soon as there is room.
        port.write(b"")
    client.close()


def test_a_client_has_the_port_for_itself(port: PtyPort) -> None:
    client = _attach(port)
    with pytest.raises(PortError) as caught:
        open_serial(str(port.link))
    assert caught.value.code is PortProblem.BUSY
    client.close()


def test_pulling_takes_the_port_and_its_link_away(port: PtyPort) -> None:
    client = _attach(port)
    port.pull()
    # Not even a dangling link.
    assert not os.path.lexists(port.link)
    with pytest.raises(PortError, match="was lost"):
        client.read(1.0)
    with pytest.raises(PortError, match="was lost"):
        client.write(b"x")
    client.close()
    # A port without a cable reads and writes nothing, and fails nowhere.
    assert port.read() == b""
    port.write(b"into the void")
    port.plug()
    again = _attach(port)
    port.write(b"back")
    assert _receive(again, 4) == b"back"
    again.close()
