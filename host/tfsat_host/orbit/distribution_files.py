"""A distribution as a table for plotting programs, and as the paper's figure of nonholonomic reorientation.

The figure, in z-y-x Euler angles, needs matplotlib, the extra `figures`.
"""

from __future__ import annotations

from pathlib import Path
from typing import TextIO

import numpy as np

from tfsat_host.orbit.distribution import Distribution

COLUMNS = (
    "joint_i,joint_j,alpha_deg,beta_deg,"
    "euler_z_deg,euler_y_deg,euler_x_deg,"
    "rotation_x_deg,rotation_y_deg,rotation_z_deg,"
    "reorientation_deg,efficiency"
)
"""The first line of the CSV. Joints are counted from 1."""


def write_csv(found: Distribution, file: TextIO) -> None:
    """Writes one loop a line, below the names of the columns."""
    table = np.column_stack(
        [
            found.joints + 1,
            np.degrees(found.displacement_rad),
            np.degrees(found.euler_zyx_rad),
            np.degrees(found.rotation_vector_rad),
            np.degrees(found.angle_rad),
            found.efficiency,
        ]
    )
    np.savetxt(file, table, fmt="%d,%d,%.6g,%.6g" + ",%.8f" * 8, header=COLUMNS, comments="")


def draw_distribution(found: Distribution, title: str, path: Path, file_format: str) -> None:
    """Draws every loop as a point, its color the efficiency, and the most efficient ones as stars.

    They are two: a loop flown backwards is as efficient, and turns the other way.
    """
    from matplotlib.figure import Figure

    angles = np.degrees(found.euler_zyx_rad)
    best = angles[found.most_efficient()]
    figure = Figure(figsize=(7.0, 5.6), layout="constrained")
    axes = figure.add_subplot(projection="3d", computed_zorder=False)
    # Rasterized, a million points are a picture of some kilobytes in a PDF or an SVG, too.
    points = axes.scatter(
        *angles.T, c=found.efficiency, s=_area(len(angles)), cmap="viridis", linewidths=0.0, rasterized=True
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
    """Of a point, in square points: many must leave room for one another."""
    return max(min(5.0, 10_000.0 / count), 0.5)
