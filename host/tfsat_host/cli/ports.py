"""`tfsat-host ports`: which serial ports there are, and which board each looks like."""

from __future__ import annotations

import argparse

from tfsat_host.cli.usage import OUTPUT, add_options
from tfsat_host.devices.serial_ports import PortInfo, identify, system_ports
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show_rows
from tfsat_host.quantity import UNKNOWN, Column, Columns, fields, records


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the common options only."""
    add_options(parser, OUTPUT)


def run(args: argparse.Namespace, out: Output) -> int:  # noqa: ARG001
    """List the ports; an empty list is a result, not a failure."""
    ports = sorted(system_ports(), key=lambda port: port.device)
    out.result({"ports": records(_PORTS, ports)}, lambda: _show(ports, out))
    return 0


def _show(ports: list[PortInfo], out: Output) -> None:
    if not ports:
        out.line("No serial ports. Plug in the Arduino Micro (sequencer) or the Teensy 4.1 (logger) by USB.")
        out.line("Without a board, device commands take --emulated.")
        return
    show_rows(_PORTS, ports, out)


def _describe_board(port: PortInfo) -> str:
    identity = identify(port)
    if identity is None:
        return UNKNOWN
    return f"{identity.board} (bootloader)" if identity.mode == "bootloader" else identity.board


def _usb_id(port: PortInfo) -> str:
    return UNKNOWN if port.vid is None or port.pid is None else f"{port.vid:04x}:{port.pid:04x}"


_PORTS: Columns = (
    Column("port", "port", of="device"),
    Column("board", "board", of=lambda port: getattr(identify(port), "board", None), words=_describe_board),
    Column("mode", of=lambda port: getattr(identify(port), "mode", None)),
    Column("", "USB id", words=_usb_id),
    *fields("vid pid serial_number"),
    Column("description", "description", words=lambda port: port.description or UNKNOWN),
)
