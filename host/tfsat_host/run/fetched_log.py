"""A recording's way from the logger into a file of this computer."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from tfsat_host.devices.board_errors import BoardError, board_error
from tfsat_host.devices.log_copies import FetchedLogs, PartialLog, sha256_if_same
from tfsat_host.devices.log_transfer import RAM, Listing, copy_name, entry_words
from tfsat_host.devices.logger import STOP_TIMEOUT_S, LoggerClient
from tfsat_host.errors import TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import Output
from tfsat_host.protocol.enums import DropPhase, ErrorCode, LoggerState
from tfsat_host.protocol.messages import ErrorReply, LogEntry, LogReadRequest
from tfsat_host.run.held_maneuver import HeldManeuver, copy_note, find_note, note_held
from tfsat_host.run.recording_copy import Copy, size_words
from tfsat_host.user_folders import NoUserFolder

FALL_WAIT_S = 15.0
"""RAM takes a drop until 5 s after the release at the earliest and a second after the landing."""
# end_capture() waits for nothing: for so long the listing may still be refused as WRONG_STATE.
_ENDING_S = 2.0


def listing_after_the_drop(logger: LoggerClient, out: Output) -> Listing:
    """Read the logger's listing, after the end of any capture into RAM.

    Waits for a drop that is being captured into RAM; ends any other capture only if a person agrees.
    """
    # The logger refuses to list while it records, or while its RAM still takes a capture.
    try:
        return logger.listing()
    except BoardError as error:
        status = logger.status()
        # A healthy recording is not ended here; only one that has failed or is closing is worth the wait.
        if error.code != ErrorCode.WRONG_STATE or status.state not in (
            LoggerState.FAILED,
            LoggerState.STOPPING,
        ):
            raise
    # The logger gives up a card that is gone after 15 s by itself, so this wait has an end.
    if status.state == LoggerState.STOPPING:
        with out.progress("Waiting: the logger tries to write the recording's end to its card"):
            return logger.wait_for_listing(STOP_TIMEOUT_S)
    # The release was seen: the capture ends by itself, and a stop now would cut the fall short.
    if status.phase != DropPhase.WAITING:
        with out.progress("Waiting for the recording's end: the card has failed, the drop goes into RAM"):
            return logger.wait_for_listing(FALL_WAIT_S)
    # No release yet, and RAM goes on as a ring: only a person knows whether a drop is still to come.
    out.confirm(
        "The card has failed, and the logger goes on in its RAM. Fetching ends that: a drop after it would not be "
        "recorded. Fetch now?",
        meaning="Nothing was done: the newest seconds stay in RAM, and it would keep a drop.",
    )
    logger.end_capture()
    return logger.wait_for_listing(_ENDING_S)


def pick(listing: Listing, number: int) -> LogEntry:
    """Return the recording of that number. Raises BoardError, as the logger would."""
    for entry in listing.entries:
        if entry.number == number:
            return entry
    if listing.card_error is not None and number != RAM:
        raise listing.card_error
    raise board_error(ErrorReply(LogReadRequest.TYPE, ErrorCode.NO_SUCH_LOG, -1))


def select_logs(logger: LoggerClient, listing: Listing, number: int | None) -> list[LogEntry]:
    """Return the recording of that number, or all if it is None. Raises BoardError.

    Of all, RAM's is included only where it holds more than the card.
    """
    if number is not None:
        return [pick(listing, number)]
    holds_drop = bool(logger.status().ram_holds_drop)
    # Only a recording that was closed is sure to have its end.
    blocks_by_session = {
        entry.session: entry.blocks for entry in listing.entries if entry.number != RAM and entry.closed
    }
    entries = [
        entry
        for entry in listing.entries
        if entry.number != RAM or holds_drop or blocks_by_session.get(entry.session, -1) < entry.blocks
    ]
    # An empty list off a card that failed is not an empty card.
    if not entries and listing.card_error is not None:
        raise listing.card_error
    return entries


def target_of(entry: LogEntry, place: str | None, *, several: bool) -> Path:
    """Return the path a recording is written to.

    `place` is a file or a folder, as typed; for several recordings, a folder.
    """
    if place is None:
        return Path(copy_name(entry))
    is_folder = several or place.endswith(("/", os.sep)) or Path(place).is_dir()
    return Path(place) / copy_name(entry) if is_folder else Path(place)


def fetch(logger: LoggerClient, entry: LogEntry, target: Path, out: Output, *, force: bool) -> Copy:
    """Fetch the recording to `target` unless it is there already; `force` overwrites another file.

    Raises:
        TfsatError: another file is there; the disk, the cable or the card fails. Blocks received are kept.
    """
    fetched, serial = FetchedLogs(), logger.identity.serial
    # A remembered copy is hashed again: only one that is unchanged saves the transfer.
    sha256 = fetched.sha256_of(serial, entry, target)
    # A file that nobody remembers may still be this recording, copied by hand: compare before refusing.
    if sha256 is None and target.exists() and not force:
        sha256 = sha256_if_same(logger, entry, target)
        if sha256 is None:
            raise TfsatError(
                what=f"{target} exists and is not this recording (session {entry.session:08x}).",
                meaning="Nothing was overwritten.",
                next_step="Name another place with --out, or add --force to overwrite it.",
            )
        _remember(fetched, serial, entry, target, sha256, out)
    if sha256 is not None:
        return Copy(entry, target, sha256, fetched=False)
    # Blocks in NAME.part that prove themselves by CRC and session are not asked for again.
    with PartialLog(target, entry, replace=force) as partial:
        copy = Copy(entry, target, resumed_blocks=partial.present_blocks)
        if partial.present_blocks:
            out.note(
                f"{partial.path} has {partial.present_blocks} of {entry.blocks} blocks already: going on."
            )
        description = f"Fetching {entry_words(entry)}, {size_words(entry.blocks)}"
        with (
            _kept_on_failure(partial, entry, out) as count,
            out.progress(description, total=entry.blocks) as advance,
        ):
            advance(partial.present_blocks)

            def put(index: int, block: bytes) -> None:
                # Count a block only once the unbuffered file has it: a full disk fails here.
                partial.put(index, block)
                count()
                advance(1)

            copy.outcome = logger.fetch_blocks(entry, partial.missing, put)
        copy.sha256 = partial.finish()
    # A copy with zeros for unreadable blocks must not let `log erase` delete the original.
    if not copy.outcome.unreadable:
        _remember(fetched, serial, entry, target, copy.sha256, out)
    return copy


def _remember(
    fetched: FetchedLogs, serial: str, entry: LogEntry, path: Path, sha256: str, out: Output
) -> None:
    """Note the copy on this computer; where that cannot be written, the copy is whole all the same."""
    try:
        fetched.add(serial, entry, path, sha256)
    except (OSError, NoUserFolder) as error:
        why = f"{error.what} {error.next_step}" if isinstance(error, NoUserFolder) else f"{error}."
        out.warn(f"{path} is whole, but this computer will not remember it: log erase will refuse. {why}")


@contextmanager
def _kept_on_failure(partial: PartialLog, entry: LogEntry, out: Output) -> Iterator[Callable[[], None]]:
    """Gives a function that counts blocks; an end before the last one is reported with those that are kept."""
    have = partial.present_blocks

    def count() -> None:
        nonlocal have
        have += 1

    def kept() -> str:
        return f"{have} of {entry.blocks} blocks are kept in {partial.path}."

    try:
        yield count
    except KeyboardInterrupt:
        # An interruption costs nothing: the next attempt finds the kept blocks by their CRC.
        out.note(f"{kept()} The same command goes on from there.")
        raise
    except OSError as error:
        raise TfsatError(
            what=f"{partial.path}: {error.strerror or error}.",
            meaning=f"{kept()} The recording on the logger is unchanged.",
            next_step=f"Make room, {size_words(entry.blocks - have)} are to come; then the same "
            "log fetch goes on from there.",
        ) from None
    except TfsatError as error:
        # A board's refusal brings its own next step; after a broken link the fetch is to be repeated.
        if isinstance(error, BoardError):
            raise error.with_words(meaning=f"{error.meaning} {kept()}") from None
        raise error.with_words(
            meaning=f"{kept()} The recording on the logger is unchanged.",
            next_step=Advice(error.next_step, "\nThe same log fetch goes on from there."),
        ) from None


def note_maneuvers(
    copies: Sequence[Copy], listing: Listing, out: Output, ask: Callable[[], HeldManeuver | None] | None
) -> None:
    """Copy beside each recording the note of the maneuver that the sequencer held.

    A session without a note gets one now if it is the newest and the board still reports the fall that it flew.

    `ask` reads the sequencer back; None: there is none to be asked.
    """
    # What the sequencer holds now can only have flown in the newest session.
    newest = max(listing.entries, key=lambda entry: entry.number, default=None)
    if (
        ask is not None
        and newest is not None
        and any(
            copy.entry.session == newest.session and find_note(copy.path, newest.session) is None
            for copy in copies
        )
    ):
        held_maneuver = ask()
        # Only a board that cannot have taken an upload since the fall proves what flew.
        if held_maneuver is not None and held_maneuver.has_flown:
            note_held(held_maneuver, newest.session, "log fetch", out.note)
    for copy in copies:
        copy.maneuver = copy_note(copy.path, copy.entry.session, out.note)


def release_ram(logger: LoggerClient, copy: Copy, out: Output) -> bool:
    """Gives RAM free once its drop is on this computer's disk, each block proven; whether it did."""
    if copy.entry.number != RAM or not logger.status().ram_holds_drop:
        return False
    # RAM is the only original: it is not given up for a copy with holes.
    if copy.outcome.torn or copy.outcome.unreadable:
        out.warn(
            Advice(
                "The copy of RAM is not whole, so the logger keeps it. To give it up: ",
                NextStep("log erase", ("ram",)),
            )
        )
        return False
    logger.erase_log(copy.entry)
    return True
