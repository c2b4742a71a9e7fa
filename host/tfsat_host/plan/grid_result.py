"""A distribution as JSON, for people, as a CSV for plotting programs, and as the paper's figure.

The figure of nonholonomic reorientation, in z-y-x Euler angles, needs matplotlib, the extra `figures`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tfsat_host.errors import UsageError
from tfsat_host.output_files import OutputFile
from tfsat_host.plan.grid import Distribution, GridManeuver
from tfsat_host.plotting import check_matplotlib, load_matplotlib
from tfsat_host.quantity import Column, Columns, Table, fields
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


def expected_error_deg(target_deg: float, error_deg: float = DROP_TEST_ERROR_DEG) -> float:
    """Error of a reorientation without feedback, if that of the drop test had `error_deg`.

    In proportion to the angle, as the paper takes it: 1.21 deg for 90 deg, and with the corrected model 0.92 deg.
    """
    return target_deg * error_deg / DROP_TEST_REORIENTATION_DEG


@dataclass(frozen=True, eq=False)
class GridResult:
    """A distribution, and what its most efficient loop makes of a robot on orbit.

    Loops follow one another without pause: 30 deg/s with an efficiency of 0.1092 make 3.28 deg/s, 27.4 s for 90 deg.

    Attributes:
        distribution: All loops of the grid.
        robot: Whose.
        asked_speed_deg_s: Of the joints; None: as fast as the slower of the loop's two servos.
        files: The written ones.
    """

    distribution: Distribution
    robot: RobotModel
    asked_speed_deg_s: float | None
    files: Sequence[Path]

    @property
    def most_efficient(self) -> GridManeuver:
        """The loop that turns the robot most for what its joints turn."""
        return self.distribution.maneuver(self.distribution.best_by_efficiency)

    @property
    def farthest(self) -> GridManeuver:
        """The loop that turns the robot most."""
        return self.distribution.maneuver(self.distribution.best_by_angle)

    @property
    def pairs(self) -> list[GridManeuver]:
        """The most efficient loop of each pair of joints."""
        return [self.distribution.maneuver(index) for index in self.distribution.best_of_pairs()]

    @property
    def joint_speed_deg_s(self) -> float:
        """How fast the joints of the most efficient loop move."""
        if self.asked_speed_deg_s is not None:
            return self.asked_speed_deg_s
        servos = (self.robot.servos[joint] for joint in self.most_efficient.joints)
        return math.degrees(min(servo.average_rate_rad_s for servo in servos))

    @property
    def average_rate_deg_s(self) -> float:
        """The robot's mean rate: the efficiency is turn per joint travel."""
        return self.joint_speed_deg_s * self.most_efficient.efficiency


def _format_farthest(result: GridResult) -> str:
    loop = result.farthest
    return (
        f"{loop.reorientation_deg:.2f} deg by joints {loop.joints[0] + 1} and {loop.joints[1] + 1}, "
        f"{loop.alpha_deg:g} and {loop.beta_deg:g} deg (efficiency {loop.efficiency:.4f})"
    )


_LOOP: Columns = (
    Column("joints", "joints", of=lambda loop: [joint + 1 for joint in loop.joints], form=".0f"),
    Column("alpha_deg", "first", form="g"),
    Column("beta_deg", "second", form="g"),
    Column("reorientation_deg", "reorientation", form=".2f"),
    Column("efficiency", "efficiency", form=".4f"),
    *fields("rotation_vector_deg"),
    Column("euler_zyx_deg", "z y x", form="+.2f"),
)
DISTRIBUTION: Columns = (
    Column("robot", "Robot", of="robot.name"),
    *fields("grid_deg=distribution.step_deg"),
    Column(
        "maneuvers",
        "Loops",
        of=lambda result: len(result.distribution.angle_rad),
        words=lambda result: (
            f"{len(result.distribution.angle_rad)} of four strokes, on a grid of {result.distribution.step_deg:g} deg"
        ),
    ),
    Column("most_efficient", columns=_LOOP),
    Column("farthest", "Farthest", words=_format_farthest, columns=_LOOP),
    Column("pairs", columns=_LOOP),
    *fields("joint_speed_deg_s"),
    Column(
        "average_rate_deg_s",
        "Average rate",
        words=lambda result: (
            f"{result.average_rate_deg_s:.2f} deg/s by the most efficient loop, joints at {result.joint_speed_deg_s:g} "
            "deg/s"
        ),
    ),
    Column("target_deg", of=lambda _result: _TARGET_DEG),
    Column(
        "slew_time_s",
        f"Time for {_TARGET_DEG:g} deg",
        of=lambda result: _TARGET_DEG / result.average_rate_deg_s,
        form=".1f",
    ),
    Column(
        "expected_error_deg",
        "Error without feedback",
        of=lambda _result: expected_error_deg(_TARGET_DEG),
        words=lambda _result: f"{expected_error_deg(_TARGET_DEG):.2f} deg, in proportion to the drop test's",
    ),
    Column("files", "Written", of=lambda result: list(result.files)),
)
"""A distribution as `tfsat-host design --grid` shows it: all in `--json`, what has a label as facts for people."""


def pair_table(result: GridResult) -> Table:
    """Return the most efficient loop of each pair of joints."""
    return Table("The most efficient loop of each pair of joints", _LOOP, result.pairs)


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
        # The area of a point, in square points, shrinks as their count grows.
        s=max(min(5.0, 10_000.0 / len(angles)), 0.5),
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
