"""Maneuvers on orbit, where time is plenty: what loops there are, how fast they turn, how they chain to a target.

    found = distribution(Multibody.of(robot), robot.joint_limits_rad, step_deg=5.0)
    found.maneuver(found.best_by_efficiency)

Angles in radians, quaternions (..., 4) with the scalar last, attitudes from body axes to inertial axes.
There is no angular momentum, so that a loop turns the robot by the same rotation at any speed.
"""

from tfsat_host.orbit.distribution import Distribution, GridManeuver, distribution
from tfsat_host.orbit.flight import Flight, Sensing, Step, fly
from tfsat_host.orbit.grid import OrbitError
from tfsat_host.orbit.planner import Planner
from tfsat_host.orbit.primitives import Primitive, PrimitiveTable, primitive_table
from tfsat_host.orbit.slew import average_rate, expected_error, slew_time_s

__all__ = [
    "Distribution",
    "Flight",
    "GridManeuver",
    "OrbitError",
    "Planner",
    "Primitive",
    "PrimitiveTable",
    "Sensing",
    "Step",
    "average_rate",
    "distribution",
    "expected_error",
    "fly",
    "primitive_table",
    "slew_time_s",
]
