"""What the joints do over time while primitives are flown: a file for `simulate --history`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TextIO

import numpy as np

from tfsat_host.dynamics.components import FloatArray
from tfsat_host.orbit.primitives import Primitive, PrimitiveTable

_SAMPLE_S = 0.05
# A spline through fewer samples of a stroke would cut its corners.
_LEAST_SAMPLES = 8


def write_joint_motion(table: PrimitiveTable, primitives: Sequence[Primitive], file: TextIO) -> None:
    """Writes t_s, the angle of every joint in deg and the number of the primitive, from 1.

    Strokes follow one another, each from rest to rest at the joint's average rate. Without primitives the joints
    rest for a second.
    """
    rows = [[0.0, *np.degrees(table.start_rad), 0.0]]
    for number, primitive in enumerate(primitives, start=1):
        for joint, angle in primitive.strokes:
            rows += _stroke(rows[-1], joint, math.degrees(angle), table.joint_rate_rad_s[joint], number)
    if len(rows) == 1:
        rows.append([1.0, *rows[0][1:]])
    joints = ",".join(f"theta{joint + 1}_deg" for joint in range(len(table.start_rad)))
    np.savetxt(
        file,
        np.array(rows),
        fmt=["%.6f", *["%.8f"] * len(table.start_rad), "%d"],
        delimiter=",",
        header=f"t_s,{joints},primitive",
        comments="",
    )


def _stroke(
    before: list[float], joint: int, angle_deg: float, rate_rad_s: float, number: int
) -> list[list[float]]:
    """The rows after `before`, up to the end of one stroke."""
    duration_s = math.radians(abs(angle_deg)) / rate_rad_s
    count = max(math.ceil(duration_s / _SAMPLE_S), _LEAST_SAMPLES)
    share: FloatArray = np.linspace(0.0, 1.0, count + 1)[1:]
    rows = np.tile(np.array(before), (count, 1))
    rows[:, 0] += duration_s * share
    rows[:, 1 + joint] += angle_deg * share * share * (3.0 - 2.0 * share)
    rows[:, -1] = number
    return [[float(value) for value in row] for row in rows]
