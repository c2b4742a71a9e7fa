"""Offsets of the model by Gauss-Newton: the unexplained rate made as small as the sensors' errors allow.

Unknown are the offsets, the momentum, and every error of the sensors that is the same at many samples (the gyros'
bias, mounting and scale; the joints' start, scale and wander), each with the uncertainty that its calibration states.
What a sensor's error can explain is so not taken for an offset, and the offsets' covariance states what correlates with
what.

What is left over beyond the sensors' errors is the model's own: the data's variances are then widened by as much, and
everything is solved again with them, so that values, covariance and information are those of one system.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import lsq_linear

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.dynamics.spatial_momentum import locked_inertia
from tfsat_host.evaluation.com_fit.momentum_residual import (
    Derivatives,
    FallSamples,
    derivatives,
    inertial_momentum,
)
from tfsat_host.evaluation.com_fit.offsets import Offsets
from tfsat_host.evaluation.motion.samples import Blocks

_STEPS = 40
# In the offsets' units, mm or %: where no offset moves by more the iteration has arrived.
_CLOSE = 1e-4
_SHORTER = 0.9
"""A step that is not so much shorter than the one before it goes round in circles: half as far from there on."""
_MIN_SHARE = 2.0**-9
"""Of a step: halved so often, it leads nowhere."""
_BLOCK_S = 0.1
"""What the sensors' errors leave over is the model's, and no noise within so long."""


@dataclass(frozen=True, eq=False)
class ModelFit:
    """Offsets that explain the motion best.

    Attributes:
        offsets: What was free.
        values: (p,) in their units.
        covariance: (p + 3 + r, p + 3 + r) of the offsets, the momentum and the sensors' errors (in units of what their
            calibration allows), after the fit.
        flown: What it was fitted to.
        equations: Of the data for the offsets, linear at the values.
        momentum_kg_m2_s: (3,) inertial axes: those of the base at the first sample.
        errors: (r,) what the sensors' errors are found to be, from what they were taken for.
        excess: Variance of the solution by what is left over, against what the sensors' noise makes: 1 if the model
            explains all.
        widening: What the data's variances were multiplied with: the excess, and what `widen_fit` was asked for.
        steps: Of Gauss and Newton.
        converged: They came to an end; else the values are where they were broken off, and mean little.
        at_bound: (p,) the offset stopped at its bound.
        derivatives: At the values.
    """

    offsets: Offsets
    values: FloatArray
    covariance: FloatArray
    flown: FallSamples
    equations: OffsetEquations
    momentum_kg_m2_s: FloatArray
    errors: FloatArray
    excess: float
    widening: float
    steps: int
    converged: bool
    at_bound: BoolArray
    derivatives: Derivatives

    @property
    def residual_rad_s(self) -> FloatArray:
        """(m, 3) unexplained after the fit."""
        return self.derivatives.residual_rad_s

    @property
    def std(self) -> FloatArray:
        """(p,) in the offsets' units."""
        return np.sqrt(np.diag(self.covariance)[: len(self.offsets)])

    @property
    def information(self) -> FloatArray:
        """(p, p) of the data on the offsets, priors not counted."""
        return self.equations.information

    @property
    def sought_information(self) -> FloatArray:
        """(s, s) of the data on the offsets that are sought, the nuisance parameters held by their priors."""
        s, prior = self.offsets.sought, np.diag(self.offsets.prior_std**-2.0)
        # Schur complement: eliminate the nuisance parameters, which their priors hold.
        nuisance = self.information[s:, s:] + prior[s:, s:]
        across = self.information[s:, :s]
        return np.asarray(self.information[:s, :s] - across.T @ np.linalg.solve(nuisance, across))

    @property
    def determined_numbers(self) -> float:
        """Of how many offsets the data tell, not the priors: the trace of the posterior covariance by information."""
        p = len(self.offsets)
        return float(np.trace(self.covariance[:p, :p] @ self.information))

    @property
    def bounded(self) -> tuple[str, ...]:
        """Names of the offsets that stopped at their bounds."""
        return tuple(name for name, at in zip(self.offsets.names, self.at_bound, strict=True) if at)


def fit_model(offsets: Offsets, kinematics: FallSamples, before: ModelFit | None = None) -> ModelFit:
    """Fits the offsets to one drop; from where another fit of the same drop ended, if there is one."""
    # Start from no offsets and the mean momentum, or from where another fit of this drop ended.
    if before is None:
        momentum = inertial_momentum(offsets.body, kinematics).mean(axis=0)
        start = Place(np.zeros(len(offsets)), momentum, kinematics.removed_errors, 0, converged=False)
    else:
        start = Place.of(before)
    # First fit as if the sensors' noise were all that is left over.
    place = _converge(offsets, kinematics, start, 1.0)
    system = _System.of(offsets, place, kinematics)
    # Estimate the variance factor by blocks (sandwich): the model's errors are correlated in each.
    rows = system.design.reshape(len(kinematics.t_s), 3, -1)
    residual = system.target.reshape(len(kinematics.t_s), 3)
    excess = max(1.0, Blocks.of(kinematics.t_s, _BLOCK_S).excess(rows, residual, system.normal, system.prior))
    # Refit with data that are worse by as much: the prior then weighs more, and the solution moves.
    if excess > 1.0:
        place = _converge(offsets, kinematics, place, excess, system)
        system = _System.of(offsets, place, kinematics)
    return _fit(offsets, kinematics, system, place, excess, excess)


def widen_fit(fit: ModelFit, misfit: float) -> ModelFit:
    """Refit the same drop with the data's standard deviations scaled by `misfit`.

    The prior stays unchanged, so that it weighs more, and the values move towards it.
    """
    widening = fit.widening * misfit**2
    place = _converge(fit.offsets, fit.flown, Place.of(fit), widening)
    return _fit(
        fit.offsets, fit.flown, _System.of(fit.offsets, place, fit.flown), place, fit.excess, widening
    )


class OffsetEquations(NamedTuple):
    """Normal equations of one drop for the offsets alone: information @ offsets = right_hand_side, without their prior.

    Attributes:
        information: (p, p).
        right_hand_side: (p,).
        own: (3 + r, p + 1) what momentum (in `momentum_unit`) and sensors' errors are best, by the offsets and 1.
        momentum_unit: kg m^2/s.
    """

    information: FloatArray
    right_hand_side: FloatArray
    own: FloatArray
    momentum_unit: float

    def place_at(self, values: FloatArray) -> Place:
        """Return the offsets (p,) with the momentum and the errors that are best with them."""
        # Back-substitute: what was eliminated is affine in the offsets, the constant in the last column.
        own = self.own @ np.append(values, 1.0)
        return Place(values, self.momentum_unit * own[:3], own[3:], 0, converged=False)


def linearize(offsets: Offsets, kinematics: FallSamples, place: Place, widening: float) -> OffsetEquations:
    """Return a drop's equations by derivatives at a place that need not be its own fit's."""
    return _System.of(offsets, place, kinematics).equations(place, widening)


class Place(NamedTuple):
    """Where Gauss and Newton are: offsets (p,), momentum (3,), the sensors' errors (r,)."""

    values: FloatArray
    momentum: FloatArray
    errors: FloatArray
    steps: int
    converged: bool

    @classmethod
    def of(cls, fit: ModelFit) -> Place:
        """Return the place where a fit ended."""
        return cls(fit.values, fit.momentum_kg_m2_s, fit.errors, fit.steps, converged=False)


def _converge(
    offsets: Offsets, kinematics: FallSamples, place: Place, widening: float, system: _System | None = None
) -> Place:
    """Iterate from a place, with its system if that is already known, until the steps vanish.

    Where offsets stop at their bounds, full steps may oscillate between places that point to each other. The
    steps are then halved until they do not. Where halved steps remain as long as full ones, the data contradict
    the model and its stated standard deviations: the iteration ends there, not converged.
    """
    p = len(offsets)
    share, before = 1.0, np.inf
    for _ in range(_STEPS):
        # Relinearize wherever the last step led; a system that is known already serves for the first.
        system = system or _System.of(offsets, place, kinematics)
        moved = system.solve(offsets, place, widening)
        # Measure the step in prior standard deviations, so that mm and % add up.
        length = float(np.linalg.norm(moved[:p] / offsets.prior_std))
        arrived = bool((np.abs(moved[:p]) < _CLOSE).all())
        # Damp where steps no longer shrink; the last one, within tolerance, is taken in full.
        share = 1.0 if arrived else share if length < _SHORTER * before else 0.5 * share
        before = length
        place = Place(
            place.values + share * moved[:p],
            place.momentum + share * moved[p : p + 3] * system.momentum_unit,
            place.errors + share * moved[p + 3 :],
            place.steps + 1,
            arrived,
        )
        if arrived or share < _MIN_SHARE:
            break
        system = None
    return place


def _fit(
    offsets: Offsets, kinematics: FallSamples, system: _System, place: Place, excess: float, widening: float
) -> ModelFit:
    """Build the fit at a place."""
    p = len(offsets)
    # Widened variances divide the data's information; the prior stays.
    data = system.normal / widening
    # The momentum was solved for in a unit of its own: scale its rows and columns back.
    scale = np.ones(len(data))
    scale[p : p + 3] = system.momentum_unit
    return ModelFit(
        offsets,
        place.values,
        np.linalg.inv(data + system.prior) * np.outer(scale, scale),
        kinematics,
        system.equations(place, widening),
        place.momentum,
        place.errors,
        excess,
        widening,
        place.steps,
        place.converged,
        np.abs(place.values) >= offsets.bounds - _CLOSE,
        system.derivatives,
    )


class _System(NamedTuple):
    """One linear step: columns of offsets, momentum and errors, whitened."""

    design: FloatArray
    normal: FloatArray
    target: FloatArray
    prior: FloatArray
    momentum_unit: float
    derivatives: Derivatives

    @classmethod
    def of(cls, offsets: Offsets, place: Place, kinematics: FallSamples) -> _System:
        # Linearize about readings from which the errors found so far are taken off.
        kinematics = kinematics.correct(place.errors)
        linearization = derivatives(offsets, place.values, kinematics, place.momentum)
        # Count the momentum in what turns the locked robot by 1 deg/s: the normal matrix is well scaled.
        inertia = locked_inertia(offsets.body, kinematics.angles_rad[:1])
        unit = float(np.trace(inertia[0])) / 3.0 * np.deg2rad(1.0)
        columns = np.concatenate(
            [linearization.by_offsets, unit * linearization.by_momentum, linearization.by_errors], axis=2
        )
        # Whiten the three rows of each sample by the inverse Cholesky factor of their noise, (m, 3, 3).
        whitening = np.linalg.inv(np.linalg.cholesky(linearization.noise))
        p, r = len(offsets), linearization.by_errors.shape[2]
        # The prior pulls towards no offset at all, from wherever the last step led.
        prior = np.diag([*offsets.prior_std**-2.0, *np.zeros(3), *np.ones(r)])
        # Stack samples and axes into rows: (3 m, p + 3 + r).
        design = (whitening @ columns).reshape(-1, p + 3 + r)
        return cls(
            design,
            design.T @ design,
            -np.einsum("nij,nj->ni", whitening, linearization.residual_rad_s).reshape(-1),
            prior,
            unit,
            linearization,
        )

    def equations(self, place: Place, widening: float) -> OffsetEquations:
        """Eliminate momentum and errors, with the errors' prior."""
        p = len(place.values)
        # Restate the step's equations in absolute unknowns, so that those of several drops can be summed.
        there = np.concatenate([place.values, place.momentum / self.momentum_unit, place.errors])
        normal = self.normal / widening
        right = self.design.T @ self.target / widening + normal @ there
        # Schur complement over momentum and errors: the momentum is free, the errors have unit variance.
        across, own_prior = normal[p:, :p], np.diag([*np.zeros(3), *np.ones(len(place.errors))])
        own = np.linalg.solve(normal[p:, p:] + own_prior, np.column_stack([-across, right[p:]]))
        return OffsetEquations(
            normal[:p, :p] + across.T @ own[:, :-1],
            right[:p] - across.T @ own[:, -1],
            own,
            self.momentum_unit,
        )

    def solve(self, offsets: Offsets, place: Place, widening: float) -> FloatArray:
        """Solve for the step of offsets, momentum and errors, within the offsets' bounds."""
        p = len(offsets)
        right = self.design.T @ self.target / widening
        # The priors pull from the place reached back to zero; the momentum has none.
        right[:p] -= place.values / offsets.prior_std**2
        right[p + 3 :] -= place.errors
        # Only offsets have bounds, and these move with the place, for the unknown is the step from there.
        unbound = np.full(len(right) - p, np.inf)
        return bounded_solution(
            self.normal / widening + self.prior,
            right,
            np.concatenate([-offsets.bounds - place.values, -unbound]),
            np.concatenate([offsets.bounds - place.values, unbound]),
        )


def bounded_solution(normal: FloatArray, right: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """(k,) least squares by its normal equations (k, k), (k,), within bounds, infinite where there is none."""
    # If the unconstrained minimum lies within the bounds it is the answer.
    free = np.linalg.solve(normal, right)
    if ((low <= free) & (free <= high)).all():
        return np.asarray(free)
    # Else bounded least squares: with the normal matrix R^T R, minimize |R x - R^-T b| over the box.
    root = np.linalg.cholesky(normal).T
    return np.asarray(lsq_linear(root, np.linalg.solve(root.T, right), (low, high), method="bvls").x)
