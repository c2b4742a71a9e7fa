"""The recording's own description: the header or a copy of it, believed only if it makes sense."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.protocol.log_layout import HEADER_BYTES
from tfsat_host.protocol.messages import BlockHeader, LogHeader

from . import errors
from .assembly import Assembly
from .source import LogSource

_WALL_CLOCK_OFFSET = LogHeader.SIZE - 8
"""What stands before it is the same in every copy; the time of day may be set while recording."""
_FULL_SCALE_COUNTS = 32768
_SCALE_TOLERANCE = 0.05
_RATE_HZ = (0.1, 8000.0)
"""The MPU-6050 makes at most 8000 gyro samples a second (RM-MPU-6000A rev. 4.2, register 25)."""
_COUNTS_PER_TURN = (16, 65536)
_TEMPERATURE_LSB_PER_C = (1.0, 10_000.0)
_TEMPERATURE_OFFSET_C = (-300.0, 300.0)


@dataclass(frozen=True)
class FoundHeader:
    """A header that was believed.

    Attributes:
        header: Scales, sensors, versions.
        is_copy: The first block is lost; this is a repetition.
        disagreements: Copies that say something else.
        time_us: The logger's clock when this header was written (wall_clock_us belongs to it).
    """

    header: LogHeader
    is_copy: bool
    disagreements: int
    time_us: int


def find_header(source: LogSource, assembly: Assembly, kind: int) -> FoundHeader:
    """Read the recording's headers (blocks of `kind`) and choose the first that makes sense.

    Raises:
        LogError: there is none, or none makes sense.
    """
    entries = assembly.entries[assembly.entries["kind"] == kind]
    if not len(entries):
        raise errors.no_header(source.path, assembly.session)
    chosen: FoundHeader | None = None
    reason = ""
    disagreements = 0
    seen: dict[bytes, str] = {}
    chosen_lasting = b""
    for position, number in zip(entries["position"].tolist(), entries["number"].tolist(), strict=True):
        body, time_us = _read(source, position)
        lasting = body[:_WALL_CLOCK_OFFSET]
        if lasting not in seen:
            seen[lasting] = absurdity(LogHeader.decode(body))
        elif chosen is not None and lasting == chosen_lasting:
            continue
        reason = reason or seen[lasting]
        if chosen is None and not seen[lasting]:
            chosen, chosen_lasting = FoundHeader(LogHeader.decode(body), number != 0, 0, time_us), lasting
        else:
            disagreements += 1
    if chosen is None:
        raise errors.absurd_header(source.path, assembly.session, reason)
    return replace(chosen, disagreements=disagreements)


def absurdity(header: LogHeader) -> str:
    """Say what is impossible about a header; empty if nothing is."""
    checks = (
        ("sampling rate", header.rate_hz, "Hz", _RATE_HZ),
        ("temperature scale", header.temperature_lsb_per_c, "LSB/°C", _TEMPERATURE_LSB_PER_C),
        ("temperature offset", header.temperature_offset_c, "°C", _TEMPERATURE_OFFSET_C),
        ("angle sensor scale", header.angle_counts_per_turn, "counts a turn", _COUNTS_PER_TURN),
    )
    for name, value, unit, (least, most) in checks:
        if not (math.isfinite(value) and least <= value <= most):
            return f"{name} {value:g} {unit} (possible: {least:g} to {most:g})"
    scales = (
        ("gyro", header.gyro_lsb_per_deg_s, "LSB/(deg/s)", header.gyro_range_deg_s),
        ("accelerometer", header.accel_lsb_per_g, "LSB/g", header.accel_range_g),
    )
    for name, scale, unit, full_scale in scales:
        if not (
            math.isfinite(scale) and abs(scale * full_scale / _FULL_SCALE_COUNTS - 1) <= _SCALE_TOLERANCE
        ):
            return f"{name} scale {scale:g} {unit} does not belong to a range of ±{full_scale}"
    return ""


def _read(source: LogSource, position: int) -> tuple[bytes, int]:
    """The payload of a header block, and the logger's clock when it was written."""
    size = HEADER_BYTES + LogHeader.SIZE
    block = bytes(source.read_into(memoryview(bytearray(size)), position * BLOCK_BYTES))
    return block[HEADER_BYTES:], BlockHeader.decode(block[:HEADER_BYTES]).time_us
