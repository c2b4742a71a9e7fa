"""Offsets of the model by Gauss-Newton: the unexplained rate made as small as the sensors' errors allow.

Unknown are the offsets, the momentum, and every error of the sensors that is the same at many samples (the gyros'
bias, mounting and scale; the joints' start, scale and wander), each with the uncertainty that its calibration states.
What a sensor's error can explain is so not taken for an offset, and the offsets' covariance says what trades against
what.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from tfsat_host.dynamics import momentum as conserved
from tfsat_host.evaluation.model_fit.offsets import Offsets
from tfsat_host.evaluation.model_fit.unexplained import (
    Derivatives,
    Flown,
    derivatives,
    inertial_momentum,
    unexplained,
)

FloatArray = NDArray[np.float64]

_STEPS = 20
_CLOSE = 1e-4
_BLOCK_S = 0.1
"""Means over so long are compared with their noise: what the sensors' errors leave over is the model's."""


@dataclass(frozen=True, eq=False)
class ModelFit:
    """Offsets that explain the motion best.

    Attributes:
        offsets: What was free.
        values: (p,) in their units.
        covariance: (p + 3 + r, p + 3 + r) of the offsets, the momentum and the sensors' errors (in units of what their
            calibration allows), after the fit.
        information: (p, p) of the data on the offsets alone, priors not counted.
        momentum_kg_m2_s: (3,) inertial axes: those of the base at the first sample.
        excess: Variance of what is left over, beside what the sensors' noise makes: 1 if the model explains all.
        steps: Of Gauss and Newton.
        at_bound: (p,) the offset stopped at its bound.
        derivatives: At the values.
        left_over_rad_s: (m, 3) unexplained after the fit.
    """

    offsets: Offsets
    values: FloatArray
    covariance: FloatArray
    information: FloatArray
    momentum_kg_m2_s: FloatArray
    excess: float
    steps: int
    at_bound: NDArray[np.bool_]
    derivatives: Derivatives
    left_over_rad_s: FloatArray

    @property
    def std(self) -> FloatArray:
        """(p,) in the offsets' units."""
        return np.sqrt(np.diag(self.covariance)[: len(self.offsets)])


def fit_model(offsets: Offsets, flown: Flown) -> ModelFit:
    """Fits the offsets to one drop."""
    values = np.zeros(len(offsets))
    momentum = inertial_momentum(offsets.body, flown).mean(axis=0)
    errors = np.zeros(0)
    steps = 0
    while steps < _STEPS:
        steps += 1
        system = _System.of(offsets, values, momentum, flown)
        moved = system.solved(offsets, values)
        values = values + moved[: len(offsets)]
        momentum = momentum + moved[len(offsets) : len(offsets) + 3] * system.momentum_unit
        errors = moved[len(offsets) + 3 :]
        if (np.abs(moved[: len(offsets)]) < _CLOSE).all():
            break
    system = _System.of(offsets, values, momentum, flown)
    left = unexplained(offsets.corrected(values), flown, momentum)
    explained = left + system.found.by_errors @ errors
    excess = _excess(flown.t_s, np.einsum("nij,nj->ni", system.whitening, explained))
    covariance = np.linalg.inv(system.normal / excess + system.prior)
    p = len(offsets)
    scale = np.ones(len(covariance))
    scale[p : p + 3] = system.momentum_unit
    full = system.normal / excess + system.prior
    own = full - np.diag([*offsets.prior_std**-2.0, *np.zeros(len(full) - p)])
    return ModelFit(
        offsets,
        values,
        covariance * np.outer(scale, scale),
        own[:p, :p] - own[:p, p:] @ np.linalg.solve(own[p:, p:], own[p:, :p]),
        momentum,
        excess,
        steps,
        np.abs(values) >= offsets.bounds * (1.0 - 1e-9),
        system.found,
        explained,
    )


@dataclass(frozen=True, eq=False)
class _System:
    """One linear step: columns of offsets, momentum and errors, whitened."""

    design: FloatArray
    target: FloatArray
    prior: FloatArray
    whitening: FloatArray
    momentum_unit: float
    found: Derivatives

    @classmethod
    def of(cls, offsets: Offsets, values: FloatArray, momentum: FloatArray, flown: Flown) -> _System:
        found = derivatives(offsets, values, flown, momentum)
        left = unexplained(offsets.corrected(values), flown, momentum)
        inertia = conserved.locked_inertia(offsets.body, flown.angles_rad[:1])
        unit = float(np.trace(inertia[0])) / 3.0 * np.deg2rad(1.0)
        columns = np.concatenate([found.by_offsets, unit * found.by_momentum, found.by_errors], axis=2)
        whitening = np.linalg.inv(np.linalg.cholesky(found.noise))
        p, r = len(offsets), found.by_errors.shape[2]
        # The prior pulls towards no offset at all, from wherever the last step led.
        prior = np.diag([*offsets.prior_std**-2.0, *np.zeros(3), *np.ones(r)])
        return cls(
            (whitening @ columns).reshape(-1, p + 3 + r),
            -np.einsum("nij,nj->ni", whitening, left).reshape(-1),
            prior,
            whitening,
            unit,
            found,
        )

    @property
    def normal(self) -> FloatArray:
        return np.asarray(self.design.T @ self.design)

    def solved(self, offsets: Offsets, values: FloatArray) -> FloatArray:
        """What to add to offsets and momentum, and the errors themselves."""
        right = self.design.T @ self.target
        right[: len(values)] -= values / offsets.prior_std**2
        found = np.linalg.solve(self.normal + self.prior, right)
        if (np.abs(values + found[: len(values)]) <= offsets.bounds).all():
            return np.asarray(found)
        root = np.linalg.cholesky(self.normal + self.prior).T
        low, high = np.full(len(found), -np.inf), np.full(len(found), np.inf)
        low[: len(values)], high[: len(values)] = -offsets.bounds - values, offsets.bounds - values
        bounded = lsq_linear(root, np.linalg.solve(root.T, right), (low, high))
        return np.asarray(bounded.x)


def _excess(t_s: FloatArray, whitened: FloatArray) -> float:
    """How much more the means over blocks scatter than their noise would; at least 1."""
    edges = np.flatnonzero(np.diff(np.floor(t_s / _BLOCK_S), prepend=-1.0))
    counts = np.diff(edges, append=len(t_s))
    sums = np.add.reduceat(whitened, edges, axis=0) / np.sqrt(counts)[:, None]
    return max(1.0, float((sums**2).mean()))
