"""A recording of a logger on this computer: how it is listed, what its copy is worth, as JSON and for people."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import datetime
from math import isfinite
from pathlib import Path

from tfsat_host import sdlog
from tfsat_host.devices.board_identity import DEVICE, Device
from tfsat_host.devices.log_transfer import RAM, Listing, Outcome, copy_name, entry_words
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.logger_state import clock_words
from tfsat_host.present.output import Output
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.protocol.messages import LogEntry
from tfsat_host.quantity import Column, Columns, columns_of, fields
from tfsat_host.sdlog.log_errors import LogError
from tfsat_host.sdlog.log_summary import warnings
from tfsat_host.units import US_PER_S


def _clock_iso(unix_us: int) -> str | None:
    # 0 stands for a logger whose clock was not set.
    if not unix_us:
        return None
    return datetime.fromtimestamp(unix_us / US_PER_S).astimezone().isoformat(timespec="milliseconds")


def size_words(blocks: int) -> str:
    """Format the size of a number of blocks in KiB or MiB."""
    n_bytes = blocks * BLOCK_BYTES
    return f"{n_bytes / 2**20:.1f} MiB" if n_bytes >= 2**20 else f"{n_bytes / 2**10:.1f} KiB"


def which_words(entry: LogEntry) -> str:
    """Return the recording's identifier as typed on the command line."""
    return "ram" if entry.number == RAM else str(entry.number)


ENTRIES: Columns = (
    Column("number", "number", words=which_words),
    Column("in_ram", of=lambda entry: entry.number == RAM),
    Column("name", "file", of=copy_name, words=lambda e: "(in RAM)" if e.number == RAM else copy_name(e)),
    Column(
        "start",
        "start",
        of=lambda entry: _clock_iso(entry.wall_clock_us),
        words=lambda entry: clock_words(entry.wall_clock_us),
    ),
    Column(
        "bytes",
        "size",
        of=lambda entry: entry.blocks * BLOCK_BYTES,
        words=lambda entry: size_words(entry.blocks),
    ),
    Column("closed", "closed", of=lambda entry: bool(entry.closed)),
    Column("session", "session", of=lambda entry: f"{entry.session:08x}"),
)
"""Recordings on a card."""


@dataclass(frozen=True, slots=True)
class DecodedCopy:
    """What the decoder says of a copy; the rate is None where it is unknown."""

    verdict: str
    samples: int
    samples_lost: int
    blocks_lost: int
    duration_s: float
    rate_hz: float | None


@dataclass
class Copy:
    """One recording on this computer.

    Attributes:
        entry: As listed.
        path: Where it is.
        sha256: Of the file.
        fetched: By this command; otherwise it was there already, unchanged.
        resumed_blocks: Blocks that an earlier attempt had fetched.
        outcome: What became of its blocks.
        maneuver: The note beside it of what the sequencer held; None: not known.
        decoded: None where nothing can be decoded.
        warnings: What is lost or doubtful.
    """

    entry: LogEntry
    path: Path
    sha256: str = ""
    fetched: bool = True
    resumed_blocks: int = 0
    outcome: Outcome = field(default_factory=Outcome)
    maneuver: Path | None = None
    decoded: DecodedCopy | None = None
    warnings: list[str] = field(default_factory=list)

    def judge(self, listing: Listing) -> None:
        """Adds what the file is worth, by decoding it; where nothing can be, whether RAM has something."""
        name = entry_words(self.entry)
        # Keep the two apart: an unreadable block is zeros in the copy, a torn one has the card's own bytes.
        for blocks, what in (
            (self.outcome.unreadable, "the card does not read them; the copy has zeros there"),
            (self.outcome.torn, "their CRC does not match: they are torn on the card itself"),
        ):
            if blocks:
                listed = ", ".join(map(str, blocks[:8])) + (", …" if len(blocks) > 8 else "")
                self.warnings.append(f"{name}, {len(blocks)} blocks ({listed}): {what}.")
        # A copy may be right byte for byte and yet hold no block that can be decoded.
        try:
            log = sdlog.load(self.path)
            self.decoded = DecodedCopy(
                log.verdict,
                len(log),
                log.samples_lost,
                log.blocks_lost,
                log.duration_s,
                log.rate_hz if isfinite(log.rate_hz) else None,
            )
            self.warnings += warnings(log)
        except LogError as error:
            self.warnings.append(
                f"{name} was copied whole, but it cannot be decoded. {error.what} {error.meaning}"
            )
            # RAM's ring may hold samples of this very session that never reached the card.
            if self.entry.number != RAM and any(
                other.number == RAM and other.session == self.entry.session for other in listing.entries
            ):
                self.warnings.append(
                    Advice("RAM has samples of that recording: ", NextStep("log fetch", ("ram",)))
                )

    def show(self, out: Output) -> None:
        """Print the copy's summary for people."""
        how = "every block checked" if self.fetched else "fetched before, unchanged"
        size = size_words(self.entry.blocks)
        out.line(f"{self.path}: {size}, session {self.entry.session:08x}, {how}.")
        if decoded := self.decoded:
            rate = "unknown rate" if decoded.rate_hz is None else f"{decoded.rate_hz:.2f} Hz"
            out.line(
                f"  {decoded.verdict}: {decoded.samples} samples in {decoded.duration_s:.3f} s, {rate}, "
                f"{decoded.samples_lost} lost"
            )
            out.line(Advice("  ", NextStep("decode", (str(self.path),))))


_COPY: Columns = (
    *columns_of("entry", ENTRIES),
    *fields("file=path fetched sha256 resumed_blocks torn_blocks=outcome.torn"),
    *fields("unreadable_blocks=outcome.unreadable maneuver warnings"),
    *(Column(name, of=f"decoded.{name}") for name in DecodedCopy.__annotations__),
)


@dataclass(frozen=True, eq=False)
class FetchedRecordings:
    """Recordings that are on this computer now.

    Attributes:
        copies: The recordings.
        ram_released: The logger's RAM was given free.
        ram_holds_drop: The logger's RAM holds a drop that no card has.
        device: The logger.
    """

    copies: Sequence[Copy]
    ram_released: bool
    ram_holds_drop: bool
    device: Device

    def show(self, out: Output) -> None:
        """Print each copy's summary for people."""
        if not self.copies:
            out.line("No recordings.")
        for copy in self.copies:
            copy.show(out)
        if self.ram_released:
            out.line(
                "The drop is safe on this computer; the logger's RAM is free, a recording may be started."
            )


FETCHED: Columns = (
    Column("logs", of="copies", columns=_COPY),
    *fields("ram_released ram_holds_drop"),
    Column("device", columns=DEVICE),
)
"""Of `log fetch --json`."""
