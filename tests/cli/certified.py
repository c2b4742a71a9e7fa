"""A recorded drop and a certificate next to it, for what `decode` and `arm` say of calibration."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from typing import Any

from tests.calibration import some_calibration
from tests.sdlog.encoder import HEADER, drop_with_release
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.certificate.file import format_calibration

HOUR = timedelta(hours=1)
MEASURED = datetime(2024, 7, 1, 9, 30, tzinfo=UTC)
"""Long past, as a certificate of the future is another thing."""
DROPPED = MEASURED + HOUR
whole_calibration = partial(some_calibration.whole_calibration, measured_at=MEASURED)


def certificate(folder: Path, calibration: Calibration, name: str = "calibration.toml") -> Path:
    file = folder / name
    file.write_text(format_calibration(calibration), encoding="utf-8")
    return file


def write_drop(folder: Path, at: datetime | None = DROPPED, image_crc: int = 0xC0FFEE) -> Path:
    """Write a drop whose recording began at that time of day, or whose start time is unknown."""
    wall_clock_us = 0 if at is None else round(at.timestamp() * 1e6)
    header = replace(HEADER, wall_clock_us=wall_clock_us, image_crc=image_crc)
    recorder, _ = drop_with_release(header=header)
    file = folder / "SD.bin"
    file.write_bytes(recorder.image())
    return file


def join_sentences(result: dict[str, Any]) -> str:
    return "\n".join(result["calibration"]["sentences"])
