"""What is asked of a simulator, and a flight made of its answers: momentum conserved, attitude by DOP853."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from tests.dynamics.histories import ClosedForm
from tfsat_host.arrays import FloatArray


@dataclass(frozen=True)
class State:
    """A robot in free fall: base attitude (x, y, z, w), base rate in base axes, joint angles and rates."""

    quaternion: FloatArray
    rate: FloatArray
    angles: FloatArray
    angle_rates: FloatArray


class Simulator(Protocol):
    """A robot in somebody else's dynamics."""

    def base_rate(self, angles: FloatArray, angle_rates: FloatArray, momentum: FloatArray) -> FloatArray:
        """Base rate (3,) at which the whole robot has `momentum` (3,) about its CoM; both in base axes."""
        ...

    def attitudes(self, state: State) -> FloatArray:
        """Rotation matrices (n, 3, 3) from each body's axes to inertial axes, in the robot file's order."""
        ...

    def momentum(self, state: State) -> FloatArray:
        """Angular momentum (3,) of the whole robot about its CoM, inertial axes."""
        ...

    def kinetic_energy_j(self, state: State) -> float:
        """Kinetic energy of the robot whose CoM is at rest."""
        ...


def fly(simulator: Simulator, history: ClosedForm, release: State, times_s: FloatArray) -> list[State]:
    """Simulate a flight released at time 0 and return its states at `times_s` (m,)."""
    # Angular momentum is conserved: it is the release's, throughout the flight.
    momentum = simulator.momentum(release)

    def rate(t: float, q: FloatArray) -> FloatArray:
        in_base = Rotation.from_quat(q).inv().apply(momentum)
        return simulator.base_rate(history.angles(t), history.rates(t), in_base)

    def derivative(t: float, q: FloatArray) -> FloatArray:
        x, y, z = rate(t, q)
        # The quaternion's derivative, scalar last.
        omega = np.array([[0, z, -y, x], [-z, 0, x, y], [y, -x, 0, z], [-x, -y, -z, 0]])
        return np.asarray(0.5 * omega @ q)

    solution = solve_ivp(
        derivative,
        (0.0, float(times_s[-1])),
        release.quaternion,
        method="DOP853",
        t_eval=times_s,
        rtol=1e-10,
        atol=1e-11,
    )
    return [
        State(q / np.linalg.norm(q), rate(t, q), history.angles(t), history.rates(t))
        for t, q in zip(solution.t, solution.y.T, strict=True)
    ]
