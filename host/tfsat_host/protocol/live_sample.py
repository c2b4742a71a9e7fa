"""An undecoded live sample: hundreds come each second, and most are read together, as columns."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Self

from tfsat_host.protocol.messages import LiveSampleStream
from tfsat_host.protocol.record import check_length

_INDEX_AND_TIME = struct.Struct("<IQ")


@dataclass(frozen=True, slots=True)
class LiveSample:
    """One sample.

    Attributes:
        index: Of the sample since the board started.
        time_us: The logger's clock, since power-up.
        payload: All of it, as `LiveSampleStream` encodes it.
    """

    index: int
    time_us: int
    payload: bytes

    @classmethod
    def from_payload(cls, payload: bytes) -> Self:
        """Take a frame's payload. Raises ProtocolError if it has another length."""
        check_length(LiveSampleStream, payload)
        index, time_us = _INDEX_AND_TIME.unpack_from(payload)
        return cls(index, time_us, payload)

    def decode(self) -> LiveSampleStream:
        """Decode all of it."""
        return LiveSampleStream.decode(self.payload)
