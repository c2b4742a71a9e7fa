"""Which rotations four-stroke loops give: every ordered pair of joints, every pair of displacements of a grid.

Paper, section "Expected on-orbit performance": joints in steps of 5 deg, loops of four strokes, all joint pairs;
efficiency is the reorientation's angle divided by all that the joints turn.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.dynamics import Multibody, quaternion, rotation_angle_rad, rotation_vector_rad
from tfsat_host.dynamics.components import batch_first
from tfsat_host.dynamics.euler import euler_zyx_rad
from tfsat_host.orbit.grid import GridAxis, OrbitError, grid_axes, lines_of
from tfsat_host.robot.model import FloatArray, IntArray

_MOST_MANEUVERS = 1_000_000
# Rounding parts the efficiencies of a loop and of the same loop backwards.
_SAME_EFFICIENCY = 1e-9


class GridManeuver(NamedTuple):
    """One loop of the grid: joint i by alpha, joint j by beta, and both back in this order.

    `joints` are indices. `euler_zyx_deg` are about z, y and x.
    """

    joints: tuple[int, int]
    alpha_deg: float
    beta_deg: float
    reorientation_deg: float
    efficiency: float
    rotation_vector_deg: tuple[float, float, float]
    euler_zyx_deg: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Distribution:
    """m loops +alpha_i +beta_j -alpha_i -beta_j.

    Attributes:
        step_deg: Of the grid.
        joints: (m, 2) indices i and j.
        displacement_rad: (m, 2) alpha and beta.
        quaternion_xyzw: (m, 4) from body axes after the loop to body axes before it; of every body the same.
    """

    step_deg: float
    joints: IntArray
    displacement_rad: FloatArray
    quaternion_xyzw: FloatArray

    @cached_property
    def angle_rad(self) -> FloatArray:
        """(m,) reorientation."""
        return rotation_angle_rad(self.quaternion_xyzw)

    @cached_property
    def efficiency(self) -> FloatArray:
        """(m,) reorientation divided by the sum of what the joints turn, there and back."""
        return np.asarray(self.angle_rad / (2.0 * np.abs(self.displacement_rad).sum(axis=1)))

    @cached_property
    def rotation_vector_rad(self) -> FloatArray:
        """(m, 3)."""
        return rotation_vector_rad(self.quaternion_xyzw)

    @cached_property
    def euler_zyx_rad(self) -> FloatArray:
        """(m, 3) about z, y and x."""
        return euler_zyx_rad(Rotation.from_quat(self.quaternion_xyzw).as_matrix())

    @property
    def best_by_efficiency(self) -> int:
        """Index of the most efficient loop, the first of equals: a loop flown backwards is as efficient."""
        return int(np.argmax(self.efficiency))

    @property
    def best_by_angle(self) -> int:
        """Index of the loop that turns farthest, the first of equals."""
        return int(np.argmax(self.angle_rad))

    def most_efficient(self) -> IntArray:
        """Indices of all loops as efficient as the best."""
        return np.flatnonzero(self.efficiency >= self.efficiency.max() * (1.0 - _SAME_EFFICIENCY))

    def best_of_pairs(self) -> list[int]:
        """Index of the most efficient loop of every ordered joint pair, the best pair first."""
        pairs = np.unique(self.joints, axis=0)
        of_pair = [np.flatnonzero((self.joints == pair).all(axis=1)) for pair in pairs]
        best = [int(indices[np.argmax(self.efficiency[indices])]) for indices in of_pair]
        return sorted(best, key=lambda index: -self.efficiency[index])

    def maneuver(self, index: int) -> GridManeuver:
        """One loop, as people read it."""
        alpha, beta = np.degrees(self.displacement_rad[index]).tolist()
        return GridManeuver(
            joints=(int(self.joints[index, 0]), int(self.joints[index, 1])),
            alpha_deg=alpha,
            beta_deg=beta,
            reorientation_deg=float(np.degrees(self.angle_rad[index])),
            efficiency=float(self.efficiency[index]),
            rotation_vector_deg=tuple(np.degrees(self.rotation_vector_rad[index]).tolist()),
            euler_zyx_deg=tuple(np.degrees(self.euler_zyx_rad[index]).tolist()),
        )


def distribution(
    body: Multibody, limits_rad: FloatArray, step_deg: float, *, start_rad: FloatArray | None = None
) -> Distribution:
    """All four-stroke loops on a grid.

    Args:
        body: One robot (no batch).
        limits_rad: (n, 2) least and greatest angle of each joint.
        step_deg: Displacements are its multiples within the limits, 0 excepted, from the start pose to both sides.
        start_rad: (n,) the pose at the start; zero if None.

    Returns:
        The loops, pair by pair in lexical order, within a pair alpha by alpha. Joints without room for a
        step have none.

    Raises:
        OrbitError: there is no loop on this grid, or there are more than a million.
    """
    start = np.zeros(body.n_joints) if start_rad is None else np.asarray(start_rad, dtype=np.float64)
    axes = grid_axes(np.asarray(limits_rad, dtype=np.float64), start, step_deg)
    _check_size(axes, step_deg)
    lines = [lines_of(body, joint, axes, start) for joint in range(body.n_joints)]
    loops: dict[tuple[int, int], FloatArray] = {}
    for i, j in combinations(range(body.n_joints), 2):
        # Along i, along j beside it, back along i beside j, back along j.
        out = quaternion.product(lines[i].alone[:, :, None], lines[j].beside[i])
        other = quaternion.product(lines[j].alone[:, None, :], lines[i].beside[j].swapaxes(1, 2))
        loop = quaternion.product(out, quaternion.inverse(other))
        loops[i, j] = loop
        loops[j, i] = quaternion.inverse(loop).swapaxes(1, 2)
    parts = [_samples(i, j, axes, loops[i, j]) for i, j in sorted(loops)]
    joints, displacements, quaternions = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    return Distribution(step_deg, joints, displacements, quaternions)


def _samples(
    i: int, j: int, axes: list[GridAxis], loop: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Joints, displacements and quaternions, one a row, of loops (4, alphas, betas)."""
    alpha, beta = axes[i].displacements_rad, axes[j].displacements_rad
    grid = np.stack(np.meshgrid(alpha, beta, indexing="ij"), axis=-1).reshape(-1, 2)
    return np.tile(np.array([i, j]), (len(grid), 1)), grid, batch_first(loop).reshape(-1, 4)


def _check_size(axes: list[GridAxis], step_deg: float) -> None:
    counts = [axis.up + axis.down for axis in axes]
    loops = sum(counts) ** 2 - sum(count * count for count in counts)
    if loops > _MOST_MANEUVERS:
        raise OrbitError(
            what=f"A grid of {step_deg:g} deg has {loops} maneuvers; this works with up to {_MOST_MANEUVERS}.",
            meaning="Nothing was computed.",
            next_step=f"Give a step of at least {step_deg * (loops / _MOST_MANEUVERS) ** 0.5 * 1.005:.3g} deg.",
        )
