"""A distribution as a document, as tables for people, as a CSV for plotting programs, and as the paper's figure.

The figure of nonholonomic reorientation, in z-y-x Euler angles, needs matplotlib, the extra `figures`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tfsat_host.errors import UsageError
from tfsat_host.output_files import OutputFile
from tfsat_host.plan.grid import Distribution, GridManeuver
from tfsat_host.plotting import check_matplotlib, load_matplotlib
from tfsat_host.quantity import Column, Columns, Table
from tfsat_host.robot import RobotModel

# Errors of the drop test's reorientation, paper, section "Result": before and after its model was corrected.
DROP_TEST_REORIENTATION_DEG = 23.3
DROP_TEST_ERROR_DEG = 0.314
DROP_TEST_CORRECTED_ERROR_DEG = 0.237

_TARGET_DEG = 90.0
_FIGURES = (".png", ".pdf", ".svg")
_FIGURE_MARKER = b"Matplotlib"  # matplotlib signs its files so
_COLUMNS = (
    "joint_i,joint_j,alpha_deg,beta_deg,"
    "euler_z_deg,euler_y_deg,euler_x_deg,"
    "rotation_x_deg,rotation_y_deg,rotation_z_deg,"
    "reorientation_deg,efficiency"
)
_LOOPS: Columns = (
    Column("joints", "joints", form=".0f"),
    Column("alpha_deg", "first", form="g"),
    Column("beta_deg", "second", form="g"),
    Column("reorientation_deg", "reorientation", form=".2f"),
    Column("efficiency", "efficiency", form=".4f"),
    Column("euler_zyx_deg", "z y x", form="+.2f"),
)


def expected_error_deg(target_deg: float, error_deg: float = DROP_TEST_ERROR_DEG) -> float:
    """Error of a reorientation without feedback, if that of the drop test had `error_deg`.

    In proportion to the angle, as the paper takes it: 1.21 deg for 90 deg, and with the corrected model 0.92 deg.
    """
    return target_deg * error_deg / DROP_TEST_REORIENTATION_DEG


def document(distribution: Distribution, robot: RobotModel, speed_deg_s: float | None) -> dict[str, Any]:
    """Build the `--json` document, without the files.

    Joints move at `speed_deg_s`; None means as fast as the servos.

    Loops follow one another without pause: 30 deg/s with an efficiency of 0.1092 make 3.28 deg/s, 27.4 s
    for 90 deg.
    """
    best = distribution.maneuver(distribution.best_by_efficiency)
    # As fast as the slower of the loop's two servos.
    if speed_deg_s is None:
        speed_deg_s = math.degrees(min(robot.servos[joint].average_rate_rad_s for joint in best.joints))
    return {
        "robot": robot.name,
        "grid_deg": distribution.step_deg,
        "maneuvers": len(distribution.angle_rad),
        "most_efficient": _as_json(best),
        "farthest": _as_json(distribution.maneuver(distribution.best_by_angle)),
        "pairs": [_as_json(distribution.maneuver(index)) for index in distribution.best_of_pairs()],
        "joint_speed_deg_s": speed_deg_s,
        # Efficiency is turn per joint travel: times the joint speed it is the robot's mean rate.
        "average_rate_deg_s": speed_deg_s * best.efficiency,
        "target_deg": _TARGET_DEG,
        "slew_time_s": _TARGET_DEG / (speed_deg_s * best.efficiency),
        "expected_error_deg": expected_error_deg(_TARGET_DEG),
    }


def _as_json(maneuver: GridManeuver) -> dict[str, Any]:
    return maneuver._asdict() | {"joints": [joint + 1 for joint in maneuver.joints]}


def lines(result: dict[str, Any]) -> Iterator[str | Table]:
    """Yield the report for people from a `document`."""
    title = f"{result['robot']}: the most efficient of each pair's loops of four strokes"
    yield Table(title, _LOOPS, result["pairs"])
    yield f"{result['maneuvers']} loops on a grid of {result['grid_deg']:g} deg."
    farthest = result["farthest"]
    yield (
        f"Farthest: {farthest['reorientation_deg']:.2f} deg by joints {farthest['joints'][0]} and "
        f"{farthest['joints'][1]}, {farthest['alpha_deg']:g} and {farthest['beta_deg']:g} deg "
        f"(efficiency {farthest['efficiency']:.4f})."
    )
    yield (
        f"With joints at {result['joint_speed_deg_s']:g} deg/s the most efficient loop again and again turns by "
        f"{result['average_rate_deg_s']:.2f} deg/s: {_TARGET_DEG:g} deg in {result['slew_time_s']:.1f} s, without "
        f"feedback to about {result['expected_error_deg']:.2f} deg, in proportion to the drop test's errors."
    )
    yield from (f"Written to {path}." for path in result["files"])


def files_for(table: Path | None, figure: Path | None) -> list[tuple[Path, bytes]]:
    """Return the files to write, each with the marker bytes by which our own files are recognized.

    Raises:
        UsageError: the figure's format is not supported.
        TfsatError: matplotlib is missing.
    """
    if figure is not None and figure.suffix.lower() not in _FIGURES:
        raise UsageError(
            what=f"{figure} does not end with the name of a picture format.",
            meaning="Nothing was drawn or written.",
            next_step=f"Let --figure end with {', '.join(_FIGURES)}.",
        )
    if figure is not None:
        check_matplotlib("--figure", "take the CSV of --out")
    outputs = ((table, _COLUMNS.encode()), (figure, _FIGURE_MARKER))
    return [(path, marker) for path, marker in outputs if path is not None]


def output_file(distribution: Distribution, robot: RobotModel, path: Path, marker: bytes) -> OutputFile:
    """Build the output file, table or figure, for an entry of `files_for`."""
    if marker == _FIGURE_MARKER:
        title = (
            f"{robot.name}: {len(distribution.angle_rad)} loops of four strokes, every "
            f"{distribution.step_deg:g} deg"
        )
        return OutputFile(path, marker, lambda to: _draw(distribution, title, to, path.suffix.lower()[1:]))
    return OutputFile(path, marker, lambda to: _write_csv(distribution, to))


def _write_csv(distribution: Distribution, path: Path) -> None:
    """Write a CSV file with one loop per line; joints are counted from 1."""
    table = np.column_stack(
        [
            distribution.joints + 1,
            np.degrees(distribution.displacement_rad),
            np.degrees(distribution.euler_zyx_rad),
            np.degrees(distribution.rotation_vector_rad),
            np.degrees(distribution.angle_rad),
            distribution.efficiency,
        ]
    )
    np.savetxt(path, table, fmt="%d,%d,%.6g,%.6g" + ",%.8f" * 8, header=_COLUMNS, comments="")


def _draw(distribution: Distribution, title: str, path: Path, file_format: str) -> None:
    """Draws every loop as a point, its color the efficiency, and the most efficient ones as stars.

    They are two: a loop flown backwards is as efficient, and turns the other way.
    """
    load_matplotlib()
    from matplotlib.figure import Figure

    angles = np.degrees(distribution.euler_zyx_rad)
    best = angles[distribution.most_efficient()]
    figure = Figure(figsize=(7.0, 5.6), layout="constrained")
    # Without computed order the stars stay in front of the cloud, by their zorder.
    axes = figure.add_subplot(projection="3d", computed_zorder=False)
    # Rasterized, a million points are a picture of some kilobytes in a PDF or an SVG, too.
    points = axes.scatter(
        *angles.T,
        c=distribution.efficiency,
        s=_area(len(angles)),
        cmap="viridis",
        linewidths=0.0,
        rasterized=True,
    )
    axes.scatter(
        *best.T,
        marker="*",
        s=220,
        c="gold",
        edgecolors="black",
        depthshade=False,
        zorder=3,
        label="most efficient",
    )
    axes.set_xlabel("z / deg")
    axes.set_ylabel("y / deg")
    axes.set_zlabel("x / deg")
    axes.set_title(title)
    axes.legend(loc="upper left")
    figure.colorbar(points, ax=axes, shrink=0.7, label="efficiency")
    figure.savefig(path, format=file_format, dpi=150)


def _area(count: int) -> float:
    """Return the area of a plotted point in square points; it shrinks as their count grows."""
    return max(min(5.0, 10_000.0 / count), 0.5)
