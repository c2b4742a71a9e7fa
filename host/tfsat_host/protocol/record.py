"""What every generated payload and log record can do: become bytes and come back."""

import struct
from collections.abc import Iterator
from dataclasses import FrozenInstanceError, dataclass, fields
from enum import IntEnum
from itertools import islice
from typing import Annotated, Any, ClassVar, Self, TypeVar, dataclass_transform, get_args

from tfsat_host.errors import TfsatError

U8 = Annotated[int, "B"]
U16 = Annotated[int, "H"]
U32 = Annotated[int, "I"]
U64 = Annotated[int, "Q"]
I16 = Annotated[int, "h"]
I32 = Annotated[int, "i"]
F32 = Annotated[float, "f"]
"""Numbers by their letter in `struct`, which is numpy's too; arrays are `Annotated[tuple[U16, ...], COUNT]`."""


class ProtocolError(TfsatError):
    """Bytes that are no valid payload of the protocol."""


@dataclass_transform(frozen_default=True)
class Record:
    """Base of the generated records: frozen dataclasses whose annotations are their layout.

    Arrays of bytes are `bytes`, other arrays are tuples. Constructor and comparison are here once: compiled by
    `dataclass` for each of sixty classes, they took longer than a command's work.

    Attributes:
        SIZE: Bytes.
        LAYOUT: Of each field its name, its kind (a `struct` letter, an enumeration or another record) and its count,
            None for a single value.
    """

    SIZE: ClassVar[int] = 0
    LAYOUT: ClassVar["Layout"] = ()
    _CODEC: ClassVar[struct.Struct]

    def __init_subclass__(cls) -> None:
        dataclass(init=False, repr=False, eq=False)(cls)
        cls.LAYOUT = tuple((field.name, *_kind_and_count(field.type)) for field in fields(cls))  # type: ignore[arg-type]
        cls._CODEC = struct.Struct("<" + _letters(cls))
        cls.SIZE = cls._CODEC.size

    def __init__(self, *values: Any, **named: Any) -> None:
        names = [name for name, _, _ in self.LAYOUT]
        given = dict(zip(names, values, strict=False))
        if len(given) != len(values) or given.keys() & named or {*given, *named} != {*names}:
            raise TypeError(f"{type(self).__name__} takes {', '.join(names) or 'nothing'}")
        given.update(named)
        self.__dict__.update((name, given[name]) for name in names)

    def __setattr__(self, name: str, value: object) -> None:
        raise FrozenInstanceError(f"cannot assign to field {name!r}")

    def __eq__(self, other: object) -> bool:
        return self.__dict__ == other.__dict__ if type(other) is type(self) else NotImplemented

    def __hash__(self) -> int:
        return hash(tuple(self.__dict__.values()))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in self.__dict__.items())})"

    def encode(self) -> bytes:
        """Return the little-endian bytes, `SIZE` long. Raises struct.error if a value is out of range."""
        return self._CODEC.pack(*_scalars(self))

    @classmethod
    def decode(cls, data: bytes) -> Self:
        """Read a record from exactly `SIZE` bytes. Raises ProtocolError."""
        check_length(cls, data)
        return _take(cls, iter(cls._CODEC.unpack(data)))

    @classmethod
    def dtype(cls) -> list[tuple[Any, ...]]:
        """What `numpy.dtype` makes a structured type of; enumerations are their numbers."""

        def item(kind: Kind) -> Any:
            if isinstance(kind, str):
                return f"<{kind}"
            return kind.dtype() if issubclass(kind, Record) else "<B"

        return [(name, item(kind), () if count is None else (count,)) for name, kind, count in cls.LAYOUT]


Kind = str | type[IntEnum] | type[Record]
Layout = tuple[tuple[str, Kind, int | None], ...]
AnyRecord = TypeVar("AnyRecord", bound=Record)


def _kind_and_count(annotation: Any) -> tuple[Kind, int | None]:
    of, *about = get_args(annotation) or (annotation,)
    if not about or isinstance(about[0], str):
        return (about[0] if about else of), None
    kind, _ = ("B", None) if of is bytes else _kind_and_count(get_args(of)[0])
    return kind, about[0]


def _letters(record: type[Record]) -> str:
    letters = ""
    for _, kind, count in record.LAYOUT:
        single = kind if isinstance(kind, str) else _letters(kind) if issubclass(kind, Record) else "B"
        letters += single * (1 if count is None else count)
    return letters


def _scalars(record: Record) -> Iterator[Any]:
    for name, _, count in record.LAYOUT:
        value = getattr(record, name)
        for item in [value] if count is None else value:
            if isinstance(item, Record):
                yield from _scalars(item)
            else:
                yield item


def check_length(record: type[Record], data: bytes) -> None:
    """Refuse bytes that are too few or too many for a record. Raises ProtocolError."""
    if len(data) != record.SIZE:
        raise _broken(f"{record.__name__} has {len(data)} bytes instead of {record.SIZE}")


def _take(record: type[AnyRecord], scalars: Iterator[Any]) -> AnyRecord:
    """A record of the next scalars, as many as it has."""

    def one(kind: Kind) -> Any:
        if isinstance(kind, str):
            return next(scalars)
        if issubclass(kind, Record):
            return _take(kind, scalars)
        number = next(scalars)
        try:
            return kind(number)
        except ValueError:
            raise _broken(f"{number} is no {kind.__name__}") from None

    made = record.__new__(record)
    for name, kind, count in record.LAYOUT:
        if count is None:
            value = one(kind)
        elif isinstance(kind, str):
            value = (bytes if kind == "B" else tuple)(islice(scalars, count))
        else:
            value = tuple([one(kind) for _ in range(count)])
        made.__dict__[name] = value
    return made


def _broken(what: str) -> ProtocolError:
    return ProtocolError(
        what=f"A board sent a message that this program cannot read: {what}.",
        meaning="Board and host were not made from the same release.",
        next_step="Flash the board from this release, or install the host package that fits it.",
    )


class Payload(Record):
    """A record that is a frame's payload; `TYPE` is the frame's type."""

    TYPE: ClassVar[int]
