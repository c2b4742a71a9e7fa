"""All integrity checks of one drop, with the likely cause of what failed: all hypotheses are tried on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.evaluation.checks.cause_evidence import (
    TestedHypothesis,
    in_words,
    of_no_kind,
    rank_causes,
    try_hypotheses,
)
from tfsat_host.evaluation.checks.check import NATS, Cause, Check, Kind
from tfsat_host.evaluation.checks.consistency import Consistency, consistency_of
from tfsat_host.evaluation.checks.gross_faults import gross_faults
from tfsat_host.evaluation.checks.momentum_checks import momentum_checks
from tfsat_host.evaluation.checks.recording_checks import completeness_checks
from tfsat_host.evaluation.checks.rest_checks import BIAS, noise_check, rest_checks
from tfsat_host.evaluation.checks.sensor_agreement import (
    AS_STATED,
    LITTLE_STATED,
    WEIGHT,
    attitude_check,
    axes_check,
    is_measured,
    lag_check,
    neighbour_checks,
    pair_checks,
    scale_checks,
    sensed_checks,
    stated_check,
    weight_check,
)
from tfsat_host.evaluation.checks.small_faults import (
    AXIS,
    NO_SENSORS,
    WEIGHT_FELT,
    WORSE,
    passing_faults,
    stated_faults,
)
from tfsat_host.evaluation.checks.stated_errors import StatedErrors, axis_std_rad, stated_errors
from tfsat_host.evaluation.checks.whole_residual import ModelRows, WholeResidual
from tfsat_host.evaluation.com_fit.com_fit import ModelFit
from tfsat_host.evaluation.motion.motion import Motion
from tfsat_host.evaluation.rest import hanging_before_release
from tfsat_host.robot import RobotModel
from tfsat_host.sdlog import DropLog


def checks_of(
    motion: Motion,
    fit: ModelFit | None,
    log: DropLog,
    calibration: Calibration,
    model: RobotModel,
    *,
    diagnosed: bool = True,
) -> tuple[Check, ...]:
    """Checks one drop; the order is that of the causes: readings, rest, sensors among each other, momentum.

    Without a `fit` of the model momentum is not checked. `calibration` is that which `motion` was made with.
    `diagnosed`: look for the cause of what failed, which takes seconds.
    """
    complete = list(completeness_checks(log, motion, model))
    hanging = hanging_before_release(log, calibration, model)
    data = consistency_of(motion, hanging, LowPass.of(log.header), calibration, model)
    stated = stated_errors(data)
    rest = [*rest_checks(data, stated), noise_check(motion.densities_rad_s_rthz)]
    sensors = [
        stated_check(motion, calibration),
        *neighbour_checks(data, stated),
        *pair_checks(data, stated),
        *sensed_checks(data, stated, motion.joints),
        *scale_checks(data, stated),
        lag_check(motion, calibration),
        attitude_check(motion, calibration, model),
    ]
    # One residual of all sensors and the model: an error that shows in both is counted once.
    residuals = whole_residual(motion, fit, data, stated)
    # Accelerometers and noise have causes of their own.
    own = [check for check in rest if check.name != BIAS.name]
    biases = [check for check in rest if check.name == BIAS.name]
    filed = [weight_check(motion, data), axes_check(motion, calibration)]
    momentum = momentum_checks(motion, fit, model.base)
    contradictory = [*biases, *sensors, *filed, *momentum, evidence_check(residuals)]
    # Hypotheses take seconds: try them only where something failed.
    if diagnosed and any(check.failed for check in contradictory):
        contradictory = explain_checks(contradictory, residuals)
    absent = _names_without_sensors(model)
    return tuple(check for check in (*complete, *own, *contradictory) if check.name not in absent)


def _names_without_sensors(model: RobotModel) -> set[str]:
    """Return the names of the checks between sensors one of which the robot file does not have."""
    names = set()
    for joint, servo in enumerate(model.servos, 1):
        if servo.absent:
            names.add(f"angle sensors of joint {joint}")
        ends = sorted((int(model.joint_inner[joint - 1]), int(model.joint_outer[joint - 1])))
        if any(model.imus[body].absent for body in ends):
            names |= {f"angle sensors and gyros of joint {joint}", f"gyro scale at joint {joint}"}
            names.add("gyros of bodies " + " and ".join(str(body + 1) for body in ends))
    return names


_ROUNDS = 6
_LINEAR_RAD = np.deg2rad(0.3)
"""Axes that lean by so much more are no other linear problem."""
_MAX_FIRST_STEP_RAD = np.deg2rad(10.0)
"""A first step may be as far off as an axis that leans is not linear."""


AS_FILED = Kind("as filed and certified", NATS, ("offsets",))
EVIDENCE_THRESHOLD_NATS = float(np.log(100.0))
"""Against all being as filed and certified: "decisive" (H. Jeffreys, Theory of Probability, 1961, appendix B)."""


def evidence_check(residuals: WholeResidual) -> Check:
    """Check that no cause is so likely that robot file or certificate must be wrong, whatever else passed."""
    if not is_measured(residuals.data.calibration):
        return AS_FILED.not_possible(LITTLE_STATED)
    sound, _ = of_no_kind(residuals)
    best = max(try_hypotheses(residuals, stated_faults(residuals)), key=lambda trial: trial.log_evidence)
    # Logarithm of the Bayes factor between the likeliest fault and none.
    value = best.log_evidence - sound.log_evidence
    sentence = f"Likeliest other cause: {best.kind}, log Bayes factor {value:.1f} against none."
    return AS_FILED.judge(value, EVIDENCE_THRESHOLD_NATS, sentence)


def whole_residual(
    motion: Motion, fit: ModelFit | None, data: Consistency, stated: StatedErrors
) -> WholeResidual:
    """Build the residual of one drop: of its sensors, and of its model if one was fitted."""
    model = None if fit is None or motion.contradicted else ModelRows.of(motion, fit)
    return WholeResidual(data, stated, model)


def diagnose(residuals: WholeResidual) -> tuple[Cause, ...]:
    """Ranked, of all that can be wrong.

    While the sensors contradict each other the axes of the joints are not fitted yet, and those lean by more than
    is linear: they are found with the likeliest hypothesis, again and again, and each hypothesis counts where it
    explains the drop best.
    """
    small = now = _small(residuals)
    here = residuals
    for _ in range(_ROUNDS if residuals.model is None else 0):
        # Fit the axes together with the likeliest fault, and linearize anew where they lead.
        fitted_tilt = _axes_found(here, max(now, key=lambda trial: trial.log_evidence))
        tilt = np.clip(fitted_tilt, -_MAX_FIRST_STEP_RAD, _MAX_FIRST_STEP_RAD)
        if np.abs(tilt - here.data.tilt_rad).max() < _LINEAR_RAD:
            break
        here = _linear_at(residuals.data, tilt)
        now = _small(here)
        # Each hypothesis keeps the best evidence of all linearizations.
        small = [max(pair, key=lambda trial: trial.log_evidence) for pair in zip(small, now, strict=True)]
    return rank_causes([*of_no_kind(residuals), *small, *try_hypotheses(residuals, gross_faults(residuals))])


def explain_checks(checks: Sequence[Check], residuals: WholeResidual) -> list[Check]:
    """Return the checks, each failed one with its compared causes.

    A sensor's fault affects everything that the sensors measure, and the check protects that.
    """
    causes = diagnose(residuals)
    explained_checks = [check.attach_causes(causes, *in_words(causes)) for check in checks]
    kind = causes[0].kind
    if kind in NO_SENSORS:
        return explained_checks
    # A sensor is at fault: what rests on it is spoilt, although the check itself protects offsets only.
    spoilt = WEIGHT.protects if kind == WEIGHT_FELT else AS_STATED.protects
    return [
        replace(check, protects=spoilt) if check.name == AS_FILED.name else check
        for check in explained_checks
    ]


def _small(residuals: WholeResidual) -> list[TestedHypothesis]:
    return try_hypotheses(residuals, [*stated_faults(residuals), *passing_faults(residuals)])


def _axes_found(residuals: WholeResidual, with_one: TestedHypothesis) -> FloatArray:
    """(3, 2) tilts of the joints' axes, if one hypothesis is true."""
    std = WORSE * axis_std_rad(residuals.data)
    tilts = std * residuals.whiten(residuals.by_tilts)
    # The hypothesis that the axes lean has no other numbers than these.
    columns = tilts if with_one.kind == AXIS else np.concatenate([tilts, with_one.columns], axis=1)
    # Columns are in prior standard deviations: the prior's information is the identity.
    normal = np.eye(columns.shape[1]) + columns.T @ columns
    solution = np.linalg.solve(normal, columns.T @ residuals.whiten(residuals.residual))
    return np.asarray(-std * solution[: residuals.by_tilts.shape[1]].reshape(-1, 2))


def _linear_at(filed: Consistency, tilt_rad: FloatArray) -> WholeResidual:
    """Build the sensors' residual for joint axes tilted by `tilt_rad` from those of the robot file."""
    axes = Multibody.of(filed.model).tilt_hinges(tilt_rad).joint_axis
    data = replace(filed, model=replace(filed.model, joint_axis=axes), tilt_rad=tilt_rad)
    return WholeResidual(data, stated_errors(data), None)
