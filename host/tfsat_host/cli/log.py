"""`tfsat-host log`: the logger's recordings over the cable: what there is, fetching, erasing."""

from __future__ import annotations

import argparse
from functools import partial
from typing import Any

from tfsat_host.cli.boards import open_logger
from tfsat_host.cli.usage import add_actions, device, file_name
from tfsat_host.exit_code import ExitCode
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import Output
from tfsat_host.quantity import record
from tfsat_host.run.held_maneuver import ask_sequencer

_RAM = 0
_ACTIONS = """
list   what is on the logger's card, and in its RAM
fetch  copy a recording to this computer, each block checked; goes on where it was interrupted
    N|ram|all   number as listed, what RAM holds, or all
    --out PATH  file, or folder; a name that ends with / is a new one (default: the recording's own name in the current
                folder)
    --force     overwrite another file of that name
erase  remove a recording that was fetched from the card
    N|ram    number as listed, or what RAM holds
    --force  even if this computer has no copy of it: it is lost then
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """List, fetch or erase; the device."""
    which = {"n|ram": _which, "n|ram|all": _which_or_all}
    kinds: dict[str, Any] = {name: {"type": kind, "dest": "which"} for name, kind in which.items()}
    add_actions(parser, _ACTIONS, after=device("logger"), out=_place, **kinds)


def run(args: argparse.Namespace, out: Output) -> int:
    """Does what was typed."""
    return {"list": _list, "fetch": _fetch, "erase": _erase}[args.action](args, out)


def _list(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.run.logger_recordings import RAM_WARNING, RECORDINGS, LoggerRecordings

    with open_logger(args, out) as logger:
        recordings = LoggerRecordings.of(logger)
    if args.emulated:
        serving = Advice("The robot of --emulated records nothing. For a recording: ", NextStep("emulate"))
        # As it is: with --emulated it would be the robot of that command's own process.
        out.note(Advice(serving, f", then in another terminal {NextStep('record start')}"))
    out.result(record(RECORDINGS, recordings), lambda: recordings.show(out))
    if recordings.status.ram_holds_drop:
        out.warn(RAM_WARNING)
    if recordings.card_error is not None:
        out.warn(f"The card's recordings cannot be listed. {recordings.card_error.what}")
    return 0


def _fetch(args: argparse.Namespace, out: Output) -> int:
    """Fetches one recording or all, judges them, and gives RAM free once its drop is safe."""
    from tfsat_host.run.fetched_log import (
        fetch,
        listing_after_the_drop,
        note_maneuvers,
        release_ram,
        select_logs,
        target_of,
    )
    from tfsat_host.run.logger_recordings import RAM_WARNING
    from tfsat_host.run.recording_copy import FETCHED, FetchedRecordings

    with open_logger(args, out) as logger:
        listing = listing_after_the_drop(logger, out)
        copies = []
        for entry in select_logs(logger, listing, args.which):
            target = target_of(entry, args.out, several=args.which is None)
            copies.append(fetch(logger, entry, target, out, force=args.force))
            copies[-1].judge(listing)
        ask = partial(ask_sequencer, out.note, logger_named=args.port is not None)
        note_maneuvers(copies, listing, out, None if args.emulated else ask)
        released = any(release_ram(logger, copy, out) for copy in copies)
        result = FetchedRecordings(copies, released, bool(logger.status().ram_holds_drop), logger.device())
    out.result(record(FETCHED, result), lambda: result.show(out))
    for copy in copies:
        out.warn_each(copy.warnings)
    if result.ram_holds_drop:
        out.warn(RAM_WARNING)
    card_left_out = args.which is None and listing.card_error is not None
    if card_left_out:
        out.warn(f"Nothing of the card was fetched. {listing.card_error}")
    return ExitCode.DATA_LOSS if card_left_out or any(copy.warnings for copy in copies) else 0


def _erase(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.run.logger_recordings import ERASED, erase

    with open_logger(args, out) as logger:
        erased = erase(logger, args.which, out, force=args.force)
        out.result(record(ERASED, erased), erased.sentence)
    return 0


def _place(text: str) -> str:
    """Check the name of a file or folder and return it as typed (argparse type).

    Raises ArgumentTypeError for an empty name.
    """
    file_name(text)
    return text


def _which(text: str) -> int:
    if text.lower() == "ram":
        return _RAM
    if not (text.isascii() and text.isdigit() and 0 < int(text) < 2**16):
        raise argparse.ArgumentTypeError(f"{text!r} is no recording: write its number as listed, ram or all")
    return int(text)


def _which_or_all(text: str) -> int | None:
    return None if text.lower() == "all" else _which(text)
