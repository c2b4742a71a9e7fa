"""A flight of known accuracy: the steps are halved until the attitude no longer changes.

Conservation of momentum cannot tell how good an integration is that computes its rates from it. Two step sizes
can: at order p half the step leaves a 2^p-th of the error, so what still changes bounds what is still wrong.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tfsat_host.dynamics import quaternion
from tfsat_host.dynamics.components import FloatArray
from tfsat_host.dynamics.history import JointHistory
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.propagate import DEFAULT_STEP_S, Flight, Release, propagate_divided, step_count

TOLERANCE_RAD = math.radians(1e-4)
STEPS_MAX = 50_000
"""Steps of one flight: tens of seconds of computing."""
# A slow flight needs no more to begin with, however long it is.
_FIRST_STEPS = 1000


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


def propagate_within(
    body: Multibody,
    history: JointHistory,
    *,
    initial_attitude_xyzw: FloatArray | None = None,
    initial_rate_rad_s: FloatArray | None = None,
    tolerance_rad: float = TOLERANCE_RAD,
    order: Literal[4, 6] = 6,
    steps_max: int = STEPS_MAX,
) -> EstimatedFlight:
    """As `propagate`, with steps as short as the tolerance needs, along the whole way.

    Args:
        body, history, initial_attitude_xyzw, initial_rate_rad_s, order: As `propagate`.
        tolerance_rad: Greatest error of the attitude.
        steps_max: Most steps of a flight. Where they are not enough, `within_tolerance` is false.

    Returns:
        The flight of the shortest steps that were tried, instants 0.01 s apart or closer, unless it is very long.

    Raises:
        ValueError: as `propagate`, or the tolerance is not positive.
    """
    if not tolerance_rad > 0.0:
        raise ValueError(f"a tolerance of {tolerance_rad} rad cannot be kept")
    release = Release.of(initial_attitude_xyzw, initial_rate_rad_s)
    duration_s = float(history.breaks_s[-1] - history.breaks_s[0])
    step_s = max(2.0 * DEFAULT_STEP_S, duration_s / _FIRST_STEPS)
    first = step_count(history.breaks_s, step_s)
    parts, error = 1, math.inf
    flight = propagate_divided(body, history, release, step_s=step_s, order=order, parts=parts)
    while error > tolerance_rad and (parts == 1 or 2 * parts * first <= steps_max):
        parts, coarse = 2 * parts, flight
        flight = propagate_divided(body, history, release, step_s=step_s, order=order, parts=parts)
        error = _apart_rad(coarse, flight)
    return EstimatedFlight(flight, error, error <= tolerance_rad)


def propagate_estimated(
    body: Multibody,
    history: JointHistory,
    *,
    initial_rate_rad_s: FloatArray | None = None,
    step_s: float,
    order: Literal[4, 6] = 6,
    tolerance_rad: float = TOLERANCE_RAD,
) -> EstimatedFlight:
    """As `propagate` with these very steps, and an estimate of its error by a second flight with half the step.

    Raises:
        ValueError: as `propagate`.
    """
    release = Release.of(None, initial_rate_rad_s)
    flight, fine = (
        propagate_divided(body, history, release, step_s=step_s, order=order, parts=parts) for parts in (1, 2)
    )
    error = _apart_rad(flight, fine)
    return EstimatedFlight(flight, error, error <= tolerance_rad)


def _apart_rad(coarse: Flight, fine: Flight) -> float:
    """Greatest angle between the attitudes of two flights, the second of which has twice the steps."""
    turn = quaternion.product(quaternion.inverse(coarse.quaternion_xyzw.T), fine.quaternion_xyzw[::2].T)
    return float(np.max(quaternion.angle(turn)))
