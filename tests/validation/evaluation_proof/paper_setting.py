"""The paper's way replayed: 5 Hz, no scale factors, angle sensors for the first angle only, a swarm on the momentum.

    The sensors are those of its section "Calibrations": biases, zero points and misalignments are calibrated, every
    scale factor is taken for one and is off by up to 3 %. The offsets are searched by its objective with N = 25, and
    next to that by our evaluation, which is told how far the scale factors may be off and learns them from the drop.

Each robot flies twice: once with its centers of mass up to 10 mm from where its model has them, and once exactly as its
model says, so that whatever is then corrected is the sensors' error.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tests.fixtures.emulated_drop import DLPF_5_HZ, Drop
from tests.validation.calibration_proof.robots import Errors
from tests.validation.evaluation_proof.flights import Difference, fly_drop
from tests.validation.evaluation_proof.objective import least_of_objective, with_centers
from tests.validation.evaluation_proof.robots import Robot
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.evaluation.com_fit.paper_swarm import swarm_fit
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.sdlog import DropLog

RATE_RAD_S = np.deg2rad([-0.73, -0.48, -0.77])
SENSED_UNTIL_S = 0.6
"""The first stroke is at 0.7 s: until then the angle sensors tell where the joints are."""
_UNDOUBTED_STD = 1e-6
_EXACT = 9
"""Number of the drop of a robot that is as its model."""


@dataclass(frozen=True, eq=False)
class Replay:
    """One drop evaluated in the paper's way.

    Attributes:
        swarm_mm: (9,) what the swarm corrects: the offsets that it finds.
        swarm_error_mm: (9,) that less the truth.
        least_error_mm: (9,) where the paper's objective is really least, less the truth.
        fit: Our fit on the same data: error, and std as stated, mm.
        true_model: The difference that the robot's true model shows: all of it is the sensors'.
        learnt: The same with the scale factors that our evaluation learns.
        before: The model as its file has it.
        after: With the swarm's offsets.
        calibrated_fit: Our fit of the same drop, all sensors calibrated and used.
        judged_before: The model as its file has it, judged by those sensors.
        judged_after: With the swarm's offsets, likewise.
    """

    swarm_mm: FloatArray
    swarm_error_mm: FloatArray
    least_error_mm: FloatArray
    fit: Errors
    true_model: Difference
    learnt: Difference
    before: Difference
    after: Difference
    calibrated_fit: Errors
    judged_before: Difference
    judged_after: Difference


def replays_of(robot: Robot, drop_5_hz: Drop) -> dict[str, Replay]:
    """Replay one drop with CoM offsets and one without."""
    # The model flies exactly as filed: whatever is then corrected is a sensor's error.
    exact = fly_drop(robot, robot.model, _EXACT, DLPF_5_HZ, rate_rad_s=RATE_RAD_S)
    return {"10 mm off": _replay(robot, drop_5_hz), "exact": _replay(robot, exact)}


def _replay(robot: Robot, drop: Drop) -> Replay:
    log = _sensed_at_first(drop.log)
    # Three evaluations: scale factors taken for one, scale factors fitted to the drop, all sensors calibrated.
    paper_evaluation = evaluate(log, robot.model, _taken_for_one(robot.paper_calibration), drop.schedule)
    evaluation = evaluate(log, robot.model, robot.paper_calibration, drop.schedule)
    calibrated = evaluate(drop.log, robot.model, robot.calibration, drop.schedule)
    driven = paper_evaluation.explained.driven
    # One search, as the paper has one.
    swarm = swarm_fit(paper_evaluation.explained.fit, driven.flown, seeds=[robot.seed])
    return Replay(
        swarm.values,
        swarm.values - drop.true_com_offsets_mm,
        least_of_objective(driven, swarm.values) - drop.true_com_offsets_mm,
        _errors(drop, evaluation),
        # At the true offsets what is left of the difference is the sensors'.
        Difference.of(with_centers(driven, drop.true_com_offsets_mm)),
        Difference.of(with_centers(evaluation.explained.driven, drop.true_com_offsets_mm)),
        Difference.of(paper_evaluation.explained.nominal),
        Difference.of(with_centers(driven, swarm.values)),
        _errors(drop, calibrated),
        Difference.of(calibrated.explained.nominal),
        Difference.of(with_centers(calibrated.explained.driven, swarm.values)),
    )


def _taken_for_one(calibration: Calibration) -> Calibration:
    """Scale factors that nobody doubts: so no sensor corrects another."""
    gyros = []
    for gyro in calibration.gyros:
        covariance = gyro.covariance.copy()
        # Variance of the scale factors only; their correlations with bias and misalignment are cut.
        covariance[6:9], covariance[:, 6:9] = 0.0, 0.0
        covariance[6:9, 6:9] = _UNDOUBTED_STD**2 * np.eye(3)
        gyros.append(replace(gyro, covariance=covariance))
    return replace(calibration, gyros=tuple(gyros))


def _errors(drop: Drop, evaluation: Evaluation) -> Errors:
    fit = evaluation.explained.fit
    return Errors(fit.values[:9] - drop.true_com_offsets_mm, fit.std[:9])


def _sensed_at_first(log: DropLog) -> DropLog:
    """Return the log as if the angle sensors had stopped before the first stroke."""
    # Angle sensors silent from the first stroke on: the joints' angles then come from the gyros alone.
    valid = log.angle_valid & (log.t_s < SENSED_UNTIL_S)[:, None]
    return replace(log, angle_valid=valid)
