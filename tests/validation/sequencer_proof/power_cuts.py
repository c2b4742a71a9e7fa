"""Campaign 2: power cuts at every EEPROM byte write of an upload, in the flashed image."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import Enum

from tests.arduino_sequencer.store_model import MANEUVER_AT, SETTINGS_AT, SLOT_BYTES
from tests.fixtures.sequencer.board import AvrBoard
from tests.fixtures.sequencer.cable import Cable, connect
from tests.validation.campaign import Broken
from tests.validation.sequencer_proof.bench import Bench, power_up, stack_never_used
from tfsat_host.devices.board_errors import BoardRefusal
from tfsat_host.devices.sequencer import SequencerClient, StoredManeuver, StoredSettings
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.protocol.enums import ErrorCode, Origin
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.servo_settings import ServoSettings

BEGUN_FROM = 3
"""Bytes of a slot's marker: so many written, and an upload is begun (core/slot_pair.h)."""
EEDR, EEARL, EEARH = 0x40, 0x41, 0x42
LOOK_S = 0.001
"""A write takes 3.4 ms: look more often than that."""

MANEUVERS = [
    schedule_maneuver(four_stroke(first, second)) for first, second in ((40, 50), (59, 70), (61, 68.5))
]
SETTINGS = [
    ServoSettings(
        20_000, (ServoSetting(1000, 11_111, 0, 0, 9000),) * 2 + (ServoSetting(1100, 9000, 0, 0, 8000),)
    ),
    ServoSettings(10_000, (ServoSetting(1010, 11_200, 0, 0, 9000),) * 3),
    ServoSettings(14_000, (ServoSetting(2050, 10_900, 1, 0, 9000),) * 3),
]


class Record(Enum):
    """What is uploaded."""

    MANEUVER = "maneuver"
    SETTINGS = "servo settings"

    @property
    def region(self) -> range:
        """The store's addresses."""
        start = MANEUVER_AT if self is Record.MANEUVER else SETTINGS_AT
        return range(start, start + 2 * SLOT_BYTES)

    def upload(self, client: SequencerClient, number: int) -> None:
        if self is Record.MANEUVER:
            client.upload(MANEUVERS[number])
        else:
            client.write_settings(SETTINGS[number])


class History(Enum):
    """What the store held before; each earlier upload took another slot. The other store holds a record too."""

    ERASED = "nothing"
    ONE_SLOT = "one record"
    BOTH_SLOTS = "two records"

    @property
    def uploads(self) -> int:
        return list(History).index(self)


class Tear(Enum):
    """What the byte under way holds after the cut."""

    ERASED = "erased"
    OLD = "as before"
    NEW = "as written"
    RANDOM = "random"

    def byte(self, write: Write, rng: random.Random) -> int:
        if self is Tear.RANDOM:
            return rng.randrange(256)
        return {Tear.ERASED: 0xFF, Tear.OLD: write.old, Tear.NEW: write.new}[self]


@dataclass(frozen=True, slots=True)
class Write:
    """One EEPROM byte write, as it begins."""

    address: int
    old: int
    new: int


@dataclass(frozen=True, slots=True)
class Held:
    """Everything stored, read back over the link after power-up; and why ARM was refused, if it was."""

    maneuver: StoredManeuver
    settings: StoredSettings
    refusal: ErrorCode


@dataclass(slots=True)
class Cuts:
    """Outcomes at the cut points of one upload."""

    record: Record
    history: History
    writes: int
    points: int = 0
    old: Counter[Tear] = field(default_factory=Counter)
    told: Counter[Tear] = field(default_factory=Counter)
    """The old record is there, and ARM is refused because of the upload."""
    new: Counter[Tear] = field(default_factory=Counter)
    stored_afterwards: int = 0
    never_used: int = 0


REWRITES = {Record.MANEUVER: 8, Record.SETTINGS: 0}
"""Byte writes of an upload of what is stored, at most: a begun maneuver's marker, and its end."""


class PowerCut(Exception):
    """The supply went as planned."""


class WatchedTransport(Cable):
    """Notes each EEPROM write of the board, and may cut the power in the middle of the n-th."""

    def __init__(self, board: AvrBoard, cut_at: int | None = None) -> None:
        super().__init__(board)
        self._watched = board
        self._before = board.eeprom_writes
        self._cut_at = cut_at
        self.writes: list[Write] = []

    def read(self, timeout_s: float) -> bytes:
        data = super().read(min(timeout_s, LOOK_S))
        board = self._watched
        count = board.eeprom_writes - self._before
        if count > len(self.writes):
            if count != len(self.writes) + 1:
                raise RuntimeError("two EEPROM writes began within a look")
            address = board.peek(EEARH) << 8 | board.peek(EEARL)
            self.writes.append(Write(address, board.eeprom()[address], board.peek(EEDR)))
        if count == self._cut_at:
            board.power(False)
            raise PowerCut
        return data


def cut_points(
    bench: Bench, record: Record, history: History, seed: int, *, sample: int | None = None
) -> Cuts:
    """Cuts the power in every byte write of an upload, or in the first, the last and a sample between.

    After each cut, for each way to tear the byte under way: the board must hold wholly the old or
    wholly the new record, the other store bit for bit what it was, and take the upload when it is repeated. From
    the third byte of the marker on it must refuse ARM for the upload, until the last byte is written; before and
    after, it must arm, unless no maneuver was ever stored. Raises Broken.
    """
    rng = random.Random(seed)
    board = bench.new_board()
    before = _prepare(board, record, history)
    old = read_all(board)
    transport = WatchedTransport(board)
    board.connect()
    record.upload(SequencerClient.connect(transport), 2)
    check_writes(transport.writes, record)
    after = board.eeprom()
    new = read_all(board)
    check_refusals(old, new)
    cuts = Cuts(record, history, len(transport.writes))
    for point in _points(len(transport.writes), sample, rng):
        cuts.points += 1
        _restart(board, before)
        _cut_upload(board, record, point)
        torn = board.eeprom()
        for tear in Tear:
            image_bytes = bytearray(torn)
            write = transport.writes[point - 1]
            image_bytes[write.address] = tear.byte(write, rng)
            _restart(board, bytes(image_bytes))
            contents = read_all(board)
            where = f"{record.value} over {history.value}, cut {point}, byte {tear.value}"
            as_written = image_bytes[write.address] == write.new
            check_held(contents, old, new, point, len(transport.writes), as_written, where)
            check_other_store(board.eeprom(), before, record, where)
            outcome = cuts.new if contents == new else cuts.old if contents == old else cuts.told
            outcome[tear] += 1
        record.upload(connect(board), 2)
        cuts.stored_afterwards += _same_content(read_all(board), new)
    if cuts.stored_afterwards != cuts.points:
        raise Broken("an upload after a power cut was not kept")
    check_other_store(after, before, record, "the whole upload")
    client = connect(board)
    record.upload(client, 0)
    cuts.never_used = stack_never_used(board, client, bench)
    board.close()
    return cuts


def check_writes(writes: Sequence[Write], record: Record) -> None:
    """Raises Broken where a byte was written that did not change, or one of another store."""
    for write in writes:
        if write.old == write.new:
            raise Broken(f"byte {write.address} was written with what it held")
        if write.address not in record.region:
            raise Broken(f"byte {write.address} is not in the store of the {record.value}")


def check_held(
    contents: Held, old: Held, new: Held, point: int, last: int, as_written: bool, where: str
) -> None:
    """Raises Broken unless the cut in byte write `point` of `last` left what it must.

    Nobody can tell the last byte of an upload, torn, from damage to a whole record: there the board may say that.
    """
    begun = point > BEGUN_FROM or (point == BEGUN_FROM and as_written)
    if replace(contents, refusal=ErrorCode.NONE) not in [
        replace(record, refusal=ErrorCode.NONE) for record in (old, new)
    ]:
        raise Broken(f"{where}: neither the old nor the new record: {contents}")
    if not begun:
        expected = [old]
    elif point == last and as_written:
        expected = [new]
    else:
        expected = [replace(old, refusal=ErrorCode.UPLOAD_INTERRUPTED)]
        if point == last:
            expected.append(replace(old, refusal=ErrorCode.STORE_DAMAGED))
    if contents not in expected:
        raise Broken(
            f"{where}: ARM says {contents.refusal.name}, with generation {contents.maneuver.generation}"
        )


def check_refusals(*uncut: Held) -> None:
    """Raises Broken unless a board whose power was never cut arms if, and only if, it holds a maneuver."""
    for contents in uncut:
        uploaded = contents.maneuver.origin is not Origin.FACTORY
        if contents.refusal != (ErrorCode.NONE if uploaded else ErrorCode.NO_MANEUVER):
            raise Broken(
                f"ARM: {contents.refusal.name}, with a maneuver of origin {contents.maneuver.origin.name}"
            )


def check_other_store(image: bytes, before: bytes, record: Record, where: str) -> None:
    """Raises Broken where a byte outside the record's store changed."""
    for address, (now, then) in enumerate(zip(image, before, strict=True)):
        if address not in record.region and now != then:
            raise Broken(f"{where}: byte {address}, of no concern to it, changed")


def second_upload_writes(bench: Bench, record: Record) -> int:
    """EEPROM writes of an upload of what is stored already. Raises Broken where a byte is another afterwards."""
    board = bench.new_board()
    client = connect(board)
    record.upload(client, 2)
    before, image = board.eeprom_writes, board.eeprom()
    record.upload(client, 2)
    writes = board.eeprom_writes - before
    if board.eeprom() != image:
        raise Broken(f"an upload of the same {record.value} left another EEPROM")
    if writes > REWRITES[record]:
        raise Broken(f"an upload of what is stored wrote {writes} bytes")
    board.close()
    return writes


def read_all(board: AvrBoard) -> Held:
    """Power-cycle the board and return what it holds."""
    _restart(board, None)
    client = connect(board)
    return Held(client.read_back(), client.settings(), why_not_armed(client))


def why_not_armed(client: SequencerClient) -> ErrorCode:
    """Return the error code of ARM, NONE if accepted; the board is SAFE again afterwards."""
    try:
        client.arm()
    except BoardRefusal as refusal:
        return refusal.code
    client.disarm()
    return ErrorCode.NONE


def _prepare(board: AvrBoard, record: Record, history: History) -> bytes:
    """Upload this history to the board and return its EEPROM.

    The other store holds one record.
    """
    client = connect(board)
    other = Record.SETTINGS if record is Record.MANEUVER else Record.MANEUVER
    other.upload(client, 0)
    for number in range(history.uploads):
        record.upload(client, number)
    return board.eeprom()


def _restart(board: AvrBoard, eeprom: bytes | None) -> None:
    board.power(False)
    if eeprom is not None:
        board.set_eeprom(eeprom)
    board.cable(False)
    power_up(board)


def _cut_upload(board: AvrBoard, record: Record, point: int) -> None:
    board.connect()
    try:
        record.upload(SequencerClient.connect(WatchedTransport(board, point)), 2)
    except PowerCut:
        return
    raise RuntimeError(f"the upload ended before write {point}")


def _points(writes: int, sample: int | None, rng: random.Random) -> list[int]:
    every = range(1, writes + 1)
    if sample is None or sample + 2 >= writes:
        return list(every)
    return sorted({1, writes, *rng.sample(every[1:-1], sample)})


def _same_content(contents: Held, expected_contents: Held) -> bool:
    """But for generations: a repeated upload after a cut that left the new record counts none."""
    return (contents.maneuver.strokes, contents.maneuver.speed_cdeg_s, contents.settings.settings) == (
        expected_contents.maneuver.strokes,
        expected_contents.maneuver.speed_cdeg_s,
        expected_contents.settings.settings,
    )
