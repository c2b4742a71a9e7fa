"""Which part an IMU is, where the header does not say it or something else came in its place."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.sdlog.encoder import HEADER, Recorder, event
from tests.sdlog.test_values import write
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.protocol.enums import ErrorCode, EventCode
from tfsat_host.sdlog import DropLog, load
from tfsat_host.sdlog.header import parts_of, temperature_scales

FAULT, RECOVERED = EventCode.SENSOR_FAULT, EventCode.SENSOR_RECOVERED
SCALES = {0x68: (340.0, 36.53125), 0x70: (333.87, 21.0), 0x98: (326.8, 25.0)}


def record_events(
    tmp_path: Path, who_am_i: list[int], *happened: tuple[int, EventCode, int, int, int]
) -> DropLog:
    """60 samples with events (sample, code, IMU, arg, value)."""
    recorder = Recorder(header=replace(HEADER, who_am_i=bytes(who_am_i)))
    while recorder.samples < 60:
        # Events of the next six samples go into their block.
        due = [entry for entry in happened if recorder.samples <= entry[0] < recorder.samples + 6]
        recorder.data(events=[event(recorder.time_us(entry[0]), *entry[1:]) for entry in due])
    recorder.close()
    return load(write(tmp_path / "SD.bin", recorder.image()))


@pytest.mark.parametrize(
    ("who_am_i", "taken_for"),
    [
        ([0x68, 0x70, 0x71, 0x98], [0x68, 0x70, 0x71, 0x98]),
        ([0, 0x70, 0x70, 0x68], [0x70, 0x70, 0x70, 0x68]),
        ([0x98, 0x98, 0, 0x12], [0x98] * 4),
        ([0, 0, 0, 0], [0x68] * 4),
    ],
)
def test_one_that_does_not_say_it_is_what_most_others_are(who_am_i: list[int], taken_for: list[int]) -> None:
    assert [part.who_am_i for part in parts_of(who_am_i)] == taken_for
    assert [part.who_am_i for part in LowPass(3, tuple(who_am_i)).parts] == taken_for
    header = replace(HEADER, who_am_i=bytes(who_am_i))
    by_part = temperature_scales(replace(HEADER, who_am_i=bytes(taken_for)))
    assert temperature_scales(header) == by_part
    for scale, part in zip(by_part, taken_for, strict=True):
        # Part 0x71 has the scale of 0x70.
        assert scale == SCALES.get(part, SCALES[0x70])


def test_a_header_is_completed_by_what_an_imu_says_later(tmp_path: Path) -> None:
    log = record_events(
        tmp_path,
        [0x68, 0, 0, 0],
        (10, RECOVERED, 1, 0, 0x70),
        (20, RECOVERED, 2, 0, 0),  # of an earlier firmware
    )
    assert log.header.who_am_i == bytes([0x68, 0x70, 0, 0])
    assert log.imu_valid.all() and log.doubts == ()
    assert log.verdict == "complete"


@pytest.mark.parametrize("value", [-1, 256, 0x7FFFFFFF])
def test_what_no_register_can_hold_changes_nothing(tmp_path: Path, value: int) -> None:
    log = record_events(
        tmp_path, [0x68, 0, 0x68, 0x68], (10, RECOVERED, 1, 0, value), (10, RECOVERED, 9, 0, 0x70)
    )
    assert log.header.who_am_i == bytes([0x68, 0, 0x68, 0x68])
    assert log.imu_valid.all() and log.doubts == ()


@pytest.mark.parametrize("first", [0x68, 0])
def test_another_part_in_its_place_is_not_believed(tmp_path: Path, first: int) -> None:
    before = [(3, RECOVERED, 1, 0, 0x68)] if first == 0 else []
    log = record_events(
        tmp_path,
        [0x68, first, 0x68, 0x68],
        *before,
        (20, FAULT, 1, ErrorCode.SENSOR_RESET, 0),
        (21, FAULT, 1, ErrorCode.SENSOR_MISSING, 0),
        (30, RECOVERED, 1, 0, 0x70),
    )
    # From the fault on, nothing of that IMU is believed.
    assert np.flatnonzero(~log.imu_valid[:, 1]).tolist() == list(range(20, 60))
    assert log.imu_valid[:, [0, 2, 3]].all()
    (doubt,) = log.doubts
    assert doubt.startswith("IMU 2 came back as another part at 5.107130 s")
    assert "MPU-6500 (WHO_AM_I 0x70)" in doubt and "MPU-6050 (WHO_AM_I 0x68)" in doubt
    assert "taken for invalid" in doubt and "record again" in doubt
    assert log.verdict == "damaged"


def test_the_headers_part_is_believed_when_it_is_back(tmp_path: Path) -> None:
    log = record_events(
        tmp_path,
        [0x68] * 4,
        (30, RECOVERED, 1, 0, 0x70),  # its fault stood in a lost block
        (36, FAULT, 1, ErrorCode.SENSOR_MISSING, 0),
        (40, RECOVERED, 1, 0, 0x68),
    )
    assert np.flatnonzero(~log.imu_valid[:, 1]).tolist() == list(range(30, 40))
    assert len(log.doubts) == 1


def test_the_same_part_that_comes_back_is_believed(tmp_path: Path) -> None:
    log = record_events(
        tmp_path, [0x68] * 4, (20, FAULT, 3, ErrorCode.SENSOR_MISSING, 0), (30, RECOVERED, 3, 0, 0x68)
    )
    assert log.imu_valid.all() and log.doubts == ()
