"""The same samples written in each decoder's own format."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np
from fastcrc.crc32 import iso_hdlc as crc32
from numpy.typing import NDArray

from tests.sdlog.encoder import ALL_VALID, SESSION, Recorder
from tfsat_host.protocol.enums import BlockKind
from tfsat_host.protocol.limits import BLOCK_MAGIC, BLOCK_VERSION, HEADER_REPEAT_BLOCKS, SAMPLES_PER_BLOCK
from tfsat_host.protocol.log_layout import CRC_OFFSET, DATA_BLOCK_DTYPE

INTERVAL_US = 3571
START_US = 5_000_000


@dataclass(frozen=True, eq=False)
class Samples:
    """What every log holds: (n,) int64 µs, (n, 28) int16 of four IMUs, (n, 6) uint16 angles."""

    t_us: NDArray[np.int64]
    imu: NDArray[np.int16]
    angle: NDArray[np.uint16]

    def rows(self) -> NDArray[np.void]:
        """(n,) packed records: time u64, imu i16[28], angle u16[6], flags u16."""
        rows = np.zeros(len(self.t_us), ROW)
        rows["t_us"], rows["imu"], rows["angle"], rows["flags"] = self.t_us, self.imu, self.angle, ALL_VALID
        return rows


ROW = np.dtype([("t_us", "<u8"), ("imu", "<i2", (28,)), ("angle", "<u2", (6,)), ("flags", "<u2")])


def make_samples(count: int) -> Samples:
    """Noise, the same every time; a whole number of full blocks."""
    chance = np.random.default_rng(1)
    count -= count % SAMPLES_PER_BLOCK
    return Samples(
        START_US + np.arange(count) * INTERVAL_US,
        chance.integers(-32768, 32768, (count, 28)).astype(np.int16),
        chance.integers(0, 4096, (count, 6)).astype(np.uint16),
    )


def write_tfsat(samples: Samples, path: Path) -> None:
    """Our blocks, with a copy of the header every few hundred, as the logger writes them."""
    data_blocks = len(samples.t_us) // SAMPLES_PER_BLOCK
    number = np.arange(data_blocks)
    # Block numbers leave a gap for each repeated header.
    number += number // (HEADER_REPEAT_BLOCKS - 1) + 1
    blocks = np.zeros(int(number[-1]) + 1, np.dtype(DATA_BLOCK_DTYPE))
    # A header block of the recorder, so that scales and session are those that a logger writes.
    header = np.frombuffer(Recorder().blocks[0], blocks.dtype)[0]
    # Every block is a header first; data blocks overwrite their places.
    blocks[:] = header
    data = blocks[number]
    data["kind"], data["sample_count"] = BlockKind.DATA, SAMPLES_PER_BLOCK
    # A block has the time of its first sample, and each sample a 16-bit offset from it.
    data["time_us"] = samples.t_us[::SAMPLES_PER_BLOCK]
    data["first_sample"] = np.arange(data_blocks) * SAMPLES_PER_BLOCK
    slots = np.zeros((data_blocks, SAMPLES_PER_BLOCK), data.dtype["samples"].base)
    slots["time_offset_us"] = samples.t_us.reshape(data_blocks, -1) - samples.t_us[::SAMPLES_PER_BLOCK, None]
    slots["flags"] = ALL_VALID
    slots["angle"] = samples.angle.reshape(data_blocks, -1, 6)
    # Seven words an IMU, in the order of its registers: accelerometer, temperature, gyro.
    imu = samples.imu.reshape(data_blocks, -1, 4, 7)
    slots["imu"]["accel"], slots["imu"]["temperature"] = imu[..., :3], imu[..., 3]
    slots["imu"]["gyro"] = imu[..., 4:]
    # Events of the copied header must not appear in each data block.
    data["samples"], data["events"] = slots, np.zeros((), data.dtype["events"].base)
    blocks[number] = data
    blocks["magic"], blocks["version"], blocks["session"] = BLOCK_MAGIC, BLOCK_VERSION, SESSION
    blocks["block_number"] = np.arange(len(blocks))
    with path.open("wb") as file:
        for block in blocks:
            # The CRC is over all bytes in front of it.
            body = block.tobytes()[:CRC_OFFSET]
            file.write(body + crc32(body).to_bytes(4, "little"))


def write_ulog(samples: Samples, path: Path) -> None:
    """PX4's ULog: one topic, one message a sample."""
    text = b"drop:uint64_t timestamp;int16_t[28] imu;uint16_t[6] angle;uint16_t flags;"
    data = np.zeros(len(samples.t_us), [("size", "<u2"), ("type", "S1"), ("id", "<u2"), ("row", ROW)])
    # ULog counts the message's size without its own three header bytes.
    data["size"], data["type"], data["row"] = ROW.itemsize + 2, b"D", samples.rows()
    with path.open("wb") as file:
        file.write(b"ULog\x01\x12\x35\x01" + struct.pack("<Q", START_US))
        # Flag bits message: no compatibility flags, no appended data.
        file.write(struct.pack("<HB40x", 40, ord("B")))
        file.write(struct.pack("<HB", len(text), ord("F")) + text)
        # Subscription: message id 0 is the topic "drop".
        file.write(struct.pack("<HBBH", 7, ord("A"), 0, 0) + b"drop")
        file.write(data.tobytes())


def write_mcap(samples: Samples, path: Path) -> None:
    """MCAP: chunks of uncompressed messages with their CRCs, by its own library."""
    from mcap.writer import CompressionType, Writer

    stream = BytesIO()
    # Without compression, as every other format here: decoding is compared, not zlib.
    writer = Writer(stream, compression=CompressionType.NONE)
    writer.start()
    schema = writer.register_schema("drop", "raw", b"")
    channel = writer.register_channel("/drop", "raw", schema)
    for row in samples.rows():
        t_ns = int(row["t_us"]) * 1000
        writer.add_message(channel, log_time=t_ns, data=row.tobytes(), publish_time=t_ns)
    writer.finish()  # type: ignore[no-untyped-call]
    path.write_bytes(stream.getvalue())


def write_dataflash(samples: Samples, path: Path) -> None:
    """ArduPilot's DataFlash: one message a sample; its array field holds 32 numbers."""
    # DataFlash has array fields of 32 int16 only; 28 of them are used.
    kinds = [("magic", "S2"), ("type", "u1"), ("t_us", "<u8"), ("imu", "<i2", (32,)), ("angle", "<u2", (6,))]
    rows = np.zeros(len(samples.t_us), [*kinds, ("flags", "<u2")])
    rows["magic"], rows["type"], rows["t_us"] = b"\xa3\x95", 129, samples.t_us
    rows["imu"][:, :28], rows["angle"], rows["flags"] = samples.imu, samples.angle, ALL_VALID

    def format_message(number: int, size: int, name: bytes, letters: bytes, labels: bytes) -> bytes:
        return struct.pack("<2sBBB4s16s64s", b"\xa3\x95", 128, number, size, name, letters, labels)

    with path.open("wb") as file:
        # The first message describes FMT messages themselves, the second one ours.
        file.write(format_message(128, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns"))
        file.write(
            format_message(129, rows.itemsize, b"DROP", b"QaHHHHHHH", b"TimeUS,Imu,A1,A2,A3,A4,A5,A6,Flags")
        )
        file.write(rows.tobytes())
