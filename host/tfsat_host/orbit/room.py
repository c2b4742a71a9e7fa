"""How far joints may move, when not all of them may, or not to the end of their range."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from tfsat_host.dynamics.components import FloatArray
from tfsat_host.errors import UsageError
from tfsat_host.robot import RobotModel


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
