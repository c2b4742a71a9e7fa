"""What a clean log decodes to: every number, in SI units, at its time."""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.paths import REPOSITORY
from tests.sdlog.encoder import ALL_VALID, HEADER, Recorder, drop_with_release, recording, renumbered, sample
from tfsat_host.sdlog import DropLog, load

GOLDEN = REPOSITORY / "protocol" / "golden_vectors.json"


def write(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path


@cache
def counts(index: int) -> tuple[int, ...]:
    """Return the raw counts of a sample, IMUs first."""
    expected = sample(index, 0)
    return (
        *(value for imu in expected.imu for value in (*imu.accel, imu.temperature, *imu.gyro)),
        *expected.angle,
    )


def assert_values(log: DropLog) -> None:
    """Assert that every sample in the log has the values that follow from its index."""
    rows = np.hstack((log.imu_counts.reshape(len(log), 28), log.angle_counts), dtype=np.int32)
    assert rows.tolist() == [list(counts(index)) for index in log.sample_index.tolist()]


def by_name(log: DropLog) -> dict[str, NDArray[Any]]:
    """Compute the columns of the tables from the log's SI columns."""
    columns: dict[str, NDArray[Any]] = {"sample": log.sample_index, "t_us": log.t_us, "t_s": log.t_s}
    for body in range(4):
        for axis, letter in enumerate("xyz"):
            columns[f"imu{body + 1}_rate_{letter}_deg_s"] = np.degrees(log.rate_rad_s[:, body, axis])
            columns[f"imu{body + 1}_specific_force_{letter}_m_s2"] = log.specific_force_m_s2[:, body, axis]
        columns[f"imu{body + 1}_temperature_c"] = log.temperature_c[:, body]
        columns[f"imu{body + 1}_clipped"] = log.clipped[:, body]
    for sensor in range(6):
        name = f"joint{sensor // 2 + 1}_sensor{sensor % 2 + 1}_angle_deg"
        columns[name] = np.degrees(log.sensor_angle_rad[:, sensor])
    return columns | {f"switch{switch + 1}_open": log.switch_open[:, switch] for switch in range(2)}


def test_a_clean_log_gives_all_values_in_si(tmp_path: Path) -> None:
    recorder = recording(5)
    log = load(write(tmp_path / "SD.bin", recorder.image()))
    assert (log.verdict, len(log), log.samples_lost, log.blocks_lost) == ("complete", 30, 0, 0)
    assert log.t_us.tolist() == [recorder.time_us(i) for i in range(30)]
    assert_values(log)
    for body in range(4):
        imu = sample(17, 0).imu[body]
        np.testing.assert_allclose(
            log.rate_rad_s[17, body], np.radians(np.array(imu.gyro) / 65.5), rtol=1e-12
        )
        np.testing.assert_allclose(
            log.specific_force_m_s2[17, body], np.array(imu.accel) / 16384 * 9.80665, rtol=1e-12
        )
        assert log.temperature_c[17, body] == pytest.approx(imu.temperature / 340 + 36.53125)
    assert log.sensor_angle_rad[17].tolist() == pytest.approx(
        [math.tau * (counts + 0.5) / 4096 for counts in sample(17, 0).angle]
    )
    assert log.rate_hz == pytest.approx(1e6 / 3571)
    assert log.header == HEADER


def test_golden_block_decodes_as_the_specification_says(tmp_path: Path) -> None:
    golden = next(b for b in json.loads(GOLDEN.read_text())["blocks"] if b["kind"] == "data")
    header = renumbered(Recorder(session=golden["head"]["session"]).blocks[0])
    log = load(write(tmp_path / "SD.bin", header + bytes.fromhex(golden["bytes"])))
    samples = golden["samples"]
    assert log.sample_index.tolist() == list(range(36, 42))
    assert log.t_us.tolist() == [golden["head"]["time_us"] + s["time_offset_us"] for s in samples]
    for row, expected in enumerate(samples):
        assert log.imu_counts[row].tolist() == [
            [*imu["accel"], imu["temperature"], *imu["gyro"]] for imu in expected["imu"]
        ]
        assert log.angle_counts[row].tolist() == expected["angle"]
        flags = [*log.imu_valid[row], *log.angle_valid[row], *log.switch_open[row], *log.clipped[row]]
        assert sum(1 << bit for bit, value in enumerate(flags) if value) == expected["flags"]
    events = sorted(golden["events"], key=lambda event: int(event["time_us"]))
    assert [(e.t_us, e.index, e.arg, e.value) for e in log.events] == [
        (e["time_us"], e["index"], e["arg"], e["value"]) for e in events
    ]
    assert (log.verdict, log.blocks_lost, log.samples_lost) == ("damaged", 6, 36)


def test_invalid_sensors_are_nan_and_nothing_else_is(tmp_path: Path) -> None:
    recorder = Recorder()
    recorder.data(flags=ALL_VALID & ~0b10_0000_0010)
    recorder.close()
    log = load(write(tmp_path / "SD.bin", recorder.image()))
    for column in (log.rate_rad_s, log.specific_force_m_s2, log.temperature_c):
        assert np.isnan(column[:, 1]).all()
        assert not np.isnan(column[:, [0, 2, 3]]).any()
    assert np.isnan(log.sensor_angle_rad[:, 5]).all()
    assert not np.isnan(log.sensor_angle_rad[:, :5]).any()


@pytest.mark.parametrize("start_us", [0, (1 << 32) - 20_000, (1 << 40) + 7])
def test_times_beyond_32_bits_stay_exact(tmp_path: Path, start_us: int) -> None:
    recorder = recording(4, start_us=start_us)
    log = load(write(tmp_path / "SD.bin", recorder.image()))
    assert log.t_us.tolist() == [recorder.time_us(i) for i in range(24)]
    assert log.t_s[-1] == pytest.approx(23 * 3571e-6)
    assert log.verdict == "complete"


def test_time_counts_from_the_release(tmp_path: Path) -> None:
    recorder, release_us = drop_with_release()
    log = load(write(tmp_path / "SD.bin", recorder.image()))
    assert log.release_us == release_us
    strokes = [log.seconds(event.t_us) for event in log.events if event.name == "stroke"]
    assert strokes == [0.70, 1.05, 1.47, 1.82]
    assert log.t_s[0] == (recorder.start_us - release_us) / 1e6


def test_partial_blocks_and_blocks_without_samples_are_taken(tmp_path: Path) -> None:
    recorder = Recorder()
    for count in (6, 1, 0, 5, 6):
        recorder.data(count)
    recorder.close()
    log = load(write(tmp_path / "SD.bin", recorder.image()))
    assert log.sample_index.tolist() == list(range(18))
    assert_values(log)
    assert log.verdict == "complete"
