"""Chains of primitives flown: after each the attitude is measured, and the rest is planned anew where it must.

The robot that flies need not be the one that the planner knows, and what is measured need not be true.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tfsat_host.dynamics import Multibody, path_rotation, quaternion
from tfsat_host.dynamics.components import FloatArray
from tfsat_host.orbit.planner import Chain, Planner, remainder
from tfsat_host.orbit.primitives import Primitive

Outcome = Literal["within tolerance", "no progress", "primitives used up"]

# While more primitives are to come, a chain may lead so far beside the target: a short one mends it at the end.
_DRIFT_RAD = math.radians(1.0)
# Plans without progress before the flight gives up: noise may hide it once or twice.
_PATIENCE = 6


@dataclass(frozen=True)
class Sensing:
    """How the attitude is measured.

    Attributes:
        noise_rad: Standard deviation of its error about each body axis, independent at every measurement.
        seed: Of the errors.
    """

    noise_rad: float = 0.0
    seed: int = 1


@dataclass(frozen=True, eq=False)
class Step:
    """One primitive flown.

    Attributes:
        primitive: What was flown.
        predicted_xyzw: (4,) attitude after it, by the planner, from what was measured before it.
        attitude_xyzw: (4,) attitude after it.
        measured_xyzw: (4,) the same, as measured.
        error_rad: From `attitude_xyzw` to the target.
        measured_error_rad: From `measured_xyzw` to the target.
    """

    primitive: Primitive
    predicted_xyzw: FloatArray
    attitude_xyzw: FloatArray
    measured_xyzw: FloatArray
    error_rad: float
    measured_error_rad: float


@dataclass(frozen=True, eq=False)
class Flight:
    """How a target attitude was approached.

    Attributes:
        target_xyzw: (4,).
        tolerance_rad: What was asked for.
        start_error_rad: At the start.
        steps: The primitives in order.
        outcome: Why it ended; "within tolerance" is what the robot believes by what it measured.
    """

    target_xyzw: FloatArray
    tolerance_rad: float
    start_error_rad: float
    steps: tuple[Step, ...]
    outcome: Outcome

    @property
    def error_rad(self) -> float:
        """The true error at the end."""
        return self.steps[-1].error_rad if self.steps else self.start_error_rad

    @property
    def least_error_rad(self) -> float:
        """The smallest true error at the start or after any primitive."""
        return min([self.start_error_rad, *(step.error_rad for step in self.steps)])

    @property
    def duration_s(self) -> float:
        """Time that the joints move."""
        return sum(step.primitive.duration_s for step in self.steps)

    @property
    def reached(self) -> bool:
        """Whether the true error at the end is within the tolerance."""
        return self.error_rad <= self.tolerance_rad


def fly(
    planner: Planner,
    target_xyzw: FloatArray,
    *,
    plant: Multibody | None = None,
    sensing: Sensing | None = None,
    initial_xyzw: FloatArray | None = None,
) -> Flight:
    """Approach a target with feedback after every primitive.

    Args:
        planner: Chooses the primitives.
        target_xyzw: (4,) attitude from body to inertial axes.
        plant: The robot that flies; the planner's own if None.
        sensing: How the attitude is measured; exactly if None.
        initial_xyzw: (4,) attitude at the start; the inertial axes if None.

    Returns:
        The flight. It ends when the measured error is within the planner's tolerance, when six plans brought no
        progress or none could be made, or after the planner's greatest number of primitives.
    """
    target = _unit(target_xyzw)
    attitude = quaternion.identity() if initial_xyzw is None else _unit(initial_xyzw)
    robot = planner.table.body if plant is None else plant
    sensor = _Sensor(sensing or Sensing())
    measured = sensor.measure(attitude)
    flight = Flight(target, planner.tolerance_rad, _error(attitude, target), (), "within tolerance")
    chain, nearest, patience = Chain((), 0.0), np.inf, _PATIENCE
    while _error(measured, target) > planner.tolerance_rad:
        needed = quaternion.product(quaternion.inverse(measured), target)
        if len(flight.steps) >= planner.most:
            return _ended(flight, "primitives used up")
        if not chain.primitives or _astray(chain, needed, planner.tolerance_rad):
            chain, to_go = planner.chain(needed), planner.to_go(needed)
            nearest, patience = (to_go, _PATIENCE) if to_go < nearest else (nearest, patience - 1)
            if not chain.primitives or patience == 0:
                return _ended(flight, "no progress")
        primitive, chain = chain.primitives[0], chain.after_first()
        predicted = quaternion.product(measured, primitive.quaternion_xyzw)
        attitude = quaternion.product(attitude, flown(robot, planner.table.start_rad, primitive))
        measured = sensor.measure(attitude)
        step = Step(
            primitive, predicted, attitude, measured, _error(attitude, target), _error(measured, target)
        )
        flight = Flight(
            target, planner.tolerance_rad, flight.start_error_rad, (*flight.steps, step), "within tolerance"
        )
    return flight


def open_loop_error_rad(
    planner: Planner,
    target_xyzw: FloatArray,
    *,
    plant: Multibody,
    initial_xyzw: FloatArray | None = None,
) -> float:
    """What error is left if the planner's first chain is flown to its end and nothing is measured on the way."""
    target = _unit(target_xyzw)
    attitude = quaternion.identity() if initial_xyzw is None else _unit(initial_xyzw)
    for primitive in planner.chain(quaternion.product(quaternion.inverse(attitude), target)).primitives:
        attitude = quaternion.product(attitude, flown(plant, planner.table.start_rad, primitive))
    return _error(attitude, target)


def flown(robot: Multibody, start_rad: FloatArray, primitive: Primitive) -> FloatArray:
    """Quaternion (4,) of a primitive's strokes, flown by `robot` from joint angles `start_rad` (n,)."""
    joints = [joint for joint, _ in primitive.strokes]
    return path_rotation(
        robot, joints, np.array([angle for _, angle in primitive.strokes]), start_rad=start_rad
    )


class _Sensor:
    """Measures attitudes with errors of its own."""

    def __init__(self, sensing: Sensing) -> None:
        self._noise_rad = sensing.noise_rad
        self._random = np.random.default_rng(sensing.seed)

    def measure(self, attitude: FloatArray) -> FloatArray:
        error = self._noise_rad * self._random.standard_normal(3)
        return quaternion.product(attitude, quaternion.exponential(error))


def _astray(chain: Chain, needed: FloatArray, tolerance: float) -> bool:
    """Whether the chain, flown from here, would no longer lead where it was meant to."""
    allowed = max(tolerance, _DRIFT_RAD) if len(chain.primitives) > 1 else tolerance
    remaining = float(quaternion.angle(remainder(chain.primitives, needed)))
    return remaining > max(allowed, chain.remaining_rad * (1.0 + 1e-6) + 1e-9)


def _ended(flight: Flight, outcome: Outcome) -> Flight:
    return Flight(flight.target_xyzw, flight.tolerance_rad, flight.start_error_rad, flight.steps, outcome)


def _error(attitude: FloatArray, target: FloatArray) -> float:
    return float(quaternion.angle(quaternion.product(quaternion.inverse(attitude), target)))


def _unit(values: FloatArray) -> FloatArray:
    array = np.asarray(values, dtype=np.float64)
    return np.asarray(array / np.linalg.norm(array))
