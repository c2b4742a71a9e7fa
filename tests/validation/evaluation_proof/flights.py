"""The drops of one robot, and what each evaluation of them was worth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from tests.fixtures.emulated_drop import DESIGNED_TOGETHER, DLPF_5_HZ, DLPF_42_HZ, OF_THE_PAPER, Drop, drop
from tests.validation.calibration_proof.robots import Errors
from tests.validation.evaluation_proof.errors import errors_of
from tests.validation.evaluation_proof.objective import least_of_objective
from tests.validation.evaluation_proof.robots import Robot
from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.com_fit.model_comparison import ComparedModel
from tfsat_host.evaluation.com_fit.paper_swarm import swarm_fit
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.maneuver import Schedule, schedule_maneuver
from tfsat_host.robot import RobotModel

FLIGHTS = {
    "42 Hz": (DLPF_42_HZ, OF_THE_PAPER),
    "5 Hz": (DLPF_5_HZ, OF_THE_PAPER),
    "42 Hz, joints together": (DLPF_42_HZ, schedule_maneuver(DESIGNED_TOGETHER)),
}
"""The drops of each robot: setting of the gyros' low-pass, and maneuver."""
RATE_STD_DEG_S = 0.7
BODIES = (1, 2, 3, 4)


@dataclass(frozen=True, slots=True)
class Difference:
    """Measured less predicted attitude of body 1, norms in deg: at the end, and root mean square over the fall."""

    final_deg: float
    rms_deg: float

    @classmethod
    def of(cls, sides: ComparedModel) -> Difference:
        return cls(float(np.rad2deg(sides.error.final_norm_rad)), float(np.rad2deg(sides.error.rms_rad)))


@dataclass(frozen=True, eq=False)
class Flight:
    """One drop of the campaign.

    Attributes:
        errors: By the names in `LABELS`.
        excess: Of the fit.
        before: The model as its file has it.
        after: The model corrected by this drop.
        crossed: The model corrected by another drop of the robot.
        swarm_mm: (9,) error of the paper's swarm, the best of its searches.
        swarm_spread_mm: (9,) standard deviation of what its searches found.
        least_mm: (9,) error of where the swarm's objective is really least.
    """

    errors: Mapping[str, Errors]
    excess: float
    before: Difference
    after: Difference
    crossed: Difference
    swarm_mm: FloatArray
    swarm_spread_mm: FloatArray
    least_mm: FloatArray


def fly_drop(
    robot: Robot,
    true_model: RobotModel,
    number: int,
    dlpf_cfg: int,
    schedule: Schedule = OF_THE_PAPER,
    rate_rad_s: FloatArray | None = None,
) -> Drop:
    """Fly one drop; `number` tells those of a robot apart.

    Args:
        robot: Whose sensors.
        true_model: What flies.
        number: For noise and, where they are not given, initial rates.
        dlpf_cfg: Setting of the gyros' low-pass.
        schedule: The maneuver.
        rate_rad_s: (3,) of the base at the release.
    """
    # [robot, drop]: two drops of a robot differ in noise and rates, not in the robot.
    random = np.random.default_rng([robot.seed, number])
    rates = np.deg2rad(RATE_STD_DEG_S) * random.standard_normal(3) if rate_rad_s is None else rate_rad_s
    return drop(
        true_model,
        robot.truth,
        model=robot.model,
        seed=1000 * number + robot.seed,
        dlpf_cfg=dlpf_cfg,
        rate_rad_s=tuple(rates.tolist()),
        schedule=schedule,
    )


def drops_of(robot: Robot) -> dict[str, Drop]:
    """Simulate each of the robot's drops."""
    return {
        name: fly_drop(robot, robot.flown, number, dlpf_cfg, schedule)
        for number, (name, (dlpf_cfg, schedule)) in enumerate(FLIGHTS.items())
    }


def flights_of(robot: Robot, drops: Mapping[str, Drop]) -> dict[str, Flight]:
    """Evaluate each drop with the robot's calibration."""
    evaluations = {
        name: evaluate(drop.log, robot.model, robot.calibration, drop.schedule)
        for name, drop in drops.items()
    }
    # Each drop is predicted by the model that the robot's next one corrected: no model judges itself.
    names = list(evaluations)
    return {
        name: _flight(drops[name], evaluations[name], evaluations[other])
        for name, other in zip(names, names[1:] + names[:1], strict=True)
    }


def _flight(drop: Drop, evaluation: Evaluation, other: Evaluation) -> Flight:
    explained = evaluation.explained
    swarm = swarm_fit(explained.fit, explained.driven.flown)
    return Flight(
        errors_of(drop, evaluation),
        explained.fit.excess,
        Difference.of(explained.nominal),
        Difference.of(explained.fitted),
        Difference.of(explained.driven.with_offsets(other.explained.fit.values)),
        swarm.values - drop.true_com_offsets_mm,
        swarm.spread,
        # Downhill from the swarm's result: what the objective itself gets wrong, without the search's part.
        least_of_objective(explained.driven, swarm.values) - drop.true_com_offsets_mm,
    )


def without_calibration(robot: Robot, drop: Drop) -> dict[str, Errors]:
    """Compute the errors of the same drop evaluated without any calibration."""
    return errors_of(drop, evaluate(drop.log, robot.model, None, drop.schedule))


def with_dead_gyro(robot: Robot, drop: Drop, body: int) -> dict[str, Errors]:
    """Compute the errors of the same drop with the IMU of a body (1 to 4) not answering at all."""
    # The flag alone says that an IMU did not answer.
    valid = drop.log.imu_valid.copy()
    valid[:, body - 1] = False
    deaf = replace(drop.log, imu_valid=valid)
    return errors_of(drop, evaluate(deaf, robot.model, robot.calibration, drop.schedule))
