"""The picture's curvature is what turns the robot: small loops add up to a large one."""

from __future__ import annotations

import numpy as np
import pytest

from tests.validation.joints_together.shape_space import SIDE_DEG, curvature_deg, maneuver_path_deg
from tfsat_host.dynamics import Multibody, path_rotation
from tfsat_host.maneuver import Maneuver, Stroke
from tfsat_host.robot import load_robot

ROBOT = load_robot()


@pytest.mark.parametrize("plane", [(0, 1), (2, 1)])
def test_small_loops_add_up_to_a_large_one(plane: tuple[int, int]) -> None:
    start, size_deg, (first, second) = np.radians([20.0, 30.0, 10.0]), 8, plane
    side = np.radians(size_deg)
    large = path_rotation(
        Multibody.of(ROBOT),
        (first, second, first, second),
        np.array([side, side, -side, -side]),
        start_rad=start,
    )
    vector_deg = np.degrees(2.0 * large[:3])
    axis = vector_deg / np.linalg.norm(vector_deg)
    # The middles of 64 squares of 1 deg.
    steps = np.radians(np.arange(size_deg) + 0.5 * SIDE_DEG)
    poses = np.tile(start, (size_deg**2, 1))
    poses[:, first] += np.repeat(steps, size_deg)
    poses[:, second] += np.tile(steps, size_deg)
    total = curvature_deg(ROBOT, plane, poses, axis).sum()
    assert total == pytest.approx(np.linalg.norm(vector_deg), rel=0.02)


def test_a_path_leads_from_pose_to_pose() -> None:
    strokes = (Stroke(1, 40.0, 0.7), Stroke(2, 30.0, 0.7), Stroke(1, -40.0, 1.2), Stroke(2, -30.0, 1.3))
    path = maneuver_path_deg(ROBOT, Maneuver(strokes))
    assert np.allclose(path[[0, -1]], 0.0, atol=1e-9)
    assert path.max(axis=0) == pytest.approx([40.0, 30.0, 0.0], abs=1e-6)
