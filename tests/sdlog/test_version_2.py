"""A drop that firmware 0.1.0 recorded, in blocks of version 2, is read as it was by the decoder of its time."""

from __future__ import annotations

import gzip
import hashlib
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import tfsat_host
from tfsat_host.sdlog import DropLog
from tfsat_host.sdlog.blocks import look

RECORDED = Path(__file__).parent / "data" / "version_2.bin.gz"
"""`tfsat-host rehearse 59 70` of that release."""
READ_THEN = {
    "sample_index": "82e1f57d119d4835",
    "t_us": "55b167383eeb49ad",
    "imu_counts": "2cccd3db0aca1a55",
    "angle_counts": "40d97a52aba711e7",
    "imu_valid": "a86b8f4c47526abb",
    "angle_valid": "bf1f731b068c62a8",
    "switch_open": "70ce16aa5f9785ba",
    "clipped": "5ba438cbe4226a32",
    "t_s": "3a0c8dd56e64ee58",
    "rate_rad_s": "eb174281fce63d14",
    "specific_force_m_s2": "fce5aeccba9c0958",
    "temperature_c": "51b9f27219f17596",
}
"""The first 16 digits of the SHA-256 of each column."""
ANGLES_THEN = "80683682b1ce601f"
"""Of the angle sensors, which were read half a count lower."""


def _digest(column: NDArray[np.generic]) -> str:
    return hashlib.sha256(np.ascontiguousarray(column).tobytes()).hexdigest()[:16]


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> DropLog:
    path = tmp_path_factory.mktemp("old") / "SD.bin"
    path.write_bytes(gzip.decompress(RECORDED.read_bytes()))
    assert set(look(memoryview(path.read_bytes())).heads["version"].tolist()) <= {0, 2}
    return tfsat_host.load(path)


def test_an_old_log_is_read_with_equal_numbers(log: DropLog) -> None:
    assert {name: _digest(getattr(log, name)) for name in READ_THEN} == READ_THEN
    half = np.pi / log.header.angle_counts_per_turn
    assert _digest(log.angle_counts * (2 * half)) == ANGLES_THEN
    np.testing.assert_allclose(log.sensor_angle_rad - half, log.angle_counts * (2 * half), atol=1e-15)


def test_an_old_log_is_whole_and_says_nothing_of_offsets(log: DropLog) -> None:
    assert (log.verdict, len(log), log.samples_lost, log.release_us) == ("complete", 2494, 0, 32_092_497)
    assert (log.doubts, log.gaps, len(log.events)) == ((), (), 14)
    assert log.footer is not None
    assert (log.footer.blocks, log.header.who_am_i, log.header.bus_khz) == (422, b"\x68" * 4, 400)
    assert {*log.header.imu_offset_us, *log.header.angle_offset_us} == {0}
