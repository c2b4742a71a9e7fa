"""A log encoded as docs/log-format.md says is complete, and read as it was meant; the page's own reader too."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.cli.process import RunCli
from tests.paths import DOCS
from tests.sdlog import page_encoder
from tests.sdlog.encoder import recording as encoded
from tests.sdlog.page_encoder import LANDING, RELEASE, REWRITTEN, STROKE, SWITCH_EDGE, Event, Sample, encode
from tfsat_host.sdlog import load

START_US, COUNT = 3_000_000, 1999
OPENED_US = (START_US + 2_000_000, START_US + 2_000_700)
# The paper's maneuver, from the release on.
STROKES_US = tuple(OPENED_US[1] + 1000 * ms for ms in (700, 1050, 1470, 1820))
LANDED_US = OPENED_US[1] + 2_500_000
REWRITTEN_US = OPENED_US[1] + 4_100_000
SILENT, CLIPPED = 700, 900
"""In the first sample IMU 2 and angle sensor 4 gave nothing, in the second IMU 4 was at the end of its range."""
AGAIN = range(50, 290)
"""Blocks of which the file holds a second copy; a header is among them."""


def sample(k: int) -> Sample:
    t_us = START_US + round(k * 1e6 / 280)
    # Bit 10 is switch 1, bit 11 switch 2.
    flags = 0x3FF | (t_us >= OPENED_US[0]) << 10 | (t_us >= OPENED_US[1]) << 11
    imu = [[(37 * k * (body + 1) + 5 * axis) % 65536 - 32768 for axis in range(7)] for body in range(4)]
    # Values over the whole range, no two columns alike.
    angle = [(7 * k + 500 * sensor) % 4096 for sensor in range(6)]
    if k == SILENT:
        # Bit 1 is IMU 2, bit 7 angle sensor 4: both gave nothing.
        flags &= ~(1 << 1 | 1 << 7)
        imu[1], angle[3] = [0] * 7, 0
    if k == CLIPPED:
        flags |= 1 << 15
        # The largest value that a 16-bit register can hold.
        imu[3][4] = 32767
    return Sample(t_us, flags, imu, angle)


SAMPLES = [sample(k) for k in range(COUNT)]
EVENTS = [
    Event(OPENED_US[0], SWITCH_EDGE, 0, 1),
    Event(OPENED_US[1], SWITCH_EDGE, 1, 1),
    Event(OPENED_US[1], RELEASE, 0, 1),
    *(Event(t_us, STROKE, index) for index, t_us in enumerate(STROKES_US)),
    Event(LANDED_US, LANDING, 0, 1, 25_000),
    Event(REWRITTEN_US, REWRITTEN, 0, 0, len(AGAIN)),
]


@pytest.fixture(scope="module")
def recording_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "SD.bin"
    path.write_bytes(encode(SAMPLES, EVENTS, AGAIN))
    return path


def test_it_is_accepted_as_complete(recording_path: Path, tfsat_host: RunCli) -> None:
    report = tfsat_host.json("decode", str(recording_path), expect=3)  # two readings missed, one clipped
    assert (report["verdict"], report["doubts"], len(report["warnings"])) == ("complete", [], 3)
    assert (report["samples"], report["samples_lost"], report["blocks_lost"]) == (COUNT, 0, 0)
    aside = {name: count for name, count in report["set_aside"].items() if count}
    assert aside == {"duplicate": len(AGAIN)}


def test_one_without_faults_is_accepted_without_a_word(tmp_path: Path, tfsat_host: RunCli) -> None:
    # Up to the sample before the first fault.
    (tmp_path / "SD.bin").write_bytes(encode(SAMPLES[:SILENT], EVENTS[:3]))
    report = tfsat_host.json("decode", "SD.bin")
    assert (report["verdict"], report["doubts"], report["warnings"]) == ("complete", [], [])
    assert (report["samples"], report["release_us"]) == (SILENT, OPENED_US[1])


def test_every_value_is_as_it_was_meant(recording_path: Path) -> None:
    log = load(recording_path)
    assert (log.verdict, log.doubts, log.gaps, log.session) == ("complete", (), (), page_encoder.SESSION)
    assert log.t_us.tolist() == [sample.time_us for sample in SAMPLES]
    assert log.imu_counts.tolist() == [sample.imu for sample in SAMPLES]
    assert log.angle_counts.tolist() == [sample.angle for sample in SAMPLES]
    assert log.release_us == OPENED_US[1]
    # Both edges are known to the microsecond, so that nothing is left open.
    assert log.release is not None and log.release.uncertainty_us == 0
    open_from = [[sample.time_us >= opened_us for opened_us in OPENED_US] for sample in SAMPLES]
    assert log.switch_open.tolist() == open_from
    assert np.argwhere(log.clipped).tolist() == [[CLIPPED, 3]]


def test_every_event_is_as_it_was_meant(recording_path: Path) -> None:
    assert [(e.name, e.t_us, e.index, e.arg, e.value) for e in load(recording_path).events] == [
        ("switch_edge", OPENED_US[0], 0, 1, 0),
        ("switch_edge", OPENED_US[1], 1, 1, 0),
        ("release", OPENED_US[1], 0, 1, 0),
        *(("stroke", t_us, index, 0, 0) for index, t_us in enumerate(STROKES_US)),
        ("landing", LANDED_US, 0, 1, 25_000),
        ("rewritten", REWRITTEN_US, 0, 0, len(AGAIN)),
    ]


def test_every_unit_is_as_it_was_meant(recording_path: Path) -> None:
    log = load(recording_path)
    imu = np.array([sample.imu for sample in SAMPLES])
    valid = np.ones((COUNT, 4), bool)
    valid[SILENT, 1] = False
    assert np.array_equal(log.imu_valid, valid)
    # By the scales of the page, in its own units.
    rate, force = np.deg2rad(imu[..., 4:] / 65.5), imu[..., :3] / 2048 * 9.80665
    temperature = imu[..., 3] / 340 + np.float64(np.float32(36.53))
    np.testing.assert_allclose(log.rate_rad_s[valid], rate[valid], rtol=1e-12)
    np.testing.assert_allclose(log.specific_force_m_s2[valid], force[valid], rtol=1e-12)
    np.testing.assert_allclose(log.temperature_c[valid], temperature[valid], rtol=1e-9, atol=1e-9)
    assert np.isnan(log.rate_rad_s[SILENT, 1]).all() and np.isnan(log.sensor_angle_rad[SILENT, 3])
    assert np.argwhere(~log.angle_valid).tolist() == [[SILENT, 3]]
    # The middle of a count: 0.5 is added before the turn.
    angle = (np.array([sample.angle for sample in SAMPLES]) + 0.5) * 2 * np.pi / 4096
    np.testing.assert_allclose(log.sensor_angle_rad[log.angle_valid], angle[log.angle_valid], rtol=1e-12)


def test_header_and_footer_are_as_they_were_meant(recording_path: Path) -> None:
    log = load(recording_path)
    assert log.header.imu_offset_us == (0, 390, 0, 390)
    assert log.header.angle_offset_us == (0, 5, 10, 15, 20, 25)
    assert (log.header.rate_hz, log.unix_offset_us) == (280.0, page_encoder.UNIX_AT_ZERO_US)
    assert log.footer is not None
    assert log.footer.blocks == recording_path.stat().st_size // 512 - len(AGAIN)
    assert (log.footer.samples, log.footer.blocks_rewritten) == (COUNT, len(AGAIN))


def test_an_end_takes_the_number_of_a_header(tmp_path: Path) -> None:
    """Number the footer 8 after block 0 and seven data blocks."""
    path = tmp_path / "SD.bin"
    path.write_bytes(encode(SAMPLES[: 7 * 6], []))
    log = load(path)
    assert path.stat().st_size == 9 * 512
    assert (log.verdict, log.doubts, len(log.t_us)) == ("complete", (), 7 * 6)


PAGE = DOCS / "log-format.md"


def test_it_prints_every_sample(tmp_path: Path) -> None:
    # The page's own reader, run as it is printed there.
    (code,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    path = tmp_path / "SD.bin"
    path.write_bytes(encoded().image())
    process = subprocess.run([sys.executable, "-c", code, path], capture_output=True, text=True, check=True)
    log = load(path)
    # Every line is a sample, in the order of the columns.
    lines = [list(map(int, line.split())) for line in process.stdout.splitlines()]
    assert [line[0] for line in lines] == log.t_us.tolist()
    assert [line[2:30] for line in lines] == log.imu_counts.reshape(len(log), 28).tolist()
    assert [line[30:] for line in lines] == log.angle_counts.tolist()
