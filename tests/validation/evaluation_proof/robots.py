"""Emulated robots with hidden errors, each calibrated from nothing: as the issue asks, and as the paper did it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tests.calibration.emulated_day import DAY_BEGINS, CalibrationDay, calibration_day
from tests.evaluation.drops import with_com_offsets
from tests.validation.calibration_proof.robots import calibrate_day, design
from tfsat_host.calibration.certificate.certificate import Calibration, Subject
from tfsat_host.calibration.sensors.gyro import SCALE_STD, GyroCalibration
from tfsat_host.calibration.solution import Solution
from tfsat_host.calibration.steps.step import StepKind
from tfsat_host.emulated.imperfections import Imperfections, draw_as_built
from tfsat_host.emulated.imu_part import imperfections_with, load_imu
from tfsat_host.emulated.manual_motion import Operator
from tfsat_host.rehearsal.faults.fault_catalog import fault_named
from tfsat_host.rehearsal.truth import ROBOTS_IMU, Truth
from tfsat_host.robot import RobotModel

COM_WITHIN_M = 0.010
BUILT_WITH = ("robot-file-uncertain=1", "imu-clocks=1")
"""All that `[uncertainty]` says, in one standard deviation; each IMU's oscillator within the 1 % of its data sheet."""
PAPER_STEPS = (StepKind.REST, StepKind.ZERO, StepKind.SWING)
"""What the paper measured (section "Calibrations"): biases, zero points and misalignments, no scale factors."""


@dataclass(frozen=True, eq=False)
class Robot:
    """One robot.

    Attributes:
        seed: What it was drawn from.
        model: How it is thought to be.
        flown: How it is: the centers of mass of bodies 1 to 3 are elsewhere, and all else is as wrong as its file says
            that it may be.
        truth: What is wrong with its sensors, servos and clocks.
        calibration: By all steps of docs/calibration.md.
        paper_calibration: By the paper's, every scale factor taken for one.
    """

    seed: int
    model: RobotModel
    flown: RobotModel
    truth: Imperfections
    calibration: Calibration
    paper_calibration: Calibration


def robot_of(seed: int) -> Robot:
    """Builds and calibrates it; a dozen seconds. Raises CalibrationError."""
    model, truth = design(seed), imperfections_with(load_imu(ROBOTS_IMU), seed, draw_as_built(seed))
    offsets = np.random.default_rng([seed, 9]).uniform(-COM_WITHIN_M, COM_WITHIN_M, (3, 3))
    built = Truth(seed, with_com_offsets(model, offsets), truth, np.zeros(3))
    for mismatch in BUILT_WITH:
        built = fault_named(mismatch).apply(built)
    truth = built.imperfections
    # Calibrated by the filed model: nobody knows what was really built.
    day = replace(calibration_day(built.model, truth, Operator.human(seed), seed), model=model)
    # The paper's steps alone leave the scale factors unknown.
    paper_evidence = tuple(evidence for evidence in day.evidence if evidence.step.kind in PAPER_STEPS)
    by_paper = calibrate_day(replace(day, evidence=paper_evidence))
    return Robot(
        seed,
        model,
        built.model,
        truth,
        _certificate(day, calibrate_day(day), None),
        _certificate(day, by_paper, [_scale_unknown(gyro) for gyro in by_paper.gyros]),
    )


def _certificate(
    day: CalibrationDay, solution: Solution, gyros: Sequence[GyroCalibration] | None
) -> Calibration:
    origin = day.evidence[0].origin
    subject = Subject(day.model.name, origin.logger_serial, origin.who_am_i, True)
    return Calibration(subject, tuple(gyros or solution.gyros), solution.joints, (), (), (), DAY_BEGINS)


def _scale_unknown(gyro: GyroCalibration) -> GyroCalibration:
    """Return the swings' calibration with the scale factors that the gyro's data sheet promises."""
    covariance = gyro.covariance.copy()
    # Without measured scale factors the data sheet's tolerance is all that is known of them.
    covariance[6:9, :] = covariance[:, 6:9] = 0.0
    covariance[6:9, 6:9] = SCALE_STD**2 * np.eye(3)
    return replace(gyro, scale=np.ones(3), covariance=covariance)
