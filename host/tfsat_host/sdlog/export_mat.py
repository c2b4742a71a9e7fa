"""MATLAB: one struct `drop`, time down the rows, one element of a struct array a body and a joint."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import scipy.io

from tfsat_host.protocol.limits import IMU_COUNT, JOINT_COUNT

from .droplog import DropLog
from .metadata import metadata

MAT_MARKER = b"MATLAB 5.0 MAT-file, made by tfsat-host decode"
"""The descriptive text at the start of the file: how the command knows a file of its own."""
_TEXT_BYTES = 116


def write_mat(log: DropLog, path: Path) -> None:
    """Write a version 5 MAT-file without the time of day: the same log gives the same file."""
    contents = {"drop": drop_struct(log)}
    scipy.io.savemat(str(path), contents, appendmat=False, oned_as="column", long_field_names=True)
    with path.open("r+b") as file:
        file.write(MAT_MARKER.ljust(_TEXT_BYTES))


def drop_struct(log: DropLog) -> dict[str, Any]:
    """`drop.t_s`, `drop.imu(i).rate_rad_s` (n by 3), `drop.joint(j).sensor_angle_rad` (n by 2), …"""
    imu = np.empty(IMU_COUNT, object)
    for i in range(IMU_COUNT):
        imu[i] = {
            "rate_rad_s": log.rate_rad_s[:, i],
            "specific_force_m_s2": log.specific_force_m_s2[:, i],
            "temperature_c": log.temperature_c[:, i],
            "valid": log.imu_valid[:, i],
            "clipped": log.clipped[:, i],
        }
    joint = np.empty(JOINT_COUNT, object)
    for j in range(JOINT_COUNT):
        pair = slice(2 * j, 2 * j + 2)
        joint[j] = {"sensor_angle_rad": log.sensor_angle_rad[:, pair], "valid": log.angle_valid[:, pair]}
    return {
        "sample_index": log.sample_index,
        "t_s": log.t_s,
        "t_us": log.t_us,
        "imu": _struct_array(imu),
        "joint": _struct_array(joint),
        "switch_open": log.switch_open,
        "events": _events(log),
        "info": _info(log),
    }


def _struct_array(items: Any) -> Any:
    """A 1 by k structured object array, which savemat writes as a struct array: drop.imu(1)."""
    array = np.empty((1, len(items)), [(name, object) for name in items[0]])
    for i, item in enumerate(items):
        array[0, i] = tuple(item.values())
    return array


def _events(log: DropLog) -> dict[str, Any]:
    return {
        "t_s": np.array([log.seconds(event.t_us) for event in log.events], float),
        "t_us": np.array([event.t_us for event in log.events], np.uint64),
        "name": np.array([event.name for event in log.events], object),
        "index": np.array([event.index for event in log.events], float),
        "arg": np.array([event.arg for event in log.events], float),
        "value": np.array([event.value for event in log.events], float),
    }


def _info(log: DropLog) -> dict[str, Any]:
    """Scalars and text of the metadata; MATLAB has no null, so what is missing is left out."""
    facts = metadata(log)
    flat = {name: facts[name] for name in _INFO_FIELDS if facts[name] is not None}
    return flat | {"header": facts["header"]}


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
