"""All integrity checks of one drop, with the likely cause of what failed."""

from __future__ import annotations

from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.evaluation.checks.check import Check
from tfsat_host.evaluation.checks.consistency import consistency_of
from tfsat_host.evaluation.checks.diagnosis import evidence_check, explain_checks, whole_residual
from tfsat_host.evaluation.checks.momentum_checks import momentum_checks
from tfsat_host.evaluation.checks.recording_checks import completeness_checks
from tfsat_host.evaluation.checks.rest_checks import BIAS, noise_check, rest_checks
from tfsat_host.evaluation.checks.sensor_agreement import (
    attitude_check,
    axes_check,
    lag_check,
    neighbour_checks,
    pair_checks,
    scale_checks,
    sensed_checks,
    stated_check,
    weight_check,
)
from tfsat_host.evaluation.checks.stated_errors import stated_errors
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

    Args:
        motion: Of the drop.
        fit: Of the model to it; None if there is none: momentum is then not checked.
        log: The recording, with the time before the release.
        calibration: That `motion` was made with.
        model: Joints and sensors.
        diagnosed: Look for the cause of what failed, which takes seconds.
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
    return (*complete, *own, *contradictory)
