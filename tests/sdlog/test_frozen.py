"""Readings that an IMU repeated are no values, whether or not the log still says that it froze."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from tests.sdlog.encoder import ALL_VALID, Recorder, event
from tests.sdlog.test_values import write
from tfsat_host.protocol.enums import ErrorCode, EventCode
from tfsat_host.protocol.limits import FROZEN_US, SAMPLES_PER_BLOCK
from tfsat_host.protocol.log_layout import CRC_OFFSET, HEADER_BYTES, SAMPLE_BYTES
from tfsat_host.sdlog import DropLog, load
from tfsat_host.sdlog.frozen import FROZEN_READINGS, invalidate_repeated

BODY = 1
FIRST = 61
INTERVAL_US = 3571
NOTICED = FIRST + FROZEN_US // INTERVAL_US + 1
IMU_OFFSET = 6 + 14 * BODY
SATURATED = struct.pack("<7h", 32767, -32768, 32767, 100, 32767, -32768, -32768)


def frozen(begin: int, end: int, *, notices: bool = True, reading: bytes | None = None) -> Recorder:
    """IMU 2 gives one reading from sample `begin` until before `end`; where it notices, none after that."""
    recorder = Recorder(interval_us=INTERVAL_US)
    while recorder.samples < 240:
        first = recorder.samples
        events = []
        if notices and first <= end < first + SAMPLES_PER_BLOCK:
            still_us = recorder.time_us(end) - recorder.time_us(begin)
            fault = (EventCode.SENSOR_FAULT, BODY, ErrorCode.SENSOR_FROZEN, still_us)
            events = [event(recorder.time_us(end), *fault)]
        recorder.data(events=events)
        block = bytearray(recorder.blocks[-1])
        for slot in range(SAMPLES_PER_BLOCK):
            at = HEADER_BYTES + slot * SAMPLE_BYTES
            imu = slice(at + IMU_OFFSET, at + IMU_OFFSET + 14)
            if first + slot == begin and reading is None:
                reading = bytes(block[imu])
            if begin <= first + slot < end and reading is not None:
                block[imu] = reading
            elif notices and first + slot >= end:
                block[imu] = bytes(14)
                struct.pack_into("<H", block, at + 4, ALL_VALID & ~(1 << BODY))
        block[CRC_OFFSET:] = struct.pack("<I", zlib.crc32(block[:CRC_OFFSET]))
        recorder.blocks[-1] = bytes(block)
    return recorder


def loaded(tmp_path: Path, blocks: list[bytes]) -> DropLog:
    log = load(write(tmp_path / "SD.bin", b"".join(blocks)))
    assert log.imu_valid[:, [0, 2, 3]].all()
    return log


def invalid(log: DropLog) -> list[int]:
    return [int(number) for number in log.sample_index[~log.imu_valid[:, BODY]]]


def test_without_the_block_of_the_event_the_same_readings_are_invalid(tmp_path: Path) -> None:
    recorder = frozen(FIRST, NOTICED)
    recorder.close()
    whole = loaded(tmp_path, recorder.blocks)
    assert invalid(whole) == list(range(FIRST, 240))
    assert whole.verdict == "complete"
    lost = 1 + NOTICED // SAMPLES_PER_BLOCK
    rest = loaded(tmp_path, recorder.blocks[:lost] + recorder.blocks[lost + 1 :])
    assert invalid(rest) == [row for row in range(FIRST, 240) if row // SAMPLES_PER_BLOCK != lost - 1]
    assert np.isnan(rest.rate_rad_s[FIRST : FIRST + 10, BODY]).all()


@pytest.mark.parametrize("block", range(1 + FIRST // SAMPLES_PER_BLOCK, 2 + NOTICED // SAMPLES_PER_BLOCK))
def test_where_the_power_is_cut_before_it_is_noticed(tmp_path: Path, block: int) -> None:
    log = loaded(tmp_path, frozen(FIRST, NOTICED).blocks[: block + 1])
    seen = range(FIRST, len(log))
    assert invalid(log) == (list(seen) if len(seen) >= FROZEN_READINGS else [])


def test_one_invalid_reading_after_it_is_enough(tmp_path: Path) -> None:
    """The event is lost, and the sensor was reset before the next block."""
    recorder = frozen(FIRST, FIRST + FROZEN_READINGS)
    lost = 1 + (FIRST + FROZEN_READINGS) // SAMPLES_PER_BLOCK
    log = loaded(tmp_path, recorder.blocks[:lost] + recorder.blocks[lost + 1 :])
    assert invalid(log)[:FROZEN_READINGS] == list(range(FIRST, FIRST + FROZEN_READINGS))


@pytest.mark.parametrize(
    ("readings", "is_frozen"), [(FROZEN_US // INTERVAL_US + 1, False), (FROZEN_US // INTERVAL_US + 2, True)]
)
@pytest.mark.parametrize("begin", [60, 61])
def test_a_standstill_that_ends_counts_from_the_loggers_limit_on(
    tmp_path: Path, begin: int, readings: int, is_frozen: bool
) -> None:
    log = loaded(tmp_path, frozen(begin, begin + readings, notices=False).blocks)
    assert invalid(log) == (list(range(begin, begin + readings)) if is_frozen else [])


def test_a_sensor_whose_axes_are_all_at_their_ends_is_not_frozen(tmp_path: Path) -> None:
    log = loaded(tmp_path, frozen(60, 120, notices=False, reading=SATURATED).blocks)
    assert invalid(log) == []
    one_axis_free = SATURATED[:12] + struct.pack("<h", 5)
    log = loaded(tmp_path, frozen(60, 120, notices=False, reading=one_axis_free).blocks)
    assert invalid(log) == list(range(60, 120))


@pytest.mark.parametrize("seed", range(5))
def test_runs_are_found_wherever_they_stand(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Against the rule, reading by reading, some rows at a time."""
    monkeypatch.setattr("tfsat_host.sdlog.frozen._ROWS_AT_A_TIME", 16)
    random = np.random.default_rng(seed)
    n = 600 + seed
    imu = random.integers(-9, 9, (n, 4, 7)).astype(np.int16)
    for body in range(4):
        for begin in random.integers(1, n, 25):
            imu[begin : begin + random.integers(1, 40), body] = imu[begin, body]
    valid = random.random((n, 4)) > 0.01
    index = np.cumsum(1 + (random.random(n) < 0.02))
    t_us = index * 5000
    expected = valid.copy()
    for body in range(4):
        row = 0
        while row < n:
            end = row + 1
            while end < n and valid[row, body] and valid[end, body]:
                if (imu[end, body] != imu[row, body]).any():
                    break
                end += 1
            goes_on = end == n or not valid[end, body] or index[end] != index[end - 1] + 1
            if end - row >= FROZEN_READINGS and (goes_on or t_us[end - 1] - t_us[row] >= FROZEN_US):
                expected[row:end, body] = False
            row = end
    assert (expected != valid).sum() > 200
    invalidate_repeated(imu, index, t_us, valid)
    np.testing.assert_array_equal(valid, expected)
