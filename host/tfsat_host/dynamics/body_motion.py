"""What every body does in a flight: its attitude, and the rates that an ideal gyro fixed to it would read."""

from __future__ import annotations

import numpy as np

from tfsat_host.dynamics.components import FloatArray
from tfsat_host.dynamics.poses import poses
from tfsat_host.dynamics.propagate import Flight


def body_attitudes(flight: Flight) -> FloatArray:
    """(m, n, 3, 3): from the axes of each body to inertial axes, at the instants of the flight."""
    rotation, _ = poses(flight.body, flight.angles_rad)
    return np.asarray(flight.attitude()[:, None] @ rotation)


def body_rates_rad_s(flight: Flight) -> FloatArray:
    """(m, n, 3): angular rate of each body against inertial space, in its own axes."""
    body = flight.body
    rotation, _ = poses(body, flight.angles_rad)
    in_base = [flight.rate_rad_s] * body.n_bodies
    for step in body.steps:
        axis = rotation[:, step.parent] @ (step.sign * body.joint_axis[step.joint])
        in_base[step.child] = in_base[step.parent] + axis * flight.angle_rates_rad_s[:, step.joint, None]
    return np.asarray(np.einsum("mnji,mnj->mni", rotation, np.stack(in_base, axis=1)))
