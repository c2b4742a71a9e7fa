"""What a drop tower leaves to moving joints: the limits of `tower_checks` on motion, for many maneuvers at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import Multibody
from tfsat_host.maneuver.maneuver import DEFAULT_PAUSE_S
from tfsat_host.plan.facility import DropTower, vertical_travel_mm
from tfsat_host.plan.reach_envelope import reach_of_bodies_mm
from tfsat_host.plan.tower_checks import release_velocities_mm_s
from tfsat_host.robot import RobotModel

# The checks look every 5 ms, a search less often: a corner on its arc gains less between two of its instants.
_MARGIN_MM = 0.1


@dataclass(frozen=True, eq=False)
class TowerRoom:
    """The test space around a robot that falls through it.

    Attributes:
        robot: With a shape for every body.
        tower: Where it falls.
    """

    robot: RobotModel
    tower: DropTower

    @property
    def max_moving_s(self) -> float:
        """Longest time from the first stroke's start to the last one's end."""
        tower = self.tower
        return min(
            tower.maneuver_time_max_s + tower.maneuver_time_tolerance_s, tower.fall_s - DEFAULT_PAUSE_S
        )

    @property
    def max_radius_mm(self) -> float:
        """Farthest that the robot may reach from the line of fall, drifting sideways as an earlier drop did."""
        tower = self.tower
        return tower.envelope_radius_mm - tower.observed_transversal_velocity_mm_s * tower.fall_s

    def remaining_mm(
        self, body: Multibody, t_s: FloatArray, angles_rad: FloatArray, attitude: FloatArray
    ) -> FloatArray:
        """(m, b) least distance to a limit: sideways, from the releaser, and to the bottom; negative beyond it.

        Args:
            body: The robot.
            t_s: (m, b) instants after the release, the first before anything moves.
            angles_rad: (n - 1, m, b).
            attitude: (4, m, b) of the base, from its axes to those at the release.
        """
        robot, tower = self.robot, self.tower
        x, y, z = np.concatenate(reach_of_bodies_mm(robot, body, angles_rad, attitude)).swapaxes(0, 1)
        slowest, fastest = release_velocities_mm_s(tower, float(robot.mass_kg.sum()))
        top, bottom = z.max(axis=0), z.min(axis=0)
        sideways = self.max_radius_mm - np.sqrt((x * x + y * y).max(axis=0))
        clearance = slowest * t_s - (top - top[0])
        # What lies lowest at the end goes on falling until the landing.
        until_s = np.concatenate([t_s[:-1], np.full_like(t_s[:1], tower.fall_s)])
        travel = vertical_travel_mm(fastest, until_s, tower.residual_acceleration_g)
        downwards = tower.usable_vertical_travel_mm - travel - (bottom[0] - bottom)
        return np.asarray(np.minimum(np.minimum(sideways, clearance), downwards)) - _MARGIN_MM
