"""A robot that differs from its model as its file says it may."""

from __future__ import annotations

import dataclasses

from tfsat_host.dynamics import Multibody
from tfsat_host.orbit.errors import OrbitError
from tfsat_host.robot import RobotModel, Uncertainty
from tfsat_host.sensitivity.parameters import Parameters
from tfsat_host.sensitivity.sources import error_sources
from tfsat_host.sensitivity.strokes import Plan, PlannedStroke
from tfsat_host.sensitivity.study import Study


def drawn_robot(robot: RobotModel, scale: float, seed: int) -> Multibody:
    """A robot drawn from the uncertainties of its file.

    Masses, centers of mass, inertias and hinges are drawn, as in a sensitivity study; strokes stay exact.

    Args:
        robot: The model.
        scale: Times the stated standard deviations.
        seed: Of the draw.

    Raises:
        OrbitError: the file states no uncertainties.
    """
    if robot.uncertainty is None:
        raise OrbitError(
            what=f"{robot.path.name} states no uncertainties, so there is nothing to draw a true robot from.",
            meaning="Nothing was planned.",
            next_step="Add a table [uncertainty] to the robot file (see robots/cubesat_3u.toml), or leave "
            "--model-error out.",
        )
    stated = Uncertainty(
        **{name: scale * value for name, value in dataclasses.asdict(robot.uncertainty).items()}
    )
    # Parameters come with a maneuver; what it is does not touch the robot.
    plan = Plan.of(robot, [PlannedStroke(joint=0, delta_rad=0.0, start_s=0.0)], 1.0)
    parameters = Parameters.of(robot, plan)
    study = Study(parameters, error_sources(parameters, stated), samples=1, seed=seed)
    drawn = parameters.robots(study.vectors(study.deviates(0)))
    return drawn.replace(
        mass_kg=drawn.mass_kg[0],
        com_m=drawn.com_m[0],
        inertia_kg_m2=drawn.inertia_kg_m2[0],
        joint_axis=drawn.joint_axis[0],
        joint_point_m=drawn.joint_point_m[0],
    )
