"""What a logger has on its card and in its RAM: listed, and erased once a copy is safe."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Self

from tfsat_host.devices.board_errors import BoardError
from tfsat_host.devices.board_identity import DEVICE, Device
from tfsat_host.devices.log_copies import FetchedLogs
from tfsat_host.devices.log_transfer import RAM, entry_words
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.error_columns import error_columns
from tfsat_host.errors import RefusedError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.logger_state import card_words
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show_rows
from tfsat_host.protocol.messages import LogEntry, LoggerStatusReply
from tfsat_host.quantity import UNKNOWN, Column, Columns, columns_of, fields
from tfsat_host.run.fetched_log import pick
from tfsat_host.run.recording_copy import ENTRIES, which_words

RAM_WARNING = Advice(
    "RAM HOLDS A DROP THAT NO CARD HAS. It is gone with the logger's power: keep it on, and type: ",
    NextStep("log fetch", ("ram",)),
)


@dataclass(frozen=True, slots=True)
class ListedRecording:
    """A recording on a logger, and where this computer has it; None where it has none."""

    entry: LogEntry
    copy: Path | None


_LISTED: Columns = (
    *columns_of("entry", ENTRIES),
    Column("fetched_to", "fetched to", of="copy", words=lambda listed: str(listed.copy or UNKNOWN)),
)


@dataclass(frozen=True, eq=False)
class LoggerRecordings:
    """What a logger has.

    Attributes:
        recordings: As the logger lists them.
        status: The logger's.
        card_error: Why the card's are not listed.
        device: The logger.
    """

    recordings: list[ListedRecording]
    status: LoggerStatusReply
    card_error: BoardError | None
    device: Device

    @classmethod
    def of(cls, logger: LoggerClient) -> Self:
        """Raises BoardError, as the logger does."""
        listing, fetched = logger.listing(), FetchedLogs()
        serial = logger.identity.serial
        recordings = [ListedRecording(entry, fetched.copy_of(serial, entry)) for entry in listing.entries]
        return cls(recordings, logger.status(), listing.card_error, logger.device())

    def show(self, out: Output) -> None:
        """Print the logger's recordings for people."""
        if self.recordings:
            show_rows(_LISTED, self.recordings, out)
        else:
            out.line("No recordings." if self.card_error is None else "No recordings can be read.")
        out.line(f"Card: {card_words(self.status)}.")
        if self.status.ram_holds_drop:
            out.line("RAM: A DROP THAT IS NOT ON THE CARD, until power goes off")
        elif any(listed.entry.number == RAM for listed in self.recordings):
            out.line("RAM: end of the last recording, until power goes off")


RECORDINGS: Columns = (
    Column("logs", of="recordings", columns=_LISTED),
    Column("ram_holds_drop", of=lambda logger: bool(logger.status.ram_holds_drop)),
    *fields("card=status.card card_free_mib=status.card_free_mib"),
    Column("card_error", columns=error_columns),
    Column("device", columns=DEVICE),
)
"""Of `log list --json`."""


@dataclass(frozen=True, slots=True)
class ErasedRecording:
    """A recording that was erased, the copy that is left of it, the logger, and the act in words."""

    entry: LogEntry
    copy: Path | None
    device: Device
    sentence: str


ERASED: Columns = (
    *columns_of("entry", ENTRIES),
    Column("erased", of=lambda _: True),
    *fields("copy"),
    Column("device", columns=DEVICE),
)
"""Of `log erase --json`."""


def erase(logger: LoggerClient, number: int, out: Output, *, force: bool) -> ErasedRecording:
    """Erase a recording after a confirmation; RAM's is given free.

    Raises:
        RefusedError: this computer has no copy of it, and not `force`.
        BoardError: there is none of that number.
    """
    entry = pick(logger.listing(), number)
    # Asked before the erasure: afterwards the status no longer tells what was given up.
    in_ram, holds_drop = entry.number == RAM, bool(logger.status().ram_holds_drop)
    copy = FetchedLogs().copy_of(logger.identity.serial, entry)
    # RAM without a drop needs no copy: the next recording overwrites it in any case.
    if copy is None and not force and (not in_ram or holds_drop):
        raise RefusedError(
            what=f"This computer has no copy of {entry_words(entry)} (session {entry.session:08x}), "
            "or the copy has changed since.",
            meaning="Erased, it would be lost. Nothing was erased.",
            next_step=Advice(
                NextStep("log fetch", (which_words(entry),)),
                "\nTo erase it all the same: the same command with --force",
            ),
        )
    copy_text = f"Copy: {copy}." if copy else "NO COPY is known to this computer."
    out.confirm(f"{copy_text} Erase {entry_words(entry)}?", meaning="Nothing was erased.")
    logger.erase_log(entry)
    # RAM is overwritten by the next recording; until then it stays as it is.
    text = f"Erased: {entry_words(entry)}."
    if in_ram and copy is not None:
        text = f"RAM is free for the next recording; what it held is safe: {copy}."
    elif in_ram and holds_drop:
        text = "Given up: a recording may be started again."
    elif in_ram:
        text = "RAM held no drop that needed keeping; a recording may be started."
    return ErasedRecording(entry, copy, logger.device(), text)
