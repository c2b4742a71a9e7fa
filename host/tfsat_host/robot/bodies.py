"""A body's entries: its inertia tensor and its shape."""

from __future__ import annotations

from itertools import product

import numpy as np

from tfsat_host.robot.arrays import frozen
from tfsat_host.robot.checks import check_inertia
from tfsat_host.robot.entries import Entry
from tfsat_host.robot.model import FloatArray

_AXES = ("x", "y", "z")


def products_are_negated(top: Entry) -> bool:
    """Whether the file's off-diagonal entries are products of inertia, which stand negated in the tensor.

    Raises:
        RobotFileError: the file does not say.
    """
    meaning = top.text("inertia_off_diagonals")
    if meaning not in ("products", "tensor"):
        top.fail("inertia_off_diagonals", f"{meaning!r} is neither", 'Write "products" or "tensor".')
    return meaning == "products"


def inertia_kg_m2(body: Entry, *, negated: bool) -> FloatArray:
    """The body's tensor (3, 3) about its center of mass.

    Raises:
        RobotFileError: it is incomplete, or no rigid body's.
    """
    entries = body.table("inertia_g_m2")
    tensor = np.zeros((3, 3))
    for i in range(3):
        for k in range(i, 3):
            value = entries.number(_AXES[i] + _AXES[k]) * 1e-3
            tensor[i, k] = tensor[k, i] = -value if negated and i != k else value
    entries.done()
    check_inertia(body, tensor)
    return tensor


def shape_m(body: Entry) -> FloatArray:
    """All corners of the body's boxes, (k, 3) in the body frame; (0, 3) if the file states no box.

    Raises:
        RobotFileError: a box is none, or the center of mass lies outside of all that they can enclose.
    """
    boxes = body.boxes("boxes_mm")
    corners = [corner for low, high in boxes for corner in product(*zip(low, high, strict=True))]
    shape = frozen(corners, (-1, 3))
    if len(shape):
        com_mm = body.vector("com_mm")
        if (com_mm < shape.min(axis=0)).any() or (com_mm > shape.max(axis=0)).any():
            body.fail(
                "boxes_mm",
                "the center of mass lies outside of the boxes",
                "Give boxes_mm and com_mm in the same frame, the body's, and boxes that hold the whole body.",
            )
    return frozen(shape * 1e-3, (-1, 3))
