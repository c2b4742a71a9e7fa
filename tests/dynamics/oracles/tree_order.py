"""Bodies from the base outwards: how simulators want a tree, whichever way its hinges count."""

from __future__ import annotations

from typing import NamedTuple

from tfsat_host.robot import RobotModel


class Branch(NamedTuple):
    """`joint` carries `child` on `parent`; `sign` is -1 where its angle is the parent's relative to the child."""

    joint: int
    parent: int
    child: int
    sign: float


def branches(robot: RobotModel) -> list[Branch]:
    """Return every joint once, a parent always before its children."""
    ends = list(enumerate(zip(robot.joint_inner.tolist(), robot.joint_outer.tolist(), strict=True)))
    tree_branches: list[Branch] = []
    placed = {robot.base}
    # Until every body has a parent that is placed.
    while len(placed) < robot.n_bodies:
        for joint, (inner, outer) in ends:
            if inner in placed and outer not in placed:
                # The sign turns the angle where the file counts it the other way.
                tree_branches.append(Branch(joint, inner, outer, 1.0))
                placed.add(outer)
            elif outer in placed and inner not in placed:
                tree_branches.append(Branch(joint, outer, inner, -1.0))
                placed.add(inner)
    return tree_branches
