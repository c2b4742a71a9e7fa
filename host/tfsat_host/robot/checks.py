"""What makes numbers a robot: real inertias, and joints that form a tree."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tfsat_host.robot.entries import Entry
from tfsat_host.robot.model import FloatArray, IntArray

# Printed inertias are rounded; a rod's or a plate's sits on the limit of the triangle inequality.
_TRIANGLE_TOLERANCE = 1e-6


def unique_names(entries: Sequence[Entry]) -> tuple[str, ...]:
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


def index_of(entry: Entry, key: str, names: tuple[str, ...], kind: str) -> int:
    """Index in `names` of the body or joint (`kind`) that `key` names.

    Raises:
        RobotFileError: there is none of that name.
    """
    name = entry.text(key)
    if name not in names:
        known = ", ".join(names) or "none"
        entry.fail(key, f"there is no {kind} {name!r}", f"Name an existing {kind} ({known}), or add it.")
    return names.index(name)


def check_inertia(body: Entry, tensor: FloatArray) -> None:
    """A rigid body's tensor (3, 3) is positive definite and obeys the triangle inequality.

    Raises:
        RobotFileError: it does not.
    """
    principal = np.linalg.eigvalsh(tensor)
    shown = ", ".join(f"{1e3 * p:.4g}" for p in principal)
    if not principal[0] > 0.0:
        body.fail(
            "inertia_g_m2",
            f"is not positive definite (principal moments {shown} g m^2)",
            "Check the diagonal, and the sign and size of the off-diagonal entries.",
        )
    if principal[0] + principal[1] < principal[2] * (1.0 - _TRIANGLE_TOLERANCE):
        body.fail(
            "inertia_g_m2",
            f"no mass distribution has the principal moments {shown} g m^2: the largest exceeds the sum of "
            "the others",
            "Check the units and the columns; the moments must be about the center of mass.",
        )


def check_tree(
    bodies: Sequence[Entry],
    joints: Sequence[Entry],
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
