"""The ends of a recording: one, if it was closed cleanly."""

from __future__ import annotations

from dataclasses import dataclass

from tfsat_host.protocol.messages import LogFooter
from tfsat_host.protocol.record import ProtocolError


@dataclass
class Footers:
    """Takes a recording's footers by number; the last one counts.

    Attributes:
        last: None if there is none, or none that can be understood.
        last_number: Its block number.
        differ: There are several and they say different things.
        not_understood: Footers with a right CRC and impossible contents.
    """

    last: LogFooter | None = None
    last_number: int = -1
    differ: bool = False
    not_understood: int = 0

    def add(self, number: int, payload: bytes) -> None:
        """A footer block: its number, and its payload, of which a LogFooter is the beginning."""
        try:
            footer = LogFooter.decode(payload[: LogFooter.SIZE])
        except ProtocolError:
            self.not_understood += 1
            return
        self.differ = self.differ or self.last not in (None, footer)
        self.last, self.last_number = footer, number
