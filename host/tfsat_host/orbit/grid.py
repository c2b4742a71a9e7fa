"""How far joints may move, their displacements on a grid, and the rotations along the grid's lines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tfsat_host.dynamics import Multibody, quaternion
from tfsat_host.dynamics.hinge import Hinge
from tfsat_host.dynamics.stroke import turned
from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.robot import RobotModel
from tfsat_host.robot.model import FloatArray

# So long a step of order 6 leaves a tenth of the 1e-6 deg that the whole loop may be wrong by.
_LONGEST_CELL_DEG = 5.0
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
    """The axes of joints with limits (n, 2) from start angles (n,).

    All multiples of the step that the limits allow; a limit that is no multiple is not itself on the grid.

    Raises:
        OrbitError: the step is no positive number, or fewer than two joints have room for it.
    """
    if not (math.isfinite(step_deg) and step_deg > 0.0):
        raise OrbitError(
            what=f"A grid step of {step_deg:g} deg is not above zero.",
            meaning="Nothing was computed.",
            next_step="Give a step such as 5.",
        )
    step = math.radians(step_deg)
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
        beside: By another joint: (4, M, N), with that joint displaced by its m-th displacement.
    """

    alone: FloatArray
    beside: dict[int, FloatArray]


def lines_of(body: Multibody, joint: int, axes: list[GridAxis], start_rad: FloatArray) -> Lines:
    """The lines along `joint`.

    Every cell of the grid is integrated once, all of them together; the strokes are running products.
    """
    others = [other for other in range(body.n_joints) if other != joint]
    shifts = [axes[other].displacements_rad for other in others]
    ends = np.cumsum([1, *(len(shift) for shift in shifts)])
    pose = np.repeat(start_rad[:, None], ends[-1], axis=1)
    for other, shift, begin in zip(others, shifts, ends, strict=False):
        pose[other, begin : begin + len(shift)] += shift
    strokes = _along(Hinge.of(body, joint, 1), axes[joint], pose)
    beside = {
        other: strokes[:, begin:end] for other, begin, end in zip(others, ends[:-1], ends[1:], strict=True)
    }
    return Lines(strokes[:, 0], beside)


def _along(hinge: Hinge, axis: GridAxis, pose: FloatArray) -> FloatArray:
    """(4, lines, N) strokes of the hinge's joint from poses (n, lines)."""
    to = axis.displacements_rad
    delta = np.sign(to) * axis.step_rad
    angles = np.repeat(pose[:, :, None], len(to), axis=2)
    angles[hinge.step.joint] += to - delta
    lengths = np.broadcast_to(delta, angles.shape[1:])
    steps = math.ceil(math.degrees(axis.step_rad) / _LONGEST_CELL_DEG)
    cells = turned(hinge, angles.reshape(len(pose), -1), lengths.reshape(-1), steps).reshape(
        4, *lengths.shape
    )
    for first, end in ((1, axis.up), (axis.up + 1, len(to))):
        for index in range(first, end):
            cells[..., index] = quaternion.product(cells[..., index - 1], cells[..., index])
    return cells


def room_rad(
    robot: RobotModel, joints: Sequence[int] | None = None, limit_deg: Sequence[float] | None = None
) -> FloatArray:
    """Least and greatest angles (n, 2) of the robot's joints; those that may not move stay at their start angle.

    Args:
        robot: Its limits hold in any case.
        joints: Indices of the joints that may move; all if None.
        limit_deg: Greatest displacement of each of `joints`, to both sides of its start angle.

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
    room = np.repeat(start[:, None], 2, axis=1)
    room[chosen] = robot.joint_limits_rad[chosen]
    if limit_deg is None:
        return room
    if len(limit_deg) != len(chosen) or not all(math.isfinite(limit) and limit > 0.0 for limit in limit_deg):
        given = ",".join(f"{limit:g}" for limit in limit_deg)
        raise UsageError(
            what=f"{len(chosen)} joints move, and the limits are {given}: each needs one, above zero.",
            meaning="Nothing was computed.",
            next_step=f"Give {len(chosen)} angles in deg, such as --limit {','.join(['30'] * len(chosen))}.",
        )
    limit = np.radians(np.array(limit_deg))
    room[chosen, 0] = np.maximum(room[chosen, 0], start[chosen] - limit)
    room[chosen, 1] = np.minimum(room[chosen, 1], start[chosen] + limit)
    return room
