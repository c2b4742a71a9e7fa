"""What in the robot model may be corrected: centers of mass as the paper does it, optionally masses and inertias."""

from __future__ import annotations

from dataclasses import dataclass

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


@dataclass(frozen=True, eq=False)
class Offsets:
    """p numbers by which a model may be off.

    Attributes:
        names: p, such as `body 2 CoM z`.
        units: p: mm, % or g m^2.
        si: (p,) what one unit is in SI.
        prior_std: (p,) in those units, about zero.
        bounds: (p,) greatest magnitude in those units; infinite without one.
        body: The model without offsets.
        kinds: p of `com`, `mass`, `inertia`.
        places: p indices of what each one is of: body and component.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    si: FloatArray
    prior_std: FloatArray
    bounds: FloatArray
    body: Multibody
    kinds: tuple[str, ...]
    places: tuple[tuple[int, int], ...]

    def __len__(self) -> int:
        return len(self.names)

    def applied(self, vectors: FloatArray) -> Multibody:
        """One robot for each of the vectors (..., p), in units; the batch axes lead, with one more for samples."""
        lead = vectors.shape[:-1]
        bodies = self.body.n_bodies
        com = np.broadcast_to(self.body.com_m, (*lead, bodies, 3)).copy()
        mass = np.broadcast_to(self.body.mass_kg, (*lead, bodies)).copy()
        inertia = np.broadcast_to(self.body.inertia_kg_m2, (*lead, bodies, 3, 3)).copy()
        for index, (kind, (body, part)) in enumerate(zip(self.kinds, self.places, strict=True)):
            value = vectors[..., index] * self.si[index]
            if kind == "com":
                com[..., body, part] += value
            elif kind == "mass":
                mass[..., body] *= 1.0 + value
            else:
                row, column = _ENTRIES[part]
                inertia[..., body, row, column] += value
                if row != column:
                    inertia[..., body, column, row] += value
        return self.body.replace(
            com_m=com[..., None, :, :], mass_kg=mass[..., None, :], inertia_kg_m2=inertia[..., None, :, :, :]
        )

    def corrected(self, vector: FloatArray) -> Multibody:
        """The robot with one vector (p,) of offsets."""
        found = self.applied(vector)
        return found.replace(
            com_m=found.com_m[0], mass_kg=found.mass_kg[0], inertia_kg_m2=found.inertia_kg_m2[0]
        )


def com_offsets(
    model: RobotModel, *, masses: bool = False, inertias: bool = False, bound_m: float = COM_BOUND_M
) -> Offsets:
    """The nine offsets of the paper, and on demand masses and inertias with what the robot file states of them.

    The prior of an offset is as wide as an even spread over its bounds: it decides nothing that the data can tell.
    """
    rows: list[tuple[str, str, float, float, float, str, tuple[int, int]]] = [
        (
            f"body {body} CoM {axis}",
            "mm",
            1e-3,
            1e3 * bound_m / 3.0**0.5,
            1e3 * bound_m,
            "com",
            (body - 1, part),
        )
        for body in COM_BODIES
        for part, axis in enumerate("xyz")
    ]
    stated = model.uncertainty
    if masses:
        std = 100.0 * (stated.mass_relative if stated and stated.mass_relative else MASS_RELATIVE_STD)
        rows += [
            (f"body {b + 1} mass", "%", 0.01, std, np.inf, "mass", (b, 0)) for b in range(model.n_bodies)
        ]
    if inertias:
        share = stated.inertia_relative if stated and stated.inertia_relative else INERTIA_RELATIVE_STD
        for b in range(model.n_bodies):
            # An entry off the diagonal is as uncertain as the moments next to it.
            std = 1e3 * share * float(np.trace(model.inertia_kg_m2[b])) / 3.0
            rows += [
                (
                    f"body {b + 1} inertia {'xyz'[i]}{'xyz'[k]}",
                    "g m^2",
                    1e-3,
                    std,
                    np.inf,
                    "inertia",
                    (b, part),
                )
                for part, (i, k) in enumerate(_ENTRIES)
            ]
    names, units, si, prior, bounds, kinds, places = zip(*rows, strict=True)
    return Offsets(
        tuple(names),
        tuple(units),
        np.array(si),
        np.array(prior),
        np.array(bounds),
        Multibody.of(model),
        tuple(kinds),
        tuple(places),
    )
