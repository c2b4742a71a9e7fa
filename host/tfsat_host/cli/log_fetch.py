"""`tfsat-host log fetch`: a recording's way into a file."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from tfsat_host.cli.advice import device_option
from tfsat_host.cli.connection import open_logger
from tfsat_host.cli.fetched import FetchedLogs
from tfsat_host.cli.log import pick, ram_warning
from tfsat_host.cli.log_copy import Copy, copy_as_dict, judge, show_copy
from tfsat_host.cli.log_words import size_words
from tfsat_host.devices.client import BoardError
from tfsat_host.devices.log_compare import sha256_if_same
from tfsat_host.devices.log_names import RAM, copy_name, entry_words
from tfsat_host.devices.log_transfer import Listing
from tfsat_host.devices.logger import STOP_TIMEOUT_S, LoggerClient
from tfsat_host.devices.partial_log import PartialLog
from tfsat_host.errors import DataLossError, TfsatError
from tfsat_host.present.output import Output
from tfsat_host.protocol.enums import DropPhase, ErrorCode, LoggerState
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.protocol.messages import LogEntry

FALL_WAIT_S = 15.0
"""RAM takes a drop until 5 s after the release at the earliest and a second after the landing."""
_ENDING_S = 2.0


def fetch(args: argparse.Namespace, out: Output) -> int:
    """Fetches one recording or all, judges them, and gives RAM free once its drop is safe."""
    fetched = FetchedLogs()
    with open_logger(args, out) as logger:
        listing = _listing(logger, out)
        copies = []
        for entry in _wanted(args, logger, listing):
            copy = _fetch_one(logger, entry, _target(args, entry), fetched, args, out)
            judge(copy, listing)
            copies.append(copy)
        released = any(_release_ram(logger, copy, out) for copy in copies)
        holds_drop = bool(logger.status().ram_holds_drop)
        result = {
            "logs": [copy_as_dict(copy) for copy in copies],
            "ram_released": released,
            "ram_holds_drop": holds_drop,
            "device": {"port": logger.port, **logger.identity.as_dict()},
        }
    out.result(result, lambda: _show(copies, released, out))
    for copy in copies:
        for warning in copy.warnings:
            out.warn(warning) if not warning.startswith(" ") else out.note(warning)
    if holds_drop:
        out.warn(ram_warning(device_option(args)))
    card_left_out = args.which is None and listing.card_error is not None
    if card_left_out:
        out.warn(f"Nothing of the card was fetched. {listing.card_error}")
    return DataLossError.exit_code if card_left_out or any(copy.warnings for copy in copies) else 0


def _listing(logger: LoggerClient, out: Output) -> Listing:
    """What there is. A drop that RAM still takes is waited for; any other capture ends only if a person agrees."""
    try:
        return logger.listing()
    except BoardError as error:
        status = logger.status()
        if error.code != ErrorCode.WRONG_STATE or status.state not in (
            LoggerState.FAILED,
            LoggerState.STOPPING,
        ):
            raise
    if status.state == LoggerState.STOPPING:
        with out.progress("the logger tries to write the recording's end to its card: waiting"):
            return logger.wait_for_listing(STOP_TIMEOUT_S)
    if status.phase != DropPhase.WAITING:
        with out.progress("the card has failed and the drop goes into RAM: waiting for its end"):
            return logger.wait_for_listing(FALL_WAIT_S)
    out.confirm(
        "The card has failed, and the logger goes on in its RAM. Fetching ends that: a drop after it would not be "
        "recorded. Fetch now?",
        meaning="Nothing was done: the newest seconds stay in RAM, and it would keep a drop.",
    )
    logger.end_capture()
    return logger.wait_for_listing(_ENDING_S)


def _wanted(args: argparse.Namespace, logger: LoggerClient, listing: Listing) -> list[LogEntry]:
    """The one that was named; of all, RAM's only where it has more than the card. Raises BoardError."""
    if args.which is not None:
        return [pick(listing, args.which)]
    holds_drop = bool(logger.status().ram_holds_drop)
    on_card = [entry for entry in listing.entries if entry.number != RAM]
    wanted = [
        entry
        for entry in listing.entries
        if entry.number != RAM or holds_drop or not any(_has_all_of(each, entry) for each in on_card)
    ]
    if not wanted and listing.card_error is not None:
        raise listing.card_error
    return wanted


def _has_all_of(on_card: LogEntry, in_ram: LogEntry) -> bool:
    """Only a recording that was closed is sure to have its end."""
    return on_card.session == in_ram.session and bool(on_card.closed) and on_card.blocks >= in_ram.blocks


def _target(args: argparse.Namespace, entry: LogEntry) -> Path:
    if args.out is None:
        return Path(copy_name(entry))
    place = Path(args.out)
    is_folder = args.which is None or args.out.endswith(("/", os.sep)) or place.is_dir()
    return place / copy_name(entry) if is_folder else place


def _fetch_one(
    logger: LoggerClient,
    entry: LogEntry,
    target: Path,
    fetched: FetchedLogs,
    args: argparse.Namespace,
    out: Output,
) -> Copy:
    serial = logger.identity.serial
    sha256 = fetched.sha256_of(serial, entry, target)
    if sha256 is None and target.exists() and not args.force:
        sha256 = sha256_if_same(logger, entry, target)
        if sha256 is None:
            raise _other_file(target, entry)
        fetched.add(serial, entry, target, sha256)
    if sha256 is not None:
        return Copy(entry, target, sha256, fetched=False)
    with PartialLog(target, entry, replace=args.force) as partial:
        copy = Copy(entry, target, resumed_blocks=partial.present_blocks)
        if partial.present_blocks:
            out.note(
                f"{partial.path} has {partial.present_blocks} of {entry.blocks} blocks already: going on."
            )
        with _kept_on_failure(partial, entry, out) as count:
            description = f"fetching {entry_words(entry)}, {size_words(entry.blocks * BLOCK_BYTES)}"
            with out.progress(description, total=entry.blocks) as advance:
                advance(partial.present_blocks)

                def put(index: int, block: bytes) -> None:
                    partial.put(index, block)
                    count()
                    advance(1)

                copy.outcome = logger.fetch_blocks(entry, partial.missing, put)
            copy.sha256 = partial.finish()
    if not copy.outcome.unreadable:
        fetched.add(serial, entry, target, copy.sha256)
    return copy


def _other_file(target: Path, entry: LogEntry) -> TfsatError:
    return TfsatError(
        what=f"{target} exists and is not this recording (session {entry.session:08x}).",
        meaning="Nothing was overwritten.",
        next_step="Name another place with --out, or add --force to overwrite it.",
    )


@contextmanager
def _kept_on_failure(partial: PartialLog, entry: LogEntry, out: Output) -> Iterator[Callable[[], None]]:
    """Gives what counts blocks; says of any end before the last that they are kept."""
    have = partial.present_blocks

    def count() -> None:
        nonlocal have
        have += 1

    def kept() -> str:
        return f"{have} of {entry.blocks} blocks are kept in {partial.path}."

    try:
        yield count
    except KeyboardInterrupt:
        out.note(f"{kept()} The same command goes on from there.")
        raise
    except OSError as error:
        raise TfsatError(
            what=f"{partial.path}: {error.strerror or error}.",
            meaning=f"{kept()} The recording is as it was, on the logger.",
            next_step=f"Make room, {size_words((entry.blocks - have) * BLOCK_BYTES)} are to come; then the same "
            "log fetch goes on from there.",
        ) from None
    except TfsatError as error:
        if isinstance(error, BoardError):
            error.meaning = f"{error.meaning} {kept()}"
        else:
            error.meaning = f"{kept()} The recording is as it was, on the logger."
            error.next_step = f"{error.next_step}\nThe same log fetch goes on from there."
        raise


def _release_ram(logger: LoggerClient, copy: Copy, out: Output) -> bool:
    """Gives RAM free once its drop is on this computer's disk, each block proven."""
    if copy.entry.number != RAM or not logger.status().ram_holds_drop:
        return False
    if not copy.is_whole:
        out.warn(
            "The copy of RAM is not whole, so the logger keeps it. To give it up: tfsat-host log erase ram"
        )
        return False
    logger.erase_log(copy.entry)
    return True


def _show(copies: list[Copy], released: bool, out: Output) -> None:
    if not copies:
        out.line("No recordings.")
    for copy in copies:
        show_copy(copy, out)
    if released:
        out.line("The drop is safe on this computer; the logger's RAM is free, a recording may be started.")
