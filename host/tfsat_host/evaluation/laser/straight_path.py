"""An even motion through scattered places, some of them wrong: robust weighted least squares."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.laser.geometry import UP, SpotEquations

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_ROUNDS = 30
_SETTLED = 1e-6
"""Relative change of the scatter after which another round would change nothing."""
_HUBER = 1.5
"""A residual beyond so many deviations weighs less while the good places are looked for."""
_LEFT_OUT = 5.0
"""A place beyond so many deviations is not used: of good ones, one in two million."""
_NORMAL_MAD = 1.4826
"""Standard deviation over median absolute deviation of a normal distribution."""
_FLOOR_M = 1e-6


@dataclass(frozen=True, eq=False)
class StraightPath:
    """The CoM's velocity at the release, extrapolated evenly.

    Attributes:
        velocity_m_s: (3,) NaN where no place shows it.
        covariance: (3, 3) of it from the scatter of the places; 0 where the velocity is NaN.
        degrees_of_freedom: Of the scatter.
        scatter_m: Root mean square of the residuals.
        kept: (2 m,) rows of the equations that were used.
        left_out: Places that were not.
    """

    velocity_m_s: FloatArray
    covariance: FloatArray
    degrees_of_freedom: int
    scatter_m: float
    kept: BoolArray
    left_out: int


def fit_straight_path(
    equations: SpotEquations, acceleration_std_m_s2: float, keep: BoolArray | None = None
) -> StraightPath:
    """Velocity, vertical acceleration 0 ± `acceleration_std_m_s2` and a zero of each spot and coordinate.

    Args:
        equations: Of m places.
        acceleration_std_m_s2: Above zero.
        keep: (2 m,) rows to use; None: all but those that lie off the others.
    """
    design, shown = _design(equations)
    # Unit weights where a place is as good as is said; the scatter then scales them all.
    design = design / equations.std_m[:, None]
    target = (equations.place_m - equations.turned_m) / equations.std_m
    prior = np.zeros(design.shape[1])
    prior[3] = 1.0 / acceleration_std_m_s2
    if keep is None:
        keep = _good(design, target, prior, len(equations.t_s) // 2)
    used_design, used_target = design[keep], target[keep]
    free = max(int(keep.sum()) - int(shown.sum()) + 1, 1)
    scale = 1.0
    fit = _solve(used_design, used_target, np.ones(len(used_target)), prior)
    for _ in range(_ROUNDS):  # what the prior weighs depends on the scatter, a little
        before, left = scale, used_target - used_design @ fit.solution
        scale = max(float(np.sqrt(left @ left / free)), _FLOOR_M / float(equations.std_m.max()))
        fit = _solve(used_design, used_target, np.ones(len(used_target)), scale * prior)
        if abs(scale - before) <= _SETTLED * before:
            break
    covariance = scale**2 * fit.inverse[:3, :3]
    hidden = ~shown[:3]
    covariance[hidden] = covariance[:, hidden] = 0.0
    left = used_target - used_design @ fit.solution
    scatter = float(np.sqrt(np.mean((left * equations.std_m[keep]) ** 2)))
    out = int((~keep[: len(keep) // 2]).sum())
    velocity = np.where(shown[:3], fit.solution[:3], np.nan)
    return StraightPath(velocity, covariance, free, scatter, keep, out)


def _design(equations: SpotEquations) -> tuple[FloatArray, BoolArray]:
    """(2 m, 8) of velocity, vertical acceleration and four zeros; (8,) whether any place shows a column."""
    time = equations.t_s[:, None]
    zeros = (equations.series[:, None] == np.arange(4)).astype(np.float64)
    falling = (equations.toward @ UP)[:, None] * time**2 / 2.0
    design = np.hstack([equations.toward * time, falling, zeros])
    # Spot 1's places move with x only by the slant of its ray: of x, nothing that is worth a number.
    seen = np.isin(np.arange(2), equations.series // 2)
    shown = np.array([seen[1], seen[0], True, True, seen[0], seen[0], seen[1], seen[1]])
    design[:, ~shown] = 0.0
    return design, shown


class _Solved(NamedTuple):
    """Least squares, and the inverse of the normal matrix."""

    solution: FloatArray
    inverse: FloatArray


def _solve(design: FloatArray, target: FloatArray, weight: FloatArray, prior: FloatArray) -> _Solved:
    """A column of zeros gets the solution zero."""
    normal = design.T @ (weight[:, None] * design) + np.diag(prior**2)
    inverse = np.asarray(np.linalg.pinv(normal, hermitian=True), dtype=np.float64)
    return _Solved(inverse @ (design.T @ (weight * target)), inverse)


def _good(design: FloatArray, target: FloatArray, prior: FloatArray, places: int) -> BoolArray:
    """(2 m,) both coordinates of the places that agree, by iteratively reweighted least squares (Huber)."""
    weight = np.ones(len(target))
    left, scale = target, 1.0
    for _ in range(_ROUNDS):
        fit = _solve(design, target, weight, scale * prior)
        left = np.abs(target - design @ fit.solution)
        before, scale = scale, max(_NORMAL_MAD * float(np.median(left)), 1e-9)
        weight = np.minimum(1.0, _HUBER * scale / np.maximum(left, 1e-12))
        if abs(scale - before) <= _SETTLED * before:
            break
    off = (left > _LEFT_OUT * scale).reshape(2, places).any(axis=0)
    return np.tile(~off, 2)
