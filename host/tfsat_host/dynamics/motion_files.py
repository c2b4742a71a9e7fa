"""Files of motion: joint angles over time as sensors or another program give them, and a flight as a table.

    t_s,theta1_deg,theta2_deg,theta3_deg
    0.000,0.0,0.0,0.0
    0.010,0.1,0.0,0.0

Times count from the release; rows before it say only where the joints then are. Other columns are ignored, so that
what `simulate --out` writes flies again. A rehearsal's truth.csv, whose joints are joint_1_deg and so on, flies too.
A flight is written as CSV in degrees for people and spreadsheets, as NPZ in SI units for programs.
"""

from __future__ import annotations

import csv
import json
import re
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Literal, NoReturn

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics.euler import euler_zyx_rad
from tfsat_host.dynamics.history import JointHistory, history_from_samples
from tfsat_host.dynamics.poses import poses
from tfsat_host.dynamics.propagate import Flight
from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.output_files import OutputFile, check_may_write, write_all

_OF_TRUTH = re.compile(r"^joint_(\d+)_deg$", re.ASCII)
_ANGLE = re.compile(r"theta\d+_deg", re.ASCII)
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
# Beyond these nothing is measured: the numbers are of another unit, or damaged.
_MAX_VALUE = {"t_s": 1e9, "deg": 1e5}
_CLOSEST_S = 1e-9


class HistoryFileError(TfsatError):
    """The file does not give the angle of every joint over time (exit code 1)."""


def read_history(
    path: Path, joint_count: int, *, between: Literal["cubic", "linear"] = "cubic"
) -> JointHistory:
    """Read the history of all joints from a file.

    Args:
        path: A CSV file with commas, decimal points and the columns t_s and theta1_deg to thetaN_deg.
        joint_count: Number of joints of the robot.
        between: Interpolation between two samples, see `history_from_samples`.

    Raises:
        HistoryFileError: the file cannot be read or understood; names file, line and cure.
    """
    try:
        # Spreadsheets may begin a file with a byte order mark.
        with path.open(encoding="utf-8-sig", newline="") as file:
            t_s, angles_deg = _samples(path, file, joint_count)
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is no text in UTF-8"
        _fail(f"The joint history {path} cannot be read: {reason}.", "Give the path of a CSV file.")
    except csv.Error as error:
        _fail(f"{path}: this is no CSV file: {error}.", f"Begin it with the line {_header(joint_count)}.")
    return history_from_samples(t_s, np.radians(angles_deg), between=between)


def _samples(path: Path, file: Iterable[str], joint_count: int) -> tuple[FloatArray, FloatArray]:
    rows = csv.reader(file, strict=True)
    required_names = _header(joint_count).split(",")
    # A rehearsal's truth names the same columns otherwise.
    names = [_OF_TRUTH.sub(r"theta\1_deg", name.strip()) for name in next(rows, [])]
    missing = [name for name in required_names if name not in names]
    if missing:
        what = f"{path}:1: there is no column {missing[0]}."
        _fail(what, f"Begin the file with the line {_header(joint_count)}; separate columns by commas.")
    # Of two columns with one name it is unknown which one is meant.
    for name in required_names:
        if names.count(name) > 1:
            what = f"{path}:1: the column {name} is there {names.count(name)} times."
            _fail(what, "Keep the one that is meant, and rename or remove the other.")
    # A joint more is another robot's motion: refuse it, while unrelated columns are ignored.
    for name in names:
        if name.lower().startswith("theta") and _ANGLE.fullmatch(name) and name not in required_names:
            what = f"{path}:1: the column {name} is one too many: the robot has {joint_count} joints."
            _fail(what, "Remove the column, or name the robot that moved so.")
    columns = [names.index(name) for name in required_names]
    samples: list[list[float]] = []
    for row in rows:
        if row:
            line = rows.line_num
            sample = [_number(path, line, row, column, names) for column in columns]
            _check_time(path, line, sample[0], samples[-1][0] if samples else None)
            samples.append(sample)
    table = _from_release(np.array(samples).reshape(-1, len(required_names)))
    if len(table) < 2:
        _fail(
            f"{path}: a history needs two samples after the release at least; there are {len(table)}.",
            "Add rows.",
        )
    return table[:, 0], table[:, 1:]


def _from_release(table: FloatArray) -> FloatArray:
    """Return the rows (m, 1 + joints) from t = 0 on.

    Angles at t = 0 are interpolated linearly if it lies between two rows.
    """
    later = table[table[:, 0] >= 0.0]
    if len(later) == len(table) or len(later) == 0 or later[0, 0] == 0.0:
        return later
    # The release lies between two rows: interpolate, so that the history begins at t = 0.
    before, after = table[len(table) - len(later) - 1], later[0]
    at_release = before + (after - before) * (0.0 - before[0]) / (after[0] - before[0])
    at_release[0] = 0.0
    return np.vstack([at_release, later])


def _number(path: Path, line: int, row: list[str], column: int, names: list[str]) -> float:
    text = row[column].strip() if column < len(row) else ""
    # Stricter than `float`, which takes nan, inf and underscores.
    if not _NUMBER.fullmatch(text):
        quoted_text = repr(text) if text else "missing"
        cure = "Write a number there, with a point for the decimals, or leave out the whole row."
        _fail(f"{path}:{line}: {names[column]} is {quoted_text}.", cure)
    value = float(text)
    largest = _MAX_VALUE.get(names[column], _MAX_VALUE["deg"])
    if abs(value) > largest:
        what = f"{path}:{line}: {names[column]} is {value:g}, beyond {largest:g}: no joint was measured so."
        _fail(what, "Correct the number, or leave out the whole row.")
    return value


def _check_time(path: Path, line: int, t_s: float, before_s: float | None) -> None:
    if before_s is not None and t_s <= before_s:
        what = f"{path}:{line}: t_s is {t_s:g} after {before_s:g} in the row before: times must increase."
        _fail(what, "Sort the rows by t_s, and keep one row for each time.")
    if before_s is not None and t_s - before_s < 0.5 * _CLOSEST_S:
        what = (
            f"{path}:{line}: t_s is {t_s - before_s:.1g} s after the row before: no clock tells them apart."
        )
        _fail(what, "Leave out one of the two rows.")


def _header(joint_count: int) -> str:
    return ",".join(["t_s", *(f"theta{joint}_deg" for joint in range(1, joint_count + 1))])


def _fail(what: str, next_step: str) -> NoReturn:
    raise HistoryFileError(
        what=what, meaning="The motion of the joints is unknown; nothing was simulated.", next_step=next_step
    )


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
    """Return the output file that `out`, a file or a folder, names; check it before anything is computed.

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
    # The output would overwrite the measurement that is being read.
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
    """Write a CSV file with one row per instant."""
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
    """Write a file for `numpy.load`.

    `json.loads(str(file["metadata"]))` gives the metadata.
    """
    attitudes = body_attitudes(flight)
    m, n = attitudes.shape[:2]
    arrays = {
        "t_s": flight.t_s,
        "base_quaternion_xyzw": flight.quaternion_xyzw,
        "momentum_kg_m2_s": flight.momentum(),
        "kinetic_energy_j": flight.kinetic_energy_j(),
        "theta_deg": np.rad2deg(flight.angles_rad),
        "theta_rate_deg_s": np.rad2deg(flight.angle_rates_rad_s),
        "body_quaternion_xyzw": Rotation.from_matrix(attitudes.reshape(-1, 3, 3)).as_quat().reshape(m, n, 4),
        "body_euler_zyx_deg": np.rad2deg(euler_zyx_rad(attitudes)),
        "body_rate_deg_s": np.rad2deg(body_rates_rad_s(flight)),
        "metadata": np.array(json.dumps(metadata)),
    }
    # As `numpy.savez` does it, but with a comment by which such a file is known as our own.
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
    # Rates add up outwards, each joint's about its axis, in base axes.
    for step in body.steps:
        axis = rotation[:, step.parent] @ (step.sign * body.joint_axis[step.joint])
        in_base[step.child] = in_base[step.parent] + axis * flight.angle_rates_rad_s[:, step.joint, None]
    # R^T w: from base axes to those of each body.
    return np.asarray(np.einsum("mnji,mnj->mni", rotation, np.stack(in_base, axis=1)))


def _rows(values: FloatArray) -> FloatArray:
    """(m, n, 3) as (m, 3 n)."""
    return values.reshape(len(values), -1)
