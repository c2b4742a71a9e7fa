"""Parquet, read back with pyarrow; and a format whose library is not installed says what to install."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from pyarrow import parquet

from tests.cli.process import RunCli
from tests.sdlog.encoder import ALL_VALID, Recorder, drop_with_release, recording
from tests.sdlog.test_values import by_name, write
from tfsat_host.quantity import record
from tfsat_host.run.exports import FORMATS, write_decoded
from tfsat_host.sdlog import DropLog, export_tables, load
from tfsat_host.sdlog import log_errors as extras
from tfsat_host.sdlog.droplog import flag_columns
from tfsat_host.sdlog.export_tables import METADATA_KEY, write_events_parquet, write_parquet
from tfsat_host.sdlog.log_errors import MissingExtraError
from tfsat_host.sdlog.log_summary import METADATA


@pytest.fixture
def log(tmp_path: Path) -> DropLog:
    return load(write(tmp_path / "SD.bin", drop_with_release()[0].image()))


def test_every_value_is_the_log_s_own_to_the_last_bit(log: DropLog, tmp_path: Path) -> None:
    write_parquet(log, tmp_path / "SD.parquet")
    table = parquet.read_table(tmp_path / "SD.parquet")
    expected = by_name(log)
    assert sorted(table.column_names) == sorted(expected)
    # Sample number and time first, then the sensors.
    assert table.column_names[:4] == ["sample", "t_us", "t_s", "imu1_rate_x_deg_s"]
    for name, column in expected.items():
        np.testing.assert_allclose(table[name].to_numpy(), column, rtol=1e-14, err_msg=name)


def test_units_and_the_recording_s_metadata_travel_with_it(log: DropLog, tmp_path: Path) -> None:
    write_parquet(log, tmp_path / "SD.parquet")
    schema = parquet.read_schema(tmp_path / "SD.parquet")
    facts = json.loads(schema.metadata[METADATA_KEY])
    units = facts["units"]
    assert {name: facts[name] for name in record(METADATA, log)} == record(METADATA, log)
    assert units["imu1_rate_x_deg_s"] == "deg/s"
    assert units["imu4_specific_force_z_m_s2"] == "m/s^2"
    assert units["imu2_temperature_c"] == "degC"
    assert units["joint3_sensor2_angle_deg"] == "deg"
    assert (units["t_us"], units["t_s"]) == ("us", "s")
    # Only counts and flags have no unit.
    assert set(schema.names) - set(units) == {"sample", *flag_columns(log)}


def test_invalid_readings_are_null_and_nothing_else_is(tmp_path: Path) -> None:
    recorder = Recorder()
    recorder.data()
    recorder.data(flags=ALL_VALID & ~0b10_0000_0010)
    write_parquet(load(write(tmp_path / "SD.bin", recorder.image())), tmp_path / "SD.parquet")
    table = parquet.read_table(tmp_path / "SD.parquet")
    null = {name: table[name].is_null().to_pylist() for name in table.column_names if table[name].null_count}
    assert set(null) == {
        *(f"imu2_rate_{axis}_deg_s" for axis in "xyz"),
        *(f"imu2_specific_force_{axis}_m_s2" for axis in "xyz"),
        "imu2_temperature_c",
        "joint3_sensor2_angle_deg",
    }
    # The second block's sensor is silent, the first one's is not.
    assert all(column == [False] * 6 + [True] * 6 for column in null.values())


def test_long_recordings_are_written_piece_by_piece(
    log: DropLog, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A small group: 600 samples make six of them.
    monkeypatch.setattr(export_tables, "_ROW_GROUP", 100)
    write_parquet(log, tmp_path / "SD.parquet")
    assert parquet.read_metadata(tmp_path / "SD.parquet").num_row_groups == 6
    table = parquet.read_table(tmp_path / "SD.parquet")
    np.testing.assert_array_equal(table["t_us"].to_numpy(), log.t_us)


def test_times_are_delta_encoded_and_everything_is_compressed_with_zstd(log: DropLog, tmp_path: Path) -> None:
    write_parquet(log, tmp_path / "SD.parquet")
    group = parquet.read_metadata(tmp_path / "SD.parquet").row_group(0)
    chunks = {group.column(i).path_in_schema: group.column(i) for i in range(group.num_columns)}
    assert "DELTA_BINARY_PACKED" in chunks["t_us"].encodings
    assert "DELTA_BINARY_PACKED" in chunks["sample"].encodings
    assert {chunk.compression for chunk in chunks.values()} == {"ZSTD"}


def test_events(log: DropLog, tmp_path: Path) -> None:
    write_events_parquet(log, tmp_path / "SD.events.parquet")
    rows = parquet.read_table(tmp_path / "SD.events.parquet").to_pylist()
    assert rows == [
        {
            "t_us": event.t_us,
            "t_s": log.seconds(event.t_us),
            "event": event.name,
            "index": event.index,
            "arg": event.arg,
            "value": event.value,
        }
        for event in log.events
    ]
    # Two edges and four strokes.
    assert len(rows) == 6


def test_a_recording_without_events(tmp_path: Path) -> None:
    recorder = Recorder()
    recorder.data(2)
    write_events_parquet(load(write(tmp_path / "SD.bin", recorder.image())), tmp_path / "e.parquet")
    table = parquet.read_table(tmp_path / "e.parquet")
    assert (table.num_rows, table.column_names[0]) == (0, "t_us")


def test_the_same_log_gives_the_same_file(log: DropLog, tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_parquet(log, tmp_path / name)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_decode_writes_both_files_and_knows_its_own_again(tfsat_host: RunCli) -> None:
    write(tfsat_host.folder / "SD.bin", drop_with_release()[0].image())
    facts = tfsat_host.json("decode", "SD.bin", "--format", "parquet")
    assert facts["files"] == {"parquet": "SD.parquet", "events_parquet": "SD.events.parquet"}
    tfsat_host("decode", "SD.bin", "--format", "parquet")
    # However much there is to say of a recording.
    blocks = recording(2000).blocks
    # Every second block is missing: much is to be said of such a recording.
    write(tfsat_host.folder / "SD.bin", b"".join(blocks[:1] + blocks[2::2]))
    for _ in range(2):
        tfsat_host("decode", "SD.bin", "--format", "parquet", expect=3)
    (tfsat_host.folder / "SD.parquet").write_bytes(b"somebody's")
    refused = tfsat_host("decode", "SD.bin", "--format", "parquet", expect=1)
    assert "not made by this command" in refused.stderr


@pytest.mark.parametrize("name", ["parquet", "mcap"])
def test_missing_extra(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # The module itself is missing, not the option.
    monkeypatch.setitem(extras.MODULES, name, ("a_module_that_nobody_has",))
    log = load(write(tmp_path / "SD.bin", recording(2).image()))
    with pytest.raises(MissingExtraError) as caught:
        write_decoded(log, tmp_path / "SD", ("csv", name), force=False)
    assert caught.value.next_step == f"python -m pip install 'tfsat-host[{name}]'"
    assert [path.name for path in tmp_path.iterdir()] == ["SD.bin"]
    # Formats that need nothing can be written, and looking for what stands there needs no extra either.
    write_decoded(log, tmp_path / "SD", [other for other in FORMATS if other != name], force=False)


def test_every_module_of_an_extra_is_installed_here() -> None:
    for name in extras.MODULES:
        extras.check_extra(name)
