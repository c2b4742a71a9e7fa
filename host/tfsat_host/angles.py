"""Angles that differ by whole turns are one."""

from __future__ import annotations

import numpy as np

from tfsat_host.arrays import FloatArray


def wrap_angle(angle_rad: FloatArray) -> FloatArray:
    """Wrap angles to [-pi, pi); NaN stays."""
    return np.asarray(np.mod(angle_rad + np.pi, 2.0 * np.pi) - np.pi)
