"""A flight as a table: CSV in degrees for people and spreadsheets, NPZ in SI units for programs."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.dynamics.euler import euler_zyx_rad
from tfsat_host.dynamics.poses import poses
from tfsat_host.dynamics.propagate import Flight
from tfsat_host.errors import UsageError
from tfsat_host.output_files import OutputFile, check_may_write, write_all
from tfsat_host.robot.model import FloatArray

_FIRST_COLUMNS = (
    "t_s",
    *(f"base_quaternion_{c}" for c in "xyzw"),
    *(f"momentum_{c}_kg_m2_s" for c in "xyz"),
    "kinetic_energy_j",
)
_FIRST_FORMATS = ("%.9f", *("%.12f",) * 4, *("%.9e",) * 4)

# How the CSV's header begins, whatever the robot, and the archive's comment.
_MARKERS = {".csv": ",".join(_FIRST_COLUMNS).encode(), ".npz": b"made by tfsat-host simulate"}
_NAME_IN_FOLDER = "simulation.csv"


def flight_path(out: Path, history: Path | None, *, force: bool) -> Path:
    """The file that `out` names, a file or a folder; checked before anything is computed.

    Raises:
        UsageError: no format has such an ending, or it is the file that the joint history is read from.
        TfsatError: something else is there.
    """
    path = out / _NAME_IN_FOLDER if out.is_dir() or not out.suffix else out
    what, cure = "", "Give another name to --out."
    if path.suffix.lower() not in _MARKERS:
        what, cure = (
            f"--out {out} ends neither in .csv nor in .npz.",
            "Name a file with one of them, or a folder.",
        )
    elif history is not None and path.exists() and history.exists() and path.samefile(history):
        what = f"--out {path} is the file that the joint history is read from."
    if what:
        raise UsageError(what=what, meaning="Nothing was done.", next_step=cure)
    check_may_write(path, marker=_MARKERS[path.suffix.lower()], force=force)
    return path


def write_flight(flight: Flight, path: Path, metadata: Mapping[str, Any], *, force: bool) -> None:
    """Writes the file whole, as its ending says; the columns are explained in docs/simulate.md.

    Raises:
        TfsatError: something else is there.
    """
    ending = path.suffix.lower()

    def write(to: Path) -> None:
        if ending == ".csv":
            _write_csv(flight, to)
        else:
            _write_npz(flight, to, metadata)

    write_all([OutputFile(path, _MARKERS[ending], write)], force=force)


def _write_csv(flight: Flight, path: Path) -> None:
    """One row an instant."""
    joints = range(1, flight.body.n_joints + 1)
    bodies = range(1, flight.body.n_bodies + 1)
    names = [
        *_FIRST_COLUMNS,
        *(f"theta{j}_deg" for j in joints),
        *(f"theta{j}_rate_deg_s" for j in joints),
        *(f"body{b}_euler_{c}_deg" for b in bodies for c in "zyx"),
        *(f"body{b}_rate_{c}_deg_s" for b in bodies for c in "xyz"),
    ]
    first = [
        flight.t_s[:, None],
        flight.quaternion_xyzw,
        flight.momentum(),
        flight.kinetic_energy_j()[:, None],
    ]
    degrees = [
        flight.angles_rad,
        flight.angle_rates_rad_s,
        _rows(euler_zyx_rad(body_attitudes(flight))),
        _rows(body_rates_rad_s(flight)),
    ]
    table = np.hstack([*first, np.round(np.rad2deg(np.hstack(degrees)), 9)]) + 0.0  # no minus zeros
    formats = [*_FIRST_FORMATS, *["%.9f"] * (len(names) - len(_FIRST_FORMATS))]
    np.savetxt(path, table, fmt=formats, delimiter=",", header=",".join(names), comments="", newline="\r\n")


def _write_npz(flight: Flight, path: Path, metadata: Mapping[str, Any]) -> None:
    """What `numpy.load` reads; `json.loads(str(file["metadata"]))` gives the metadata."""
    attitudes = body_attitudes(flight)
    m, n = attitudes.shape[:2]
    arrays = {
        "t_s": flight.t_s,
        "base_quaternion_xyzw": flight.quaternion_xyzw,
        "momentum_kg_m2_s": flight.momentum(),
        "kinetic_energy_j": flight.kinetic_energy_j(),
        "theta_rad": flight.angles_rad,
        "theta_rate_rad_s": flight.angle_rates_rad_s,
        "body_quaternion_xyzw": Rotation.from_matrix(attitudes.reshape(-1, 3, 3)).as_quat().reshape(m, n, 4),
        "body_euler_zyx_rad": euler_zyx_rad(attitudes),
        "body_rate_rad_s": body_rates_rad_s(flight),
        "metadata": np.array(json.dumps(metadata)),
    }
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w") as member:
                np.lib.format.write_array(member, array, allow_pickle=False)
        archive.comment = _MARKERS[".npz"]


def body_attitudes(flight: Flight) -> FloatArray:
    """(m, n, 3, 3): from the axes of each body to inertial axes, at the instants of the flight."""
    rotation, _ = poses(flight.body, flight.angles_rad)
    return np.asarray(flight.attitude()[:, None] @ rotation)


def body_rates_rad_s(flight: Flight) -> FloatArray:
    """(m, n, 3): angular rate of each body against inertial space, in its own axes."""
    body = flight.body
    rotation, _ = poses(body, flight.angles_rad)
    in_base = [flight.rate_rad_s] * body.n_bodies
    for step in body.steps:
        axis = rotation[:, step.parent] @ (step.sign * body.joint_axis[step.joint])
        in_base[step.child] = in_base[step.parent] + axis * flight.angle_rates_rad_s[:, step.joint, None]
    return np.asarray(np.einsum("mnji,mnj->mni", rotation, np.stack(in_base, axis=1)))


def _rows(values: FloatArray) -> FloatArray:
    """(m, n, 3) as (m, 3 n)."""
    return values.reshape(len(values), -1)
