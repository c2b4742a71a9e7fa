"""The picture of a distribution: the paper's figure of nonholonomic reorientation in z-y-x Euler angles.

Needs matplotlib, the extra `figures`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tfsat_host.orbit.distribution import Distribution


def draw_distribution(found: Distribution, title: str, path: Path, file_format: str) -> None:
    """Draws every loop as a point, its color the efficiency, the most efficient one a star."""
    from matplotlib.figure import Figure

    angles = np.degrees(found.euler_zyx_rad)
    best = angles[found.best_by_efficiency]
    figure = Figure(figsize=(7.0, 5.6), layout="constrained")
    axes = figure.add_subplot(projection="3d")
    points = axes.scatter(*angles.T, c=found.efficiency, s=5, cmap="viridis")
    axes.scatter(*best[:, None], marker="*", s=220, c="gold", edgecolors="black", label="most efficient")
    axes.set_xlabel("z / deg")
    axes.set_ylabel("y / deg")
    axes.set_zlabel("x / deg")
    axes.set_title(title)
    axes.legend(loc="upper left")
    figure.colorbar(points, ax=axes, shrink=0.7, label="efficiency")
    figure.savefig(path, format=file_format, dpi=150)
