"""Frames on the link: COBS(type, sequence, payload, CRC-16/IBM-3740) and a zero byte."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import crcmod.predefined
from cobs import cobs

crc16 = crcmod.predefined.mkCrcFun("crc-ccitt-false")
"""CRC-16/IBM-3740 of bytes (crcmod calls it crc-ccitt-false)."""

_MAX_FRAME_BYTES = 1024
"""More bytes than this without a zero are garbage, whatever they are."""


@dataclass(frozen=True, slots=True)
class Frame:
    """One undamaged frame."""

    type: int
    sequence: int
    payload: bytes


def encode_frame(frame: Frame) -> bytes:
    """Return the bytes to send, the final zero included."""
    body = bytes((frame.type, frame.sequence)) + frame.payload
    encoded: bytes = cobs.encode(body + crc16(body).to_bytes(2, "little"))
    return encoded + b"\0"


class FrameReceiver:
    """Takes bytes as they come and yields the undamaged frames among them."""

    def __init__(self) -> None:
        self._pending = bytearray()
        self.rejected = 0
        """Pieces between zeros that were no frame."""

    def feed(self, data: bytes) -> Iterator[Frame]:
        """Yield each frame that `data` completes; what is damaged is counted and dropped."""
        self._pending += data
        *pieces, rest = self._pending.split(b"\0")
        self._pending = rest
        if len(self._pending) > _MAX_FRAME_BYTES:
            self._pending.clear()
            self.rejected += 1
        for piece in pieces:
            if not piece:
                continue
            frame = decode_frame(bytes(piece))
            if frame is None:
                self.rejected += 1
            else:
                yield frame


def decode_frame(piece: bytes) -> Frame | None:
    """Decode the bytes between two zeros; None when they are damaged."""
    try:
        body: bytes = cobs.decode(piece)
    except cobs.DecodeError:
        return None
    # Type, sequence and CRC are the least of a frame.
    if len(body) < 4 or crc16(body[:-2]) != int.from_bytes(body[-2:], "little"):
        return None
    return Frame(body[0], body[1], body[2:-2])
