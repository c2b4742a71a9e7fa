"""The files, read back with the formats' own readers."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
from pyarrow import csv as arrow_csv

from tests.sdlog.encoder import ALL_VALID, Recorder, drop_with_release, long_recording
from tests.sdlog.test_values import by_name, write
from tfsat_host.errors import TfsatError
from tfsat_host.quantity import record
from tfsat_host.sdlog import DropLog, export_arrays, load
from tfsat_host.sdlog.export_arrays import write_mat, write_npz
from tfsat_host.sdlog.export_tables import write_csv, write_events_csv
from tfsat_host.sdlog.log_summary import METADATA


@pytest.fixture
def log(tmp_path: Path) -> DropLog:
    return load(write(tmp_path / "SD.bin", drop_with_release()[0].image()))


def read_csv(path: Path) -> dict[str, list[str]]:
    with path.open(newline="") as file:
        rows = list(csv.reader(file))
    assert {len(row) for row in rows} == {len(rows[0])}
    return {name: [row[i] for row in rows[1:]] for i, name in enumerate(rows[0])}


def test_csv_holds_every_value_to_the_sensor_s_resolution(log: DropLog, tmp_path: Path) -> None:
    write_csv(log, tmp_path / "SD.csv")
    table = read_csv(tmp_path / "SD.csv")
    columns = by_name(log)
    assert table.keys() == columns.keys()
    # Half of the last digit that is written for each unit.
    half_digit = {"deg_s": 5.1e-5, "deg": 5.1e-5, "m_s2": 5.1e-6, "_c": 5.1e-4}
    for name, column in columns.items():
        atol = next((atol for unit, atol in half_digit.items() if name.endswith(unit)), 0.0)
        np.testing.assert_allclose(np.array(table[name], float), column, atol=atol, rtol=0, err_msg=name)


def test_csv_has_types_that_a_foreign_reader_infers(log: DropLog, tmp_path: Path) -> None:
    write_csv(log, tmp_path / "SD.csv")
    # Types that a reader without our schema takes for numbers.
    table = arrow_csv.read_csv(tmp_path / "SD.csv")
    types = {str(table[name].type) for name in table.column_names if name not in ("sample", "t_us")}
    assert types == {"double", "int64"}
    np.testing.assert_array_equal(table["t_us"].to_numpy(), log.t_us)
    np.testing.assert_allclose(
        table["imu2_specific_force_z_m_s2"], log.specific_force_m_s2[:, 1, 2], atol=5.1e-6
    )


def test_csv_leaves_invalid_readings_empty_and_shows_clipping(tmp_path: Path) -> None:
    recorder = Recorder()
    recorder.data()
    # Bits of IMU 2 and of angle sensor 6, and IMU 3's clip flag.
    recorder.data(flags=(ALL_VALID & ~0b10_0000_0010) | 1 << 14)
    log = load(write(tmp_path / "SD.bin", recorder.image()))
    write_csv(log, tmp_path / "SD.csv")
    table = read_csv(tmp_path / "SD.csv")
    # Empty is not zero: nothing was measured there.
    empty = {name for name, column in table.items() if "" in column}
    assert empty == {
        *(f"imu2_rate_{axis}_deg_s" for axis in "xyz"),
        *(f"imu2_specific_force_{axis}_m_s2" for axis in "xyz"),
        "imu2_temperature_c",
        "joint3_sensor2_angle_deg",
    }
    assert table["imu2_temperature_c"][6:] == [""] * 6
    assert table["imu3_clipped"] == ["0"] * 6 + ["1"] * 6


def test_csv_is_the_same_for_a_log_of_many_chunks(tmp_path: Path) -> None:
    # More blocks than are written at once.
    log = load(write(tmp_path / "SD.bin", long_recording(3000, start_us=999_000)))
    write_csv(log, tmp_path / "SD.csv")
    table = read_csv(tmp_path / "SD.csv")
    assert [int(text) for text in table["t_us"]] == log.t_us.tolist()
    assert [float(text) for text in table["t_s"]] == log.t_s.tolist()


def test_events_csv(log: DropLog, tmp_path: Path) -> None:
    write_events_csv(log, tmp_path / "SD.events.csv")
    table = read_csv(tmp_path / "SD.events.csv")
    assert table["event"] == ["switch_edge", "switch_edge", "stroke", "stroke", "stroke", "stroke"]
    # The release is t = 0; the strokes are where the maneuver put them.
    assert table["t_s"][1:] == ["0.000000", "0.700000", "1.050000", "1.470000", "1.820000"]
    assert [int(text) for text in table["t_us"]] == [event.t_us for event in log.events]


IN_RADIANS = {"rate_deg_s": "rate_rad_s", "sensor_angle_deg": "sensor_angle_rad"}


def test_npz(log: DropLog, tmp_path: Path) -> None:
    write_npz(log, tmp_path / "SD.npz")
    with np.load(tmp_path / "SD.npz") as file:
        for name in set(file.files) - {"metadata"}:
            # Degrees as in the CSV; everything else is the log's own, type included.
            column = np.rad2deg(getattr(log, IN_RADIANS[name])) if name in IN_RADIANS else getattr(log, name)
            np.testing.assert_array_equal(file[name], column)
            assert file[name].dtype == column.dtype
        assert {"sample_index", "t_s", "rate_deg_s", "sensor_angle_deg", "clipped"} < set(file.files)
        facts = json.loads(str(file["metadata"]))
    assert (facts["verdict"], facts["samples"], facts["header"]["rate_hz"]) == ("complete", len(log), 280)


def read_mat(path: Path) -> Any:
    return scipy.io.loadmat(path, squeeze_me=True, struct_as_record=False)["drop"]


def test_mat_is_a_struct_as_matlab_has_them(log: DropLog, tmp_path: Path) -> None:
    write_mat(log, tmp_path / "SD.mat")
    drop = read_mat(tmp_path / "SD.mat")
    np.testing.assert_array_equal(drop.t_s, log.t_s)
    np.testing.assert_array_equal(drop.t_us, log.t_us)
    np.testing.assert_array_equal(drop.sample_index, log.sample_index)
    np.testing.assert_array_equal(drop.switch_open, log.switch_open)
    for body in range(4):
        np.testing.assert_array_equal(drop.imu[body].rate_deg_s, np.rad2deg(log.rate_rad_s[:, body]))
        np.testing.assert_array_equal(drop.imu[body].specific_force_m_s2, log.specific_force_m_s2[:, body])
        np.testing.assert_array_equal(drop.imu[body].temperature_c, log.temperature_c[:, body])
        np.testing.assert_array_equal(drop.imu[body].valid, log.imu_valid[:, body])
        np.testing.assert_array_equal(drop.imu[body].clipped, log.clipped[:, body])
    for joint in range(3):
        # Two sensors a joint, in the order of their numbers.
        pair = slice(2 * joint, 2 * joint + 2)
        np.testing.assert_array_equal(
            drop.joint[joint].sensor_angle_deg, np.rad2deg(log.sensor_angle_rad[:, pair])
        )
        np.testing.assert_array_equal(drop.joint[joint].valid, log.angle_valid[:, pair])
    assert list(drop.events.name[:3]) == ["switch_edge", "switch_edge", "stroke"]
    np.testing.assert_array_equal(drop.events.t_s, [log.seconds(event.t_us) for event in log.events])
    np.testing.assert_array_equal(drop.events.t_us, [event.t_us for event in log.events])
    assert (drop.info.verdict, drop.info.session, drop.info.samples) == ("complete", "1234abcd", len(log))
    assert drop.info.header.gyro_lsb_per_deg_s == 65.5
    assert drop.info.release_us == log.release_us
    # The same numbers once more, as text that a script can read.
    assert json.loads(drop.info.metadata_json) == record(METADATA, log)
    raw = scipy.io.loadmat(tmp_path / "SD.mat")["drop"]
    # Time down the rows, as MATLAB's functions expect it.
    assert raw["t_s"][0, 0].shape == (len(log), 1)
    assert raw["imu"][0, 0].shape == (1, 4)
    assert raw["events"][0, 0]["name"][0, 0].shape == (6, 1), "a cell array, time down the rows"


def test_mat_numbers_are_doubles_and_flags_logicals(log: DropLog, tmp_path: Path) -> None:
    """MATLAB's integers round every quotient: diff(drop.t_us)/1e6 would be zero."""
    write_mat(log, tmp_path / "SD.mat")
    read = scipy.io.loadmat(tmp_path / "SD.mat", simplify_cells=True)["drop"]
    numbers = dict(leaves(read))
    flags = {
        name for name in numbers if name.split(".")[-1] in ("valid", "clipped", "switch_open", "is_copy")
    }
    assert flags
    for name, value in numbers.items():
        kind = np.asarray(value).dtype.kind
        if kind in "biuf":
            # scipy reads logicals as the small integers that they are stored in.
            assert kind in ("iu" if name in flags else "f"), name


def leaves(value: Any, name: str = "drop") -> Iterator[tuple[str, Any]]:
    """(path, value) of everything in nested structs."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from leaves(inner, f"{name}.{key}")
    elif isinstance(value, list | np.ndarray) and len(value) and isinstance(value[0], dict):
        for i, inner in enumerate(value):
            yield from leaves(inner, f"{name}({i + 1})")
    else:
        yield name, value


def test_invalid_readings_are_nan_in_mat_and_npz(tmp_path: Path) -> None:
    recorder = Recorder()
    recorder.data(flags=ALL_VALID & ~0b10_0000_0010)
    log = load(write(tmp_path / "SD.bin", recorder.image()))
    write_mat(log, tmp_path / "SD.mat")
    write_npz(log, tmp_path / "SD.npz")
    drop = read_mat(tmp_path / "SD.mat")
    assert np.isnan(drop.imu[1].rate_deg_s).all() and np.isfinite(drop.imu[0].rate_deg_s).all()
    assert np.isnan(drop.joint[2].sensor_angle_deg).all(axis=0).tolist() == [False, True]
    with np.load(tmp_path / "SD.npz") as file:
        assert np.isnan(file["rate_deg_s"]).all(axis=(0, 2)).tolist() == [False, True, False, False]


def test_a_recording_too_long_for_a_mat_file_is_refused(
    log: DropLog, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A small limit in place of two gibibytes.
    monkeypatch.setattr(export_arrays, "_MAX_BYTES", 100_000)
    with pytest.raises(TfsatError, match="do not fit into a MAT-file") as caught:
        write_mat(log, tmp_path / "SD.mat")
    assert "--format parquet" in caught.value.next_step
    assert not (tmp_path / "SD.mat").exists()
    monkeypatch.setattr(export_arrays, "_MAX_BYTES", 200_000)
    write_mat(log, tmp_path / "SD.mat")
    # What is refused is reckoned from what is written.
    size = (tmp_path / "SD.mat").stat().st_size
    assert 1.0 < size / (len(log) * export_arrays.bytes_per_sample()) < 1.2


def test_an_empty_event_list_can_be_written(tmp_path: Path) -> None:
    recorder = Recorder()
    recorder.data(2)
    log = load(write(tmp_path / "SD.bin", recorder.image()))
    write_mat(log, tmp_path / "SD.mat")
    write_events_csv(log, tmp_path / "SD.events.csv")
    drop = scipy.io.loadmat(tmp_path / "SD.mat", squeeze_me=True, struct_as_record=False)["drop"]
    assert drop.events.t_s.size == 0
    assert read_csv(tmp_path / "SD.events.csv")["t_us"] == []
