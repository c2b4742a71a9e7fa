"""Names of bodies and joints, and the tree that they form."""

from __future__ import annotations

from collections.abc import Sequence

from tfsat_host.config import Table
from tfsat_host.robot.model import IntArray


def unique_names(entries: Sequence[Table]) -> tuple[str, ...]:
    """The `name` of every entry.

    Raises:
        RobotFileError: two have the same.
    """
    names: list[str] = []
    for entry in entries:
        name = entry.text("name")
        if name in names:
            entry.fail("name", f"{name!r} is used twice", "Give each its own name.")
        names.append(name)
    return tuple(names)


def check_tree(
    bodies: Sequence[Table],
    joints: Sequence[Table],
    inner: IntArray,
    outer: IntArray,
    body_names: tuple[str, ...],
) -> None:
    """Joints from `inner` to `outer` (n - 1,) connect all bodies without a loop.

    Raises:
        RobotFileError: a joint closes a loop or joins a body to itself, or a body is not connected.
    """
    group = list(range(len(body_names)))
    for joint, a, b in zip(joints, inner, outer, strict=True):
        if a == b:
            joint.fail("outer", "the joint joins a body to itself", "Name two different bodies.")
        if group[a] == group[b]:
            joint.fail(
                "outer",
                f"the joint closes a loop: {body_names[a]!r} and {body_names[b]!r} are already connected",
                "Remove one joint of the loop; only open chains and trees can be computed.",
            )
        group = [group[a] if g == group[b] else g for g in group]
    for body, g in enumerate(group):
        if g != group[0]:
            bodies[body].fail(
                "name",
                f"no joint connects {body_names[body]!r} with {body_names[0]!r}",
                "Add the missing `[[joint]]`, or remove the body.",
            )
