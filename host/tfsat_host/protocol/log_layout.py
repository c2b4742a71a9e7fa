"""Where things stand in a block of the log and in a sample's flags; the records as numpy types, without numpy."""

from __future__ import annotations

from typing import Any

from .limits import (
    ANGLE_SENSOR_COUNT,
    BLOCK_BYTES,
    EVENTS_PER_BLOCK,
    IMU_COUNT,
    SAMPLES_PER_BLOCK,
    SWITCH_COUNT,
)
from .messages import BlockHeader, Event, LogHeader, Sample

HEADER_BYTES = BlockHeader.SIZE
EVENTS_OFFSET = HEADER_BYTES + SAMPLES_PER_BLOCK * Sample.SIZE
CRC_OFFSET = BLOCK_BYTES - 4
_RESERVED = CRC_OFFSET - EVENTS_OFFSET - EVENTS_PER_BLOCK * Event.SIZE

IMU_VALID_BIT = 0
"""Of a sample's flags; the first of IMU_COUNT bits, as the next are the first of their sensors'."""
ANGLE_VALID_BIT = IMU_VALID_BIT + IMU_COUNT
SWITCH_OPEN_BIT = ANGLE_VALID_BIT + ANGLE_SENSOR_COUNT
CLIPPED_BIT = SWITCH_OPEN_BIT + SWITCH_COUNT

BLOCK_HEADER_DTYPE = BlockHeader.dtype()
LOG_HEADER_DTYPE = LogHeader.dtype()
SAMPLE_DTYPE = Sample.dtype()
EVENT_DTYPE = Event.dtype()
DATA_BLOCK_DTYPE: list[tuple[Any, ...]] = [
    *BLOCK_HEADER_DTYPE,
    ("samples", SAMPLE_DTYPE, (SAMPLES_PER_BLOCK,)),
    ("events", EVENT_DTYPE, (EVENTS_PER_BLOCK,)),
    *([("reserved", f"V{_RESERVED}")] if _RESERVED else []),
    ("crc", "<u4"),
]
