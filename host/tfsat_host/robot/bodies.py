"""A body's entries: its inertia tensor and its shape."""

from __future__ import annotations

from itertools import product

import numpy as np

from tfsat_host.config import Table
from tfsat_host.robot.model import FloatArray, frozen

BODY = "name mass_kg origin_mm com_mm inertia_g_m2 boxes_mm"
_ENTRIES = ("xx", "xy", "xz", "yy", "yz", "zz")
# Printed inertias are rounded; a rod's or a plate's sits on the limit of the triangle inequality.
_TRIANGLE_TOLERANCE = 1e-6


def inertia_kg_m2(body: Table, *, negated: bool) -> FloatArray:
    """The body's tensor (3, 3) about its center of mass; `negated`: the file gives products of inertia.

    Raises:
        RobotFileError: it is incomplete, or no rigid body's: not positive definite, or against the triangle
            inequality.
    """
    entries = body.table("inertia_g_m2", " ".join(_ENTRIES))
    upper = np.zeros((3, 3))
    upper[np.triu_indices(3)] = [entries.number(key) * 1e-3 for key in _ENTRIES]
    diagonal, products = np.diag(np.diag(upper)), np.triu(upper, 1) * (-1.0 if negated else 1.0)
    tensor = diagonal + products + products.T
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
    return tensor


def shape_m(body: Table) -> FloatArray:
    """All corners of the body's boxes, (k, 3) in the body frame; (0, 3) if the file states no box.

    Raises:
        RobotFileError: a box is none, or the center of mass lies outside of all that they can enclose.
    """
    if not body.has("boxes_mm"):
        return frozen([], 0, 3)
    wanted = "boxes, each as its lowest and highest corner: [[[xmin, ymin, zmin], [xmax, ymax, zmax]]]"
    boxes = body.array("boxes_mm", -1, 2, 3, wanted=wanted)
    if not (boxes[:, 0] < boxes[:, 1]).all():
        body.fail("boxes_mm", "a box has no volume", "Write each box's lowest corner first.")
    com_mm = body.array("com_mm", 3)
    if (com_mm < boxes.min(axis=(0, 1))).any() or (com_mm > boxes.max(axis=(0, 1))).any():
        body.fail(
            "boxes_mm",
            "the center of mass lies outside of the boxes",
            "Give boxes_mm and com_mm in the same frame, the body's, and boxes that hold the whole body.",
        )
    corners = [corner for low, high in boxes for corner in product(*zip(low, high, strict=True))]
    return frozen(np.array(corners) * 1e-3, -1, 3)
