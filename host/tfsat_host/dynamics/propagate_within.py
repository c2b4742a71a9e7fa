"""Propagation with steps as short as a tolerance needs, and an estimate of the error that is left."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import quaternion
from tfsat_host.dynamics.history import JointHistory
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.propagate import DEFAULT_STEP_S, Flight, Propagation
from tfsat_host.dynamics.stroke import GAIN, TOLERANCE_RAD

STEPS_MAX = 50_000
"""Steps of one flight: tens of seconds of computing."""
# A slow flight needs no more to begin with, however long it is.
_FIRST_STEPS = 1000
# A batch begins with as few steps as may do: in none of them the base turns farther by its rate at the release.
_FIRST_TURN_RAD = 0.25


@dataclass(frozen=True, eq=False)
class EstimatedFlight:
    """A flight, and how wrong it may be.

    Attributes:
        flight: The whole motion.
        error_rad: By how much its attitude differs at most from that of a flight with steps twice or half as
            long, at any instant that both have: above the error of the integration once steps are short.
        within_tolerance: Whether that is small enough.
    """

    flight: Flight
    error_rad: float
    within_tolerance: bool


class FinalAttitudes(NamedTuple):
    """Where a batch of robots ends, quaternions (4, ...), and how wrong the worst of them may be."""

    quaternion: FloatArray
    error_rad: float


def propagate_within(
    body: Multibody,
    history: JointHistory,
    *,
    initial_attitude_xyzw: FloatArray | None = None,
    initial_rate_rad_s: FloatArray | None = None,
    tolerance_rad: float = TOLERANCE_RAD,
    order: Literal[4, 6] = 6,
    steps_max: int = STEPS_MAX,
    step_s: float | None = None,
) -> EstimatedFlight:
    """Propagate as `propagate` does, with steps short enough for a tolerance along the whole flight.

    Args:
        body, history, initial_attitude_xyzw, initial_rate_rad_s, order: As `propagate`.
        tolerance_rad: Greatest error of the attitude.
        steps_max: Most steps of a flight. If they are not enough, `within_tolerance` is false.
        step_s: Longest step, whatever the tolerance needs; a second flight with half of it gives the error.

    Returns:
        The flight of the shortest steps tried, with instants 0.01 s apart or closer, unless it is very long.

    Raises:
        ValueError: as `propagate`, or the tolerance is not positive.
    """
    if not tolerance_rad > 0.0:
        raise ValueError(f"a tolerance of {tolerance_rad} rad cannot be kept")
    duration_s = float(history.breaks_s[-1] - history.breaks_s[0])
    # Begin with twice the default: the halving that gives the error then leads to it.
    longest_s = max(2.0 * DEFAULT_STEP_S, duration_s / _FIRST_STEPS) if step_s is None else step_s
    course = Propagation(
        body, history, initial_attitude_xyzw, initial_rate_rad_s, step_s=longest_s, order=order
    )
    if step_s is None:
        parts, attitudes, error = _halve_steps(course, tolerance_rad, steps_max)
    else:
        # A stated step stands: half of it serves for the estimate alone.
        parts, attitudes, fine = 1, course.attitudes(), course.attitudes(2)
        error = _angle_between_rad(attitudes, fine[::2])
    return EstimatedFlight(course.flight(parts, attitudes), error, error <= tolerance_rad)


def final_attitudes(
    body: Multibody,
    history: JointHistory,
    *,
    initial_rate_rad_s: FloatArray | None = None,
    tolerance_rad: float = TOLERANCE_RAD,
    steps_max: int = STEPS_MAX,
) -> FinalAttitudes:
    """Compute the final attitudes of a batch of robots, each with a joint history of its own.

    All take the same steps, as short as the tolerance needs for the worst of them: differences between two
    robots are then right to more digits than their attitudes.

    Args:
        body: A batch of robots, of one axis.
        history: Histories of the same batch.
        initial_rate_rad_s: (3,) rate of every base at the start, base axes; None: no angular momentum.
        tolerance_rad: Greatest error of an attitude after any of the first, longest steps.
        steps_max: Most steps of a flight. If they are not enough, the error is above the tolerance.
    """
    # A spinning base limits the first steps by its turn; without momentum one may span a whole piece.
    turning = 0.0 if initial_rate_rad_s is None else float(np.linalg.norm(initial_rate_rad_s))
    step_s = _FIRST_TURN_RAD / turning if turning > 0.0 else math.inf
    course = Propagation(body, history, None, initial_rate_rad_s, step_s=step_s, order=6)
    # The last halving may change GAIN times the tolerance: at most a 16th of that is left.
    _, attitudes, change = _halve_steps(course, GAIN * tolerance_rad, steps_max, every_instant=False)
    return FinalAttitudes(attitudes[-1], change / GAIN)


def _halve_steps(
    course: Propagation, tolerance_rad: float, steps_max: int, *, every_instant: bool = True
) -> tuple[int, FloatArray, float]:
    """Into how many parts steps are divided, the attitudes (m, 4, ...), and how much the last halving changed.

    Attitudes of every instant, or of those alone that the undivided steps have.
    """
    parts, error, fine = 1, math.inf, course.attitudes()
    # Halve once at least, for there is no estimate before.
    while error > tolerance_rad and (parts == 1 or 2 * parts * course.steps <= steps_max):
        parts, coarse = 2 * parts, fine
        fine = course.attitudes(parts, keep=1 if every_instant else parts)
        # Compare at the instants that both have.
        error = _angle_between_rad(coarse, fine[:: 2 if every_instant else 1])
    return parts, fine, error


def _angle_between_rad(a: FloatArray, b: FloatArray) -> float:
    """Greatest angle between attitudes (m, 4, ...)."""
    turn = quaternion.product(quaternion.inverse(a.swapaxes(0, 1)), b.swapaxes(0, 1))
    return float(np.max(quaternion.angle(turn)))
