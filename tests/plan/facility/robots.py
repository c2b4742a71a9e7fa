"""Robots whose reach is known without tfsat."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from tfsat_host.maneuver import Maneuver, Schedule, Stroke, schedule_maneuver
from tfsat_host.robot import RobotModel, load_robot


def schedule_of(*strokes: tuple[int, float], speed_deg_s: float = 170.0) -> Schedule:
    """Strokes (joint, degrees) by the schedule rule."""
    return schedule_maneuver(Maneuver(tuple(Stroke(*s) for s in strokes), speed_deg_s=speed_deg_s))


def scissors() -> RobotModel:
    """Build two equal rods of 100 mm, 1 kg each, upright end to end, hinged about y where they meet.

    By symmetry a joint angle of q tilts each by q / 2: the ends lie 100 sin(q/2) beside the hinge and the
    center of mass 50 sin(q/2), so the reach is 50 sin(q/2) and the height 200 cos(q/2).
    """
    robot = load_robot()
    return dataclasses.replace(
        robot,
        base=0,
        body_names=("lower", "upper"),
        mass_kg=np.ones(2),
        origin_m=np.zeros((2, 3)),
        com_m=np.array([[0.0, 0.0, -0.05], [0.0, 0.0, 0.05]]),
        inertia_kg_m2=np.tile(np.diag([8e-4, 8e-4, 1e-5]), (2, 1, 1)),
        shape_m=(np.array([[0.0, 0.0, -0.1], [0.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.1]])),
        joint_names=("hinge",),
        joint_inner=np.array([0]),
        joint_outer=np.array([1]),
        joint_axis=np.array([[0.0, 1.0, 0.0]]),
        joint_point_m=np.zeros((1, 3)),
        joint_limits_rad=robot.joint_limits_rad[:1],
        servos=robot.servos[:1],
        imus=(),
        angle_sensors=(),
    )


def starting_at(robot: RobotModel, *start_deg: float) -> RobotModel:
    """Return the same robot with its joints at these angles at the release."""
    servos = (
        dataclasses.replace(servo, start_rad=math.radians(angle))
        for servo, angle in zip(robot.servos, start_deg, strict=True)
    )
    return dataclasses.replace(robot, servos=tuple(servos))
