"""The rollout that we are measured against does the same maneuver, and does it properly."""

from __future__ import annotations

import numpy as np
import pytest

from tests.validation.design_bench.mujoco_rollout import reorientation_by_rollout
from tfsat_host.dynamics import Multibody, path_rotation, rotation_angle_rad
from tfsat_host.robot import load_robot

STROKES_DEG = [(0, 58.75), (1, 70.29), (0, -58.75), (1, -70.29)]


@pytest.mark.parametrize(("timestep_s", "tolerance_deg"), [(1e-3, 0.03), (1e-4, 0.004)])
def test_a_rollout_finds_our_reorientation_as_its_steps_get_shorter(
    timestep_s: float, tolerance_deg: float
) -> None:
    robot = load_robot()
    joints, deltas_deg = zip(*STROKES_DEG, strict=True)
    ours = path_rotation(Multibody.of(robot), joints, np.radians(deltas_deg))
    rollout = reorientation_by_rollout(robot, STROKES_DEG, 170.0, timestep_s)
    # An integrator of first order: a tenth of the step, a tenth of the error.
    assert rollout.reorientation_deg == pytest.approx(np.degrees(rotation_angle_rad(ours)), abs=tolerance_deg)
    assert rollout.tracking_error_rad < 1e-3
    # Four strokes and 0.1 s of settling.
    assert rollout.steps == pytest.approx((2 * (58.75 + 70.29) / 170.0 + 0.1) / timestep_s, abs=2)
