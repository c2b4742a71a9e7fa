"""The whole evaluation of one drop.

from tfsat_host.evaluation.evaluation import evaluate
drop = evaluate(load("SD.bin"), load_robot(), read_calibration("calibration.toml"), schedule)
drop.reorientation.angle_rad, drop.reorientation.std_rad
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from tfsat_host.calibration.apply import apply_calibration
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.evaluation.checks.cause_evidence import find_culprit
from tfsat_host.evaluation.checks.check import UNKNOWN, Check, SensorColumn, withheld_by
from tfsat_host.evaluation.checks.drop_checks import checks_of
from tfsat_host.evaluation.checks.recording_checks import maneuver_check
from tfsat_host.evaluation.checks.rest_checks import start_pose_check
from tfsat_host.evaluation.checks.small_faults import AXIS, NO_SENSORS, STATED_TOO_WELL
from tfsat_host.evaluation.clocks import align_clocks
from tfsat_host.evaluation.com_fit.identifiability import identifiability
from tfsat_host.evaluation.com_fit.model_comparison import compare_model
from tfsat_host.evaluation.com_fit.offsets import Offsets, model_offsets
from tfsat_host.evaluation.com_fit.paper_swarm import swarm_fit
from tfsat_host.evaluation.evaluated_drop import (
    AXES_FILED,
    CERTIFICATE,
    SENSED,
    Turn,
)
from tfsat_host.evaluation.evaluated_drop import Evaluation as Evaluation
from tfsat_host.evaluation.fall_instants import LATEST_LANDING_S, fall_instants
from tfsat_host.evaluation.fallback_calibration import with_fallbacks
from tfsat_host.evaluation.motion.motion import Motion, initial_rates, motion_of, notes_of
from tfsat_host.evaluation.motion.samples import EvaluationError, samples_of
from tfsat_host.evaluation.rest import MAX_DURATION_S, Rest, rest_before_release
from tfsat_host.evaluation.stages import ExternalObservations as ExternalObservations
from tfsat_host.evaluation.stages import find_first_stroke_s, find_release_velocity, measure_micro_gravity
from tfsat_host.evaluation.standing_joints import standing_joints
from tfsat_host.evaluation.strokes import strokes_flown
from tfsat_host.maneuver import Schedule
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.robot import ASSUMED, RobotModel
from tfsat_host.robot.absent_parts import bodies_of, ignore_absent
from tfsat_host.sdlog import DropLog
from tfsat_host.sdlog.droplog import rows_of

MIN_WIDENING, MAX_WIDENING = 3.0, 40.0
"""Checks tell the factor roughly. Sensors that still contradict each other with errors so many times as stated are not
badly calibrated, but broken."""


def evaluate(
    log: DropLog,
    model: RobotModel,
    calibration: Calibration | None,
    schedule: Schedule | None = None,
    *,
    recorded: datetime | None = None,
    witnesses: ExternalObservations | None = None,
    offsets: Offsets | None = None,
    swarm: bool = False,
) -> Evaluation:
    """Evaluates a drop.

    Args:
        log: Decoded, with a release.
        model: The robot.
        calibration: Of its sensors, the one that held at the drop; None: design values with their uncertainty, and the
            biases of the rest before the release.
        schedule: What was commanded; None: strokes are not looked for.
        recorded: When the drop was: landings since do not matter. None: all known landings come before it.
        witnesses: What else was filmed.
        offsets: What of the model may be corrected; None: all that its file calls uncertain.
        swarm: Search for the centers of mass by the paper's particle swarm, too.

    Raises:
        EvaluationError: no release, a hole in all gyros, a bias that cannot be had, or no motion that explains the
            readings.
    """
    # What the robot file does not have is not used, whatever its pins read or a certificate says of it.
    log, calibration = ignore_absent(log, model), calibration and calibration.of_robot(model)
    near = _near_fall(log)
    rest = rest_before_release(near)
    fallback = with_fallbacks(calibration, near, model, rest, recorded)
    drop = _Drop(
        near, model, schedule, rest, fallback.notes, witnesses or ExternalObservations(), offsets, swarm
    )
    return replace(drop.judge(fallback.calibration), log=log)


_NEAR_S = (-MAX_DURATION_S - 1.0, LATEST_LANDING_S + 1.0)
"""After the release: no rest is looked for earlier, and no landing later."""


def _near_fall(log: DropLog) -> DropLog:
    """Return the rows that an evaluation looks at: a robot may have hung for an hour before."""
    first, last = np.searchsorted(log.t_s, _NEAR_S)
    return rows_of(log, slice(int(first), int(last))) if first < last else log


@dataclass(frozen=True, eq=False)
class _Drop:
    """What an evaluation is made of, but for the calibration; see `evaluate`."""

    log: DropLog
    model: RobotModel
    schedule: Schedule | None
    rest: Rest
    notes: tuple[str, ...]
    witnesses: ExternalObservations
    offsets: Offsets | None
    swarm: bool

    def judge(self, calibration: Calibration) -> Evaluation:
        """Evaluate the drop, and withhold what its checks do not protect."""
        evaluation = self.evaluate(calibration)
        # One sensor that contradicts all others is left out; only several together are taken to be less certain.
        if (remaining := self.without_culprit(calibration, evaluation)) is not None:
            return remaining
        # If the sensors contradict each other, try greater errors than stated before anything is withheld.
        widened_evaluation, widest = self.with_less_stated(calibration, evaluation)
        if widened_evaluation is None:
            return replace(evaluation.with_withheld(withheld_by(evaluation.checks)), widest=widest)
        # What the greater errors explain need not be withheld any more.
        withheld = withheld_by(widened_evaluation.checks)
        return replace(
            widened_evaluation, model=self.model, calibration=calibration, checks=evaluation.checks
        ).with_withheld(withheld)

    def evaluate(self, calibration: Calibration, *, diagnosed: bool = True) -> Evaluation:
        """Evaluate the drop with one calibration, withholding nothing.

        Failed checks get no cause unless `diagnosed`.
        """
        try:
            return self._evaluate(calibration, diagnosed)
        except np.linalg.LinAlgError as error:
            # A wrong file or certificate makes the system singular: the input is at fault, not the program.
            raise EvaluationError(
                what=f"{self.log.path}: no motion explains the readings with this calibration, not even roughly "
                f"({error}).",
                meaning="There are no numbers of this drop; the recording is unchanged.",
                next_step=Advice(
                    "Check that calibration, robot file and maneuver are those of this drop, and compare the "
                    "logger's settings in the recording with yours: ",
                    NextStep("decode"),
                    ".",
                ),
            ) from error

    def with_less_stated(
        self, certificate: Calibration, evaluation: Evaluation
    ) -> tuple[Evaluation | None, float]:
        """Evaluate with the ± of certificate or joint axes widened until the sensors agree.

        The evaluation is None if the sensors agree anyhow, if no such ± reconcile them, or if the kind of cause is
        not one that greater ± describe. The second result is the greatest factor that was tried.
        """
        # Greater errors describe a badly stated certificate or axis, but no step or slip at one moment.
        kind = evaluation.causes[0].kind if evaluation.causes else UNKNOWN
        if kind not in NO_SENSORS | STATED_TOO_WELL:
            return None, 1.0
        leaning = kind == AXIS
        # A leaning joint axis spoils the offsets as well: the checks that protect them must agree, too.
        results = SENSED | {"offsets"} if leaning else SENSED
        widening, excess = 1.0, _excess(evaluation.checks, results)
        # The excess is a factor of errors: widen by it, by three at least, until the sensors agree.
        while excess > 1.0 and (widening := widening * max(excess, MIN_WIDENING)) <= MAX_WIDENING:
            drop = replace(self, model=_with_leaning_axes(self.model, widening)) if leaning else self
            calibration = certificate if leaning else certificate.widen(widening)
            # Search by the sensors' checks alone; the whole evaluation runs once, with the factor found.
            excess = drop.contradiction(calibration, results)
            if not excess:
                widened_evaluation = drop.evaluate(calibration, diagnosed=False)
                kind_widened = AXES_FILED if leaning else CERTIFICATE
                return replace(widened_evaluation, widening=widening, widened=kind_widened), widening
            # Some check still failed, however little: keep the loop going.
            excess = max(excess, 1.0 + 1e-9)
        return None, min(widening, MAX_WIDENING)

    def without_culprit(self, calibration: Calibration, evaluation: Evaluation) -> Evaluation | None:
        """Evaluate without the one sensor that the causes accuse; None if there is none, or the others do not agree."""
        culprit = find_culprit(evaluation.causes)
        if culprit is None:
            return None
        drop = replace(self, log=_silence(self.log, culprit))
        # The others must agree among each other: else the wrong one was accused, or several are wrong.
        if drop.contradiction(calibration, SENSED):
            return None
        remaining = drop.evaluate(calibration, diagnosed=False)
        # Of a sensor that is left out no note says that its samples are bridged.
        notes = tuple(note for note in remaining.notes if not note.startswith(f"The {culprit.name} lacks"))
        whole = replace(remaining, log=self.log, notes=notes, checks=evaluation.checks, left_out=culprit)
        return whole.with_withheld(withheld_by(remaining.checks))

    def contradiction(self, calibration: Calibration, results: frozenset[str]) -> float:
        """Compute how far the sensors behind any of the results contradict each other, without any model.

        The result is 0 if they do not, and infinite if no motion explains the readings with the calibration.
        """
        try:
            checks = checks_of(
                self._motion(calibration), None, self.log, calibration, self.model, diagnosed=False
            )
        except np.linalg.LinAlgError:
            # No motion explains the readings at all: worse than any contradiction.
            return np.inf
        return _excess(checks, results)

    def _motion(self, calibration: Calibration) -> Motion:
        samples = samples_of(self.log, calibration, self.model)
        return motion_of(
            samples, calibration, self.model, self.rest.densities_rad_s_rthz, LowPass.of(self.log.header)
        )

    def _evaluate(self, calibration: Calibration, diagnosed: bool) -> Evaluation:
        log, model, schedule, witnesses = self.log, self.model, self.schedule, self.witnesses
        # By sensors alone: what the robot did must not depend on the masses that are to be judged.
        motion = self._motion(calibration)
        samples = motion.samples
        # Clocks before strokes: each is looked for where the logger saw its line rise.
        clocks = (
            None if schedule is None else align_clocks(log, schedule, witnesses.video, witnesses.video_rate)
        )
        strokes = (
            () if schedule is None or clocks is None else strokes_flown(motion, schedule, clocks.stroke_s)
        )
        first_stroke_s = find_first_stroke_s(log, schedule, clocks, samples.until_s)
        # The momentum is taken before the first stroke and then drives the model's prediction.
        explained = compare_model(motion, self.offsets or model_offsets(model), first_stroke_s)
        # All of the recording: rest and landing lie outside the samples of the motion.
        calibrated_samples = apply_calibration(Counts.from_log(log), calibration, model)
        velocity, against = find_release_velocity(witnesses, motion, model, first_stroke_s, clocks)
        return Evaluation(
            log=log,
            model=model,
            calibration=calibration,
            schedule=schedule,
            notes=(
                *self.notes,
                *notes_of(motion, [gyro.body for gyro in calibration.gyros if gyro.absent]),
                *(clocks.notes if clocks else ()),
                *against,
            ),
            rest=self.rest,
            instants=fall_instants(log, calibrated_samples),
            micro_gravity=measure_micro_gravity(
                log, calibrated_samples, motion, model, first_stroke_s, strokes
            ),
            clocks=clocks,
            release_velocity=velocity,
            motion=motion,
            turns=tuple(Turn.of(body) for body in motion.bodies),
            initial_rates=initial_rates(motion, first_stroke_s),
            strokes=strokes,
            standing=standing_joints(motion, strokes, bodies_of(model)[:-1]) if strokes else (),
            explained=explained,
            identifiability=identifiability(explained.fit),
            checks=(
                *checks_of(motion, explained.fit, log, calibration, model, diagnosed=diagnosed),
                start_pose_check(log, calibration, model),
                maneuver_check(log, motion, strokes),
            ),
            swarm=swarm_fit(explained.fit, explained.driven.flown) if self.swarm else None,
        )


def _excess(checks: Sequence[Check], results: frozenset[str]) -> float:
    """Return the greatest excess of a failed check of any of the results over its limit; 0 if all passed.

    The excess is a factor of errors.
    """
    against = (check.excess for check in checks if check.failed and results.intersection(check.protects))
    return max(against, default=0.0)


def _silence(log: DropLog, sensor: SensorColumn) -> DropLog:
    """Return the log as if the sensor had never answered."""
    imu_valid, angle_valid = log.imu_valid.copy(), log.angle_valid.copy()
    (imu_valid if sensor.kind == "gyro" else angle_valid)[:, sensor.column] = False
    return replace(log, imu_valid=imu_valid, angle_valid=angle_valid)


def _with_leaning_axes(model: RobotModel, factor: float) -> RobotModel:
    stated = model.uncertainty or ASSUMED
    return replace(model, uncertainty=replace(stated, joint_axis_rad=factor * stated.joint_axis_rad))
