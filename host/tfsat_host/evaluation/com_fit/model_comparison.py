"""The nominal and the fitted model, driven by the measured joints, against the measured attitude of body 1."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from tfsat_host.arrays import BoolArray, FloatArray, describe_fields
from tfsat_host.dynamics.poses import poses
from tfsat_host.evaluation.com_fit.com_fit import ModelFit, fit_model, widen_fit
from tfsat_host.evaluation.com_fit.momentum_residual import (
    Derivatives,
    FallSamples,
    derivatives,
    flown_of,
)
from tfsat_host.evaluation.com_fit.offsets import Offsets
from tfsat_host.evaluation.com_fit.prediction import (
    AttitudeError,
    Prediction,
    attitude_error,
    difference_covariance,
    initial_momentum,
    predict,
)
from tfsat_host.evaluation.motion.gyro_signal import Lag
from tfsat_host.evaluation.motion.motion import Motion, quiet_samples

EXPECTED_DISTANCE = 2.8
"""Of three angles that are as uncertain as stated, in their own uncertainty: 95 % lie within."""
UNEXPLAINED = 4.6
"""Three normal angles are so far from zero, in their own uncertainty, once in ten thousand drops."""
IMPLAUSIBLE_STDS = 5.0
"""Of the prior: one of fifty numbers is so far off by chance in 30,000 drops; more likely it is another error."""
_LINEAR_RAD = 1e-3
"""Joint angles that were off by less than this carried rates from body to body as well as right ones."""
_RELINEARIZED = 5
_CONTRADICTED = 10.0
"""Times the expected distance. Joints that were taken wrong leave less than one; where a sensor contradicts the others,
20 to 1,100 are left, in the last linearisation as in the first."""
BODY_1 = 0
"""The body whose attitude the paper compares."""


@dataclass(frozen=True, eq=False)
class ComparedModel:
    """A model against the measurement.

    Attributes:
        values: (p,) offsets of the model, in their units.
        prediction: Of the base.
        error: Of body 1: measured less predicted.
    """

    values: FloatArray
    prediction: Prediction
    error: AttitudeError


@dataclass(frozen=True, eq=False)
class ModelInput:
    """What any model of the robot is driven by and compared with.

    Attributes:
        flown: Measured joint motion and rates.
        rotation: (m, 4, 3, 3) from each body's axes to the base's.
        quiet: (m,) samples before the first stroke, which tell the momentum.
        lag: Of the gyros.
        offsets: What may be corrected, and of which model.
    """

    flown: FallSamples
    rotation: FloatArray
    quiet: BoolArray
    lag: Lag
    offsets: Offsets

    def with_offsets(self, values: FloatArray) -> ComparedModel:
        """Compare the measurement with the model at given offsets (p,), such as none, or those of other drops."""
        momentum = initial_momentum(self.offsets.correct(values), self.flown, self.quiet)
        linearization = derivatives(self.offsets, values, self.flown, momentum)
        # Before a fit the sensors' errors are independent and of variance one.
        return self._compare(values, linearization, np.eye(linearization.by_errors.shape[2]), fitted=False)

    def with_fit(self, fit: ModelFit) -> ComparedModel:
        """Compare the measurement with the model at offsets that were fitted to this very drop."""
        p = len(self.offsets)
        # Leave the momentum out: the prediction takes its own from the quiet samples.
        indices = np.r_[0:p, p + 3 : len(fit.covariance)]
        return self._compare(
            fit.values, fit.derivatives, fit.covariance[np.ix_(indices, indices)], fitted=True
        )

    def _compare(
        self, values: FloatArray, linearization: Derivatives, errors: FloatArray, *, fitted: bool
    ) -> ComparedModel:
        body, turned = self.offsets.correct(values), self.rotation[:, BODY_1]
        prediction = predict(body, self.flown, initial_momentum(body, self.flown, self.quiet))
        covariance = difference_covariance(
            self.flown, turned, BODY_1, linearization, errors, self.quiet, fitted=fitted
        )
        error = attitude_error(prediction, self.flown, turned, BODY_1, self.lag, covariance)
        return ComparedModel(values, prediction, error)


@dataclass(frozen=True, eq=False)
class ModelComparison:
    """What the model makes of a drop.

    Attributes:
        driven: What drives it.
        fit: The offsets that explain the motion best. Where even they miss the attitude by more than the sensors'
            errors allow, something unknown is at work in them as well: the data are taken to be worse by as much.
        nominal: The model as its file has it.
        fitted: The model with those offsets, against sensors without the errors that the fit found in them; its
            uncertainty is not widened by what even it misses.
    """

    driven: ModelInput
    fit: ModelFit
    nominal: ComparedModel
    fitted: ComparedModel

    __repr__ = describe_fields

    @property
    def nominal_explains(self) -> bool:
        """The model as it is predicts the attitude within the stated errors."""
        return self.nominal.error.mahalanobis <= UNEXPLAINED

    @property
    def fitted_explains(self) -> bool:
        """The corrected model does."""
        return self.fitted.error.mahalanobis <= UNEXPLAINED

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
            yield f"The fit of the correction did not converge in {fit.steps} steps: its result is invalid."
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
        if not self.fitted_explains:
            yield self._missed_sentence()

    def _missed_sentence(self) -> str:
        before, after = self.nominal.error, self.fitted.error
        missed = (
            f"misses the attitude by {np.rad2deg(after.final_norm_rad):.2f} deg, {after.mahalanobis:.1f} times what "
            "all stated uncertainties together explain"
        )
        if self.nominal_explains:
            return (
                f"The corrected model {missed}, and the model as it is by {np.rad2deg(before.final_norm_rad):.2f} deg, "
                f"{before.mahalanobis:.1f} times: the correction is wrong, and nothing is said against the model."
            )
        return f"Even the corrected model {missed}."


def compare_model(motion: Motion, offsets: Offsets, first_stroke_s: float) -> ModelComparison:
    """Fits the offsets and compares both models with the measured attitude of body 1.

    Until `first_stroke_s` nothing but the release has moved the robot.
    """

    def driven_by(kinematics: FallSamples, lag: Lag) -> ModelInput:
        rotation, _ = poses(offsets.body.tilt_hinges(kinematics.tilt_rad), kinematics.angles_rad)
        return ModelInput(kinematics, rotation, quiet_samples(kinematics.t_s, first_stroke_s), lag, offsets)

    def sensed_by(fit: ModelFit) -> tuple[ModelInput, ComparedModel, float]:
        """Sensors without the errors that a fit found; the model it found against them, in expected distances."""
        sensed = driven_by(flown_of(motion, fit.errors), motion.lag)
        after = sensed.with_fit(fit)
        return sensed, after, after.error.mahalanobis / EXPECTED_DISTANCE

    kinematics = flown_of(motion)
    driven = driven_by(kinematics, motion.lag)
    fit = fit_model(offsets, kinematics)
    sensed, after, misfit = sensed_by(fit)
    # Errors that turn the joints noticeably are no longer linear: take them off in earnest, and refit.
    for _ in range(_RELINEARIZED):
        # Done where the linearization held; hopeless where the sensors contradict each other.
        if kinematics.turned_by(fit.errors) < _LINEAR_RAD or misfit > _CONTRADICTED:
            break
        kinematics = sensed.flown
        fit = fit_model(offsets, kinematics, fit)
        sensed, after, misfit = sensed_by(fit)
    # Widen the offsets' covariance, but judge the corrected model by the errors as stated.
    if misfit > 1.0:
        stated, fit = fit, widen_fit(fit, misfit)
        after = sensed.with_fit(replace(fit, covariance=stated.covariance))
    return ModelComparison(driven, fit, driven.with_offsets(np.zeros(len(offsets))), after)
