from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.orbit import euler_zyx_rad, quaternion_of_euler_zyx


def test_angles_and_back_as_scipy_has_them() -> None:
    angles = np.random.default_rng(1).uniform(-1.0, 1.0, (50, 3)) * [np.pi, np.pi / 2, np.pi]
    expected = Rotation.from_euler("ZYX", angles)
    found = quaternion_of_euler_zyx(angles)
    assert (expected.inv() * Rotation.from_quat(found)).magnitude().max() < 1e-12
    assert np.abs(euler_zyx_rad(found) - angles).max() < 1e-9
