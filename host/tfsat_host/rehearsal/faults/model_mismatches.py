"""How a hidden robot can be another one than its file says, which stays as it is.

Where several numbers go wrong, the size is one standard deviation of each, as in a robot file's `[uncertainty]`;
signs, directions and bodies follow from the day's seed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.protocol.limits import IMU_COUNT
from tfsat_host.rehearsal.faults.fault import Size, mismatch
from tfsat_host.rehearsal.truth import CORRECTED_BODIES, Truth
from tfsat_host.robot import RobotModel, Uncertainty
from tfsat_host.robot.model import UNCERTAIN

Random = np.random.Generator
PERCENT, MM, DEG = 1e-2, 1e-3, np.pi / 180.0


def _model(truth: Truth, **fields: Any) -> Truth:
    return replace(truth, model=replace(truth.model, **fields))


def _change_masses(truth: Truth, percent: float, random: Random) -> Truth:
    mass = truth.model.mass_kg
    # Log-normal: no draw makes a mass negative.
    return _model(truth, mass_kg=mass * np.exp(PERCENT * percent * random.standard_normal(mass.shape)))


def _change_inertias(truth: Truth, percent: float, random: Random) -> Truth:
    strain = PERCENT * percent * random.standard_normal((truth.model.n_bodies, 3, 3))
    # (E + E^T) / sqrt 2 of independent normals: symmetric, with a distribution that favours no axes.
    pairs = zip(truth.model.inertia_kg_m2, (strain + strain.swapaxes(1, 2)) / 2.0**0.5, strict=True)
    return _model(truth, inertia_kg_m2=np.array([strained_inertia(*pair) for pair in pairs]))


def strained_inertia(inertia_kg_m2: FloatArray, strain: FloatArray) -> FloatArray:
    """Inertia tensor (3, 3) of a body with the second moments S' = L e^E L^T, where those of `inertia_kg_m2` are L L^T.

    S' is positive definite with S = tr(I) / 2 1 - I, so that no moment is negative or greater than the other two
    together: the body can exist (Wensing, Kim, Slotine, IEEE RA-L 3, 2018).

    `inertia_kg_m2` is about the center of mass; `strain` is E, (3, 3), symmetric.

    Raises:
        numpy.linalg.LinAlgError: no body has `inertia_kg_m2`.
    """
    # L of the second moments S = L L^T; fails for a tensor that no distribution of mass has.
    root = np.linalg.cholesky(_complement(inertia_kg_m2))
    values, axes = np.linalg.eigh(strain)
    # e^E - 1, so that no strain leaves the tensor as it was to the last bit.
    change = root @ (axes * np.expm1(values)) @ axes.T @ root.T
    # From second moments to inertia: I = tr(S) 1 - S, which is linear, so it holds for the change.
    return np.asarray(inertia_kg_m2 + np.trace(change) * np.eye(3) - change)


def _complement(inertia: FloatArray) -> FloatArray:
    return np.asarray(np.trace(inertia) / 2.0 * np.eye(3) - inertia)


def _square_to_axes(model: RobotModel, std: float, random: Random) -> FloatArray:
    """(n - 1, 3) normal in both directions across each joint's axis."""
    # Take out the component along the axis: to shift or scale a hinge along itself changes no motion.
    deviations = std * random.standard_normal(model.joint_axis.shape)
    return np.asarray(
        deviations - np.sum(deviations * model.joint_axis, axis=1, keepdims=True) * model.joint_axis
    )


def _shift_hinges(truth: Truth, mm: float, random: Random) -> Truth:
    moved = _square_to_axes(truth.model, MM * mm, random)
    return _model(truth, joint_point_m=truth.model.joint_point_m + moved)


def _lean_axes(truth: Truth, deg: float, random: Random) -> Truth:
    leaning = truth.model.joint_axis + _square_to_axes(truth.model, DEG * deg, random)
    return _model(truth, joint_axis=leaning / np.linalg.norm(leaning, axis=1, keepdims=True))


def _shift_centers(first: int, end: int) -> Callable[[Truth, float, Random], Truth]:
    def shift(truth: Truth, mm: float, random: Random) -> Truth:
        com = truth.model.com_m.copy()
        com[first:end] += MM * mm * random.standard_normal(com[first:end].shape)
        return _model(truth, com_m=com)

    return shift


def _draw_from_file(truth: Truth, times: float, random: Random) -> Truth:
    """Change every parameter for which the robot file states an uncertainty.

    Centers of mass that are drawn anyway are left out.
    """
    stated = (truth.model.uncertainty or Uncertainty()).figures()
    for key, change in _OF_FILE.items():
        if stated[key]:
            truth = change(truth, times * stated[key] * _SHOWN[key], random)
    return truth


_OF_FILE: Mapping[str, Callable[[Truth, float, Random], Truth]] = {
    "mass_relative": _change_masses,
    "inertia_relative": _change_inertias,
    "joint_point_mm": _shift_hinges,
    "joint_axis_deg": _lean_axes,
    "com_mm": _shift_centers(CORRECTED_BODIES, IMU_COUNT),
}
"""By the key of `[uncertainty]`."""
_SHOWN = {key: 1.0 / PERCENT if key.endswith("_relative") else 1.0 for key in UNCERTAIN}

FAULTS = (
    mismatch(
        "wrong-masses",
        "Each body's mass is another.",
        _change_masses,
        Size(2.0, "%", most=50.0),
    ),
    mismatch(
        "wrong-inertias",
        "Each body's inertia is another.",
        _change_inertias,
        Size(3.0, "%", most=20.0),
    ),
    mismatch(
        "wrong-hinge-points",
        "Each hinge is elsewhere.",
        _shift_hinges,
        Size(0.5, "mm", most=20.0),
    ),
    mismatch(
        "wrong-hinge-axes",
        "Each hinge's axis leans.",
        _lean_axes,
        Size(0.5, "deg", most=10.0),
    ),
    mismatch(
        "wrong-com-of-body-4",
        "Body 4's center of mass is elsewhere.",
        _shift_centers(CORRECTED_BODIES, IMU_COUNT),
        Size(3.0, "mm", most=50.0),
    ),
    mismatch(
        "wrong-coms",
        "The centers of mass of bodies 1 to 3, which an evaluation corrects, are elsewhere once more.",
        _shift_centers(0, CORRECTED_BODIES),
        Size(3.0, "mm", most=50.0),
    ),
    mismatch(
        "robot-file-uncertain",
        "Masses, inertias, hinges and body 4's center of mass are all drawn from the robot file's [uncertainty].",
        _draw_from_file,
        Size(1.0, "times", most=10.0),
    ),
)
