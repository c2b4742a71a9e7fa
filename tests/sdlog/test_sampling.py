"""Ticks without a sample, and sensors that stood still or missed readings: found, reported, and invalidated."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from tests.sdlog.encoder import ALL_VALID, Recorder, event, long_recording
from tests.sdlog.test_decode_command import decode, decode_json
from tests.sdlog.test_values import write
from tfsat_host.protocol.enums import ErrorCode, EventCode
from tfsat_host.protocol.limits import FROZEN_US, SAMPLES_PER_BLOCK
from tfsat_host.protocol.log_layout import CRC_OFFSET, HEADER_BYTES
from tfsat_host.protocol.messages import Sample
from tfsat_host.sdlog import DropLog, load
from tfsat_host.sdlog.imu_validity import FROZEN_READINGS, invalidate_repeated
from tfsat_host.sdlog.log_summary import grave_warnings, single_misses, warnings


def with_pause(pause_us: int) -> Recorder:
    """Four full blocks; the third begins late."""
    recorder = Recorder()
    recorder.data()
    recorder.data()
    recorder.start_us += pause_us
    recorder.data()
    recorder.data()
    recorder.close()
    return recorder


@pytest.mark.parametrize(("pause_us", "ticks"), [(3571, 1), (2000, 1), (3571 * 9, 9)])
def test_ticks_without_a_sample_are_a_warning_and_no_loss(tmp_path: Path, pause_us: int, ticks: int) -> None:
    path = write(tmp_path / "SD.bin", with_pause(pause_us).image())
    log = load(path)
    assert (log.verdict, log.samples_lost, log.gaps) == ("complete", 0, ())
    assert log.late_rows.tolist() == [12]
    facts = decode_json(path, expect=3)
    late = facts["late_samples"]
    assert (late["count"], late["ticks_missed"], late["longest_us"]) == (1, ticks, 3571 + pause_us)
    assert f"none in {ticks} ticks" in decode(path, expect=3).stderr


def test_jitter_is_no_missed_tick(tmp_path: Path) -> None:
    log = load(write(tmp_path / "SD.bin", with_pause(1700).image()))
    assert log.late_rows.tolist() == []


def test_the_time_across_lost_blocks_is_a_gap_and_no_missed_tick(tmp_path: Path) -> None:
    blocks = with_pause(0).blocks
    log = load(write(tmp_path / "SD.bin", b"".join(blocks[:2] + blocks[3:])))
    assert log.late_rows.tolist() == []
    assert log.verdict == "damaged"


def test_late_samples_are_found_at_any_place_of_a_long_log(tmp_path: Path) -> None:
    image = long_recording(12_000, late_us={5461: 4000, 10_922: 4000})
    log = load(write(tmp_path / "SD.bin", image))
    assert log.late_rows.tolist() == [5460 * 6, 10_921 * 6]


@pytest.mark.parametrize(
    "cause",
    [ErrorCode.SENSOR_MISSING, ErrorCode.BUS_STUCK, ErrorCode.SENSOR_FROZEN, ErrorCode.SENSOR_RESET],
)
def test_what_was_read_before_a_fault_was_noticed_is_invalid(tmp_path: Path, cause: ErrorCode) -> None:
    recorder = Recorder()
    for _ in range(5):
        recorder.data()
    noticed_us = recorder.time_us(recorder.samples)
    still_us = noticed_us - recorder.time_us(20)
    recorder.data(
        events=[
            event(noticed_us, EventCode.SENSOR_FAULT, 2, cause, still_us),
            event(noticed_us, EventCode.SENSOR_FAULT, 1, ErrorCode.SENSOR_FOREIGN, still_us),
        ]
    )
    recorder.close()
    log = load(write(tmp_path / "SD.bin", recorder.image()))
    assert np.flatnonzero(~log.imu_valid[:, 2]).tolist() == list(range(20, 30))
    assert log.imu_valid[:, [0, 1, 3]].all()
    assert np.isnan(log.rate_rad_s[20:30, 2]).all()
    assert log.verdict == "complete"


@pytest.mark.parametrize(("index", "value"), [(4, 10_000), (255, 10_000), (0, -5), (0, 0)])
def test_a_frozen_sensor_that_makes_no_sense_changes_nothing(tmp_path: Path, index: int, value: int) -> None:
    recorder = Recorder()
    recorder.data()
    at_us = recorder.time_us(recorder.samples)
    recorder.data(events=[event(at_us, EventCode.SENSOR_FAULT, index, ErrorCode.SENSOR_FROZEN, value)])
    log = load(write(tmp_path / "SD.bin", recorder.image()))
    assert log.imu_valid.all()


def test_the_last_seconds_written_twice_change_nothing(tmp_path: Path) -> None:
    recorder = Recorder()
    for _ in range(900):
        recorder.data()
    recorder.close()
    again = recorder.blocks[500:800]
    path = write(tmp_path / "SD.bin", b"".join([*recorder.blocks, *again, bytes(512)]))
    log = load(path)
    assert (log.verdict, len(log), log.set_aside.duplicate) == ("complete", 5400, 300)
    facts = decode_json(path)
    assert facts["warnings"] == []
    torn = [bytes(512) if 520 <= number < 530 else block for number, block in enumerate(recorder.blocks)]
    mended = load(write(path, b"".join([*torn, *again])))
    assert (mended.verdict, len(mended), mended.set_aside.duplicate) == ("complete", 5400, 290)
    assert np.array_equal(mended.imu_counts, log.imu_counts)
    assert np.array_equal(mended.t_us, log.t_us)


WITHOUT_IMU_2 = ALL_VALID & ~0x2


def test_single_misses_are_few_and_alone() -> None:
    valid = np.ones(1000, bool)
    assert single_misses(valid)
    valid[[3, 5, 900]] = False
    assert single_misses(valid)
    valid[4] = False
    assert not single_misses(valid)
    often = np.ones(1000, bool)
    often[:22:2] = False
    assert not single_misses(often)


@pytest.mark.parametrize(("samples", "grave"), [(1, 0), (2, 1)])
def test_one_is_told_and_not_grave(tmp_path: Path, samples: int, grave: int) -> None:
    recorder = Recorder()
    for block in range(60):
        if block == 30:
            recorder.data(samples, flags=WITHOUT_IMU_2)
        recorder.data()
    recorder.close()
    path = tmp_path / "SD.bin"
    path.write_bytes(recorder.image())
    log = load(path)
    assert [line for line in warnings(log) if "IMU of body 2" in line]
    assert len(grave_warnings(log)) == grave


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
            at = HEADER_BYTES + slot * Sample.SIZE
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


def load_blocks(tmp_path: Path, blocks: list[bytes]) -> DropLog:
    log = load(write(tmp_path / "SD.bin", b"".join(blocks)))
    assert log.imu_valid[:, [0, 2, 3]].all()
    return log


def invalid(log: DropLog) -> list[int]:
    return [int(number) for number in log.sample_index[~log.imu_valid[:, BODY]]]


def test_without_the_block_of_the_event_the_same_readings_are_invalid(tmp_path: Path) -> None:
    recorder = frozen(FIRST, NOTICED)
    recorder.close()
    complete_log = load_blocks(tmp_path, recorder.blocks)
    assert invalid(complete_log) == list(range(FIRST, 240))
    assert complete_log.verdict == "complete"
    lost = 1 + NOTICED // SAMPLES_PER_BLOCK
    rest = load_blocks(tmp_path, recorder.blocks[:lost] + recorder.blocks[lost + 1 :])
    assert invalid(rest) == [row for row in range(FIRST, 240) if row // SAMPLES_PER_BLOCK != lost - 1]
    assert np.isnan(rest.rate_rad_s[FIRST : FIRST + 10, BODY]).all()


@pytest.mark.parametrize("block", range(1 + FIRST // SAMPLES_PER_BLOCK, 2 + NOTICED // SAMPLES_PER_BLOCK))
def test_where_the_power_is_cut_before_it_is_noticed(tmp_path: Path, block: int) -> None:
    log = load_blocks(tmp_path, frozen(FIRST, NOTICED).blocks[: block + 1])
    frozen_samples = range(FIRST, len(log))
    assert invalid(log) == (list(frozen_samples) if len(frozen_samples) >= FROZEN_READINGS else [])


def test_one_invalid_reading_after_it_is_enough(tmp_path: Path) -> None:
    """Mark frozen readings invalid by a single invalid reading that follows them.

    The fault event is lost, and the sensor was reset before the next block.
    """
    recorder = frozen(FIRST, FIRST + FROZEN_READINGS)
    lost = 1 + (FIRST + FROZEN_READINGS) // SAMPLES_PER_BLOCK
    log = load_blocks(tmp_path, recorder.blocks[:lost] + recorder.blocks[lost + 1 :])
    assert invalid(log)[:FROZEN_READINGS] == list(range(FIRST, FIRST + FROZEN_READINGS))


@pytest.mark.parametrize(
    ("readings", "is_frozen"), [(FROZEN_US // INTERVAL_US + 1, False), (FROZEN_US // INTERVAL_US + 2, True)]
)
@pytest.mark.parametrize("begin", [60, 61])
def test_a_standstill_that_ends_counts_from_the_loggers_limit_on(
    tmp_path: Path, begin: int, readings: int, is_frozen: bool
) -> None:
    log = load_blocks(tmp_path, frozen(begin, begin + readings, notices=False).blocks)
    assert invalid(log) == (list(range(begin, begin + readings)) if is_frozen else [])


def test_a_sensor_whose_axes_are_all_at_their_ends_is_not_frozen(tmp_path: Path) -> None:
    log = load_blocks(tmp_path, frozen(60, 120, notices=False, reading=SATURATED).blocks)
    assert invalid(log) == []
    one_axis_free = SATURATED[:12] + struct.pack("<h", 5)
    log = load_blocks(tmp_path, frozen(60, 120, notices=False, reading=one_axis_free).blocks)
    assert invalid(log) == list(range(60, 120))


@pytest.mark.parametrize("seed", range(5))
def test_runs_are_found_wherever_they_stand(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Against the rule, reading by reading, some rows at a time."""
    monkeypatch.setattr("tfsat_host.sdlog.imu_validity._ROWS_AT_A_TIME", 16)
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
