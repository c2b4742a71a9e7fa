"""The robot as one rigid body, its joints locked at zero."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tfsat_host.robot.model import FloatArray, RobotModel


@dataclass(frozen=True, eq=False)
class Totals:
    """Mass properties of the whole robot at zero joint angles, global axes.

    `com_m`: (3,) global. `inertia_kg_m2`: (3, 3) tensor about that point.
    """

    mass_kg: float
    com_m: FloatArray
    inertia_kg_m2: FloatArray


def totals(robot: RobotModel) -> Totals:
    """Sums over all bodies, by the parallel axis theorem."""
    com = robot.origin_m + robot.com_m
    mass = float(robot.mass_kg.sum())
    center = robot.mass_kg @ com / mass
    arm = com - center
    squared = np.einsum("ni,ni->n", arm, arm)[:, None, None] * np.eye(3) - arm[:, :, None] * arm[:, None, :]
    inertia = (robot.inertia_kg_m2 + robot.mass_kg[:, None, None] * squared).sum(axis=0)
    return Totals(mass, center, inertia)
