"""Euler angles z-y-x, up to the attitudes where they lock."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tfsat_host.dynamics.euler import euler_zyx_rad


def test_they_are_scipys_intrinsic_zyx() -> None:
    turns = Rotation.random(200, rng=np.random.default_rng(1))
    assert euler_zyx_rad(turns.as_matrix()) == pytest.approx(turns.as_euler("ZYX"), abs=1e-12)


@pytest.mark.parametrize("y_deg", [90.0, -90.0, 89.9999999999])
def test_where_z_and_x_turn_about_one_axis_they_still_give_the_rotation(y_deg: float) -> None:
    turn = Rotation.from_euler("ZYX", [30.0, y_deg, -50.0], degrees=True)
    angles = euler_zyx_rad(turn.as_matrix())
    assert angles[2] == 0.0
    assert Rotation.from_euler("ZYX", angles).as_matrix() == pytest.approx(turn.as_matrix(), abs=1e-9)
