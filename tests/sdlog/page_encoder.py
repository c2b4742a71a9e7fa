"""An encoder of what docs/log-format.md says: nothing of tfsat is imported.

Its draft was written from the page alone. What the page did not tell, it got wrong; both were mended then.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

HEADER, DATA, FOOTER = 1, 2, 3
SWITCH_EDGE, STROKE, RELEASE, LANDING, REWRITTEN = 1, 2, 7, 8, 12
STOPPED_BY_HOST = 1
MAX_SAMPLES, MAX_EVENTS = 6, 2

SESSION = 0xC0DE0001
RATE_HZ = 280.0
UNIX_AT_ZERO_US = 1_700_000_000_000_000
SCHEMA = (
    b"tfsat log, little endian, 512 B blocks: head 32, 6 Sample, 2 Event, CRC-32 at 508. "
    b"Read at + imu_offset_us, angle_offset_us. "
    b"Sample: time_offset_us u32, flags u16, imu ImuReading[4], angle u16[6] turn/angle_counts_per_turn. "
    b"ImuReading: accel i16[3] g/accel_lsb_per_g, temperature i16 C, gyro i16[3] deg/s/gyro_lsb_per_deg_s. "
    b"Event: time_us u64, code u8, index u8, arg u16, value i32."
)


@dataclass(frozen=True)
class Sample:
    """Raw counts; each IMU's are accel x y z, temperature, gyro x y z."""

    time_us: int
    flags: int
    imu: list[list[int]]
    angle: list[int]


@dataclass(frozen=True)
class Event:
    """Something that happened, with its own time."""

    time_us: int
    code: int
    index: int = 0
    arg: int = 0
    value: int = 0


@dataclass(frozen=True)
class Content:
    """What one data block holds."""

    first_sample: int
    samples: Sequence[Sample]
    events: Sequence[Event]

    @property
    def time_us(self) -> int:
        """That of the first sample; without samples, of the first event."""
        return self.samples[0].time_us if self.samples else self.events[0].time_us


def encode(samples: Sequence[Sample], events: Sequence[Event], again: range = range(0)) -> bytes:
    """Return the bytes of the whole file.

    Args:
        samples: Samples by time; two or more.
        events: Events in any order.
        again: Numbers of the blocks that are written a second time, before the footer.
    """
    blocks: list[bytes] = []
    for content in contents(samples, events):
        # The header is repeated early, and then every 256 blocks.
        if len(blocks) == 8 or len(blocks) % 256 == 0:
            blocks.append(header_block(len(blocks), content))
        blocks.append(data_block(len(blocks), content))
    copies = [blocks[number] for number in again]
    return b"".join((*blocks, *copies, footer_block(len(blocks), samples, len(copies))))


def contents(samples: Sequence[Sample], events: Sequence[Event]) -> Iterator[Content]:
    """Six samples a block, with the events up to the next; those without a slot get blocks of their own."""
    waiting = sorted(events, key=lambda event: event.time_us)
    for first in range(0, len(samples), MAX_SAMPLES):
        rows = samples[first : first + MAX_SAMPLES]
        end = first + len(rows)
        due = [event for event in waiting if end == len(samples) or event.time_us < samples[end].time_us]
        waiting = waiting[len(due) :]
        yield Content(first, rows, due[:MAX_EVENTS])
        # Events that found no slot get blocks of their own.
        for slot in range(MAX_EVENTS, len(due), MAX_EVENTS):
            yield Content(end, (), due[slot : slot + MAX_EVENTS])


def block(
    kind: int, number: int, first_sample: int, time_us: int, payload: bytes, in_use: tuple[int, int] = (0, 0)
) -> bytes:
    """512 bytes: head, payload, zeros, CRC. `in_use`: slots of samples and of events."""
    head = struct.pack("<4s4B4IQ", b"TFS1", 3, kind, *in_use, SESSION, number, first_sample, 0, time_us)
    body = (head + payload).ljust(508, b"\0")
    # The CRC of everything before it, zero-padded to the block's end.
    return body + struct.pack("<I", zlib.crc32(body))


def header_block(number: int, following: Content) -> bytes:
    """IMUs at 500 deg/s and 16 g on buses of 400 kHz; the time is that of the block that follows."""
    payload = (
        struct.pack("<8s3BB", bytes(range(1, 9)), 0, 1, 0, 0b1111),  # hash, firmware, IMUs that answered
        struct.pack("<8sI", b"a logger", 0xDEADBEEF),  # serial number, CRC of the image
        struct.pack("<5fI", RATE_HZ, 65.5, 2048, 340, 36.53, 4096),  # rate and scales
        struct.pack("<HBB4s", 500, 16, 3, b"\x68" * 4),  # ranges, filter, WHO_AM_I
        struct.pack("<HH384s", 400, 30, SCHEMA),  # bus, seconds after the landing
        struct.pack("<Q", UNIX_AT_ZERO_US + following.time_us),
        struct.pack("<4H6H", 0, 390, 0, 390, 0, 5, 10, 15, 20, 25),  # when each sensor was read
    )
    return block(HEADER, number, following.first_sample, following.time_us, b"".join(payload))


def data_block(number: int, content: Content) -> bytes:
    """Samples from byte 32 on, events from byte 476 on."""
    samples = b"".join(sample_bytes(sample, content.time_us) for sample in content.samples)
    events = b"".join(
        struct.pack("<QBBHi", event.time_us, event.code, event.index, event.arg, event.value)
        for event in content.events
    )
    payload = samples.ljust(476 - 32, b"\0") + events
    in_use = len(content.samples), len(content.events)
    return block(DATA, number, content.first_sample, content.time_us, payload, in_use)


def sample_bytes(sample: Sample, block_time_us: int) -> bytes:
    """Return the 74 bytes of a sample."""
    counts = [count for imu in sample.imu for count in imu]
    return struct.pack("<IH28h6H", sample.time_us - block_time_us, sample.flags, *counts, *sample.angle)


def footer_block(number: int, samples: Sequence[Sample], copies: int) -> bytes:
    """Return the footer of a recording without loss, closed at its last sample."""
    nominal_us = 1e6 / RATE_HZ
    steps = [after.time_us - before.time_us for before, after in pairwise(samples)]
    # A step of more than one and a half intervals is a missed tick, not jitter.
    on_time = [step for step in steps if step <= 1.5 * nominal_us]
    rms_us = math.sqrt(sum((step - nominal_us) ** 2 for step in on_time) / len(on_time))
    payload = (
        struct.pack("<3I", len(samples), 0, number + 1),  # samples, dropped ones, blocks
        struct.pack("<I", 3),  # most blocks that waited
        struct.pack("<2IfI", min(steps), max(steps), rms_us, len(steps) - len(on_time)),
        struct.pack("<2I", 896, 12),  # room of the ring, longest stall
        struct.pack("<IB", copies, STOPPED_BY_HOST),
    )
    return block(FOOTER, number, len(samples), samples[-1].time_us, b"".join(payload))
