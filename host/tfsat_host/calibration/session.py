"""The steps of a calibration one after the other: done, judged, kept; repeated where refused, resumed where ended."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from typing import Protocol

from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.certificate.calibration_campaign import Campaign
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.solution import SensorKnowledge
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.calibration.steps.step import Axis, Step, StepKind, rest, sweeps, swings, turn, zero
from tfsat_host.errors import UsageError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.robot import RobotModel
from tfsat_host.robot.absent_parts import bodies_of, bodies_with_imu, require_joint

REST_HOLDS = timedelta(minutes=15)
"""For so long a bias may stand for a motion: it drifts with the temperature."""
RESUME_WITHIN = timedelta(hours=1)


class Operator(Protocol):
    """Who has the steps done and recorded, and is informed of them: a person at a terminal, or a program."""

    def record(self, step: Step, calibration: SensorKnowledge) -> Evidence:
        """Has a step done and reads the sensors meanwhile, with what is known of them."""

    def on_refused(self, error: CalibrationError) -> None:
        """Report a refused step: returning repeats it, raising ends the session."""

    def on_accepted(self, step: Evidence, calibration: Calibration) -> None:
        """Report that a step was accepted and kept."""

    def on_resumed(self, number: int, step: Evidence) -> None:
        """Report that a step, by its number from 1, is not repeated because it was kept before."""


class Session:
    """Some steps into one certificate.

    Attributes:
        steps: In order.
        kept: Of them, those that were accepted, in this session or (if it resumes) before.

    Args:
        steps: What is to be measured.
        campaign: Judges and keeps.
        operator: Has them done.
        resume: Leave out what was accepted within `RESUME_WITHIN` and since the last landing.
        compare: Compare zero points with those known before; not after a sensor was fastened at another angle.
    """

    def __init__(
        self,
        steps: Sequence[Step],
        campaign: Campaign,
        operator: Operator,
        *,
        resume: bool = False,
        compare: bool = True,
    ) -> None:
        self.steps = tuple(steps)
        self.kept: list[Evidence] = []
        self._campaign = campaign
        self._operator = operator
        self._resume = resume
        self._compare = compare

    def run(self) -> None:
        """Run every step until it is accepted.

        Raises what the operator and `Campaign.accept` raise.
        """
        for number, step in enumerate(self.steps, 1):
            before = recent(self._campaign, step, RESUME_WITHIN) if self._resume else None
            if before is not None:
                self._operator.on_resumed(number, before)
            self.kept.append(before or self._record_until_accepted(step))

    @property
    def kept_words(self) -> str:
        """How many steps are kept, a sentence."""
        n_kept, total = len(self.kept), len(self.steps)
        if not n_kept:
            return f"0 of {total} steps kept; the earlier calibration is unchanged."
        return f"{n_kept} of {total} steps {'is' if n_kept == 1 else 'are'} kept in {self._campaign.certificate}."

    def _record_until_accepted(self, step: Step) -> Evidence:
        anew = step.kind == StepKind.ZERO and not self._compare
        while True:
            # Before the first accepted step there is no certificate: the designs stand in for it.
            evidence = self._operator.record(step, self._campaign.calibration or self._campaign.solution())
            try:
                calibration = self._campaign.accept(evidence, anew=anew)
            except CalibrationError as error:
                # Nothing was kept: the operator either returns, to repeat the step, or raises.
                self._operator.on_refused(error)
                continue
            self._operator.on_accepted(evidence, calibration)
            return evidence


def steps_of(quantity: str, joint: int | None, turned: tuple[Axis, float] | None = None) -> tuple[Step, ...]:
    """Return the steps that measure `bias`, `zero`, `misalignment` or `scale`.

    They are of a joint, or a turn of the whole robot.
    """
    if quantity == "bias":
        return (rest(),)
    if quantity == "zero":
        return (zero(joint),)
    if turned is not None:
        return (turn(*turned),)
    if joint is None:
        raise ValueError(f"{quantity} needs a joint")
    return swings(joint) if quantity == "misalignment" else sweeps(joint)


def fit_steps(steps: Sequence[Step], model: RobotModel) -> tuple[Step, ...]:
    """Return the steps of a robot of fewer parts: without absent bodies, measured by the IMUs that are there.

    Raises:
        UsageError: no IMU measures one of them, or the joint is absent.
    """
    bodies, sensed = set(bodies_of(model)), set(bodies_with_imu(model))
    fitted = []
    for step in steps:
        if step.joint is not None:
            require_joint(model, step.joint)
        by_gyro = step.kind in (StepKind.SWING, StepKind.SWEEP, StepKind.TURN)
        moved = tuple(body for body in step.moved if body in (sensed if by_gyro else bodies))
        if moved or not step.moved:
            fitted.append(
                replace(step, moved=moved, held=tuple(body for body in step.held if body in bodies))
            )
    if not fitted:
        raise UsageError(
            what=f"No IMU of {model.name} measures this: the bodies that move have none.",
            meaning="Nothing was measured, and no drop misses it.",
            next_step=Advice("What is left to measure: ", NextStep("calibrate show")),
        )
    return tuple(fitted)


def with_rest(steps: Sequence[Step], campaign: Campaign, model: RobotModel) -> tuple[Step, ...]:
    """Return the steps, preceded by a rest unless a recent one gives the biases."""
    first = fit_steps([rest()], model)
    return tuple(steps) if recent(campaign, first[0], REST_HOLDS) is not None else (*first, *steps)


def recent(campaign: Campaign, step: Step, within: timedelta) -> Evidence | None:
    """Find the step's recording, if it is no older than `within` and the robot has not landed since."""
    landing = None if campaign.calibration is None else campaign.calibration.last_landing
    for evidence in campaign.evidence:
        fresh = datetime.now(UTC) - evidence.recorded_at <= within
        if evidence.step == step and fresh and (landing is None or evidence.recorded_at > landing):
            return evidence
    return None
