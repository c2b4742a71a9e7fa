"""What a wrong joint angle makes of rates that are carried over it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.motion.fusion import Fused

FloatArray = NDArray[np.float64]

_STEP_RAD = 1e-4


def rates_by_angles(
    fused_at: Callable[[FloatArray], Fused], angles_rad: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """(n, 6, 3) base and joint rates, and (n, 4, 3, 3) the bodies' rates that follow, by the joint angles.

    Args:
        fused_at: The rates from the same readings at other joint angles (n, 3).
        angles_rad: (n, 3).
    """
    both, bodies = [], []
    for step in _STEP_RAD * np.eye(angles_rad.shape[1]):
        high, low = fused_at(angles_rad + step), fused_at(angles_rad - step)
        base = high.base_rate_rad_s - low.base_rate_rad_s
        both.append(np.concatenate([base, high.joint_rate_rad_s - low.joint_rate_rad_s], axis=1))
        bodies.append(high.body_rates() - low.body_rates())
    return np.stack(both, axis=-1) / (2.0 * _STEP_RAD), np.stack(bodies, axis=-1) / (2.0 * _STEP_RAD)
