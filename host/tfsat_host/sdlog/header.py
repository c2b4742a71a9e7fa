"""The recording's own description: the header or a copy of it, believed only if it makes sense."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

from tfsat_host.protocol.messages import LogHeader
from tfsat_host.protocol.record import ProtocolError

from . import errors
from .parts import MPU_6050, parts_of

WALL_CLOCK = slice(444, 452)
"""What stands beside it is the same in every copy; the time of day may be set while recording."""
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


class HeaderChoice:
    """Takes a recording's headers by number and keeps the first that makes sense."""

    def __init__(self) -> None:
        self._chosen: FoundHeader | None = None
        self._chosen_lasting = b""
        self._refused_lasting = b""
        self._reason = ""
        self._others = 0

    def add(self, number: int, time_us: int, payload: bytes) -> None:
        """A header block: its number, its time, and its payload, of which a LogHeader is the beginning."""
        lasting = payload[: WALL_CLOCK.start] + payload[WALL_CLOCK.stop :]
        if self._chosen is not None:
            self._others += lasting != self._chosen_lasting
            return
        if lasting != self._refused_lasting:
            header, absurd = _understand(payload[: LogHeader.SIZE])
            if header is not None:
                self._chosen, self._chosen_lasting = FoundHeader(header, number != 0, 0, time_us), lasting
                return
            self._reason, self._refused_lasting = self._reason or absurd, lasting
        self._others += 1

    def found(self, path: Path, session: int) -> FoundHeader:
        """The header to believe.

        Raises:
            LogError: there is none, or none makes sense.
        """
        if self._chosen is None:
            if not self._reason:
                raise errors.no_header(path, session)
            raise errors.absurd_header(path, session, self._reason)
        return replace(self._chosen, disagreements=self._others)


def _understand(payload: bytes) -> tuple[LogHeader | None, str]:
    """The header, or None and what is wrong with it."""
    try:
        header = LogHeader.decode(payload)
    except ProtocolError as error:
        return None, error.what
    absurd = absurdity(header)
    return (None, absurd) if absurd else (header, "")


def temperature_scales(header: LogHeader) -> list[tuple[float, float]]:
    """Of each IMU: counts a °C, and °C at 0. Its part tells them, and of an MPU-6050 the header."""
    own = (header.temperature_lsb_per_c, header.temperature_offset_c)
    return [
        own if part.who_am_i == MPU_6050 else (part.temperature_lsb_per_c, part.temperature_offset_c)
        for part in parts_of(header.who_am_i)
    ]


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
