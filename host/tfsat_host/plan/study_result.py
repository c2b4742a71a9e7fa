"""What a study of sensitivity found: effects of parameters and sources, and where its figures are doubtful."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import simulation_result
from tfsat_host.maneuver import Schedule
from tfsat_host.plan.spread import Derivatives, LinearSpread, Spread, Summary
from tfsat_host.plan.study import Outcomes, Study
from tfsat_host.robot import RobotModel, Uncertainty

_MIN_SAMPLES = 100  # for a standard deviation to be compared
_KINDS = {
    "mass": "masses",
    "com": "centers of mass",
    "inertia": "inertia tensors",
    "joint_point": "points of joint axes",
    "joint_axis": "directions of joint axes",
    "stroke": "ends of strokes",
    "servo_scale": "scales of servos",
    "servo_speed": "speeds of servos",
    "servo_acceleration": "accelerations of servos",
    "servo_delay": "delays of servos",
}


@dataclass(frozen=True, eq=False, slots=True)
class ParameterEffect:
    """One parameter of the model, and what its standard deviation gives the rotation angle to first order."""

    parameter: str
    value: float
    std: float
    unit: str
    reorientation_deg_per_unit: float
    contribution_deg: float
    rotation_vector_deg_per_unit: FloatArray


@dataclass(frozen=True, slots=True)
class SourceEffect:
    """One source of error: its `std` in words, its share of the variance to first order and by the samples."""

    source: str
    kind: str
    std: str
    linear_deg: float
    linear_share: float
    share: float
    rank_correlation: float
    end_rank_correlation: float


@dataclass(frozen=True, slots=True)
class KindEffect:
    """All sources of one kind; the greatest of them first."""

    kind: str
    sources: tuple[SourceEffect, ...]

    @property
    def linear_deg(self) -> float:
        """What they give together: independent, so their squares add up."""
        return math.hypot(*(source.linear_deg for source in self.sources))

    @property
    def linear_share(self) -> float:
        """Their share of the variance to first order."""
        return sum(source.linear_share for source in self.sources)

    @property
    def share(self) -> float:
        """Their share of the variance by the samples."""
        return sum(source.share for source in self.sources)


@dataclass(frozen=True, eq=False)
class StudyResult:
    """What a study of sensitivity found.

    Attributes:
        robot: Whose model.
        schedule: The maneuver.
        initial_rate_deg_s: Of the base at the release, as typed; None: no angular momentum.
        stated: The standard deviations.
        study: What was drawn.
        derivatives: At the nominal parameters.
        linear: The spread to first order.
        summary: The spread by the samples.
        outcomes: Of all samples.
        seconds: That the samples took.
        schedule_notices: Of the maneuver.
        path: Of the samples, as they are written; None: not asked for.
        calibration: The certificate whose servos the robot has; None: those of its file.
    """

    robot: RobotModel
    schedule: Schedule
    initial_rate_deg_s: Sequence[float] | None
    stated: Uncertainty
    study: Study
    derivatives: Derivatives
    linear: LinearSpread
    summary: Summary
    outcomes: Outcomes
    seconds: float
    schedule_notices: tuple[str, ...]
    path: Path | None
    calibration: Path | None = None

    @cached_property
    def parameters(self) -> list[ParameterEffect]:
        """All parameters: what contributes most first; of equal ones the steeper derivative."""
        effects = map(
            ParameterEffect,
            self.study.parameters.names,
            self.study.parameters.nominal.tolist(),
            self.study.sources.parameter_sigma.tolist(),
            self.study.parameters.units,
            self.derivatives.of_reorientation.tolist(),
            self.linear.of_parameters_deg.tolist(),
            self.derivatives.of_rotation_vector,
        )
        return sorted(effects, key=lambda row: (-row.contribution_deg, -abs(row.reorientation_deg_per_unit)))

    @cached_property
    def sources(self) -> list[SourceEffect]:
        """All sources of error, the greatest share of the variance first."""
        effects = map(
            SourceEffect,
            self.study.sources.names,
            self.study.sources.kinds,
            self.study.sources.sigmas,
            self.linear.of_sources_deg.tolist(),
            self.linear.shares.tolist(),
            self.summary.variance_shares.tolist(),
            self.summary.rank_correlation.tolist(),
            self.summary.end_rank_correlation.tolist(),
        )
        return sorted(effects, key=lambda row: -row.linear_share)

    @property
    def kinds(self) -> list[KindEffect]:
        """The sources by their kind, without kinds that do nothing to this rotation."""
        effects = [
            KindEffect(words, tuple(source for source in self.sources if source.kind == kind))
            for kind, words in _KINDS.items()
        ]
        effective = [
            effect
            for effect in effects
            if any(source.linear_deg or source.share for source in effect.sources)
        ]
        return sorted(effective, key=lambda effect: -effect.linear_deg)

    @property
    def integration_error_deg(self) -> float:
        """How wrong the worst attitude may be by the error of the integration."""
        return math.degrees(max(self.derivatives.error_rad, self.outcomes.error_rad))

    @property
    def reorientation(self) -> Spread:
        """The spread of the rotation angle by the samples."""
        return self.summary.outputs["reorientation_deg"]

    @cached_property
    def doubts(self) -> tuple[str, ...]:
        """Notices where the figures are doubtful, one sentence each.

        They tell of too large an integration error, and of first order differing from the samples by more than
        a quarter.
        """
        sentences = []
        if self.integration_error_deg > simulation_result.ERROR_DEG:
            sentences.append(
                f"An attitude may be wrong by {self.integration_error_deg:.2g} deg by the error of the integration: "
                "give a lower --initial-rate, or a maneuver that ends earlier."
            )
        sampled, linear_deg = self.reorientation.std, self.linear.reorientation_deg
        # First order fails where it differs by a quarter, and by more than four standard errors of chance.
        difference = abs(linear_deg - sampled.value)
        if (
            self.study.samples >= _MIN_SAMPLES
            and difference > 0.25 * sampled.value + 4.0 * sampled.standard_error
        ):
            sentences.append(
                f"To first order the standard deviation is {linear_deg:.3g} deg, by the samples "
                f"{sampled.value:.3g}: the errors are too large for first order, go by the samples."
            )
        return tuple(sentences)
