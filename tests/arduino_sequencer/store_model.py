"""Two slots that take turns, what bits that turn over in them lead to; by the words of docs/sequencer.md."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Generic, TypeVar

from tests.arduino_sequencer.maneuvers import RawManeuver
from tfsat_host.protocol.enums import ErrorCode, Origin
from tfsat_host.protocol.messages import SettingsWriteRequest

MANEUVER_AT, SETTINGS_AT, SLOT_BYTES = 512, 768, 128
"""Addresses of the stores; from slot to slot."""
COMPLETE, BEGUN, ERASED = bytes([0x3C, 0x96] * 2), bytes([0xC3, 0x69] * 2), bytes([0xFF] * 4)
"""A slot's marker."""
MARKER_BYTES, HEAD_BYTES, CRC_BYTES = 4, 6, 2
SLOT_EXTRA_BYTES = MARKER_BYTES + HEAD_BYTES + CRC_BYTES
MANEUVER_USED_BYTES = SLOT_EXTRA_BYTES + 3 + 16 * 7
SETTINGS_USED_BYTES = SLOT_EXTRA_BYTES + SettingsWriteRequest.SIZE
BEGUN_FROM = 3
"""Bytes of the marker: so many make a begun one."""
Record = TypeVar("Record", RawManeuver, SettingsWriteRequest)


class Kind(Enum):
    """What the board takes a slot for when it starts."""

    UNUSED = auto()
    WHOLE = auto()
    BEGUN = auto()
    DAMAGED = auto()


@dataclass
class Slot(Generic[Record]):
    """One place for a record: a marker, the generation, the record, a CRC."""

    record: Record | None = None
    """None: nothing was ever written behind the marker."""
    generation: int = 0
    marker: bytes = ERASED
    flipped: set[tuple[int, int]] = field(default_factory=set)
    """Behind the marker: byte of the slot, bit of the byte."""

    @property
    def is_whole(self) -> bool:
        return self.record is not None and not self.flipped

    def flip(self, byte: int, bit: int) -> None:
        if byte < MARKER_BYTES:
            marker = bytearray(self.marker)
            marker[byte] ^= 1 << bit
            self.marker = bytes(marker)
        else:
            self.flipped ^= {(byte, bit)}

    def kind(self, newest: int) -> Kind:
        """Next to another slot that holds the current record, of generation `newest`; 0: there is none."""
        older = self.is_whole and self.generation < newest
        if self.marker == COMPLETE:
            return Kind.WHOLE if older else Kind.DAMAGED
        begun = sum(is_ == expected_byte for is_, expected_byte in zip(self.marker, BEGUN, strict=True))
        if begun < BEGUN_FROM and older:
            return Kind.WHOLE
        if begun < BEGUN_FROM and self.record is None and not self.flipped:
            return Kind.UNUSED
        return Kind.BEGUN if begun else Kind.DAMAGED


@dataclass
class Store(Generic[Record]):
    """One record that outlives the power; `busy` while it is being written."""

    factory: Record
    slots: list[Slot[Record]] = field(default_factory=lambda: [Slot(), Slot()])
    current: int | None = None
    kinds: list[Kind] = field(default_factory=lambda: [Kind.UNUSED, Kind.UNUSED])
    """As the board found the slots when it started, or left them since."""
    begun: bool = False
    busy: bool = False

    @property
    def record(self) -> Record:
        stored_record = None if self.current is None else self.slots[self.current].record
        return self.factory if stored_record is None else stored_record

    @property
    def generation(self) -> int:
        return 0 if self.current is None else self.slots[self.current].generation

    @property
    def origin(self) -> Origin:
        return Origin.FACTORY if self.current is None else Origin.UPLOADED

    @property
    def other(self) -> int:
        return 0 if self.current is None else 1 - self.current

    @property
    def defect(self) -> ErrorCode:
        """Why a board with this store does not arm."""
        if Kind.DAMAGED in self.kinds:
            return ErrorCode.STORE_DAMAGED
        return ErrorCode.UPLOAD_INTERRUPTED if self.begun or Kind.BEGUN in self.kinds else ErrorCode.NONE

    def begin(self) -> None:
        """Somebody wants another record."""
        self.slots[self.other].marker = BEGUN
        self.begun = self.busy = True

    def store_record(self, record: Record) -> bool:
        """Begins to store; False if that very record is there, or on its way, already, and all is whole."""
        other = self.other
        if (
            record == self.record
            and self.origin == Origin.UPLOADED
            and self.kinds[other] in (Kind.UNUSED, Kind.WHOLE)
        ):
            if self.begun:
                self.slots[other].marker = ERASED if self.kinds[other] == Kind.UNUSED else COMPLETE
                self.begun, self.busy = False, True
            return False
        self.slots[other] = Slot(record, self.generation + 1, COMPLETE)
        self.kinds[other] = Kind.WHOLE
        self.current, self.begun, self.busy = other, False, True
        return True

    def load(self) -> None:
        """Load the store as the board does at start: the newest intact slot counts."""
        self.current, self.begun, newest = None, False, 0
        for index, slot in enumerate(self.slots):
            if slot.marker == COMPLETE and slot.is_whole and slot.generation > newest:
                self.current, newest = index, slot.generation
        self.kinds = [
            Kind.WHOLE if index == self.current else slot.kind(newest)
            for index, slot in enumerate(self.slots)
        ]


def without_markers(image: bytes) -> bytes:
    """Return the EEPROM image with its markers erased: the rest, which an unfinished upload leaves alone."""
    stripped_image = bytearray(image)
    for store in (MANEUVER_AT, SETTINGS_AT):
        for slot in (store, store + SLOT_BYTES):
            stripped_image[slot : slot + MARKER_BYTES] = ERASED
    return bytes(stripped_image)
