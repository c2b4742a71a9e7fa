"""`tfsat-host ports`: which serial ports there are, and which board each looks like."""

from __future__ import annotations

import argparse

from tfsat_host.cli.usage import OUTPUT, add_options
from tfsat_host.devices.serial_ports import PortInfo, identify, system_ports
from tfsat_host.present.output import Output


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the common options only."""
    add_options(parser, OUTPUT)


def run(args: argparse.Namespace, out: Output) -> int:  # noqa: ARG001
    """Lists the ports; an empty list is a result, not a failure."""
    ports = sorted(system_ports(), key=lambda port: port.device)
    out.result({"ports": [_as_json(port) for port in ports]}, lambda: _show(ports, out))
    return 0


def _as_json(port: PortInfo) -> dict[str, object]:
    identity = identify(port)
    return {
        "port": port.device,
        "board": identity.board if identity else None,
        "mode": identity.mode if identity else None,
        "vid": port.vid,
        "pid": port.pid,
        "serial_number": port.serial_number,
        "description": port.description,
    }


def _show(ports: list[PortInfo], out: Output) -> None:
    if not ports:
        out.line("No serial ports. Plug in the Arduino Micro (sequencer) or the Teensy 4.1 (logger) by USB.")
        out.line("Without a board, device commands take --emulated.")
        return
    rows = [(port.device, _looks_like(port), _usb_id(port), port.description or "–") for port in ports]
    out.table(("port", "board", "USB id", "description"), rows)


def _looks_like(port: PortInfo) -> str:
    identity = identify(port)
    if identity is None:
        return "–"
    return f"{identity.board} (bootloader)" if identity.mode == "bootloader" else identity.board


def _usb_id(port: PortInfo) -> str:
    return "–" if port.vid is None or port.pid is None else f"{port.vid:04x}:{port.pid:04x}"
