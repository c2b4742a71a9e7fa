"""Ticks without a sample, and sensors that stood still: found, said, and taken back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.sdlog.encoder import Recorder, event, long_recording
from tests.sdlog.test_decode_command import decode, decode_json
from tests.sdlog.test_values import write
from tfsat_host.protocol.enums import ErrorCode, EventCode
from tfsat_host.sdlog import load


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
