"""Two slots that take turns, what bits that turn over in them lead to; by the protocol's words."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Generic, TypeVar

from tests.sequencer.maneuvers import RawManeuver
from tfsat_host.protocol.enums import Origin
from tfsat_host.protocol.messages import SettingsWriteRequest

MANEUVER_AT, SETTINGS_AT = 0, 256
"""Addresses of the stores."""
SLOT_EXTRA_BYTES = 1 + 4 + 2
MANEUVER_SLOT_BYTES = SLOT_EXTRA_BYTES + 3 + 16 * 7
SETTINGS_SLOT_BYTES = SLOT_EXTRA_BYTES + SettingsWriteRequest.SIZE
Record = TypeVar("Record", RawManeuver, SettingsWriteRequest)


@dataclass
class Slot(Generic[Record]):
    """One place for a record: a marker, the generation, the record, a CRC."""

    record: Record
    generation: int
    flipped: set[tuple[int, int]] = field(default_factory=set)
    """Byte of the slot, bit of the byte."""

    @property
    def marked(self) -> bool:
        return all(byte != 0 for byte, _ in self.flipped)

    @property
    def whole(self) -> bool:
        return not self.flipped


@dataclass
class Store(Generic[Record]):
    """One record that outlives the power; `busy` while it is being written."""

    factory: Record
    slots: list[Slot[Record] | None] = field(default_factory=lambda: [None, None])
    current: int | None = None
    damaged: set[int] = field(default_factory=set)
    """Slots; as the board found them when it started."""
    busy: bool = False

    @property
    def _held(self) -> Slot[Record] | None:
        return None if self.current is None else self.slots[self.current]

    @property
    def record(self) -> Record:
        return self.factory if self._held is None else self._held.record

    @property
    def generation(self) -> int:
        return 0 if self._held is None else self._held.generation

    @property
    def origin(self) -> Origin:
        return Origin.FACTORY if self._held is None else Origin.UPLOADED

    def put(self, record: Record) -> bool:
        """Begins to store; False if that very record is there, or on its way, already, and all is whole."""
        if record == self.record and self.origin == Origin.UPLOADED and not self.damaged:
            return False
        slot = 0 if self.current is None else 1 - self.current
        self.slots[slot] = Slot(record, self.generation + 1)
        self.damaged.discard(slot)
        self.current, self.busy = slot, True
        return True

    def flip(self, slot: int, byte: int, bit: int) -> bool:
        """Turns a bit over, or back; False where nothing was ever stored."""
        target = self.slots[slot]
        if target is None:
            return False
        target.flipped ^= {(byte, bit)}
        return True

    def load(self) -> None:
        """The board starts: the newest slot that is whole counts."""
        self.current, self.damaged, newest = None, set(), 0
        for index, slot in enumerate(self.slots):
            if slot is None or not slot.marked:
                continue
            if not slot.whole:
                self.damaged.add(index)
            elif slot.generation > newest:
                self.current, newest = index, slot.generation
