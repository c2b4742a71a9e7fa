"""Arrays: NPZ, and MATLAB's MAT-file, with the recording's metadata.

Units are those of the CSV, each in its name: degrees and deg/s, m/s², °C. The MAT-file has one struct `drop`, time
down the rows, one element of a struct array a body and a joint. Every number in it is a double, as MATLAB's own are:
its integers round quotients (`diff(t_us)/1e6` would be 0) and do not mix with each other. Times in µs and counts are
exact in a double up to 2^53.
"""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from tfsat_host.errors import TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.limits import ANGLE_SENSOR_COUNT, IMU_COUNT, JOINT_COUNT, SWITCH_COUNT
from tfsat_host.quantity import record

from .droplog import SENSORS_PER_JOINT, DropLog, rows_of
from .log_summary import METADATA

NPZ_MARKER = b"made by tfsat-host decode"
"""The archive's comment: how the command knows a file of its own."""
MAT_MARKER = b"MATLAB 5.0 MAT-file, made by tfsat-host decode"
"""The descriptive text at the start of the file: how the command knows a file of its own."""
_ROWS_AT_A_TIME = 1 << 15
_COLUMNS = (
    "sample_index",
    "t_us",
    "t_s",
    "rate_deg_s",
    "specific_force_m_s2",
    "temperature_c",
    "sensor_angle_deg",
    "imu_valid",
    "angle_valid",
    "switch_open",
    "clipped",
)
_IN_RADIANS = {"rate_deg_s": "rate_rad_s", "sensor_angle_deg": "sensor_angle_rad"}
"""The attribute of `DropLog` that an exported column in degrees is made of."""
# Length of the descriptive text that opens a version 5 MAT-file.
_TEXT_BYTES = 116
_MAX_BYTES = 2**31 - 2**20
"""A variable of a version 5 MAT-file has at most 2^31 bytes, descriptions included."""
_INFO_FIELDS = (
    "source",
    "session",
    "verdict",
    "samples",
    "samples_lost",
    "blocks_lost",
    "duration_s",
    "rate_hz",
    "release_us",
    "release_uncertainty_us",
    "t_s_origin",
)


def write_npz(log: DropLog, path: Path) -> None:
    """Write what `numpy.load` reads; `json.loads(str(file["metadata"]))` gives the metadata."""
    text = np.array(json.dumps(record(METADATA, log)))
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        for name in _COLUMNS:
            with _member(archive, name) as member:
                _write_column(log, name, member)
        with _member(archive, "metadata") as member:
            np.lib.format.write_array(member, text, allow_pickle=False)
        archive.comment = NPZ_MARKER


def _member(archive: zipfile.ZipFile, name: str) -> IO[bytes]:
    # A member's size is not known when it is begun, and a column may exceed a plain ZIP's 4 GiB.
    return archive.open(f"{name}.npy", "w", force_zip64=True)


def _write_column(log: DropLog, name: str, member: IO[bytes]) -> None:
    """Some rows at a time: what is computed stays in the processor's cache, and is not kept."""
    for start in range(0, len(log), _ROWS_AT_A_TIME):
        part = np.ascontiguousarray(
            exported_column(rows_of(log, slice(start, start + _ROWS_AT_A_TIME)), name)
        )
        # NPY's header tells the whole shape first; the trailing dimensions are those of any part.
        if start == 0:
            shape = (len(log), *part.shape[1:])
            np.lib.format.write_array_header_1_0(
                member, {"descr": part.dtype.str, "fortran_order": False, "shape": shape}
            )
        member.write(part.data)


def exported_column(log: DropLog, name: str) -> NDArray[Any]:
    """Return a column under its exported name, in its exported unit."""
    in_radians = _IN_RADIANS.get(name)
    return np.asarray(getattr(log, name) if in_radians is None else np.rad2deg(getattr(log, in_radians)))


def write_mat(log: DropLog, path: Path) -> None:
    """Write a version 5 MAT-file without the time of day: the same log gives the same file.

    Raises:
        TfsatError: the recording does not fit into a variable of such a file.
    """
    # The struct `drop` is one variable: all columns together must stay below the limit.
    if len(log) * bytes_per_sample() > _MAX_BYTES:
        raise TfsatError(
            what=f"{len(log)} samples do not fit into a MAT-file: its variables end at 2 GiB.",
            meaning="No MAT-file was written; the recording is untouched.",
            next_step=Advice(
                "Write Parquet and read it with MATLAB's parquetread: ",
                NextStep("decode", ("--format", "parquet")),
            ),
        )
    import scipy.io

    contents = {"drop": drop_struct(log)}
    scipy.io.savemat(str(path), contents, appendmat=False, oned_as="column", long_field_names=True)
    # Replace savemat's descriptive text, in which the time of day stands.
    with path.open("r+b") as file:
        file.write(MAT_MARKER.ljust(_TEXT_BYTES))


def drop_struct(log: DropLog) -> dict[str, Any]:
    """`drop.t_s`, `drop.imu(i).rate_deg_s` (n by 3), `drop.joint(j).sensor_angle_deg` (n by 2), …"""
    rate_deg_s, angle_deg = exported_column(log, "rate_deg_s"), exported_column(log, "sensor_angle_deg")
    imu = np.empty(IMU_COUNT, object)
    for i in range(IMU_COUNT):
        imu[i] = {
            "rate_deg_s": rate_deg_s[:, i],
            "specific_force_m_s2": log.specific_force_m_s2[:, i],
            "temperature_c": log.temperature_c[:, i],
            "valid": log.imu_valid[:, i],
            "clipped": log.clipped[:, i],
        }
    joint = np.empty(JOINT_COUNT, object)
    for j in range(JOINT_COUNT):
        pair = slice(SENSORS_PER_JOINT * j, SENSORS_PER_JOINT * (j + 1))
        joint[j] = {"sensor_angle_deg": angle_deg[:, pair], "valid": log.angle_valid[:, pair]}
    return {
        # Integers as doubles: exact up to 2^53, and MATLAB's integer arithmetic would round quotients.
        "sample_index": log.sample_index.astype(float),
        "t_s": log.t_s,
        "t_us": log.t_us.astype(float),
        "imu": _struct_array(imu),
        "joint": _struct_array(joint),
        "switch_open": log.switch_open,
        "events": _events(log),
        "info": _info(log),
    }


def _struct_array(items: Any) -> Any:
    """Build a 1 by k structured object array, which savemat writes as a struct array: drop.imu(1)."""
    array = np.empty((1, len(items)), [(name, object) for name in items[0]])
    for i, item in enumerate(items):
        array[0, i] = tuple(item.values())
    return array


def _events(log: DropLog) -> dict[str, Any]:
    names = {"t_s": 1, "t_us": 0, "name": 2, "index": 3, "arg": 4, "value": 5}
    return {
        name: np.array([row[i] for row in log.event_rows()], object if name == "name" else float)
        for name, i in names.items()
    }


def _info(log: DropLog) -> dict[str, Any]:
    """Return the recording's metadata for MATLAB, without missing values: MATLAB has no null.

    The complete metadata is in `metadata_json`.
    """
    facts = record(METADATA, log)
    return _as_matlab({name: facts[name] for name in _INFO_FIELDS}) | {
        "doubts": np.array(facts["doubts"], object),
        "header": _as_matlab(facts["header"]),
        "metadata_json": json.dumps(facts),
    }


def _as_matlab(facts: dict[str, Any]) -> dict[str, Any]:
    """Text, logicals and doubles."""
    return {name: _matlab_value(value) for name, value in facts.items() if value is not None}


def _matlab_value(value: Any) -> Any:
    if isinstance(value, list):
        return np.array(value, float)
    # Python's bool is an int, but a MATLAB logical must not become a double.
    return float(value) if isinstance(value, int) and not isinstance(value, bool) else value


def bytes_per_sample() -> int:
    """Doubles: index, two times, seven values an IMU, one an angle sensor; the rest are logicals."""
    doubles = 3 + 7 * IMU_COUNT + ANGLE_SENSOR_COUNT
    return 8 * doubles + 2 * IMU_COUNT + ANGLE_SENSOR_COUNT + SWITCH_COUNT
