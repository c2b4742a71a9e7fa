"""Campaign 2, continued: one byte of the EEPROM is another, whichever it is and whatever it becomes."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path

from tests.arduino_sequencer.store_model import (
    BEGUN,
    COMPLETE,
    MANEUVER_AT,
    MANEUVER_USED_BYTES,
    MARKER_BYTES,
    SETTINGS_AT,
    SETTINGS_USED_BYTES,
    SLOT_BYTES,
)
from tests.fixtures.sequencer.board import EEPROM_BYTES, ERASED, Board, load_library
from tests.fixtures.sequencer.cable import connect, native_board
from tests.validation.campaign import Broken
from tests.validation.sequencer_proof.bench import Bench
from tests.validation.sequencer_proof.power_cuts import MANEUVERS, SETTINGS, Held, read_all, why_not_armed
from tfsat_host.protocol.enums import ErrorCode

VALUES, UNUSED_VALUES = 256, 8
TOLD = (ErrorCode.STORE_DAMAGED, ErrorCode.UPLOAD_INTERRUPTED, ErrorCode.STORE_OLD_LAYOUT)
OLD_MARKER = 0xA5
OLD_MARKERS = (0, 122, 256, 292)
"""Where layout 1 had the markers of its four slots."""


class Case(Enum):
    """What the EEPROM holds before: uploads of the maneuver and of the servo settings, and what came after."""

    ONE = "a maneuver, factory settings"
    BOTH = "a maneuver, servo settings"
    TWO = "two maneuvers, two settings"
    BEGUN = "the same, and a maneuver begun"
    BEGUN_SETTINGS = "the same, and settings begun"
    OLD = "the old layout"

    @property
    def uploads(self) -> tuple[int, int]:
        return {Case.ONE: (1, 0), Case.BOTH: (1, 1), Case.OLD: (0, 0)}.get(self, (2, 2))

    @property
    def may_arm(self) -> bool:
        return self in (Case.ONE, Case.BOTH, Case.TWO)

    def image(self, library: Path) -> bytes:
        """Build the EEPROM image of a native board with this history."""
        board = native_board(load_library(library), ERASED)
        client = connect(board)
        # Uploads as a host makes them: the stores are written, not the bytes.
        maneuvers, settings = self.uploads
        for number in range(maneuvers):
            client.upload(MANEUVERS[number])
        for number in range(settings):
            client.write_settings(SETTINGS[number])
        image = bytearray(board.eeprom())
        if self in (Case.BEGUN, Case.BEGUN_SETTINGS):
            # The older marker set to "begun": an upload cut short in the middle.
            older = MANEUVER_AT if self is Case.BEGUN else SETTINGS_AT
            assert image[older : older + MARKER_BYTES] == COMPLETE
            image[older : older + MARKER_BYTES] = BEGUN
        # A board with the layout of an earlier firmware, never erased.
        if self is Case.OLD:
            for address in OLD_MARKERS:
                image[address : address + 2] = bytes([OLD_MARKER, 1])
        return bytes(image)


class Place(Enum):
    """Whose byte it is."""

    MARKER = "a marker"
    RECORD = "a record, its head or CRC"
    OTHER = "nothing in use"

    @classmethod
    def of(cls, address: int) -> Place:
        for start, used_bytes in ((MANEUVER_AT, MANEUVER_USED_BYTES), (SETTINGS_AT, SETTINGS_USED_BYTES)):
            # Two slots of each record, one after the other.
            offset = (address - start) % SLOT_BYTES
            if start <= address < start + 2 * SLOT_BYTES and offset < used_bytes:
                return cls.MARKER if offset < MARKER_BYTES else cls.RECORD
        return cls.OTHER


@dataclass(slots=True)
class Damaged:
    """What came of each place's bytes."""

    case: Case
    values: Counter[Place] = field(default_factory=Counter)
    armed: Counter[Place] = field(default_factory=Counter)
    refused: Counter[tuple[Place, ErrorCode]] = field(default_factory=Counter)


@dataclass(frozen=True, slots=True)
class DamagedImage:
    """As many in the flashed image."""

    case: Case
    tried: int


def damage_native(library: Path, case: Case, seed: int, *, sample: int | None = None) -> Damaged:
    """Sets each byte in use to each value, or to a sample of them; the board starts and is told to arm.

    Raises Broken where it arms with anything but what was committed last, or refuses without saying why.
    """
    image = case.image(library)
    board = native_board(load_library(library), image)
    committed = _native_held(board)
    # The history itself must arm or refuse as its case says; only then damage is judged.
    if (committed.refusal == ErrorCode.NONE) != case.may_arm:
        raise Broken(f"{case.value}: ARM says {committed.refusal.name}")
    result = Damaged(case)
    for address, value in _changes(random.Random(seed), sample):
        contents = _native_held(board, _change_byte(image, address, value))
        place = Place.of(address)
        _check(contents, committed, case, f"{case.value}: byte {address} is {value:#04x}")
        result.values[place] += 1
        if contents.refusal == ErrorCode.NONE:
            result.armed[place] += 1
        else:
            result.refused[place, contents.refusal] += 1
    return result


def damage_image(bench: Bench, library: Path, case: Case, seed: int, *, count: int) -> DamagedImage:
    """Check sampled damage to the EEPROM of the flashed image against the native board.

    The image must hold and answer the same as the native board.
    """
    rng = random.Random(seed)
    image = case.image(library)
    native, board = native_board(load_library(library), image), bench.new_board()
    for _ in range(count):
        # Half of the addresses lie in the stores or behind them, the others anywhere.
        address = rng.randrange(rng.choice((0, MANEUVER_AT)), len(image))
        value = rng.randrange(VALUES)
        damaged = _change_byte(image, address, value)
        expected = _native_held(native, damaged)
        board.power(False)
        # EEPROM contents survive the power: the image starts with the damaged ones.
        board.set_eeprom(damaged)
        contents = read_all(board)
        # The image must hold and answer exactly what the native core does.
        if contents != expected:
            raise Broken(
                f"{case.value}, byte {address} is {value:#04x}: the image {contents}, native {expected}"
            )
    board.close()
    return DamagedImage(case, count)


def _changes(rng: random.Random, sample: int | None) -> Iterator[tuple[int, int]]:
    """Yield the byte changes as (address, value).

    Every byte in use gets all values and every other byte some; with `sample` both get fewer, the markers more.
    """
    for address in range(EEPROM_BYTES):
        place = Place.of(address)
        # Every byte in use takes all 256 values; unused ones a few.
        count = UNUSED_VALUES if place is Place.OTHER else VALUES
        if sample is not None:
            count = sample * (8 if place is Place.MARKER else 1)
        for value in rng.sample(range(VALUES), count):
            yield address, value


def _change_byte(image: bytes, address: int, value: int) -> bytes:
    return image[:address] + bytes([value]) + image[address + 1 :]


def _check(contents: Held, committed: Held, case: Case, where: str) -> None:
    # With damage, arming is only right where the store still holds the committed record.
    if contents.refusal == ErrorCode.NONE:
        if not case.may_arm or contents != committed:
            raise Broken(f"{where}: it arms with {contents}")
    # A refusal must be one of those that say what happened to the store.
    elif contents.refusal not in TOLD:
        raise Broken(f"{where}: ARM says {contents.refusal.name}")


def _native_held(board: Board, image: bytes | None = None) -> Held:
    """Power-cycle the native board with this EEPROM and return what it holds and refuses."""
    board.power(False)
    if image is not None:
        board.set_eeprom(image)
    board.power(True)
    # Power-up and start: the native board runs a millisecond.
    board.run(1000)
    client = connect(board)
    return Held(client.read_back(), client.settings(), why_not_armed(client))
