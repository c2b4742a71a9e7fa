"""Mutates logs whose truth is known, and judges what the decoder makes of them.

A script of bytes says what is done to a file of two recordings: cuts, flips, blocks swapped, copied,
overwritten, removed, bytes inserted, and heads changed with their CRC made right again. Unless a CRC was
made right, what the decoder says must be the truth or flagged; after it, only sane.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from tests.sdlog.encoder import ALL_VALID, Recorder, event, renumbered, sample
from tfsat_host.errors import TfsatError
from tfsat_host.protocol.enums import EventCode
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.protocol.messages import BlockHeader
from tfsat_host.quantity import record
from tfsat_host.sdlog import DropLog, LogError, load
from tfsat_host.sdlog.log_summary import SUMMARY, warnings

NEW, OLD = 0x1234ABCD, 0x0BADCAFE
_OPEN = ALL_VALID | 0x0C00
_MAX_STEPS = 12


@dataclass(frozen=True)
class Truth:
    """What one recording holds."""

    recorder: Recorder
    rows: dict[int, tuple[int, list[int]]]
    events: list[tuple[int, int, int, int]]
    release_us: int


class Script:
    """Reads a mutation's numbers from the fuzzer's bytes; zeros when they have run out."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 0

    @property
    def ended(self) -> bool:
        return self._at >= len(self._data)

    def below(self, limit: int) -> int:
        """Draw a number from 0 to `limit` - 1."""
        # Beyond the script's end all numbers are zero: short scripts stay valid and the fuzzer can shorten them.
        number_bytes = self._data[self._at : self._at + 2].ljust(2, b"\0")
        self._at += 2
        return int.from_bytes(number_bytes, "little") % max(limit, 1)

    def take(self, count: int) -> bytes:
        chunk = self._data[self._at : self._at + count].ljust(count, b"\0")
        self._at += count
        return chunk


@dataclass
class Card:
    """The file under mutation; `resealed` once a changed block got a right CRC."""

    data: bytearray
    resealed: bool = False

    @property
    def blocks(self) -> int:
        return len(self.data) // BLOCK_BYTES

    def block(self, number: int) -> slice:
        return slice(number * BLOCK_BYTES, (number + 1) * BLOCK_BYTES)


@cache
def truths() -> dict[int, Truth]:
    """Build two recordings with everything that a log can have.

    They have copies of the header, partial and empty blocks, events and drops.
    """
    return {NEW: _truth(NEW, 5_000_000, 4), OLD: _truth(OLD, 90_000_000, 5)}


def _truth(session: int, start_us: int, repeat: int) -> Truth:
    # Different sessions and intervals of repeated headers: blocks of one must not be taken for the other's.
    recorder = Recorder(session=session, start_us=start_us, repeat_blocks=repeat)
    # A full block, a partial one, a full one: sample numbers go on across the short block.
    recorder.data()
    recorder.data(3)
    recorder.data()
    release_us = recorder.time_us(recorder.samples) + 1234
    # The second switch opens 300 us before the first one: the release is the later edge.
    edges = [
        event(release_us - 300, EventCode.SWITCH_EDGE, 1, 1),
        event(release_us, EventCode.SWITCH_EDGE, 0, 1),
    ]
    recorder.data(flags=_OPEN, events=edges)
    # A block without samples is as valid as a full one.
    recorder.data(0, flags=_OPEN)
    recorder.data(flags=_OPEN)
    stroke = event(release_us + 700_000, EventCode.STROKE)
    recorder.data(flags=_OPEN, events=[stroke])
    recorder.data(2, flags=_OPEN)
    recorder.close()
    events = [(e.time_us, e.index, e.arg, e.value) for e in (*edges, stroke)]
    return Truth(recorder, _sample_rows(recorder), events, release_us)


def _sample_rows(recorder: Recorder) -> dict[int, tuple[int, list[int]]]:
    rows = {}
    for index in range(recorder.samples):
        truth = sample(index, 0)
        imu = [
            value
            for imu_reading in truth.imu
            for value in (*imu_reading.accel, imu_reading.temperature, *imu_reading.gyro)
        ]
        rows[index] = (recorder.time_us(index), [*imu, *truth.angle])
    return rows


def pristine() -> bytearray:
    """Return the new recording, followed by unused space and the remains of the old recording."""
    new, old = truths()[NEW].recorder, truths()[OLD].recorder
    # Without its first blocks the old recording lies there like the remains of an overwritten file.
    return bytearray(new.image() + bytes(BLOCK_BYTES) + b"".join(old.blocks[3:]))


def mutate_log(script: Script) -> Card:
    """Apply the script's steps to the pristine file."""
    card = Card(pristine())
    for _ in range(_MAX_STEPS):
        if script.ended or not card.data:
            break
        STEPS[script.below(len(STEPS))](card, script)
    return card


def _cut(card: Card, script: Script) -> None:
    del card.data[script.below(len(card.data)) :]


def _cut_at_a_block(card: Card, script: Script) -> None:
    del card.data[script.below(card.blocks + 1) * BLOCK_BYTES :]


def _flip(card: Card, script: Script) -> None:
    card.data[script.below(len(card.data))] ^= 1 << script.below(8)


def _overwrite(card: Card, script: Script) -> None:
    at, new = script.below(len(card.data)), script.take(script.below(9))
    card.data[at : at + len(new)] = new


def _swap(card: Card, script: Script) -> None:
    # Two blocks exchanged keep their right CRCs: only numbers and times tell their places.
    block, other = card.block(script.below(card.blocks)), card.block(script.below(card.blocks))
    card.data[block], card.data[other] = bytes(card.data[other]), bytes(card.data[block])


def _copy_over(card: Card, script: Script) -> None:
    card.data[card.block(script.below(card.blocks))] = card.data[card.block(script.below(card.blocks))]


def _copy_behind(card: Card, script: Script) -> None:
    first = script.below(card.blocks)
    card.data += card.data[first * BLOCK_BYTES : (first + 1 + script.below(6)) * BLOCK_BYTES]


def _blank(card: Card, script: Script) -> None:
    block = card.block(script.below(card.blocks))
    # Zeros, erased flash, and a pattern: what a card may show for a lost block.
    fill = (0x00, 0xFF, 0xA5)[script.below(3)]
    card.data[block] = bytes([fill]) * len(card.data[block])


def _remove(card: Card, script: Script) -> None:
    del card.data[card.block(script.below(card.blocks))]


def _insert_bytes(card: Card, script: Script) -> None:
    at = script.below(len(card.data))
    card.data[at:at] = script.take(script.below(9))


def _splice(card: Card, script: Script) -> None:
    """Blocks of a recording, in good order, somewhere."""
    blocks = truths()[(NEW, OLD)[script.below(2)]].recorder.blocks
    first, at = script.below(len(blocks)), script.below(card.blocks + 1) * BLOCK_BYTES
    card.data[at:at] = b"".join(blocks[first : first + 1 + script.below(6)])


def _tear(card: Card, script: Script) -> None:
    """Replace the end of one block by the end of another."""
    block, other = card.block(script.below(card.blocks)), card.block(script.below(card.blocks))
    at = script.below(BLOCK_BYTES)
    card.data[block] = card.data[block][:at] + card.data[other][at:]


def _reseal(card: Card, script: Script) -> None:
    """Overwrite bytes of a block's header or payload and correct its CRC."""
    block = card.block(script.below(card.blocks))
    # Only the CRC is computed anew: the decoder must stay sane although the content is a lie.
    text = bytearray(card.data[block])
    if len(text) < BLOCK_BYTES:
        return
    # Half of the changes hit the block's head, where nearly every field matters.
    at = script.below(BLOCK_BYTES) if script.below(2) else script.below(BlockHeader.SIZE)
    new = script.take(1 + script.below(8))
    text[at : at + len(new)] = new
    try:
        card.data[block] = renumbered(bytes(text[:BLOCK_BYTES]))
    except TfsatError:  # a head that no encoder can write
        return
    card.resealed = True


STEPS: tuple[Callable[[Card, Script], None], ...] = (
    _cut,
    _cut_at_a_block,
    _flip,
    _overwrite,
    _swap,
    _copy_over,
    _copy_behind,
    _blank,
    _remove,
    _insert_bytes,
    _splice,
    _tear,
    _reseal,
)


def check(data: bytes, path: Path) -> str:
    """Decode a mutated file, written to `path`; what came of it. Raises AssertionError where it is wrong."""
    card = mutate_log(Script(data))
    path.write_bytes(card.data)
    try:
        log = load(path)
    except LogError as error:
        # A refusal must tell what to do next.
        assert error.what and error.meaning and error.next_step
        return "refused"
    _check_sane(log)
    # A right CRC over wrong contents cannot be detected: only sanity is asked for.
    if card.resealed:
        json.dumps(record(SUMMARY, log))
        return f"resealed: {log.verdict}"
    _check_true(log)
    return log.verdict


def _check_sane(log: DropLog) -> None:
    n = len(log)
    # No NaN and no column of another length, whatever the input was.
    assert n and log.imu_counts.shape == (n, 4, 7) and log.angle_counts.shape == (n, 6)
    assert all(len(column) == n for column in (log.sample_index, log.imu_valid, log.angle_valid))
    assert log.samples_lost >= 0 and log.blocks_lost >= 0
    for column in (log.rate_rad_s, log.specific_force_m_s2, log.temperature_c):
        assert np.isfinite(column[log.imu_valid]).all()
    assert np.isfinite(log.sensor_angle_rad[log.angle_valid]).all()
    # A log that is not damaged may only start late; it has no gap in the middle.
    if log.verdict != "damaged":
        assert log.gaps in ((), (log.late_start,)) and not log.doubts
        assert log.samples_lost == log.blocks_lost == 0
        assert (np.diff(log.sample_index) == 1).all() and (np.diff(log.t_us) > 0).all()


def _check_true(log: DropLog) -> None:
    truth = truths()[log.session]
    assert log.header == truth.recorder.header
    decoded_rows = np.hstack(
        (log.imu_counts.reshape(len(log), 28), log.angle_counts), dtype=np.int32
    ).tolist()
    # Every decoded sample must be one that was recorded, value by value.
    for index, t_us, row in zip(log.sample_index.tolist(), log.t_us.tolist(), decoded_rows, strict=True):
        assert (t_us, row) == truth.rows[index], index
    assert (np.diff(log.sample_index) > 0).all()
    assert log.imu_valid.all() and log.angle_valid.all()
    events = [(e.t_us, e.index, e.arg, e.value) for e in log.events]
    # No event may appear twice or be invented.
    assert len(set(events)) == len(events) and set(events) <= set(truth.events)
    if log.release is not None:
        # The true release lies within the bounds that the decoder states.
        assert log.release.earliest_us <= truth.release_us <= log.release.latest_us
    # Complete: all samples, all events and the exact release.
    if log.verdict == "complete":
        assert len(log) == truth.recorder.samples and events == truth.events
        assert log.release_us == truth.release_us
    else:
        assert warnings(log)
    # Truncated: one unbroken run of samples, with a beginning or an end missing.
    if log.verdict == "truncated":
        first = int(log.sample_index[0])
        assert log.sample_index.tolist() == list(range(first, first + len(log)))
        assert log.late_start is not None or first == 0
        begin = truth.events.index(events[0]) if events else 0
        assert begin == 0 or log.late_start is not None
        assert events == truth.events[begin : begin + len(events)]
    # With the footer the decoder knows the total and must count exactly what is missing.
    if log.footer is not None:
        before = log.late_start.samples if log.late_start else 0
        assert log.samples_lost == truth.recorder.samples - len(log) - before
