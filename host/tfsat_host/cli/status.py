"""`tfsat-host status`: what the boards are doing."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.options import add_output_options
from tfsat_host.cli.output import Output
from tfsat_host.devices.discovery import BoardName, find_port
from tfsat_host.devices.port_errors import PortError
from tfsat_host.errors import TfsatError

if TYPE_CHECKING:
    from tfsat_host.devices.transport import Transport

Rows = list[tuple[str, str]]


def configure(parser: argparse.ArgumentParser) -> None:
    """Which boards: those that are found, one port, or the emulated ones."""
    group = parser.add_argument_group("device").add_mutually_exclusive_group()
    group.add_argument("--port", metavar="PORT", help="ask the board at this port only, whichever it is")
    group.add_argument("--emulated", action="store_true", help="ask the emulated robot's boards")
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Asks every board that can be reached; one that is missing is said, not a failure, if another answers."""
    found: dict[str, Any] = {}
    rows: Rows = []
    missing: list[TfsatError] = []
    for transport_or_error in _transports(args, out):
        if isinstance(transport_or_error, TfsatError):
            missing.append(transport_or_error)
            continue
        board, state, lines = _ask(transport_or_error)
        found[board] = state
        rows += lines
    if not found:
        raise missing[0]
    for error in missing:
        out.note(error.what)
    out.result(found, lambda: _show(rows, out))
    return 0


def _show(rows: Rows, out: Output) -> None:
    for name, text in rows:
        out.line(f"{name:<14} {text}" if name.startswith(" ") else f"{name:<10} {text}")


def _transports(args: argparse.Namespace, out: Output) -> list[Transport | TfsatError]:
    from tfsat_host.cli.connection import open_port
    from tfsat_host.devices.transport import SerialTransport

    if args.emulated:
        return _emulated_transports(out)
    if args.port is not None:
        return [open_port("sequencer", args.port, out)]
    results: list[Transport | TfsatError] = []
    boards: tuple[BoardName, ...] = ("sequencer", "logger")
    for board in boards:
        try:
            results.append(SerialTransport(find_port(board)))
        except PortError as error:
            results.append(error)
    return results


def _emulated_transports(out: Output) -> list[Transport | TfsatError]:
    from tfsat_host.emulated.build import ensure_built
    from tfsat_host.emulated.robot import SETTLE_US, BoardIndex, EmulatedRobot
    from tfsat_host.emulated.state import eeprom_path, load_eeprom
    from tfsat_host.emulated.transport import EmulatedTransport

    ensure_built(progress=out.note)
    robot = EmulatedRobot(eeprom=load_eeprom(eeprom_path()))
    robot.advance(SETTLE_US)
    return [EmulatedTransport(robot, board) for board in BoardIndex]


def _ask(transport: Transport) -> tuple[str, dict[str, Any], Rows]:
    """Name, state and lines of the board at the other end."""
    from tfsat_host.devices.client import Client
    from tfsat_host.devices.logger import LoggerClient
    from tfsat_host.devices.sequencer import SequencerClient
    from tfsat_host.protocol.enums import Board

    try:
        client = Client(transport)
        identity = client.hello()
        name = identity.board.name.lower()
        device = {"port": transport.name, **identity.as_dict()}
        head = [(name, f"{transport.name}, {identity.describe()}")]
        if identity.board == Board.SEQUENCER:
            state, lines = _sequencer(SequencerClient(client, identity))
        else:
            state, lines = _logger(LoggerClient(client, identity))
    finally:
        transport.close()
    return name, {"device": device, **state}, head + lines


def _sequencer(board: Any) -> tuple[dict[str, Any], Rows]:
    status = board.status()
    stored = board.read_back()
    state = {
        "state": status.state.name.lower(),
        "fault": status.fault.name.lower(),
        "last_refusal": status.last_refusal.name.lower(),
        "switches_closed": _closed(status.switches_open),
        "reset_cause": status.reset_cause.name.lower(),
        "strokes_started": status.strokes_started,
        "knocks": status.knocks,
        "uptime_s": status.uptime_ms / 1000,
        "maneuver": {
            "origin": stored.origin.name.lower(),
            "strokes": [
                {"t_s": start_us / 1e6, "joint": joint, "angle_deg": angle_cdeg / 100}
                for joint, angle_cdeg, start_us in stored.strokes
            ],
            "end_s": stored.end_us / 1e6,
            "crc": f"{stored.crc:04x}",
        },
    }
    strokes = ", ".join(
        f"{start_us / 1e6:.2f} s joint {joint} {angle_cdeg / 100:+g}°"
        for joint, angle_cdeg, start_us in stored.strokes
    )
    lines = [
        ("  state", _with_fault(state["state"], state["fault"])),
        ("  maneuver", f"{strokes} ({state['maneuver']['origin']})"),
        ("  switches", _switches(status.switches_open)),
        (
            "  last start",
            f"{status.reset_cause.name.lower().replace('_', ' ')}, {state['uptime_s']:.0f} s ago",
        ),
        ("  knocks", str(status.knocks)),
    ]
    return state, lines


def _logger(board: Any) -> tuple[dict[str, Any], Rows]:
    status = board.status()
    present = [bool(status.imu_present >> bit & 1) for bit in range(4)]
    state = {
        "state": status.state.name.lower(),
        "error": status.error.name.lower(),
        "imu_present": present,
        "switches_closed": _closed(status.switches_open),
        "session": f"{status.session:08x}",
        "samples": status.samples,
        "samples_dropped": status.samples_dropped,
        "blocks_written": status.blocks_written,
        "ring_peak_blocks": status.ring_peak_blocks,
        "rate_hz": status.rate_hz,
        "uptime_s": status.uptime_ms / 1000,
    }
    imus = ", ".join(f"{body} {'ok' if here else 'MISSING'}" for body, here in enumerate(present, 1))
    lines = [
        ("  state", _with_fault(state["state"], state["error"])),
        ("  IMUs", imus),
        ("  switches", _switches(status.switches_open)),
        ("  recording", f"{status.samples} samples, {status.samples_dropped} dropped, {status.rate_hz} Hz"),
    ]
    return state, lines


def _closed(switches_open: int) -> list[bool]:
    return [not switches_open >> bit & 1 for bit in range(2)]


def _switches(switches_open: int) -> str:
    return ", ".join(
        f"{number} {'closed' if closed else 'OPEN'}"
        for number, closed in enumerate(_closed(switches_open), 1)
    )


def _with_fault(state: str, fault: str) -> str:
    return state if fault == "none" else f"{state}: {fault.replace('_', ' ')}"
