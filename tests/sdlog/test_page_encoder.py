"""What a stranger writes from docs/log-format.md alone is accepted at once, and read as it was meant."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.cli.process import RunCli
from tests.sdlog.page_encoder import MOST_SAMPLES, Encoder, Happening, Reading
from tfsat_host.sdlog import load

START_US, STEP_US, COUNT = 3_000_000, 3571, 1999
OPENED_US = (START_US + 2_000_000, START_US + 2_000_700)
SILENT = 700
"""In this sample IMU 2 and angle sensor 4 gave nothing."""


def reading(k: int) -> Reading:
    t_us = START_US + k * STEP_US
    flags = 0x3FF | (t_us >= OPENED_US[0]) << 10 | (t_us >= OPENED_US[1]) << 11
    if k == SILENT:
        flags &= ~(1 << 1 | 1 << 7)
    imu = [[(37 * k * (body + 1) + 5 * axis) % 65536 - 32768 for axis in range(7)] for body in range(4)]
    return Reading(t_us, imu, [(7 * k + 500 * sensor) % 4096 for sensor in range(6)], flags)


def happenings(from_us: int, to_us: int) -> list[Happening]:
    known = [
        Happening(OPENED_US[0], 1, 0, 1),
        Happening(OPENED_US[1], 1, 1, 1),
        Happening(OPENED_US[1], 7, 0, 1),
        *(Happening(OPENED_US[1] + 1000 * ms, 2, n) for n, ms in enumerate((700, 1050, 1470, 1820))),
    ]
    return [one for one in known if from_us < one.time_us <= to_us]


def encoded() -> bytes:
    encoder = Encoder(0xC0DE0001, 280.0)
    past_us = 0
    for first in range(0, COUNT, MOST_SAMPLES):
        readings = [reading(k) for k in range(first, min(first + MOST_SAMPLES, COUNT))]
        waiting = happenings(past_us, readings[-1].time_us)
        past_us = readings[-1].time_us
        encoder.add(readings, waiting[:2])
        if waiting[2:]:
            encoder.add([], waiting[2:])
    return encoder.close(past_us + 100)


def test_it_is_accepted_as_complete(tmp_path: Path, tfsat_host: RunCli) -> None:
    (tmp_path / "SD.bin").write_bytes(encoded())
    said = tfsat_host.json("decode", "SD.bin", expect=3)  # two sensors missed a reading
    assert (said["verdict"], said["doubts"], len(said["warnings"])) == ("complete", [], 2)
    assert (said["samples"], said["samples_lost"], said["blocks_lost"]) == (COUNT, 0, 0)


def test_every_value_is_as_it_was_meant(tmp_path: Path) -> None:
    path = tmp_path / "SD.bin"
    path.write_bytes(encoded())
    log = load(path)
    meant = [reading(k) for k in range(COUNT)]
    assert (log.verdict, log.doubts, log.gaps, log.session) == ("complete", (), (), 0xC0DE0001)
    assert log.t_us.tolist() == [one.time_us for one in meant]
    assert log.imu_counts.tolist() == [one.imu for one in meant]
    assert log.angle_counts.tolist() == [one.angle for one in meant]
    assert log.release_us == OPENED_US[1]
    assert [(e.name, e.t_us, e.index) for e in log.events] == [
        ("switch_edge", OPENED_US[0], 0),
        ("switch_edge", OPENED_US[1], 1),
        ("release", OPENED_US[1], 0),
        *(("stroke", OPENED_US[1] + 1000 * ms, n) for n, ms in enumerate((700, 1050, 1470, 1820))),
    ]
    gyro = np.array([[imu[4:] for imu in one.imu] for one in meant])
    valid = np.ones((COUNT, 4), bool)
    valid[SILENT, 1] = False
    assert np.array_equal(log.imu_valid, valid)
    np.testing.assert_allclose(log.rate_rad_s[valid], np.deg2rad(gyro[valid] / 65.5), rtol=1e-12)
    assert np.isnan(log.rate_rad_s[SILENT, 1]).all() and np.isnan(log.sensor_angle_rad[SILENT, 3])
    shown = (np.array([one.angle for one in meant]) + 0.5) * 2 * np.pi / 4096
    np.testing.assert_allclose(log.sensor_angle_rad[log.angle_valid], shown[log.angle_valid], rtol=1e-12)
    assert (log.header.imu_offset_us, log.header.rate_hz) == ((0, 390, 0, 390), 280.0)
    assert log.unix_offset_us == 1_700_000_000_000_000
    assert log.footer is not None and log.footer.blocks == len(encoded()) // 512
