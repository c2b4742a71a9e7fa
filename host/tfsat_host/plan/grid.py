"""Which rotations four-stroke loops give: every ordered pair of joints, every pair of displacements of a grid.

Paper, section "Expected on-orbit performance": joints in steps of 5 deg, loops of four strokes, all joint pairs;
efficiency is the reorientation's angle divided by all that the joints turn. Rates and errors follow in proportion.

    found = distribution(Multibody.of(robot), robot.joint_limits_rad, step_deg=5.0)
    found.maneuver(found.best_by_efficiency)
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import FloatArray, IntArray
from tfsat_host.dynamics import Multibody, quaternion, rotation_angle_rad, rotation_vector_rad
from tfsat_host.dynamics.components import batch_first
from tfsat_host.dynamics.euler import euler_zyx_rad
from tfsat_host.dynamics.stroke import Hinge, rotate_base
from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.robot import RobotModel

# So long a step of order 6 leaves a tenth of the 1e-6 deg that the whole loop may be wrong by.
_MAX_CELL_DEG = 5.0
# A limit of 90 deg is 18 steps of 5 deg although neither is an exact binary number of radians.
_ROUNDING = 1e-9


class OrbitError(TfsatError):
    """The grid, the target or the robot does not allow an answer (exit code 1)."""


class GridAxis(NamedTuple):
    """One joint's displacements: `up` multiples of the step above the start pose, `down` below it."""

    up: int
    down: int
    step_rad: float

    @property
    def displacements_rad(self) -> FloatArray:
        """(up + down,): step, 2 step, ..., then -step, -2 step, ..."""
        return self.step_rad * np.concatenate([np.arange(1, self.up + 1), -np.arange(1, self.down + 1)])


def grid_axes(limits_rad: FloatArray, start_rad: FloatArray, step_deg: float) -> list[GridAxis]:
    """Build the grid axes of joints with limits (n, 2) from start angles (n,).

    An axis holds all multiples of the step within the limits; a limit that is not a multiple is not on the
    grid.

    Raises:
        OrbitError: the step is not a positive number, or fewer than two joints have room for it.
    """
    if not (math.isfinite(step_deg) and step_deg > 0.0):
        raise OrbitError(
            what=f"A grid step of {step_deg:g} deg is not above zero.",
            meaning="Nothing was computed.",
            next_step="Give a step such as 5.",
        )
    step = math.radians(step_deg)
    # (n, 2) in steps, signed; the tolerance keeps a limit that is a multiple of the step.
    room = (limits_rad - start_rad[:, None]) / step
    axes = [
        GridAxis(max(math.floor(above + _ROUNDING), 0), max(math.floor(-below + _ROUNDING), 0), step)
        for below, above in room
    ]
    if sum(axis.up + axis.down > 0 for axis in axes) < 2:
        raise OrbitError(
            what=f"Fewer than two joints can move by {step_deg:g} deg from the start pose.",
            meaning="A loop that turns the robot takes two joints.",
            next_step="Give a smaller step, or wider limits_deg in the robot file.",
        )
    return axes


@dataclass(frozen=True, eq=False)
class Lines:
    """Rotations of the base by every stroke of one joint from its start angle along the grid's lines.

    Attributes:
        alone: (4, N) quaternions by displacement, all other joints at their start angles.
        displaced: By another joint: (4, M, N), with that joint displaced by its m-th displacement.
    """

    alone: FloatArray
    displaced: dict[int, FloatArray]


def lines_of(body: Multibody, joint: int, axes: list[GridAxis], start_rad: FloatArray) -> Lines:
    """Compute the base's rotations by strokes along `joint` at all grid displacements of other joints.

    All cells of the grid are integrated once, in one batch; the strokes are running products.
    """
    others = [other for other in range(body.n_joints) if other != joint]
    shifts = [axes[other].displacements_rad for other in others]
    # Lines side by side: first from the start pose, then by every displacement of every other joint.
    ends = np.cumsum([1, *(len(shift) for shift in shifts)])
    pose = np.repeat(start_rad[:, None], ends[-1], axis=1)
    for other, shift, begin in zip(others, shifts, ends, strict=False):
        pose[other, begin : begin + len(shift)] += shift
    strokes = _along(Hinge.of(body, joint, 1), axes[joint], pose)
    displaced = {
        other: strokes[:, begin:end] for other, begin, end in zip(others, ends[:-1], ends[1:], strict=True)
    }
    return Lines(strokes[:, 0], displaced)


def _along(hinge: Hinge, axis: GridAxis, pose: FloatArray) -> FloatArray:
    """(4, lines, N) strokes of the hinge's joint from poses (n, lines)."""
    # A cell is the last grid step of a stroke: it ends at `to`, and begins one step nearer the start.
    to = axis.displacements_rad
    delta = np.sign(to) * axis.step_rad
    angles = np.repeat(pose[:, :, None], len(to), axis=2)
    angles[hinge.step.joint] += to - delta
    lengths = np.broadcast_to(delta, angles.shape[1:])
    # Divide long cells, so that one step of order 6 keeps its accuracy.
    steps = math.ceil(math.degrees(axis.step_rad) / _MAX_CELL_DEG)
    cells = rotate_base(hinge, angles.reshape(len(pose), -1), lengths.reshape(-1), steps).reshape(
        4, *lengths.shape
    )
    # Running products along both half lines: strokes of every length from single cells.
    for first, end in ((1, axis.up), (axis.up + 1, len(to))):
        for index in range(first, end):
            cells[..., index] = quaternion.product(cells[..., index - 1], cells[..., index])
    return cells


def room_rad(
    robot: RobotModel, joints: Sequence[int] | None = None, limit_deg: Sequence[float] | None = None
) -> FloatArray:
    """Return the least and greatest angles (n, 2) of the robot's joints.

    Joints that may not move stay at their start angle; `joints` are the indices of those that may, all if
    None. `limit_deg` is the greatest displacement of each of these, to both sides of its start angle; the
    robot's own limits hold in any case.

    Raises:
        UsageError: the joints are not the robot's, or the limits do not fit them.
    """
    chosen = list(range(robot.n_joints) if joints is None else joints)
    if len(set(chosen)) < max(len(chosen), 2) or not all(0 <= joint < robot.n_joints for joint in chosen):
        raise UsageError(
            what=f"{robot.name} has joints 1 to {robot.n_joints}; a loop takes two or more different ones of them.",
            meaning="Nothing was computed.",
            next_step="Give their numbers, such as --joints 1,2, or leave --joints out.",
        )
    start = np.array([servo.start_rad for servo in robot.servos])
    # Joints that are not chosen get a range without width, and so no displacements.
    room = np.repeat(start[:, None], 2, axis=1)
    room[chosen] = robot.joint_limits_rad[chosen]
    if limit_deg is None:
        return room
    if len(limit_deg) != len(chosen) or not all(math.isfinite(limit) and limit > 0.0 for limit in limit_deg):
        limits_text = ",".join(f"{limit:g}" for limit in limit_deg)
        raise UsageError(
            what=f"{len(chosen)} joints move, and the limits are {limits_text}: each needs one, above zero.",
            meaning="Nothing was computed.",
            next_step=f"Give {len(chosen)} angles in deg, such as --limit {','.join(['30'] * len(chosen))}.",
        )
    limit = np.radians(np.array(limit_deg))
    # What is asked for can only narrow the robot's own limits.
    room[chosen, 0] = np.maximum(room[chosen, 0], start[chosen] - limit)
    room[chosen, 1] = np.minimum(room[chosen, 1], start[chosen] + limit)
    return room


_MAX_MANEUVERS = 1_000_000
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
        """Return one loop of the distribution, in degrees."""
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
    """Compute all four-stroke loops on a grid.

    Args:
        body: One robot (no batch).
        limits_rad: (n, 2) least and greatest angle of each joint.
        step_deg: Grid step; displacements are its nonzero multiples within the limits, to both sides of the
            start pose.
        start_rad: (n,) start pose; zero if None.

    Returns:
        The loops, pair by pair in lexical order, within a pair by alpha. Joints without room for a
        step have no loops.

    Raises:
        OrbitError: the grid has no loop, or more than a million.
    """
    start = np.zeros(body.n_joints) if start_rad is None else np.asarray(start_rad, dtype=np.float64)
    axes = grid_axes(np.asarray(limits_rad, dtype=np.float64), start, step_deg)
    _check_size(axes, step_deg)
    # Integrate every stroke once; all loops are products of these.
    lines = [lines_of(body, joint, axes, start) for joint in range(body.n_joints)]
    loops: dict[tuple[int, int], FloatArray] = {}
    for i, j in combinations(range(body.n_joints), 2):
        # Along i, along j displaced by i, back along i displaced by j, back along j.
        out = quaternion.product(lines[i].alone[:, :, None], lines[j].displaced[i])
        other = quaternion.product(lines[j].alone[:, None, :], lines[i].displaced[j].swapaxes(1, 2))
        loop = quaternion.product(out, quaternion.inverse(other))
        loops[i, j] = loop
        # The pair j, i is the same loop backwards: its inverse, with alpha and beta exchanged.
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
    # Ordered pairs of different joints: all pairs less those of a joint with itself.
    loops = sum(counts) ** 2 - sum(count * count for count in counts)
    if loops > _MAX_MANEUVERS:
        # The count falls with the square of the step, so its square root scales the advice.
        raise OrbitError(
            what=f"A grid of {step_deg:g} deg has {loops} maneuvers; this works with up to {_MAX_MANEUVERS}.",
            meaning="Nothing was computed.",
            next_step=f"Give a step of at least {step_deg * (loops / _MAX_MANEUVERS) ** 0.5 * 1.005:.3g} deg.",
        )
