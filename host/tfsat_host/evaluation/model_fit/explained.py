"""One drop explained by the model as it is and by the model corrected: fit, predictions, attitude errors."""

from __future__ import annotations

from collections.abc import Iterator
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
from tfsat_host.evaluation.model_fit.fit import ModelFit, fit_model, widened
from tfsat_host.evaluation.model_fit.offsets import Offsets
from tfsat_host.evaluation.model_fit.unexplained import Derivatives, Flown, derivatives, flown_of
from tfsat_host.evaluation.motion.lag import Lag
from tfsat_host.evaluation.motion.motion import Motion

FloatArray = NDArray[np.float64]

EXPECTED_DISTANCE = 2.8
"""Of three angles that are as uncertain as is said, in their own uncertainty: 95 % lie within."""
UNEXPLAINED = 4.6
"""Three normal angles are so far from zero, in their own uncertainty, once in ten thousand drops."""
IMPLAUSIBLE_STDS = 3.0
"""Of the prior: an offset that was not thought possible is more likely something else's error."""
_LINEAR_RAD = 1e-3
"""Joint angles that were off by less than this carried rates from body to body as well as right ones."""
_RELINEARIZED = 5
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
            errors allow, something unknown is at work in them as well: the data are taken to be worse by as much.
        before: The model as its file has it.
        after: The model with those offsets, beside sensors without the errors that the fit found in them; its
            uncertainty is not widened by what even it misses.
    """

    driven: Driven
    fit: ModelFit
    before: Sides
    after: Sides

    @property
    def explains_before(self) -> bool:
        """The model as it is predicts the attitude within the stated errors."""
        return self.before.error.mahalanobis <= UNEXPLAINED

    @property
    def explains_after(self) -> bool:
        """The corrected model does."""
        return self.after.error.mahalanobis <= UNEXPLAINED

    @property
    def offered(self) -> bool:
        """The correction may be applied, as far as the fit can tell: nothing is `withheld`."""
        return not self.withheld

    @property
    def withheld(self) -> tuple[str, ...]:
        """Why the correction must not be applied, a sentence each; empty if it may be."""
        return tuple(self._against())

    def _against(self) -> Iterator[str]:
        fit = self.fit
        if not fit.converged:
            yield f"The fit of the correction found no end in {fit.steps} steps: where it was broken off means nothing."
        if fit.bounded:
            names = ", ".join(fit.bounded)
            yield f"The correction stopped at its bound: {names}. The true one lies beyond, or is another one."
        far = np.abs(fit.values) > IMPLAUSIBLE_STDS * fit.offsets.prior_std
        if far.any():
            names = ", ".join(np.array(fit.offsets.names)[far])
            yield (
                f"The correction is more than {IMPLAUSIBLE_STDS:g} times what was allowed for {names}: more likely it "
                "stands for another error."
            )
        if not self.explains_after:
            yield self._missed()

    def _missed(self) -> str:
        before, after = self.before.error, self.after.error
        missed = (
            f"misses the attitude by {np.rad2deg(after.final_norm_rad):.2f} deg, {after.mahalanobis:.1f} times what "
            "all stated uncertainties together explain"
        )
        if self.explains_before:
            return (
                f"The corrected model {missed}, and the model as it is by {np.rad2deg(before.final_norm_rad):.2f} deg, "
                f"{before.mahalanobis:.1f} times: the correction is wrong, and nothing is said against the model."
            )
        return f"Even the corrected model {missed}."


def explain(motion: Motion, offsets: Offsets, first_stroke_s: float) -> Explained:
    """Fits the offsets and compares both models with the measured attitude of body 1.

    Args:
        motion: What the robot did.
        offsets: What may be corrected, and of which model.
        first_stroke_s: Until then nothing but the release has moved the robot.
    """

    def driven_by(flown: Flown, lag: Lag) -> Driven:
        rotation, _ = poses(offsets.body, flown.angles_rad)
        return Driven(flown, rotation, quiet_samples(flown.t_s, first_stroke_s), lag, offsets)

    flown = flown_of(motion)
    driven = driven_by(flown, motion.lag)
    fit = fit_model(offsets, flown)
    for _ in range(_RELINEARIZED):
        if flown.turned_by(fit.errors) < _LINEAR_RAD:
            break
        flown = flown_of(motion, fit.errors)
        fit = fit_model(offsets, flown)
    sensed = driven_by(flown_of(motion, fit.errors), motion.lag)
    after = sensed.beside_fit(fit)
    misfit = after.error.mahalanobis / EXPECTED_DISTANCE
    if misfit > 1.0:
        stated, fit = fit, widened(fit, flown, misfit)
        after = sensed.beside_fit(replace(fit, covariance=stated.covariance))
    return Explained(driven, fit, driven.beside(np.zeros(len(offsets))), after)
