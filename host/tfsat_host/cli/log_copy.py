"""A recording on this computer: what it is worth, for people and as JSON."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.log_words import ENTRIES, size_words
from tfsat_host.devices.log_names import RAM, entry_words
from tfsat_host.devices.log_transfer import Listing, Outcome
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.protocol.messages import LogEntry
from tfsat_host.quantity import fields, record

if TYPE_CHECKING:
    from tfsat_host.present.output import Output

_DECODED = ("verdict", "samples", "samples_lost", "blocks_lost", "duration_s", "rate_hz")


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
        facts: What decoding says; empty where nothing can be decoded.
        warnings: What is lost or doubtful.
    """

    entry: LogEntry
    path: Path
    sha256: str = ""
    fetched: bool = True
    resumed_blocks: int = 0
    outcome: Outcome = field(default_factory=Outcome)
    facts: dict[str, Any] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)

    @property
    def is_whole(self) -> bool:
        """It holds what the logger holds, and nothing of it is damaged."""
        return not self.outcome.torn and not self.outcome.unreadable


def judge(copy: Copy, listing: Listing) -> None:
    """Adds what the file is worth, by decoding it; where nothing can be, whether RAM has something."""
    from tfsat_host import sdlog
    from tfsat_host.sdlog.errors import LogError
    from tfsat_host.sdlog.summary import summary

    name = entry_words(copy.entry)
    for blocks, what in (
        (copy.outcome.unreadable, "the card does not read them; the copy has zeros there"),
        (copy.outcome.torn, "their CRC does not match: they are torn on the card itself"),
    ):
        if blocks:
            listed = ", ".join(map(str, blocks[:8])) + (", …" if len(blocks) > 8 else "")
            copy.warnings.append(f"{name}, {len(blocks)} blocks ({listed}): {what}.")
    try:
        copy.facts = summary(sdlog.load(copy.path))
        copy.warnings += copy.facts["warnings"]
    except LogError as error:
        copy.warnings.append(
            f"{name} was copied whole, but it cannot be decoded. {error.what} {error.meaning}"
        )
        if any(_is_in_ram(each, copy.entry) for each in listing.entries):
            copy.warnings.append("RAM has samples of that recording: tfsat-host log fetch ram")


def _is_in_ram(listed: LogEntry, on_card: LogEntry) -> bool:
    return listed.number == RAM != on_card.number and listed.session == on_card.session


_COPY = fields(
    "fetched sha256 resumed_blocks torn_blocks=outcome.torn unreadable_blocks=outcome.unreadable warnings"
)


def copy_as_dict(copy: Copy) -> dict[str, Any]:
    """For `--json`."""
    return {
        **record(ENTRIES, copy.entry),
        "file": copy.path,
        **record(_COPY, copy),
        **{name: copy.facts.get(name) for name in _DECODED},
    }


def show_copy(copy: Copy, out: Output) -> None:
    """For people."""
    how = "every block checked" if copy.fetched else "fetched before, unchanged"
    size = size_words(copy.entry.blocks * BLOCK_BYTES)
    out.line(f"{copy.path}: {size}, session {copy.entry.session:08x}, {how}.")
    if not copy.facts:
        return
    facts = copy.facts
    rate = "unknown rate" if facts["rate_hz"] is None else f"{facts['rate_hz']:.2f} Hz"
    out.line(
        f"  {facts['verdict']}: {facts['samples']} samples in {facts['duration_s']:.3f} s, {rate}, "
        f"{facts['samples_lost']} lost"
    )
    out.line(f"  tfsat-host decode {copy.path}")
