"""Which serial port a board is on.

`--port` beats the environment variable, which beats autodetection by USB vendor and product id.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

from tfsat_host.devices.port_errors import (
    PortError,
    PortProblem,
    ambiguous_error,
    bootloader_error,
    none_found_error,
)
from tfsat_host.devices.serial_port import open_serial

__all__ = [
    "BoardName",
    "Identity",
    "Mode",
    "PortError",
    "PortInfo",
    "PortProblem",
    "find_port",
    "identify",
    "open_serial",
    "port_variable",
    "system_ports",
]

BoardName = Literal["sequencer", "logger"]
Mode = Literal["sketch", "bootloader"]


@dataclass(frozen=True, slots=True)
class PortInfo:
    """A serial port of this computer, as the operating system describes it."""

    device: str
    vid: int | None = None
    pid: int | None = None
    serial_number: str | None = None
    description: str | None = None


@dataclass(frozen=True, slots=True)
class Identity:
    """What a port's USB ids say it is; only HELLO tells for certain."""

    board: BoardName
    mode: Mode


# Arduino's boards.txt (micro.vid/pid, 0x2341 Arduino LLC, 0x2A03 Arduino srl) and PJRC's udev rules.
# A Teensy in its bootloader is a HID device: it never shows up as a serial port.
_USB_IDS: Mapping[tuple[int, int], Identity] = {
    (0x2341, 0x8037): Identity("sequencer", "sketch"),
    (0x2A03, 0x8037): Identity("sequencer", "sketch"),
    (0x2341, 0x8237): Identity("sequencer", "sketch"),
    (0x2341, 0x0037): Identity("sequencer", "bootloader"),
    (0x2A03, 0x0037): Identity("sequencer", "bootloader"),
    (0x2341, 0x0237): Identity("sequencer", "bootloader"),
    (0x16C0, 0x0483): Identity("logger", "sketch"),
}


def port_variable(board: BoardName) -> str:
    """Name of the environment variable that names the board's port."""
    return f"TFSAT_{board.upper()}_PORT"


def identify(port: PortInfo) -> Identity | None:
    """What the port looks like by its USB ids; None when it is none of ours."""
    if port.vid is None or port.pid is None:
        return None
    return _USB_IDS.get((port.vid, port.pid))


def system_ports() -> list[PortInfo]:
    """The serial ports of this computer."""
    from serial.tools.list_ports import comports

    return [PortInfo(p.device, p.vid, p.pid, p.serial_number, p.description) for p in comports()]


def find_port(
    board: BoardName,
    explicit: str | None = None,
    environ: Mapping[str, str] | None = None,
    list_ports: Callable[[], Iterable[PortInfo]] = system_ports,
) -> str:
    """The device path of the board's port.

    Args:
        board: Which board is wanted.
        explicit: What `--port` said; then nothing is scanned and nothing is checked.
        environ: The environment; the process's own by default.
        list_ports: Gives the ports of this computer.

    Raises:
        PortError: no port looks like the board, several do, or it waits in its bootloader.
    """
    if explicit is not None:
        return explicit
    named = (os.environ if environ is None else environ).get(port_variable(board))
    if named:
        return named
    ports = list(list_ports())
    candidates = [port for port in ports if identify(port) == Identity(board, "sketch")]
    if len(candidates) == 1:
        return candidates[0].device
    if candidates:
        raise ambiguous_error(board, [_described(port) for port in candidates], port_variable(board))
    for port in ports:
        if identify(port) == Identity(board, "bootloader"):
            raise bootloader_error(board, port.device)
    raise none_found_error(board, [_described(port) for port in ports], port_variable(board))


def _described(port: PortInfo) -> str:
    identity = identify(port)
    looks = identity.board if identity else (port.description or "unknown")
    serial = f", serial number {port.serial_number}" if port.serial_number else ""
    return f"{port.device} ({looks}{serial})"
