"""NPZ: the arrays of `DropLog` in SI units, and its metadata as one JSON string."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .droplog import DropLog
from .metadata import metadata

NPZ_MARKER = b"made by tfsat-host decode"
"""The archive's comment: how the command knows a file of its own."""


def si_columns(log: DropLog) -> dict[str, NDArray[Any]]:
    """Name (with unit) to column; shapes as documented at `DropLog`."""
    return {
        "sample_index": log.sample_index,
        "t_us": log.t_us,
        "t_s": log.t_s,
        "rate_rad_s": log.rate_rad_s,
        "specific_force_m_s2": log.specific_force_m_s2,
        "temperature_c": log.temperature_c,
        "sensor_angle_rad": log.sensor_angle_rad,
        "imu_valid": log.imu_valid,
        "angle_valid": log.angle_valid,
        "switch_open": log.switch_open,
        "clipped": log.clipped,
    }


def write_npz(log: DropLog, path: Path) -> None:
    """Write what `numpy.load` reads; `json.loads(str(file["metadata"]))` gives the metadata."""
    text = np.array(json.dumps(metadata(log)))
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        for name, column in [*si_columns(log).items(), ("metadata", text)]:
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asarray(column, order="C"), allow_pickle=False)
        archive.comment = NPZ_MARKER
