"""Whether a file on this computer is a recording that the logger holds, whatever it is called."""

from __future__ import annotations

import hashlib
from pathlib import Path

from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.partial_log import SessionError, unproven_spans
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.protocol.messages import LogEntry


def sha256_if_same(logger: LoggerClient, entry: LogEntry, path: Path) -> str | None:
    """The file's SHA-256 if it is the recording, block by block; None if it is not.

    Blocks that prove themselves by their CRC and session are taken for the recording's; only the others are read
    from the logger, zeros included, as they may be room that was never filled.

    Raises:
        OSError: the file cannot be read.
        TfsatError: what the transfer raises.
    """
    if not path.is_file() or path.stat().st_size != entry.blocks * BLOCK_BYTES:
        return None
    with path.open("rb", buffering=0) as file:
        try:
            doubtful = list(unproven_spans(file, entry))
        except SessionError:
            return None
        differing: list[int] = []

        def compare(index: int, block: bytes) -> None:
            file.seek(index * BLOCK_BYTES)
            if file.read(BLOCK_BYTES) != block:
                differing.append(index)

        outcome = logger.fetch_blocks(entry, doubtful, compare)
        if differing or outcome.unreadable:
            return None
        file.seek(0)
        return hashlib.file_digest(file, "sha256").hexdigest()
