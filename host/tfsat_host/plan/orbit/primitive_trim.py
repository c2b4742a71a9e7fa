"""A primitive off the grid: its displacements solved for the rotation that is left."""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import quaternion
from tfsat_host.plan.orbit.chain_search import nearest
from tfsat_host.plan.orbit.primitives import Primitive, PrimitiveTable

# The nearest primitives of so many shapes are tried: some have a joint at its limit, or too little to say about an
# axis. Among so many of the nearest they are looked for.
_SHAPES = 6
_CANDIDATES = 200
# Central differences: truncation near 1e-12 and rounding near 1e-10 are far below any tolerance.
_DIFFERENCE_RAD = 1e-6
# The sequencer's resolution is 0.01 deg: what rounds to nothing is not flown.
_STILL_RAD = np.radians(0.005)
# What is left by the model's account matters little below this share of the tolerance. Then the shortest loop is
# best, for the model's errors grow with what the joints turn.
SHARE_OF_TOLERANCE = 0.25


def trim_primitive(
    table: PrimitiveTable, needed: FloatArray, tolerance_rad: float
) -> tuple[Primitive, float]:
    """Fit the displacements of a primitive to a rotation; return it and the remaining angle in rad.

    Args:
        table: Its primitives are the starting points; its body, limits and start pose apply.
        needed: (4,) the rotation, body axes.
        tolerance_rad: Of the solutions that leave a quarter of this or less, the shortest is taken.
    """
    # Several starts, the nearest primitive of each shape: a solution cannot change its order of strokes.
    near = nearest(table, needed, _CANDIDATES)
    _, first = np.unique(table.shape[near], return_index=True)
    starts = near[np.sort(first)[:_SHAPES]]
    tries = [_solve_primitive(table, table.primitive(int(index)), needed) for index in starts]
    # Solutions well inside the tolerance are equally good by the model: fly the shortest of them.
    enough = max(min(remaining for _, remaining in tries), SHARE_OF_TOLERANCE * tolerance_rad)
    return min(
        (solution for solution in tries if solution[1] <= enough), key=lambda solution: solution[0].duration_s
    )


def _solve_primitive(
    table: PrimitiveTable, primitive: Primitive, needed: FloatArray
) -> tuple[Primitive, float]:
    """Solve for one primitive's displacements by least squares, within the joints' limits."""
    shape = primitive.shape
    joints = list(shape.joints)
    low, high = (table.limits_rad[joints] - table.start_rad[joints, None]).T

    # One batch of 2 d + 1 columns gives the residual and both sides of its central differences.
    shifts = _DIFFERENCE_RAD * np.hstack(
        [np.zeros((len(joints), 1)), np.eye(len(joints)), -np.eye(len(joints))]
    )
    # `least_squares` asks for the Jacobian in a call of its own: keep it by the bits of its argument.
    slope_cache: dict[bytes, FloatArray] = {}

    def residual(displacement: FloatArray) -> FloatArray:
        """Rotation vector (3,) that displacements (d,) leave; its slopes come with it, at the price of a call."""
        undone = quaternion.inverse(table.rotations(shape, displacement[:, None] + shifts))
        vectors = quaternion.logarithm(quaternion.product(undone, needed[:, None]))
        forward, backward = np.split(vectors[:, 1:], 2, axis=1)
        slope_cache[displacement.tobytes()] = np.asarray((forward - backward) / (2.0 * _DIFFERENCE_RAD))
        return np.asarray(vectors[:, 0])

    def slopes(displacement: FloatArray) -> FloatArray:
        return slope_cache[displacement.tobytes()]

    # The residual is a rotation vector, its length the angle that is left.
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
    # Judge what is flown: the rotation after small strokes were set to zero.
    trimmed = table.primitive_of(shape, np.where(np.abs(solved) < _STILL_RAD, 0.0, solved))
    undone_xyzw = quaternion.inverse(trimmed.quaternion_xyzw)
    return trimmed, float(quaternion.angle(quaternion.product(undone_xyzw, needed)))
