"""Blocks that do not stand at multiples of their size: something was put before an image, or cut off it."""

from __future__ import annotations

from tfsat_host.protocol.limits import BLOCK_BYTES

from .blocks import MAGIC, is_sound
from .source import LogSource


def find_shift(source: LogSource) -> int:
    """How many bytes behind a multiple of BLOCK_BYTES the first undamaged block begins; 0 if there is none.

    Slower than a look at the sectors, so it is for files where that found nothing.

    Raises:
        LogError: the file cannot be read.
    """
    # What is kept of the chunk before is one block, so an index in the window tells the shift.
    kept = bytes(BLOCK_BYTES)
    for _, data in source.chunks():
        window = kept + data
        at = window.find(MAGIC)
        while 0 <= at <= len(window) - BLOCK_BYTES:
            if at % BLOCK_BYTES and is_sound(window[at : at + BLOCK_BYTES]):
                return at % BLOCK_BYTES
            at = window.find(MAGIC, at + 1)
        kept = window[-BLOCK_BYTES:]
    return 0
