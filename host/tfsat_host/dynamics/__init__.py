"""A free-floating robot: attitude by conservation of angular momentum, for any joint history.

    body = Multibody.of(load_robot())
    flight = propagate(body, sampled(t_s, angles_rad), initial_rate_rad_s=[0.0, 0.0, 0.1])

Angles in radians, vectors (..., 3), quaternions (..., 4) with the scalar last; an attitude leads from body
axes to inertial axes. Without initial rate the robot has no angular momentum; then a path of strokes is
enough, whatever their speed: `path_rotation(body, joints, deltas_rad)`.
"""

from tfsat_host.dynamics.history import (
    JointHistory,
    TimedMove,
    history_from_moves,
    history_from_samples,
    servo_moves,
)
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses
from tfsat_host.dynamics.propagate import Flight, propagate
from tfsat_host.dynamics.propagate_within import propagate_within
from tfsat_host.dynamics.quaternion import rotation_angle_rad, rotation_vector_rad
from tfsat_host.dynamics.spatial_momentum import connection, joint_momentum, kinetic_energy_j, locked_inertia
from tfsat_host.dynamics.stroke import path_rotation, stroke_rotation

__all__ = [
    "Flight",
    "JointHistory",
    "Multibody",
    "TimedMove",
    "connection",
    "history_from_moves",
    "history_from_samples",
    "joint_momentum",
    "kinetic_energy_j",
    "locked_inertia",
    "path_rotation",
    "poses",
    "propagate",
    "propagate_within",
    "rotation_angle_rad",
    "rotation_vector_rad",
    "servo_moves",
    "stroke_rotation",
]
