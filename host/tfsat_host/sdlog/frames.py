"""A recording as a pandas DataFrame and as an xarray Dataset, in the units of the CSV, each named in the attributes."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

from tfsat_host.protocol.limits import ANGLE_SENSOR_COUNT, IMU_COUNT, SWITCH_COUNT
from tfsat_host.quantity import record

from .droplog import SENSORS_PER_JOINT, DropLog, flag_columns, physical_columns
from .export_arrays import exported_column
from .export_tables import unit_of_column
from .log_errors import check_extra
from .log_summary import METADATA

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

_DIMS = {
    "rate_deg_s": ("t_s", "body", "axis"),
    "specific_force_m_s2": ("t_s", "body", "axis"),
    "temperature_c": ("t_s", "body"),
    "sensor_angle_deg": ("t_s", "sensor"),
    "switch_open": ("t_s", "switch"),
    "clipped": ("t_s", "body"),
}


def to_dataframe(log: DropLog) -> pd.DataFrame:
    """Return the columns of the CSV, a row a sample, by `t_s`; a value that was not valid is NaN.

    `attrs["units"]` has the unit of each column, `attrs["recording"]` the recording's metadata.

    Raises:
        MissingExtraError: pandas is not installed.
    """
    check_extra("pandas")
    import pandas as pd

    physical = {
        column.name: np.where(column.valid, column.values(slice(None)), np.nan)
        for column in physical_columns(log)
    }
    columns = {"sample": log.sample_index, "t_us": log.t_us, **physical, **flag_columns(log)}
    frame = pd.DataFrame(columns, index=pd.Index(log.t_s, name="t_s"))
    units = {name: unit for name in ("t_s", *columns) if (unit := unit_of_column(name))}
    frame.attrs = {"units": units, "recording": record(METADATA, log)}
    return frame


def to_xarray(log: DropLog) -> xr.Dataset:
    """Return the same by `t_s`, body (1 to 4), axis, angle sensor (1a to 3b) and switch (1, 2).

    Each variable's `attrs["units"]` has its unit, the dataset's `attrs` the recording's metadata, nested ones as JSON.

    Raises:
        MissingExtraError: xarray is not installed.
    """
    check_extra("xarray")
    import xarray as xr

    sensors = [
        f"{k // SENSORS_PER_JOINT + 1}{'ab'[k % SENSORS_PER_JOINT]}" for k in range(ANGLE_SENSOR_COUNT)
    ]
    variables = {
        name: (dims, exported_column(log, name), {"units": unit} if (unit := unit_of_column(name)) else {})
        for name, dims in _DIMS.items()
    }
    coordinates = {
        "t_s": ("t_s", log.t_s, {"units": "s"}),
        "t_us": ("t_s", log.t_us, {"units": "us"}),
        "body": range(1, IMU_COUNT + 1),
        "axis": list("xyz"),
        "sensor": sensors,
        "switch": range(1, SWITCH_COUNT + 1),
    }
    # What netCDF can keep: text and numbers, all else as JSON.
    facts = {
        name: value if type(value) in (str, int, float) else json.dumps(value)
        for name, value in record(METADATA, log).items()
    }
    return xr.Dataset(variables, coordinates, attrs=facts)
