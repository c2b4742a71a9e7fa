"""NPZ: the arrays of `DropLog` in SI units, and its metadata as one JSON string."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from .droplog import DropLog, rows_of
from .metadata import metadata

NPZ_MARKER = b"made by tfsat-host decode"
"""The archive's comment: how the command knows a file of its own."""
_ROWS_AT_A_TIME = 1 << 15

_COLUMNS: dict[str, Callable[[DropLog], NDArray[Any]]] = {
    "sample_index": lambda log: log.sample_index,
    "t_us": lambda log: log.t_us,
    "t_s": lambda log: log.t_s,
    "rate_rad_s": lambda log: log.rate_rad_s,
    "specific_force_m_s2": lambda log: log.specific_force_m_s2,
    "temperature_c": lambda log: log.temperature_c,
    "sensor_angle_rad": lambda log: log.sensor_angle_rad,
    "imu_valid": lambda log: log.imu_valid,
    "angle_valid": lambda log: log.angle_valid,
    "switch_open": lambda log: log.switch_open,
    "clipped": lambda log: log.clipped,
}


def si_columns(log: DropLog) -> dict[str, NDArray[Any]]:
    """Name (with unit) to column; shapes as documented at `DropLog`."""
    return {name: column(log) for name, column in _COLUMNS.items()}


def write_npz(log: DropLog, path: Path) -> None:
    """Write what `numpy.load` reads; `json.loads(str(file["metadata"]))` gives the metadata."""
    text = np.array(json.dumps(metadata(log)))
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        for name, column in _COLUMNS.items():
            with _member(archive, name) as member:
                _write_column(log, column, member)
        with _member(archive, "metadata") as member:
            np.lib.format.write_array(member, text, allow_pickle=False)
        archive.comment = NPZ_MARKER


def _member(archive: zipfile.ZipFile, name: str) -> IO[bytes]:
    return archive.open(f"{name}.npy", "w", force_zip64=True)


def _write_column(log: DropLog, column: Callable[[DropLog], NDArray[Any]], member: IO[bytes]) -> None:
    """Some rows at a time: what is computed stays in the processor's cache, and is not kept."""
    for start in range(0, len(log), _ROWS_AT_A_TIME):
        part = np.ascontiguousarray(column(rows_of(log, slice(start, start + _ROWS_AT_A_TIME))))
        if start == 0:
            shape = (len(log), *part.shape[1:])
            np.lib.format.write_array_header_1_0(
                member, {"descr": part.dtype.str, "fortran_order": False, "shape": shape}
            )
        member.write(part.data)
