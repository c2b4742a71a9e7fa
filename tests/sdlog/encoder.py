"""Makes logs for the tests, block by block, from the generated records."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np

from tfsat_host.protocol.enums import BlockKind, EventCode, StopReason
from tfsat_host.protocol.limits import (
    BLOCK_BYTES,
    BLOCK_MAGIC,
    BLOCK_VERSION,
    EVENTS_PER_BLOCK,
    PROTOCOL_HASH,
    SAMPLES_PER_BLOCK,
)
from tfsat_host.protocol.log_layout import (
    BLOCK_HEADER_DTYPE,
    CRC_OFFSET,
    EVENTS_OFFSET,
    HEADER_BYTES,
)
from tfsat_host.protocol.messages import BlockHeader, Event, ImuReading, LogFooter, LogHeader, Sample

ALL_VALID = 0x03FF
SESSION = 0x1234ABCD
HEADER = LogHeader(
    protocol_hash=PROTOCOL_HASH,
    firmware_version=bytes((0, 1, 0)),
    imu_present=0xF,
    board_serial=b"12345678",
    image_crc=0xC0FFEE,
    rate_hz=280.0,
    gyro_lsb_per_deg_s=65.5,
    accel_lsb_per_g=16384.0,
    temperature_lsb_per_c=340.0,
    temperature_offset_c=36.53125,
    angle_counts_per_turn=4096,
    gyro_range_deg_s=500,
    accel_range_g=2,
    dlpf_cfg=3,
    who_am_i=bytes((0x68,) * 4),
    bus_khz=400,
    after_landing_s=30,
    schema=b"sample: u32 time_offset_us".ljust(384, b"\0"),
    wall_clock_us=0,
    imu_offset_us=(0, 390, 0, 390),
    angle_offset_us=(0, 5, 10, 15, 20, 25),
    maneuver_known=1,
    maneuver_crc=0x7A11,
)


def sealed(head: BlockHeader, body: bytes) -> bytes:
    """Return a block with its CRC."""
    # The CRC is over the block without itself.
    text = (head.encode() + body).ljust(CRC_OFFSET, b"\0")
    return text + struct.pack("<I", zlib.crc32(text))


@cache
def sample(index: int, time_offset_us: int, flags: int = ALL_VALID) -> Sample:
    """Return a sample whose every number follows from its index."""
    imu = tuple(
        ImuReading(
            accel=tuple(_i16(index * 7 + body * 100 + axis) for axis in range(3)),
            temperature=_i16(-4000 + index + body),
            gyro=tuple(_i16(3 * index - 11 * body - axis) for axis in range(3)),
        )
        for body in range(4)
    )
    return Sample(time_offset_us, flags, imu, tuple((index * 5 + 600 * k) % 4096 for k in range(6)))


def _i16(value: int) -> int:
    # Wraps into 16 bits as the sensor's register does.
    return (value + 32768) % 65536 - 32768


@dataclass
class Recorder:
    """Writes a recording the way the logger does; `blocks` is what is on the card."""

    session: int = SESSION
    start_us: int = 5_000_000
    interval_us: int = 3571
    header: LogHeader = HEADER
    repeat_blocks: int = 256
    blocks: list[bytes] = field(default_factory=list)
    samples: int = 0
    dropped: int = 0

    def __post_init__(self) -> None:
        self._add(BlockKind.HEADER, self.header.encode())

    def time_us(self, index: int) -> int:
        """Return the time at which sample `index` is taken."""
        return self.start_us + index * self.interval_us

    def data(
        self, count: int = SAMPLES_PER_BLOCK, *, flags: int = ALL_VALID, events: Sequence[Event] = ()
    ) -> None:
        """Append one data block, and the repeated header when it is due."""
        slots = [
            sample(self.samples + slot, slot * self.interval_us, flags).encode() for slot in range(count)
        ]
        body = b"".join(slots).ljust(SAMPLES_PER_BLOCK * Sample.SIZE, b"\0")
        body += b"".join(event.encode() for event in events).ljust(EVENTS_PER_BLOCK * Event.SIZE, b"\0")
        self._add(BlockKind.DATA, body, count, len(events))
        self.samples += count
        # The repeated header follows the block that made it due.
        if len(self.blocks) % self.repeat_blocks == 0:
            self._add(BlockKind.HEADER, self.header.encode())

    def drop(self, samples: int) -> None:
        """Count samples as dropped because the ring was full."""
        self.samples += samples
        self.dropped += samples

    def close(self) -> None:
        """Append the footer of a clean stop."""
        footer = LogFooter(
            samples=self.samples,
            samples_dropped=self.dropped,
            blocks=len(self.blocks) + 1,
            ring_peak_blocks=3,
            interval_min_us=self.interval_us - 2,
            interval_max_us=self.interval_us + 2,
            jitter_rms_us=1.5,
            late_ticks=0,
            ring_blocks=768,
            card_stall_max_ms=7,
            blocks_rewritten=0,
            stop_reason=StopReason.HOST,
        )
        self._add(BlockKind.FOOTER, footer.encode())

    def image(self) -> bytes:
        """Return the file's bytes."""
        return b"".join(self.blocks)

    def _add(self, kind: BlockKind, body: bytes, sample_count: int = 0, event_count: int = 0) -> None:
        head = BlockHeader(
            magic=BLOCK_MAGIC,
            version=BLOCK_VERSION,
            kind=kind,
            sample_count=sample_count,
            event_count=event_count,
            session=self.session,
            block_number=len(self.blocks),
            first_sample=self.samples,
            samples_dropped=self.dropped,
            time_us=self.time_us(self.samples),
        )
        self.blocks.append(sealed(head, body))


def recording(data_blocks: int = 6, *, closed: bool = True, **settings: Any) -> Recorder:
    """Build a recording of `data_blocks` full blocks without loss, closed unless told otherwise."""
    recorder = Recorder(**settings)
    for _ in range(data_blocks):
        recorder.data()
    if closed:
        recorder.close()
    return recorder


def long_recording(
    blocks: int, *, start_us: int = 5_000_000, late_us: Mapping[int, int] | None = None
) -> bytes:
    """Build a header and full blocks that differ only in number and time, 3571 us a sample.

    Args:
        blocks: Number of blocks, the header included.
        start_us: Time of the first sample.
        late_us: Delay in us by block number, for that block and all after it.
    """
    header, data = recording(1, closed=False, start_us=start_us).blocks
    # One block as a pattern: only number and time differ from block to block.
    image = np.tile(np.frombuffer(data, np.uint8), (blocks, 1))
    image[0] = np.frombuffer(header, np.uint8)
    heads = image[:, :HEADER_BYTES].view(np.dtype(BLOCK_HEADER_DTYPE))[:, 0]
    heads["block_number"] = np.arange(blocks)
    heads["first_sample"] = SAMPLES_PER_BLOCK * np.maximum(np.arange(blocks) - 1, 0)
    heads["time_us"] = start_us + 3571 * heads["first_sample"].astype(np.uint64)
    for number, later_us in (late_us or {}).items():
        heads["time_us"][number:] += np.uint64(later_us)
    # A CRC for each block: number and time differ.
    crcs = [zlib.crc32(block) for block in image[:, :CRC_OFFSET]]
    image[:, CRC_OFFSET:] = np.array(crcs, "<u4").view(np.uint8).reshape(-1, 4)
    return image.tobytes()


def event(time_us: int, code: EventCode, index: int = 0, arg: int = 0, value: int = 0) -> Event:
    """Build one event."""
    return Event(time_us, code, index, arg, value)


def drop_with_release(closed: bool = True, **settings: Any) -> tuple[Recorder, int]:
    """Return a recording with a release and four strokes at the paper's times, and the release's time."""
    recorder = Recorder(**settings)
    recorder.data()
    recorder.data()
    # The release lies between two samples, as it does in a log.
    release_us = recorder.time_us(recorder.samples) + 1234
    recorder.data(
        events=[
            event(release_us - 300, EventCode.SWITCH_EDGE, 1, 1),
            event(release_us, EventCode.SWITCH_EDGE, 0, 1),
        ],
        flags=ALL_VALID | 0x0C00,
    )
    for number, after_us in enumerate((700_000, 1_050_000, 1_470_000, 1_820_000)):
        # Strokes fall into the block that was recorded at their time.
        while recorder.time_us(recorder.samples + SAMPLES_PER_BLOCK) < release_us + after_us:
            recorder.data(flags=ALL_VALID | 0x0C00)
        recorder.data(
            flags=ALL_VALID | 0x0C00, events=[event(release_us + after_us, EventCode.STROKE, number)]
        )
    if closed:
        recorder.close()
    return recorder, release_us


def renumbered(block: bytes, **changes: Any) -> bytes:
    """Return the same block with changed header fields and a matching CRC."""
    # Changed fields and a CRC that fits: the decoder must see the change, not the damage.
    head = replace(BlockHeader.decode(block[: BlockHeader.SIZE]), **changes)
    return sealed(head, block[BlockHeader.SIZE : CRC_OFFSET])


assert BLOCK_BYTES == CRC_OFFSET + 4
assert EVENTS_OFFSET == BlockHeader.SIZE + SAMPLES_PER_BLOCK * Sample.SIZE
