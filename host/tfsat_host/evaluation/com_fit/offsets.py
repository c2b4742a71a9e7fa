"""By how much the robot model may be off: the paper's centers of mass, and all else that its file calls uncertain.

The offsets that the paper corrects are the centers of mass of bodies 1 to 3. Masses, inertias, hinge points and the
center of mass of body 4 are nuisance parameters: the fit holds them within what the robot file's `[uncertainty]` says
of them, so that what they make uncertain is in the covariance of the others. The hinges' axes are among the errors of
the sensors (`motion/error_model.py`), as the rates of neighbouring bodies tell them.

No values make a body that cannot exist. A mass is multiplied by e^x. An inertia tensor I has the second moments

    S = tr(I) / 2 1 - I = L L^T,    S' = L e^E L^T

with E symmetric: S' stays positive definite, which is the triangle inequality of I' (as the log-Cholesky parameters of
C. Rucker, P. Wensing, Smooth Parameterization of Rigid-Body Inertia, IEEE RA-L 7, 2022, at a fixed center of mass).
Entries of E that are independent, those off the diagonal with half the variance, prefer no axes.

A hinge moves square to its axis: along it the point is free.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from scipy.linalg import expm

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics.multibody import Multibody, across
from tfsat_host.robot import ASSUMED, RobotModel, Uncertainty
from tfsat_host.robot.absent_parts import bodies_of

COM_BOUND_M = 0.010
"""Within it the paper searches (section Result, d = 10 mm)."""
COM_BODIES = (1, 2, 3)
"""Body 4 does not move with respect to body 3 in the paper's maneuver, so nothing tells its offset from body 3's."""
Kind = Literal["com", "mass", "inertia", "point"]


class Parameter(NamedTuple):
    """One number by which a model may be off.

    Attributes:
        name: Such as `body 2 CoM z`.
        unit: mm or %.
        kind: Of number.
        of: Index of the body or the joint.
        shape: What one SI unit adds: (3,) to a point, (3, 3) to E of an inertia, () to the logarithm of a mass.
        prior_std: In the unit, about zero.
        bound: Greatest magnitude in the unit; infinite without one.
    """

    name: str
    unit: str
    kind: Kind
    of: int
    shape: FloatArray
    prior_std: float
    bound: float = np.inf

    @property
    def si(self) -> float:
        """What one unit is in SI."""
        return 1e-3 if self.unit == "mm" else 0.01


@dataclass(frozen=True, eq=False)
class Offsets:
    """p numbers by which a model may be off.

    Attributes:
        parameters: p, first those that are sought.
        body: The model without offsets.
        sought: How many are corrected as the paper does; the others are nuisance parameters.
    """

    parameters: tuple[Parameter, ...]
    body: Multibody
    sought: int

    def __len__(self) -> int:
        return len(self.parameters)

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters; `units`, `kinds`, `prior_std` and `bounds` likewise."""
        return tuple(parameter.name for parameter in self.parameters)

    @property
    def units(self) -> tuple[str, ...]:
        return tuple(parameter.unit for parameter in self.parameters)

    @property
    def kinds(self) -> tuple[Kind, ...]:
        return tuple(parameter.kind for parameter in self.parameters)

    @property
    def prior_std(self) -> FloatArray:
        return np.array([parameter.prior_std for parameter in self.parameters])

    @property
    def bounds(self) -> FloatArray:
        return np.array([parameter.bound for parameter in self.parameters])

    @property
    def alone(self) -> Offsets:
        """Those that are sought, without the nuisance parameters."""
        return replace(self, parameters=self.parameters[: self.sought])

    def apply(self, vectors: FloatArray) -> Multibody:
        """Build one robot for each of the vectors (..., p), in units.

        The batch axes lead, with one more for samples.
        """
        return self._with(vectors, sampled=True)

    def correct(self, vector: FloatArray) -> Multibody:
        """Build the robot corrected by one vector (p,) of offsets."""
        return self._with(vector, sampled=False)

    def inertia_slope(self, parameter: Parameter, vector: FloatArray) -> FloatArray:
        """(3, 3) of a body's tensor at offsets (p,) by one entry of its E, SI; to second order in E."""
        root = _root(self.body.inertia_kg_m2[parameter.of])
        # All entries of this body's strain together: the slope is taken at the offsets reached.
        strain = sum(
            value * other.si * other.shape
            for value, other in zip(vector, self.parameters, strict=True)
            if other.kind == "inertia" and other.of == parameter.of
        )
        # Symmetrize e^E X: the slope of the exponential, but for terms of second order in E.
        half = expm(strain) @ parameter.shape
        return _inertia(root @ (0.5 * (half + half.T)) @ root.T)

    def _with(self, vectors: FloatArray, *, sampled: bool) -> Multibody:
        lead, body = vectors.shape[:-1], self.body
        # Sum up what the parameters add: to points in m, to masses and tensors in the exponent.
        moved: dict[Kind, FloatArray] = {
            "com": _repeat_axes(body.com_m, lead),
            "point": _repeat_axes(body.joint_point_m, lead),
            "mass": np.zeros((*lead, body.n_bodies)),
            "inertia": np.zeros((*lead, *body.inertia_kg_m2.shape)),
        }
        for index, parameter in enumerate(self.parameters):
            value = parameter.si * vectors[..., index]
            # Index past the batch axes: each robot's value times the parameter's shape.
            moved[parameter.kind][(slice(None),) * len(lead) + (parameter.of,)] += np.multiply.outer(
                value, parameter.shape
            )
        # Exponentials keep masses positive and tensors physical, however far a step of the fit goes.
        fields = {
            "com_m": moved["com"],
            "joint_point_m": moved["point"],
            "mass_kg": body.mass_kg * np.exp(moved["mass"]),
            "inertia_kg_m2": _strain_inertia(body.inertia_kg_m2, moved["inertia"]),
        }
        if sampled:
            fields = {name: np.expand_dims(values, len(lead)) for name, values in fields.items()}
        return body.replace(**fields)


def _repeat_axes(values: FloatArray, lead: tuple[int, ...]) -> FloatArray:
    return np.broadcast_to(values, (*lead, *values.shape)).copy()


def _strain_inertia(inertia: FloatArray, strain: FloatArray) -> FloatArray:
    """(..., n, 3, 3) tensors with S' = L e^E L^T; `inertia` (n, 3, 3), E `strain` (..., n, 3, 3)."""
    root = _root(inertia)
    # A tensor without strain stays as filed to the last digit: the root would round it.
    return np.where(
        strain.any(axis=(-1, -2), keepdims=True),
        _inertia(root @ expm(strain) @ root.swapaxes(-1, -2)),
        inertia,
    )


def _root(inertia: FloatArray) -> FloatArray:
    """L (..., 3, 3) of the second moments L L^T of an inertia tensor; a rod or a plate has none in a direction."""
    moments, axes = np.linalg.eigh(_complement(inertia))
    return np.asarray(axes * np.sqrt(np.maximum(moments, 0.0))[..., None, :])


def _complement(tensor: FloatArray) -> FloatArray:
    """tr(T) / 2 1 - T: second moments (..., 3, 3) of a body's inertia tensor."""
    return np.asarray(0.5 * np.trace(tensor, axis1=-2, axis2=-1)[..., None, None] * np.eye(3) - tensor)


def _inertia(moments: FloatArray) -> FloatArray:
    """tr(S) 1 - S: the inertia tensor (..., 3, 3) of a body with those second moments."""
    return np.asarray(np.trace(moments, axis1=-2, axis2=-1)[..., None, None] * np.eye(3) - moments)


def model_offsets(model: RobotModel) -> Offsets:
    """Build the paper's nine offsets and the nuisance parameters whose uncertainty the robot file states.

    A stated uncertainty of 0 takes the parameters for exact; a file that states none is taken to be as
    uncertain as `ASSUMED`. The priors of the centers of mass are as wide as a uniform spread over their bounds and
    decide nothing that the data determine.
    """
    bound_mm = 1e3 * COM_BOUND_M
    # A uniform spread over plus and minus d has the standard deviation d / sqrt(3).
    sought = tuple(
        parameter._replace(bound=bound_mm)
        for body in COM_BODIES
        if body in bodies_of(model)
        for parameter in _center(model, body - 1, bound_mm / 3.0**0.5)
    )
    return Offsets(
        (*sought, *_uncertain(model, model.uncertainty or ASSUMED)), Multibody.of(model), len(sought)
    )


def _center(model: RobotModel, b: int, std_mm: float) -> Iterator[Parameter]:
    for axis, direction in zip("xyz", np.eye(3), strict=True):
        yield Parameter(f"{model.body_names[b]} CoM {axis}", "mm", "com", b, direction, std_mm)


def _uncertain(model: RobotModel, stated: Uncertainty) -> Iterator[Parameter]:
    for b, name in enumerate(model.body_names[: len(bodies_of(model))]):
        # The sought centers have their own, wider priors.
        if stated.com_m and b + 1 not in COM_BODIES:
            yield from _center(model, b, 1e3 * stated.com_m)
        if stated.mass_relative:
            yield Parameter(f"{name} mass", "%", "mass", b, np.ones(()), 100.0 * stated.mass_relative)
        if stated.inertia_relative:
            yield from _of_inertia(name, b, 100.0 * stated.inertia_relative)
    if stated.joint_point_m:
        present = zip(model.joint_names, model.joint_axis, model.servos, strict=True)
        for j, (name, axis, servo) in enumerate(present):
            if servo.absent:
                continue
            # Along the axis a hinge point means nothing: two directions each.
            for side in across(axis):
                letter = "xyz"[int(np.argmax(np.abs(side)))]
                yield Parameter(f"{name} point {letter}", "mm", "point", j, side, 1e3 * stated.joint_point_m)


def _of_inertia(name: str, body: int, std_percent: float) -> Iterator[Parameter]:
    """E of one body, so that each moment of a cube has that standard deviation."""
    for i in range(3):
        for k in range(i, 3):
            shape = np.zeros((3, 3))
            shape[i, k] = shape[k, i] = 1.0
            # Twice the variance on the diagonal makes the distribution of E the same in all axes.
            std = std_percent * 2.0**0.5 if i == k else std_percent
            yield Parameter(f"{name} inertia {'xyz'[i]}{'xyz'[k]}", "%", "inertia", body, shape, std)
