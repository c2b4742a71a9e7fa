"""What every generated payload and log record can do: become bytes and come back."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, ClassVar, Self

from tfsat_host.errors import TfsatError


class ProtocolError(TfsatError):
    """Bytes that are no valid payload of the protocol."""


@dataclass(frozen=True, slots=True)
class Record:
    """Base of the generated records.

    A field's kind in `LAYOUT` is a `struct` letter, an enumeration or another record; its count is
    None for a single value. Arrays of bytes are `bytes`, other arrays are tuples.
    """

    SIZE: ClassVar[int] = 0
    LAYOUT: ClassVar[Layout] = ()

    def encode(self) -> bytes:
        """Return the little-endian bytes, `SIZE` long. Raises struct.error if a value is out of range."""
        parts = []
        for name, kind, count in self.LAYOUT:
            value = getattr(self, name)
            parts += [_pack(kind, item) for item in ([value] if count is None else value)]
        return b"".join(parts)

    @classmethod
    def decode(cls, data: bytes) -> Self:
        """Read a record from exactly `SIZE` bytes. Raises ProtocolError."""
        if len(data) != cls.SIZE:
            raise _broken(f"{cls.__name__} has {len(data)} bytes instead of {cls.SIZE}")
        values = []
        offset = 0
        for _, kind, count in cls.LAYOUT:
            items = []
            for _ in range(1 if count is None else count):
                item, offset = _unpack(kind, data, offset)
                items.append(item)
            if count is None:
                values.append(items[0])
            else:
                values.append(bytes(items) if kind == "B" else tuple(items))
        return cls(*values)


Kind = str | type[IntEnum] | type[Record]
Layout = tuple[tuple[str, Kind, int | None], ...]


def _pack(kind: Kind, value: Any) -> bytes:
    if isinstance(kind, str):
        return struct.pack("<" + kind, value)
    if isinstance(value, Record):
        return value.encode()
    return struct.pack("<B", value)


def _unpack(kind: Kind, data: bytes, offset: int) -> tuple[Any, int]:
    if isinstance(kind, str):
        return struct.unpack_from("<" + kind, data, offset)[0], offset + struct.calcsize("<" + kind)
    if issubclass(kind, Record):
        return kind.decode(data[offset : offset + kind.SIZE]), offset + kind.SIZE
    try:
        return kind(data[offset]), offset + 1
    except ValueError:
        raise _broken(f"{data[offset]} is no {kind.__name__}") from None


def _broken(what: str) -> ProtocolError:
    return ProtocolError(
        what=f"A board sent a message that this program cannot read: {what}.",
        meaning="Board and host were not made from the same release.",
        next_step="Flash the board from this release, or install the host package that fits it.",
    )
