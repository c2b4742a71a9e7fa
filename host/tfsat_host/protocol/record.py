"""What every generated payload and log record can do: become bytes and come back."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import Field, FrozenInstanceError, dataclass
from enum import IntEnum
from typing import Any, ClassVar, Self, TypeVar, dataclass_transform

from tfsat_host.errors import TfsatError


class ProtocolError(TfsatError):
    """Bytes that are no valid payload of the protocol."""


@dataclass_transform(frozen_default=True)
class Record:
    """Base of the generated records: each is a frozen dataclass with the fields of its `LAYOUT`.

    A field's kind in `LAYOUT` is a `struct` letter, an enumeration or another record; its count is
    None for a single value. Arrays of bytes are `bytes`, other arrays are tuples.

    What `dataclass` would compile for each class is here once: sixty classes took longer than a command's work.
    """

    SIZE: ClassVar[int] = 0
    LAYOUT: ClassVar[Layout] = ()
    __slots__: tuple[str, ...] = ()
    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    def __init__(self, *values: Any, **named: Any) -> None:
        names = self.__slots__
        if named or len(values) != len(names):
            given = dict(zip(names, values, strict=False))
            if len(given) != len(values) or given.keys() & named or {*given, *named} != {*names}:
                raise TypeError(f"{type(self).__name__} takes {', '.join(names) or 'nothing'}")
            values = tuple((given | named)[name] for name in names)
        for name, value in zip(names, values, strict=True):
            object.__setattr__(self, name, value)

    def __setattr__(self, name: str, value: object) -> None:
        raise FrozenInstanceError(f"cannot assign to field {name!r}")

    def _values(self) -> tuple[Any, ...]:
        return tuple(getattr(self, name) for name in self.__slots__)

    def __eq__(self, other: object) -> bool:
        return self._values() == other._values() if type(other) is type(self) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._values())

    def __repr__(self) -> str:
        values = zip(self.__slots__, self._values(), strict=True)
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in values)})"

    def __reduce__(self) -> tuple[type, tuple[Any, ...]]:
        return type(self), self._values()

    def encode(self) -> bytes:
        """Return the little-endian bytes, `SIZE` long. Raises struct.error if a value is out of range."""
        return _codec(type(self)).pack(*_flatten(self))

    @classmethod
    def decode(cls, data: bytes) -> Self:
        """Read a record from exactly `SIZE` bytes. Raises ProtocolError."""
        if len(data) != cls.SIZE:
            raise _broken(f"{cls.__name__} has {len(data)} bytes instead of {cls.SIZE}")
        return _build(cls, _codec(cls).unpack(data), 0)


class _FieldsOnDemand:
    """Makes a dataclass of a record when `asdict`, `replace` or `fields` asks for the first time."""

    def __get__(self, record: Record | None, of: type[Record]) -> dict[str, Field[Any]] | None:
        if not of.LAYOUT:
            return None
        dataclass(init=False, repr=False, eq=False)(of)
        return of.__dataclass_fields__


Record.__dataclass_fields__ = _FieldsOnDemand()  # type: ignore[assignment]


class Payload(Record):
    """A record that is a frame's payload; `TYPE` is the frame's type."""

    TYPE: ClassVar[int]
    __slots__ = ()


Kind = str | type[IntEnum] | type[Record]
Layout = tuple[tuple[str, Kind, int | None], ...]
AnyRecord = TypeVar("AnyRecord", bound=Record)


_CODECS: dict[type[Record], struct.Struct] = {}
_PLANS: dict[type[Record], tuple[tuple[Kind, int | None, int, int], ...]] = {}


def _codec(record: type[Record]) -> struct.Struct:
    """All scalars of a record, nested ones in their places, as one struct; made once."""
    if record not in _CODECS:
        _CODECS[record] = struct.Struct("<" + _letters(record))
    return _CODECS[record]


def _letters(record: type[Record]) -> str:
    letters = ""
    for _, kind, count in record.LAYOUT:
        single = kind if isinstance(kind, str) else _letters(kind) if issubclass(kind, Record) else "B"
        letters += single * (1 if count is None else count)
    return letters


def _flatten(record: Record) -> Iterator[Any]:
    for name, _, count in record.LAYOUT:
        value = getattr(record, name)
        for item in [value] if count is None else value:
            if isinstance(item, Record):
                yield from _flatten(item)
            else:
                yield item


def _build(record: type[AnyRecord], scalars: tuple[Any, ...], first: int) -> AnyRecord:
    """From its scalars, which stand in a row from `first` on."""
    values = []
    for kind, count, start, width in _plan(record):
        at = first + start
        if count is None:
            values.append(scalars[at] if isinstance(kind, str) else _item(kind, scalars, at))
        elif kind == "B":
            values.append(bytes(scalars[at : at + count]))
        elif isinstance(kind, str):
            values.append(scalars[at : at + count])
        else:
            values.append(tuple(_item(kind, scalars, at + i * width) for i in range(count)))
    return record(*values)


def _item(kind: type[IntEnum] | type[Record], scalars: tuple[Any, ...], at: int) -> Any:
    if issubclass(kind, Record):
        return _build(kind, scalars, at)
    try:
        return kind(scalars[at])
    except ValueError:
        raise _broken(f"{scalars[at]} is no {kind.__name__}") from None


def _plan(record: type[Record]) -> tuple[tuple[Kind, int | None, int, int], ...]:
    """Of each field its kind and count, where its scalars begin, and how many an item has; made once."""
    if record not in _PLANS:
        plan, start = [], 0
        for _, kind, count in record.LAYOUT:
            width = len(_letters(kind)) if not isinstance(kind, str) and issubclass(kind, Record) else 1
            plan.append((kind, count, start, width))
            start += width * (1 if count is None else count)
        _PLANS[record] = tuple(plan)
    return _PLANS[record]


def _broken(what: str) -> ProtocolError:
    return ProtocolError(
        what=f"A board sent a message that this program cannot read: {what}.",
        meaning="Board and host were not made from the same release.",
        next_step="Flash the board from this release, or install the host package that fits it.",
    )
