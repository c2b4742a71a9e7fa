"""One drop explained by the model as it is and by the model corrected: fit, predictions, attitude errors."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tfsat_host.dynamics.poses import poses
from tfsat_host.evaluation.initial_rates import quiet_samples
from tfsat_host.evaluation.model_fit.comparison import (
    AttitudeError,
    Prediction,
    attitude_error,
    difference_covariance,
    initial_momentum,
    predicted,
)
from tfsat_host.evaluation.model_fit.fit import ModelFit, fit_model
from tfsat_host.evaluation.model_fit.offsets import Offsets
from tfsat_host.evaluation.model_fit.unexplained import Derivatives, Flown, derivatives, flown_of
from tfsat_host.evaluation.motion.lag import Lag
from tfsat_host.evaluation.motion.motion import Motion

FloatArray = NDArray[np.float64]

EXPECTED_DISTANCE = 2.8
"""Of three angles that are as uncertain as is said, in their own uncertainty: 95 % lie within."""
BODY_1 = 0
"""The body whose attitude the paper compares."""


@dataclass(frozen=True, eq=False)
class Sides:
    """A model beside the measurement.

    Attributes:
        values: (p,) offsets of the model, in their units.
        prediction: Of the base.
        error: Of body 1: measured less predicted.
    """

    values: FloatArray
    prediction: Prediction
    error: AttitudeError


@dataclass(frozen=True, eq=False)
class Driven:
    """What any model of the robot is driven by and compared with.

    Attributes:
        flown: Measured joint motion and rates.
        rotation: (m, 4, 3, 3) from each body's axes to the base's.
        quiet: (m,) samples before the first stroke, which tell the momentum.
        lag: Of the gyros.
        offsets: What may be corrected, and of which model.
    """

    flown: Flown
    rotation: FloatArray
    quiet: NDArray[np.bool_]
    lag: Lag
    offsets: Offsets

    def beside(self, values: FloatArray) -> Sides:
        """The model with given offsets (p,), such as none, or those of other drops."""
        momentum = initial_momentum(self.offsets.corrected(values), self.flown, self.quiet)
        found = derivatives(self.offsets, values, self.flown, momentum)
        return self._beside(values, found, np.eye(found.by_errors.shape[2]), fitted=False)

    def beside_fit(self, fit: ModelFit) -> Sides:
        """The model with offsets that were fitted to this very drop."""
        p = len(self.offsets)
        kept = np.r_[0:p, p + 3 : len(fit.covariance)]
        return self._beside(fit.values, fit.derivatives, fit.covariance[np.ix_(kept, kept)], fitted=True)

    def _beside(self, values: FloatArray, found: Derivatives, errors: FloatArray, *, fitted: bool) -> Sides:
        body, turned = self.offsets.corrected(values), self.rotation[:, BODY_1]
        prediction = predicted(body, self.flown, initial_momentum(body, self.flown, self.quiet))
        covariance = difference_covariance(
            self.flown, turned, BODY_1, found, errors, self.quiet, fitted=fitted
        )
        error = attitude_error(prediction, self.flown, turned, BODY_1, self.lag, covariance)
        return Sides(values, prediction, error)


@dataclass(frozen=True, eq=False)
class Explained:
    """What the model makes of a drop.

    Attributes:
        driven: What drives it.
        fit: The offsets that explain the motion best. Where even they miss the attitude by more than the sensors'
            errors allow, something unknown is at work in them as well: their covariance is widened by as much.
        before: The model as its file has it.
        after: The model with those offsets.
    """

    driven: Driven
    fit: ModelFit
    before: Sides
    after: Sides


def explain(motion: Motion, offsets: Offsets, first_stroke_s: float) -> Explained:
    """Fits the offsets and compares both models with the measured attitude of body 1.

    Args:
        motion: What the robot did.
        offsets: What may be corrected, and of which model.
        first_stroke_s: Until then nothing but the release has moved the robot.
    """
    flown = flown_of(motion, offsets.body)
    rotation, _ = poses(offsets.body, flown.angles_rad)
    driven = Driven(flown, rotation, quiet_samples(flown.t_s, first_stroke_s), motion.lag, offsets)
    fit = fit_model(offsets, flown)
    after = driven.beside_fit(fit)
    misfit = max(1.0, after.error.mahalanobis / EXPECTED_DISTANCE)
    fit = fit if misfit == 1.0 else _widened(fit, misfit)
    return Explained(driven, fit, driven.beside(np.zeros(len(offsets))), after)


def _widened(fit: ModelFit, misfit: float) -> ModelFit:
    """With the data's deviations so many times as large; what was known before the drop stays known."""
    errors = len(fit.covariance) - len(fit.offsets) - 3
    before = np.diag(np.concatenate([fit.offsets.prior_std**-2.0, np.zeros(3), np.ones(errors)]))
    by_data = np.linalg.inv(fit.covariance) - before
    covariance = np.linalg.inv(by_data / misfit**2 + before)
    return replace(fit, covariance=covariance, information=fit.information / misfit**2)
