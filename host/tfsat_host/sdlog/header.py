"""The recording's own description: the header or a copy of it, believed only if it makes sense."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from tfsat_host.protocol.imus import IMU_PARTS, ImuPart
from tfsat_host.protocol.log_layout import LOG_HEADER_DTYPE
from tfsat_host.protocol.messages import LogHeader
from tfsat_host.protocol.record import ProtocolError

from .log_errors import LOOK_AGAIN, LogError

_FIELDS: Mapping[str, Any] = np.dtype(LOG_HEADER_DTYPE).fields or {}
_WALL_CLOCK_AT: int = _FIELDS["wall_clock_us"][1]
WALL_CLOCK = slice(_WALL_CLOCK_AT, _WALL_CLOCK_AT + 8)
"""Where it is in a header; all other bytes are the same in every copy, but it may be set while recording."""
MIN_TIME_OF_DAY = datetime(2020, 1, 1, tzinfo=UTC)
"""An earlier one was told by a computer without a clock, and tells nothing."""
MIN_WALL_CLOCK_US = round(MIN_TIME_OF_DAY.timestamp() * 1e6)
MPU_6050 = next(iter(IMU_PARTS))
"""What an IMU is taken for that did not answer, where no other one did."""
_FULL_SCALE_COUNTS = 32768
# Room for rounded data-sheet scales (131 x 250 = 32750), far from the factor 2 between two ranges.
_SCALE_TOLERANCE = 0.05
_GYRO_RANGES_DEG_S, _ACCEL_RANGES_G = (250, 500, 1000, 2000), (2, 4, 8, 16)
_BUS_KHZ = (100, 400)
_RATE_HZ = (0.1, 8000.0)
"""The MPU-6050 makes at most 8000 gyro samples a second (RM-MPU-6000A rev. 4.2, register 25)."""
_US_PER_S = 1e6
_COUNTS_PER_TURN = (16, 65536)
_TEMPERATURE_LSB_PER_C = (1.0, 10_000.0)
_TEMPERATURE_OFFSET_C = (-300.0, 300.0)


class HeaderChoice:
    """Takes a recording's headers by number and keeps the first that makes sense.

    Attributes:
        is_copy: The first block is lost; what was kept is a repetition.
        time_us: The logger's clock when that header was written (its wall_clock_us belongs to it).
        disagreements: Copies that differ from it.
    """

    def __init__(self) -> None:
        self.is_copy = False
        self.time_us = self.disagreements = 0
        self._header: LogHeader | None = None
        self._lasting = self._refused = b""
        self._reason = ""

    def add(self, number: int, time_us: int, payload: bytes) -> None:
        """Take a header block's number, time and payload, which begins with a LogHeader."""
        # Compare copies without the wall clock, which a host may set while the logger records.
        lasting = payload[: WALL_CLOCK.start] + payload[WALL_CLOCK.stop :]
        if self._header is None and lasting != self._refused:
            # Keep the first that makes sense; bytes that were refused once are not examined again.
            self._header, absurd = _understand(payload[: LogHeader.SIZE])
            if self._header is not None:
                self.is_copy, self.time_us, self._lasting = number != 0, time_us, lasting
                return
            self._reason, self._refused = self._reason or absurd, lasting
        # Every later copy that differs, and any before the first good one, makes the recording doubtful.
        self.disagreements += self._header is None or lasting != self._lasting

    def header(self, path: Path, session: int) -> LogHeader:
        """Scales, sensors, versions.

        Raises:
            LogError: there is no header, or none makes sense.
        """
        if self._header is not None:
            return self._header
        if not self._reason:
            raise LogError(
                f"{path}: recording {session:08x} has lost its header and every copy of it.",
                LOOK_AGAIN,
                "The scales of its numbers are unknown, so no value can be given.",
            )
        raise LogError(
            f"{path}: the header of recording {session:08x} makes no sense: {self._reason}.",
            "Flash the logger from this release and record again; keep the file as evidence.",
            "Its values would be wrong by an unknown factor, so none are given.",
        )


def _understand(payload: bytes) -> tuple[LogHeader | None, str]:
    """Decode and check a header; return it, or None with the reason why it was rejected."""
    try:
        header = LogHeader.decode(payload)
    except ProtocolError as error:
        return None, error.what
    absurd = _absurdity(header)
    return (None, absurd) if absurd else (header, "")


def parts_of(who_am_i: Sequence[int]) -> tuple[ImuPart, ...]:
    """Return the part of each IMU; one that did not answer is taken to be the most common part.

    The IMUs of a robot are bought together.
    """
    part_counts = Counter(answer for answer in who_am_i if answer in IMU_PARTS)
    likely = part_counts.most_common(1)[0][0] if part_counts else MPU_6050
    return tuple(IMU_PARTS.get(answer, IMU_PARTS[likely]) for answer in who_am_i)


def temperature_scales(header: LogHeader) -> list[tuple[float, float]]:
    """Return each IMU's temperature scale: counts per °C, and °C at a count of 0.

    The scale is that of the IMU's part; for an MPU-6050 it is in the header.
    """
    own = (header.temperature_lsb_per_c, header.temperature_offset_c)
    return [
        own if part.who_am_i == MPU_6050 else (part.temperature_lsb_per_c, part.temperature_offset_c)
        for part in parts_of(header.who_am_i)
    ]


def _absurdity(header: LogHeader) -> str:
    """Say what is impossible about a header; empty if nothing is."""
    # Believe a header only if it is possible: a wrong scale would falsify all values without a sign.
    checks = (
        ("sampling rate", header.rate_hz, "Hz", _RATE_HZ),
        ("temperature scale", header.temperature_lsb_per_c, "LSB/°C", _TEMPERATURE_LSB_PER_C),
        ("temperature offset", header.temperature_offset_c, "°C", _TEMPERATURE_OFFSET_C),
        ("angle sensor scale", header.angle_counts_per_turn, "counts a turn", _COUNTS_PER_TURN),
    )
    for name, value, unit, (least, most) in checks:
        if not (math.isfinite(value) and least <= value <= most):
            return f"{name} {value:g} {unit} (possible: {least:g} to {most:g})"
    # Registers and bus take a few values only.
    settings = (
        ("low-pass setting", header.dlpf_cfg, range(len(IMU_PARTS[MPU_6050].gyro_delay_us))),
        ("gyro range in deg/s", header.gyro_range_deg_s, _GYRO_RANGES_DEG_S),
        ("accelerometer range in g", header.accel_range_g, _ACCEL_RANGES_G),
        ("bus clock in kHz", header.bus_khz, _BUS_KHZ),
    )
    for name, value, possible in settings:
        if value not in possible:
            return f"{name} {value} (possible: {', '.join(map(str, possible))})"
    # Each sensor is read within the sampling period that it belongs to.
    latest_us = max(*header.imu_offset_us, *header.angle_offset_us)
    if latest_us * header.rate_hz > _US_PER_S:
        return f"a sensor read {latest_us} us after its sample, at {header.rate_hz:g} samples a second"
    # Scale times range is the full scale of a signed 16-bit count, or the two belong to different settings.
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
