"""The last primitive need not lie on the grid: displacements solved for the rotation that is left."""

from __future__ import annotations

import numpy as np

from tfsat_host.design.loops import Loops
from tfsat_host.dynamics import quaternion
from tfsat_host.orbit.primitives import Primitive, PrimitiveTable
from tfsat_host.orbit.search import nearest
from tfsat_host.robot.model import FloatArray

# The nearest primitives of so many shapes are tried: some have a joint at its limit, or too little to say about an
# axis. Among so many of the nearest they are looked for.
_SHAPES = 6
_NEAREST = 200
_DIFFERENCE_RAD = 1e-6
# The sequencer's resolution is 0.01 deg: what rounds to nothing is not flown.
_STILL_RAD = np.radians(0.005)
# What is left by the model's account matters little below this share of the tolerance. Then the shortest loop is
# best, for the model's errors grow with what the joints turn.
_SHARE_OF_TOLERANCE = 0.25


def trimmed(table: PrimitiveTable, needed: FloatArray, tolerance_rad: float) -> tuple[Primitive, float]:
    """The primitive with free displacements that comes nearest to a rotation, and what it leaves in rad.

    Args:
        table: Its primitives are where the solution starts, its body, limits and start pose what it keeps to.
        needed: (4,) the rotation, body axes.
        tolerance_rad: Of those that leave a quarter of this or less, the shortest is taken.
    """
    near = nearest(table, needed, _NEAREST)
    _, first = np.unique(table.shape[near], return_index=True)
    starts = near[np.sort(first)[:_SHAPES]]
    tries = [_solved(table, table.primitive(int(index)), needed) for index in starts]
    enough = max(min(remaining for _, remaining in tries), _SHARE_OF_TOLERANCE * tolerance_rad)
    return min((found for found in tries if found[1] <= enough), key=lambda found: found[0].duration_s)


def _solved(table: PrimitiveTable, primitive: Primitive, needed: FloatArray) -> tuple[Primitive, float]:
    """Least squares in the displacements of one primitive, within the joints' limits."""
    from scipy.optimize import least_squares

    shape = primitive.shape
    joints = list(shape.joints)
    loops = Loops(table.body, joints, (shape.sequence,), start_rad=table.start_rad, steps=table.steps)
    low, high = (table.limits_rad[joints] - table.start_rad[joints, None]).T

    def left(displacements: FloatArray) -> FloatArray:
        """Rotation vectors (3, b) that displacements (d, b) leave."""
        undone = quaternion.inverse(loops.rotations(displacements)[:, 0])
        return quaternion.logarithm(quaternion.product(undone, needed[:, None]))

    def slopes(displacement: FloatArray) -> FloatArray:
        about = displacement[:, None] + _DIFFERENCE_RAD * np.hstack(
            [np.eye(len(joints)), -np.eye(len(joints))]
        )
        forward, backward = np.split(left(about), 2, axis=1)
        return np.asarray((forward - backward) / (2.0 * _DIFFERENCE_RAD))

    def residual(displacement: FloatArray) -> FloatArray:
        return np.asarray(left(displacement[:, None])[:, 0])

    solution = least_squares(
        residual,
        np.clip(primitive.displacement_rad, low, high),
        jac=slopes,
        bounds=(low, high),
        xtol=1e-12,
        ftol=1e-12,
        gtol=1e-14,
        max_nfev=20,
    )
    solved = np.clip(solution.x, low, high)
    displacement = np.where(np.abs(solved) < _STILL_RAD, 0.0, solved)
    rotation = loops.rotations(displacement[:, None])[:, 0, 0]
    remaining = float(quaternion.angle(quaternion.product(quaternion.inverse(rotation), needed)))
    return Primitive(shape, displacement, rotation, table.duration_of(shape, displacement)), remaining
