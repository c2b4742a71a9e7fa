"""`tfsat-host status`: what the boards are doing."""

from __future__ import annotations

import argparse
from contextlib import ExitStack, closing
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.boards import PLACE, Place, absent, interruptible, most_telling, places
from tfsat_host.cli.usage import add_options
from tfsat_host.devices.serial_ports import BOARDS, BoardName
from tfsat_host.errors import Interrupted, TfsatError
from tfsat_host.json_values import error_as_dict
from tfsat_host.next_step import Advice
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.present.sequencer_state import Rows


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options that select the boards: those found, one port, or the emulated ones."""
    add_options(parser, PLACE)


def run(args: argparse.Namespace, out: Output) -> int:
    """Asks every board that can be reached; one that is missing is a note, not a failure, if another answers."""
    answers: dict[BoardName, tuple[dict[str, Any], Rows]] = {}
    errors: list[tuple[BoardName | None, TfsatError]] = []
    with ExitStack() as stack:
        for place in places(args, out, stack):
            try:
                board, state, rows = _ask(place)
            except Interrupted:
                raise
            except TfsatError as error:
                errors.append((place.expected, error))
                continue
            if place.expected not in (None, board):
                out.warn(f"{place.said_by} is the {board}'s port, not the {place.expected}'s: correct it.")
                if board in answers:
                    continue
            answers[board] = state, rows
    if not answers:
        raise most_telling([error for _, error in errors])
    board_states: dict[str, Any] = dict.fromkeys(BOARDS)
    for missed, reason in errors:
        out.note(reason.what)
        if missed is not None and not absent(reason):
            board_states[missed] = {"error": error_as_dict(reason)}
    board_states |= {board: state for board, (state, _) in answers.items()}
    _stand_against_arming(board_states, answers)
    out.result(board_states, lambda: _show([row for _, rows in answers.values() for row in rows], out))
    _warn(board_states["logger"], out)
    return 0


def _warn(logger: dict[str, Any] | None, out: Output) -> None:
    if logger is None:
        return
    for text in logger.get("attention", ()):
        out.warn(text)
    if logger.get("ram_holds_drop"):
        from tfsat_host.run.logger_recordings import RAM_WARNING

        out.warn(RAM_WARNING)


def _stand_against_arming(
    board_states: dict[str, Any], answers: dict[BoardName, tuple[dict[str, Any], Rows]]
) -> None:
    """Show the logger's reason to refuse arming in the sequencer's arming row.

    The sequencer does not know of the logger.
    """
    from tfsat_host.present.sequencer_state import READY_TO_ARM

    refusal = (board_states["logger"] or {}).get("arm_refusal")
    if refusal is None or "sequencer" not in answers:
        return
    state, rows = answers["sequencer"]
    arming = ("  arming", READY_TO_ARM)
    if arming in rows:
        state["arm_refusal"] = refusal
        text = f"would be refused because of the logger. {refusal['what']} {refusal['next_step']}"
        rows[rows.index(arming)] = ("  arming", " ".join(text.split()))


def _show(rows: Rows, out: Output) -> None:
    for name, text in rows:
        width = 14 if name.startswith(" ") else 10
        out.line(Advice(f"{name:<{width}} ", text))


def _ask(place: Place) -> tuple[BoardName, dict[str, Any], Rows]:
    """Name, state and lines of the board at the other end."""
    from tfsat_host.devices.client import Client
    from tfsat_host.devices.logger import LoggerClient
    from tfsat_host.devices.sequencer import SequencerClient
    from tfsat_host.present.logger_state import logger_state
    from tfsat_host.present.sequencer_state import sequencer_state
    from tfsat_host.protocol.enums import Board

    with closing(place.connect()) as transport, interruptible(transport.name):
        client = Client(transport)
        identity = client.hello()
        name: BoardName = "sequencer" if identity.board == Board.SEQUENCER else "logger"
        if name == "sequencer":
            state, lines = sequencer_state(SequencerClient(client, identity))
        else:
            state, lines = logger_state(LoggerClient(client, identity))
        device = {"port": transport.name, **identity.as_dict()}
        return name, {"device": device, **state}, [(name, f"{transport.name}, {identity.describe()}"), *lines]
