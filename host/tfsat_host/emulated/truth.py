"""The emulated robot's truth, to judge what the instruments made of it."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

FloatArray = NDArray[np.float64]

BODY_1_ATTITUDE = slice(4, 8)
"""Columns of body 1's quaternion (x, y, z, w) in a row of truth."""


def true_reorientation_deg(truth: FloatArray, released_s: float, until_s: float) -> float:
    """Rotation of body 1 from the release to `until_s` after it, deg.

    Args:
        truth: See `EmulatedRobot.truth`.
        released_s: Virtual time of the release.
        until_s: After the release.
    """
    first, last = (int(np.argmin(np.abs(truth[:, 0] - t_s))) for t_s in (released_s, released_s + until_s))
    start, end = Rotation.from_quat(truth[[first, last], BODY_1_ATTITUDE])
    return float(np.rad2deg((start.inv() * end).magnitude()))


def format_truth(truth: FloatArray, released_s: float) -> str:
    """CSV: time after release, joint angles in deg, attitudes as quaternions, body rates in deg/s."""
    names = ["t_s", *(f"joint_{i}_deg" for i in range(1, 4))]
    names += [f"body_{i}_q{axis}" for i in range(1, 5) for axis in "xyzw"]
    names += [f"body_{i}_rate_{axis}_deg_s" for i in range(1, 5) for axis in "xyz"]
    rows = truth.copy()
    rows[:, 0] -= released_s
    rows[:, 1:4] = np.rad2deg(rows[:, 1:4])
    rows[:, 20:32] = np.rad2deg(rows[:, 20:32])
    text = io.StringIO()
    np.savetxt(text, rows, fmt="%.9g", delimiter=",", header=",".join(names), comments="")
    return text.getvalue()
