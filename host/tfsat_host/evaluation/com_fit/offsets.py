"""What in the robot model may be corrected: centers of mass as the paper does it, optionally masses and inertias.

A parameter names the field of the model and the entries that it moves, so that another one (a hinge's point, an axis)
is another row of `com_offsets`: the fit, its covariance and what correlates with what follow from the rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.robot import RobotModel

COM_BOUND_M = 0.010
"""Within it the paper searches (section Result, d = 10 mm)."""
COM_BODIES = (1, 2, 3)
"""Body 4 does not move with respect to body 3 in the paper's maneuver, so nothing tells its offset from body 3's."""
MASS_RELATIVE_STD = 0.02
INERTIA_RELATIVE_STD = 0.03
_ENTRIES = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))

Kind = Literal["com", "mass", "inertia"]
_FIELDS: dict[Kind, str] = {"com": "com_m", "mass": "mass_kg", "inertia": "inertia_kg_m2"}
"""Of `Multibody`."""


class Parameter(NamedTuple):
    """One number by which a model may be off.

    Attributes:
        name: Such as `body 2 CoM z`.
        unit: mm, % or g m^2.
        si: What one unit is in SI.
        kind: Of number.
        entries: Indices into the model's field that are off by it.
    """

    name: str
    unit: str
    si: float
    kind: Kind
    entries: tuple[tuple[int, ...], ...]


@dataclass(frozen=True, eq=False)
class Offsets:
    """p numbers by which a model may be off.

    Attributes:
        parameters: p.
        prior_std: (p,) in their units, about zero.
        bounds: (p,) greatest magnitude in their units; infinite without one.
        body: The model without offsets.
    """

    parameters: tuple[Parameter, ...]
    prior_std: FloatArray
    bounds: FloatArray
    body: Multibody

    def __len__(self) -> int:
        return len(self.parameters)

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters; `units` and `kinds` likewise."""
        return tuple(one.name for one in self.parameters)

    @property
    def units(self) -> tuple[str, ...]:
        return tuple(one.unit for one in self.parameters)

    @property
    def kinds(self) -> tuple[Kind, ...]:
        return tuple(one.kind for one in self.parameters)

    def applied(self, vectors: FloatArray) -> Multibody:
        """One robot for each of the vectors (..., p), in units; the batch axes lead, with one more for samples."""
        lead = vectors.shape[:-1]
        fields = {kind: np.asarray(getattr(self.body, field)) for kind, field in _FIELDS.items()}
        moved = {kind: np.broadcast_to(all_, (*lead, *all_.shape)).copy() for kind, all_ in fields.items()}
        for index, one in enumerate(self.parameters):
            value = vectors[..., index] * one.si
            for entry in one.entries:
                at: Any = (..., *entry)
                if one.kind == "mass":
                    moved[one.kind][at] *= 1.0 + value
                else:
                    moved[one.kind][at] += value
        batch = {_FIELDS[kind]: np.expand_dims(all_, len(lead)) for kind, all_ in moved.items()}
        return self.body.replace(**batch)

    def corrected(self, vector: FloatArray) -> Multibody:
        """The robot with one vector (p,) of offsets."""
        found = self.applied(vector)
        return found.replace(**{field: getattr(found, field)[0] for field in _FIELDS.values()})


def com_offsets(
    model: RobotModel, *, masses: bool = False, inertias: bool = False, bound_m: float = COM_BOUND_M
) -> Offsets:
    """The nine offsets of the paper, and on demand masses and inertias with what the robot file states of them.

    The prior of an offset is as wide as an even spread over its bounds: it decides nothing that the data can tell.
    """
    bound_mm, stated = 1e3 * bound_m, model.uncertainty
    rows: list[tuple[Parameter, float, float]] = [
        (
            Parameter(f"body {body} CoM {axis}", "mm", 1e-3, "com", ((body - 1, part),)),
            bound_mm / 3.0**0.5,
            bound_mm,
        )
        for body in COM_BODIES
        for part, axis in enumerate("xyz")
    ]
    if masses:
        std = 100.0 * (stated.mass_relative if stated and stated.mass_relative else MASS_RELATIVE_STD)
        rows += [
            (Parameter(f"body {b + 1} mass", "%", 0.01, "mass", ((b,),)), std, np.inf)
            for b in range(model.n_bodies)
        ]
    if inertias:
        share = stated.inertia_relative if stated and stated.inertia_relative else INERTIA_RELATIVE_STD
        for b in range(model.n_bodies):
            # An entry off the diagonal is as uncertain as the moments next to it.
            std = 1e3 * share * float(np.trace(model.inertia_kg_m2[b])) / 3.0
            for i, k in _ENTRIES:
                entries = tuple({(b, i, k), (b, k, i)})
                name = f"body {b + 1} inertia {'xyz'[i]}{'xyz'[k]}"
                rows.append((Parameter(name, "g m^2", 1e-3, "inertia", entries), std, np.inf))
    prior, bounds = np.array([row[1:] for row in rows]).T
    return Offsets(tuple(row[0] for row in rows), prior, bounds, Multibody.of(model))
