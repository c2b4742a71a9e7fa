"""A recording as pandas and xarray have it: the values of the CSV, with their units."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from tests.sdlog.encoder import ALL_VALID, Recorder
from tests.sdlog.test_values import write
from tfsat_host.quantity import record
from tfsat_host.sdlog import DropLog, load, log_errors
from tfsat_host.sdlog.log_summary import METADATA


@pytest.fixture
def log(tmp_path: Path) -> DropLog:
    recorder = Recorder()
    # IMU 2 and the last angle sensor are silent.
    recorder.data(flags=ALL_VALID & ~0b10_0000_0010)
    return load(write(tmp_path / "SD.bin", recorder.image()))


def test_a_dataframe_has_the_columns_of_the_csv_and_their_units(log: DropLog) -> None:
    frame = log.to_dataframe()
    assert frame.index.name == "t_s"
    np.testing.assert_array_equal(frame.index, log.t_s)
    np.testing.assert_allclose(frame["imu1_rate_x_deg_s"], np.rad2deg(log.rate_rad_s[:, 0, 0]), rtol=1e-12)
    assert frame["imu2_rate_x_deg_s"].isna().all()
    assert frame["joint3_sensor2_angle_deg"].isna().all()
    units = frame.attrs["units"]
    assert units["imu1_rate_x_deg_s"] == "deg/s"
    assert units["joint1_sensor1_angle_deg"] == "deg"
    assert units["imu1_temperature_c"] == "degC"
    assert "switch1_open" not in units
    assert frame.attrs["recording"]["verdict"] == log.verdict


def test_a_dataset_is_labelled_by_body_axis_and_sensor(log: DropLog) -> None:
    data = log.to_xarray()
    rate = data["rate_deg_s"].sel(body=1, axis="y")
    np.testing.assert_array_equal(rate, np.rad2deg(log.rate_rad_s[:, 0, 1]))
    assert (rate.attrs["units"], data["specific_force_m_s2"].attrs["units"]) == ("deg/s", "m/s^2")
    assert data["rate_deg_s"].sel(body=2).isnull().all()
    assert data["sensor_angle_deg"].sel(sensor="3b").isnull().all()
    assert data["t_s"].attrs["units"] == "s"
    assert data.attrs["session"] == f"{log.session:08x}"


def test_a_dataset_is_kept_as_netcdf(log: DropLog, tmp_path: Path) -> None:
    log.to_xarray().to_netcdf(tmp_path / "SD.nc", engine="scipy")
    again = xr.open_dataset(tmp_path / "SD.nc", engine="scipy", decode_times=False)
    np.testing.assert_array_equal(
        again["rate_deg_s"].sel(body=1, axis="y"), np.rad2deg(log.rate_rad_s[:, 0, 1])
    )
    assert json.loads(again.attrs["header"])["rate_hz"] == record(METADATA, log)["header"]["rate_hz"]


@pytest.mark.parametrize("extra", ["pandas", "xarray"])
def test_without_the_extra_it_says_what_to_install(
    log: DropLog, monkeypatch: pytest.MonkeyPatch, extra: str
) -> None:
    monkeypatch.setattr(log_errors, "find_spec", lambda _name: None)
    with pytest.raises(log_errors.MissingExtraError) as caught:
        {"pandas": log.to_dataframe, "xarray": log.to_xarray}[extra]()
    assert caught.value.next_step == f"python -m pip install 'tfsat-host[{extra}]'"
