"""The numbers of the section "Expected on-orbit performance"."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from itertools import chain

import numpy as np
from scipy.spatial.transform import Rotation

from tests.validation.paper_numbers.numbers import Row, row
from tfsat_host.dynamics import Multibody, path_rotation, rotation_angle_rad
from tfsat_host.plan.error_sources import error_sources
from tfsat_host.plan.grid import distribution
from tfsat_host.plan.grid_result import DROP_TEST_CORRECTED_ERROR_DEG, DROP_TEST_ERROR_DEG, expected_error_deg
from tfsat_host.plan.orbit.joint_motion_file import moves_of
from tfsat_host.plan.orbit.orbit_flight import Flight, fly
from tfsat_host.plan.orbit.orbit_planner import Planner
from tfsat_host.plan.orbit.primitives import primitive_table
from tfsat_host.plan.parameters import Parameters, Plan, PlannedStroke
from tfsat_host.plan.spread import derivatives, linear_spread
from tfsat_host.robot import RobotModel, Uncertainty

JOINT_RATE_DEG_S = 30.0


def orbit_rows(robot: RobotModel) -> list[Row]:
    """Compute the rows for the distribution of four-stroke loops and what follows from the best loop."""
    body = Multibody.of(robot)
    right = np.pi / 2
    # A quarter turn each, and back in reverse order: a closed loop.
    turned = path_rotation(body, [2, 1, 2, 1], np.array([right, right, -right, -right]))
    # The angle of the whole reorientation, not of one axis.
    angle_deg = float(np.degrees(rotation_angle_rad(turned)))
    efficiency = angle_deg / 360.0
    rate = JOINT_RATE_DEG_S * efficiency
    grid = distribution(body, robot.joint_limits_rad, 5.0)
    best = grid.maneuver(grid.best_by_efficiency)
    i, j = (joint + 1 for joint in best.joints)
    flights = {at_once: _plan_all_axes(robot, at_once) for at_once in (1, 3)}
    return [
        row("reorientation of joints 3 and 2 by 90 deg", "39.31", angle_deg, unit="deg"),
        # Efficiency is rotation over joint travel.
        row("its efficiency", "0.1092", efficiency),
        row("efficiency 39.31/(2 x (90 + 90)), by the paper's angle", "0.1092", 39.31 / 360.0),
        Row(
            "best efficiency of the 5 deg grid",
            "0.1092 (90/90)",
            f"{best.efficiency:.4f} ({best.alpha_deg:.0f}/{best.beta_deg:.0f})",
            f"{best.efficiency - 0.1092:+.4f}",
            {
                "loops": str(len(grid.angle_rad)),
                "the most efficient": f"joint {i} by {best.alpha_deg:.0f} deg, joint {j} by {best.beta_deg:.0f} deg",
                "it turns by": f"{best.reorientation_deg:.2f} deg",
            },
        ),
        row(
            "average reorientation rate at 30 deg/s",
            "3.28",
            rate,
            unit="deg/s",
        ),
        row("time for 90 deg", "27.4", 90.0 / rate, unit="s", details=_times(flights)),
        row("time for 90 deg, joints together", "27.4", flights[3].duration_s, unit="s"),
        row(
            "accuracy for 90 deg, model not corrected",
            "1.21",
            expected_error_deg(90.0, DROP_TEST_ERROR_DEG),
            unit="deg",
            details=_accuracies(robot, flights),
        ),
        row(
            "accuracy for 90 deg, corrected model",
            "0.92",
            expected_error_deg(90.0, DROP_TEST_CORRECTED_ERROR_DEG),
            unit="deg",
        ),
    ]


def _plan_all_axes(robot: RobotModel, moving_at_once: int) -> Flight:
    """Fly 90 deg about z, within 1 deg in all axes, with so many joints that move at the same time."""
    table = primitive_table(robot, 5.0)
    planner = Planner.of(table, "search", math.radians(1.0), share=1.0, moving_at_once=moving_at_once)
    return fly(planner, Rotation.from_euler("z", 90.0, degrees=True).as_quat())


def _times(flights: Mapping[int, Flight]) -> dict[str, str]:
    """Return what the time for the angle leaves out: the loops tilt the axis."""
    return {
        "z:90 within 1 deg in all axes": f"{flights[1].duration_s:.1f} s",
        "loops for it": str(len(flights[1].steps)),
    }


def _accuracies(robot: RobotModel, flights: Mapping[int, Flight]) -> dict[str, str]:
    """Return the rms attitude error of z:90 by the robot file's uncertainties, without a measurement on the way."""
    stated = robot.uncertainty
    assert stated is not None
    exact_servos = replace(stated, servo_speed_relative=0.0, servo_delay_s=0.0)
    return {
        f"{joints}, {servos}": f"{_attitude_error_deg(robot, flights[at_once], uncertainty):.2f} deg"
        for servos, uncertainty in (("as the file says", stated), ("servos as they are", exact_servos))
        for at_once, joints in ((1, "one joint at a time"), (3, "joints together"))
    }


def _attitude_error_deg(robot: RobotModel, flight: Flight, stated: Uncertainty) -> float:
    moves = chain(*moves_of(robot, [step.primitive for step in flight.steps]))
    strokes = [PlannedStroke(move.joint, move.delta_rad, move.start_s) for move in moves]
    plan = Plan.of(robot, strokes, math.radians(JOINT_RATE_DEG_S))
    parameters = Parameters.of(robot, plan)
    return linear_spread(derivatives(parameters), error_sources(parameters, stated)).attitude_deg
