"""Recordings over the cable: what there is, their blocks, and their end.

The logger sends what was asked for as unasked frames, and what the cable loses is asked for again. A block
that begins with the magic number carries its own CRC-32 and proves itself by it. One that does not is read
`READINGS` times: if it stays so, it is torn on the card itself, and the copy has it as it is.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

from tfsat_host.devices.board_errors import BoardError
from tfsat_host.devices.client import Client
from tfsat_host.errors import TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol import messages as msg
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.protocol.limits import BLOCK_BYTES, BLOCK_MAGIC, LOG_PART_BYTES, LOG_READ_BLOCKS

READINGS = 3
"""A block that never proves itself is torn on the card after so many."""
SILENCE_S = 0.25
"""The logger sends without a pause; after this the rest of a window is lost."""
SILENT_WINDOWS = 3
"""The logger answers but sends nothing: after so many tries its card cannot read the block."""
FRUITLESS_WINDOWS = 50
"""Pieces come, but not one more block: after so many tries the cable is of no use."""
UNREADABLE_LIMIT = 16
"""Blocks in a row that the card does not read: then it is the card, and no block of it."""
_LAST_NUMBER = 0xFFFF
_CARD_ERRORS = (
    ErrorCode.NO_CARD,
    ErrorCode.CARD_UNREADABLE,
    ErrorCode.CARD_WRITE_FAILED,
)
_PARTS = BLOCK_BYTES // LOG_PART_BYTES
_CRC_OFFSET = BLOCK_BYTES - 4
# Magic at 0, version, kind and counts passed over, session at 8 (log format, BlockHeader).
_MAGIC_VERSION_SESSION = struct.Struct("<I4xI")
_ZEROS = bytes(BLOCK_BYTES)

RAM = 0
"""The number of what the logger's RAM holds."""

Put = Callable[[int, bytes], None]
"""Takes a block: its index in the recording, its bytes."""
Span = tuple[int, int]
"""Blocks in a row: the first, and how many."""


def recording_name(number: int) -> str:
    """Return the file name of a recording on the card."""
    return f"DROP{number:04}.BIN"


def copy_name(entry: msg.LogEntry) -> str:
    """Return the file name for a fetched copy: the card's; that of RAM contains its session."""
    return f"RAM-{entry.session:08x}.BIN" if entry.number == RAM else recording_name(entry.number)


def entry_words(entry: msg.LogEntry) -> str:
    """Name the entry for people, to be used in a sentence."""
    return "what RAM holds" if entry.number == RAM else recording_name(entry.number)


class TransferError(TfsatError):
    """The logger answers but does not send its recording."""


@dataclass
class Outcome:
    """What became of a transfer.

    Attributes:
        torn: Blocks that begin like ours and whose CRC never matched: they stand so on the card.
        unreadable: Blocks that the card does not read; the copy has zeros there.
    """

    torn: list[int] = field(default_factory=list)
    unreadable: list[int] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Listing:
    """What there is to fetch.

    Attributes:
        entries: What RAM holds, if anything, then the card's recordings by number.
        card_error: Why the card's are not all there; RAM's is there without any card.
    """

    entries: list[msg.LogEntry]
    card_error: BoardError | None = None


def list_logs(client: Client) -> Listing:
    """List the recordings in RAM and on the card.

    Raises:
        BoardError: WRONG_STATE while it records.
    """
    entries: list[msg.LogEntry] = []
    try:
        for entry in _walk(client):
            entries.append(entry)  # noqa: PERF402  what came before an error stays
    except BoardError as error:
        # A bad card must not hide what RAM holds: keep the entries that came before its error.
        if error.code not in _CARD_ERRORS:
            raise
        return Listing(entries, error)
    return Listing(entries)


def _walk(client: Client) -> Iterator[msg.LogEntry]:
    number = 0
    while number <= _LAST_NUMBER:
        reply = client.request(msg.LogListRequest(number), msg.LogListReply)
        if not reply.found:
            return
        yield reply.entry
        number = reply.entry.number + 1


def is_whole(block: bytes) -> bool:
    """It begins with the magic number and its CRC-32 matches."""
    magic, _ = _MAGIC_VERSION_SESSION.unpack_from(block)
    return magic == BLOCK_MAGIC and _crc_matches(block)


def session_of(block: bytes) -> int:
    """Read the session id from a whole block."""
    _, session = _MAGIC_VERSION_SESSION.unpack_from(block)
    return int(session)


def fetch_blocks(client: Client, entry: msg.LogEntry, spans: Iterable[Span], put: Put) -> Outcome:
    """Has blocks of a listed recording sent until each has arrived; `put` is given each block once.

    Raises:
        BoardError: the recording is not there any more, or the logger records.
        NoAnswer, PortError: the cable; what was put is right.
        TransferError: the card does not read the recording.
    """
    outcome = Outcome()
    for first, count in spans:
        # In windows of what a single request may send; losses are repaired within each.
        for start in range(first, first + count, LOG_READ_BLOCKS):
            end = min(start + LOG_READ_BLOCKS, first + count)
            _Window(client, entry, range(start, end), put, outcome).fetch()
    return outcome


class _Window:
    """A few blocks, asked for until each has arrived or was given up."""

    def __init__(
        self, client: Client, entry: msg.LogEntry, blocks: range, put: Put, outcome: Outcome
    ) -> None:
        self._client = client
        self._entry = entry
        self._missing = set(blocks)
        self._put = put
        self._outcome = outcome
        self._readings: dict[int, int] = {}
        self._parts: dict[int, dict[int, bytes]] = {}

    def fetch(self) -> None:
        silent = fruitless = 0
        while self._missing:
            # Ask for the first run that is still missing: after a loss, only the holes are sent again.
            first, count = self._first_run()
            n_pieces, arrived = self._read(first, count)
            for index, block in arrived.items():
                self._take(index, block)
            # No pieces at all: the card does not read. Pieces but no whole block: the cable.
            silent = 0 if n_pieces else silent + 1
            fruitless = 0 if arrived else fruitless + 1
            if silent == SILENT_WINDOWS:
                self._give_up(first)
                silent = fruitless = 0
            elif fruitless == FRUITLESS_WINDOWS:
                raise _useless_cable(self._client.transport.name)

    def _read(self, first: int, count: int) -> tuple[int, dict[int, bytes]]:
        """Request blocks, and return the number of pieces that came before a timeout, and the complete blocks."""
        request = msg.LogReadRequest(self._entry.number, self._entry.session, first, count)
        coming = self._client.request(request, msg.LogReadReply).count
        n_pieces, blocks = 0, dict[int, bytes]()
        # Collect until all have come, or a silence shows that the rest is lost.
        while len(blocks) < coming and (pieces := self._client.log_pieces(SILENCE_S)):
            n_pieces += len(pieces)
            for piece in pieces:
                if isinstance(piece, msg.LogZerosStream):
                    # Blocks of zeros travel as a count.
                    run = range(piece.first_block, piece.first_block + piece.count)
                    blocks.update(dict.fromkeys(run, _ZEROS))
                elif block := self._join(piece):
                    blocks[piece.block] = block
        return n_pieces, blocks

    def _join(self, piece: msg.LogPartStream) -> bytes | None:
        """Return the block that this part completes, or None.

        A block left incomplete by a lost part is kept for the next window.
        """
        parts = self._parts.setdefault(piece.block, {})
        parts[piece.part] = piece.data
        if any(part not in parts for part in range(_PARTS)):
            return None
        del self._parts[piece.block]
        return b"".join(parts[part] for part in range(_PARTS))

    def _first_run(self) -> Span:
        first = min(self._missing)
        count = 1
        while first + count in self._missing:
            count += 1
        return first, count

    def _take(self, index: int, block: bytes) -> None:
        if index not in self._missing:
            return
        # Count the readings: a wrong CRC that stays is the card's, one that goes was the cable's.
        self._readings[index] = self._readings.get(index, 0) + 1
        if not _can_be_right(block):
            if self._readings[index] < READINGS:
                return
            self._outcome.torn.append(index)
        self._missing.discard(index)
        self._put(index, block)

    def _give_up(self, index: int) -> None:
        unreadable = self._outcome.unreadable
        unreadable.append(index)
        # So many consecutive blocks are no single bad sectors: the card as a whole has failed.
        if unreadable[-UNREADABLE_LIMIT:] == list(range(index - UNREADABLE_LIMIT + 1, index + 1)):
            raise TransferError(
                what=f"The logger answers but sends none of the blocks {unreadable[-UNREADABLE_LIMIT]} to {index}.",
                meaning="Its card does not read them, or the cable loses everything that is long.",
                next_step=Advice(
                    "Try another cable or port. If it stays so, take the card out and copy it: "
                    "ddrescue reads around bad sectors; then ",
                    NextStep("decode", ("card.img",)),
                    " with the image.",
                ),
            )
        self._missing.discard(index)
        self._put(index, _ZEROS)


def _can_be_right(block: bytes) -> bool:
    """No CRC contradicts it: only what begins like a block of ours has one."""
    magic, _ = _MAGIC_VERSION_SESSION.unpack_from(block)
    return magic != BLOCK_MAGIC or _crc_matches(block)


def _crc_matches(block: bytes) -> bool:
    return zlib.crc32(block[:_CRC_OFFSET]) == int.from_bytes(block[_CRC_OFFSET:], "little")


def _useless_cable(port: str) -> TransferError:
    return TransferError(
        what=f"The cable at {port} loses too much: {FRUITLESS_WINDOWS} tries have brought no further block.",
        meaning="The recording on the logger is unchanged.",
        next_step="Use another cable, without a hub, then the same command again.",
    )
