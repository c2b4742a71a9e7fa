"""Loops in the space of joint angles, before the curvature that turns the robot: the picture of the page.

At zero momentum a small loop in the plane of two joints turns the robot by its area times the curvature there; a large
one by about the sum. What is drawn is that rotation for a square of 1 deg, about the axis of the whole maneuver.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import Multibody, path_rotation
from tfsat_host.dynamics.history import history_from_moves
from tfsat_host.dynamics.simulation import timed_moves
from tfsat_host.maneuver import Maneuver, schedule_maneuver
from tfsat_host.plotting import load_matplotlib
from tfsat_host.report.figures import BLACK, BLUE, PAGE_MM, RC, VERMILION
from tfsat_host.robot import RobotModel

PLANES: Final = ((0, 1), (2, 1), (0, 2))
SIDE_DEG: Final = 1.0
"""Of the small loop."""
_MM_PER_INCH = 25.4
_GRID_DEG = np.linspace(0.0, 90.0, 46)
_STYLES = ({"color": BLACK, "linestyle": "--"}, {"color": BLUE}, {"color": VERMILION, "linestyle": ":"})


def maneuver_path_deg(robot: RobotModel, maneuver: Maneuver) -> FloatArray:
    """Return joint angles (n, joints) in deg on the way of a maneuver."""
    history = history_from_moves(robot, timed_moves(robot, schedule_maneuver(maneuver)))
    t_s = np.linspace(history.breaks_s[0], history.breaks_s[-1], 600)
    return np.degrees(history.angles_rad(t_s))


def curvature_deg(
    robot: RobotModel, plane: tuple[int, int], poses_rad: FloatArray, axis: FloatArray
) -> FloatArray:
    """Return the rotation (k,) in deg about a unit vector (3,) by a square of `SIDE_DEG` about each of poses (k, n)."""
    first, second = plane
    side = np.radians(SIDE_DEG)
    corner = poses_rad.copy()
    corner[:, [first, second]] -= 0.5 * side
    deltas = np.tile([side, side, -side, -side], (len(poses_rad), 1))
    loop = path_rotation(Multibody.of(robot), (first, second, first, second), deltas, start_rad=corner)
    # A rotation this small is twice the vector part of its quaternion.
    return np.asarray(np.degrees(2.0 * loop[:, :3] @ axis))


def draw_shape_space(
    robot: RobotModel, paths_deg: Mapping[str, FloatArray], axis: FloatArray, path: Path
) -> None:
    """Write the picture: a plane of two joints a panel, the third joint at 45 deg, all paths (n, joints) before it."""
    mpl = load_matplotlib()
    maps = {plane: _curvature_map(robot, plane, axis) for plane in PLANES}
    most = max(float(np.abs(values).max()) for values in maps.values())
    with mpl.rc_context(RC):
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import Normalize
        from matplotlib.figure import Figure

        scale = ScalarMappable(Normalize(-1e3 * most, 1e3 * most), "PuOr")

        figure = Figure(figsize=(PAGE_MM / _MM_PER_INCH, 68.0 / _MM_PER_INCH), layout="constrained")
        panels = figure.subplots(1, len(PLANES))
        for panel, ((first, second), values) in zip(panels, maps.items(), strict=True):
            panel.pcolormesh(
                _GRID_DEG, _GRID_DEG, 1e3 * values, cmap=scale.cmap, norm=scale.norm, rasterized=True
            )
            for (label, angles), style in zip(paths_deg.items(), _STYLES, strict=False):
                panel.plot(angles[:, first], angles[:, second], label=label, linewidth=1.3, **style)
            panel.set(xlabel=f"joint {first + 1} / deg", ylabel=f"joint {second + 1} / deg", aspect="equal")
            panel.grid(visible=False)
        figure.colorbar(scale, ax=panels, label="rotation by a loop of 1 deg × 1 deg / 0.001 deg", shrink=0.8)
        figure.legend(
            *panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=len(paths_deg)
        )
        figure.savefig(path, dpi=200, metadata={"Software": None})


def _curvature_map(robot: RobotModel, plane: tuple[int, int], axis: FloatArray) -> FloatArray:
    across, up = np.meshgrid(_GRID_DEG, _GRID_DEG)
    poses = np.full((across.size, 3), 45.0)
    poses[:, plane[0]], poses[:, plane[1]] = across.ravel(), up.ravel()
    return curvature_deg(robot, plane, np.radians(poses), axis).reshape(across.shape)
