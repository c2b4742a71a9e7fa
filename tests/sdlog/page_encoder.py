"""An encoder written from docs/log-format.md alone: nothing of tfsat is imported, every number is the page's."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field

BLOCK, CRC_AT, HEAD, EVENTS_AT = 512, 508, 32, 476
MOST_SAMPLES, MOST_EVENTS = 6, 2
HEADER, DATA, FOOTER = 1, 2, 3
VERSION = 3
EARLY_HEADER, HEADER_EACH = 8, 256
STOPPED_BY_HOST = 1


@dataclass
class Reading:
    """One sample: 4 times accelerometer x y z, temperature, gyro x y z; 6 angles; flags."""

    time_us: int
    imu: list[list[int]]
    angle: list[int]
    flags: int


@dataclass
class Happening:
    """One event."""

    time_us: int
    code: int
    index: int = 0
    arg: int = 0
    value: int = 0


@dataclass
class Encoder:
    """A recording, block by block."""

    session: int
    rate_hz: float
    blocks: list[bytes] = field(default_factory=list)
    samples: int = 0
    times_us: list[int] = field(default_factory=list)

    def add(self, readings: list[Reading], happenings: list[Happening]) -> None:
        """A data block, and before it the header if that is due."""
        assert len(readings) <= MOST_SAMPLES and len(happenings) <= MOST_EVENTS
        time_us = readings[0].time_us if readings else happenings[0].time_us
        number = len(self.blocks)
        if number == EARLY_HEADER or number % HEADER_EACH == 0:
            self._put(HEADER, time_us, self._header(time_us))
        body = bytearray(EVENTS_AT - HEAD + 16 * MOST_EVENTS)
        for slot, one in enumerate(readings):
            counts = [count for imu in one.imu for count in imu]
            struct.pack_into(
                "<IH28h6H", body, 74 * slot, one.time_us - time_us, one.flags, *counts, *one.angle
            )
        for slot, event in enumerate(happenings):
            struct.pack_into(
                "<QBBHi",
                body,
                EVENTS_AT - HEAD + 16 * slot,
                event.time_us,
                event.code,
                event.index,
                event.arg,
                event.value,
            )
        self._put(DATA, time_us, bytes(body), len(readings), len(happenings))
        self.samples += len(readings)
        self.times_us += [one.time_us for one in readings]

    def close(self, time_us: int) -> bytes:
        """The file, closed cleanly."""
        steps = [b - a for a, b in zip(self.times_us, self.times_us[1:], strict=False)]
        nominal = 1e6 / self.rate_hz
        rms = (sum((step - nominal) ** 2 for step in steps) / len(steps)) ** 0.5
        footer = struct.pack(
            "<6If4IB",
            *(self.samples, 0, len(self.blocks) + 1, 3, min(steps), max(steps)),
            rms,
            *(sum(step > 1.5 * nominal for step in steps), 896, 12, 0),
            STOPPED_BY_HOST,
        )
        self._put(FOOTER, time_us, footer)
        return b"".join(self.blocks)

    def _header(self, time_us: int) -> bytes:
        return struct.pack(
            "<8s3sB8sIfffffIHBB4sHH384sQ4H6H",
            b"\1\2\3\4\5\6\7\x08",
            b"\0\1\0",
            0xF,
            b"a logger",
            0xDEADBEEF,
            self.rate_hz,
            *(65.5, 2048.0, 340.0, 36.53),
            4096,
            *(500, 16, 3),
            b"\x68" * 4,
            *(400, 30),
            b"written from the page",
            1_700_000_000_000_000 + time_us,
            *(0, 390, 0, 390),
            *(0, 5, 10, 15, 20, 25),
        )

    def _put(self, kind: int, time_us: int, payload: bytes, samples: int = 0, events: int = 0) -> None:
        head = struct.pack(
            "<4s4B4IQ",
            b"TFS1",
            *(VERSION, kind, samples, events),
            *(self.session, len(self.blocks), self.samples, 0),
            time_us,
        )
        block = (head + payload).ljust(CRC_AT, b"\0")
        self.blocks.append(block + struct.pack("<I", zlib.crc32(block)))
