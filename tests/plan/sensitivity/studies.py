"""The maneuver 59/70 of the drop tower robot, and studies of it."""

from __future__ import annotations

import dataclasses

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.plan.error_sources import error_sources
from tfsat_host.plan.parameters import Parameters, Plan, PlannedStroke
from tfsat_host.plan.study import Study
from tfsat_host.robot import RobotModel, Uncertainty

RATE_RAD_S = np.radians(170.0)
STROKES = tuple(
    PlannedStroke(joint, np.radians(delta_deg), start_s)
    for joint, delta_deg, start_s in ((0, 59.0, 0.70), (1, 70.0, 1.05), (0, -59.0, 1.47), (1, -70.0, 1.82))
)
EXACT = Uncertainty(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def parameters_of(robot: RobotModel, initial_rate_rad_s: FloatArray | None = None) -> Parameters:
    return Parameters.of(robot, Plan.of(robot, STROKES, RATE_RAD_S, until_s=2.5), initial_rate_rad_s)


def study_of(robot: RobotModel, stated: Uncertainty, *, samples: int, seed: int = 0) -> Study:
    parameters = parameters_of(robot)
    return Study(parameters, error_sources(parameters, stated), samples, seed)


def stated_by(robot: RobotModel) -> Uncertainty:
    assert robot.uncertainty is not None
    return robot.uncertainty


def scale_uncertainty(stated: Uncertainty, factor: float) -> Uncertainty:
    return Uncertainty(**{name: factor * value for name, value in dataclasses.asdict(stated).items()})
