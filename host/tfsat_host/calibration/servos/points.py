"""How a servo is measured: where it is sent, and where it came to rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil
from typing import Final

from tfsat_host.protocol.messages import ServoSetting

STEP_CDEG: Final = 1500
"""About so far from place to place."""
LEAST_STEPS: Final = 5
"""Closer together where the limits are narrow: so many places tell a bend from scatter."""
ROUNDS: Final = 2
"""Each place is visited so often from either side: repeated visits tell how well the servo repeats itself."""
HOLD_S: Final = 1.0
"""How long each visit is held."""


@dataclass(frozen=True, slots=True)
class ServoPoint:
    """One visit: the servo was given a pulse and came to rest.

    Attributes:
        pulse_us: Width of the pulse that held it.
        direction: How the joint came there: +1 opening, -1 closing, 0 where that is unknown.
        reached_rad: Joint angle at rest.
        std_rad: Standard deviation of that by the sensors' noise alone; the servo's own scatter is found from the
            visits, and an error that all visits share (zero point, scale) is the sensors' calibration's.
    """

    pulse_us: float
    direction: int
    reached_rad: float
    std_rad: float


def servo_plan(servo: ServoSetting) -> tuple[int, ...]:
    """Angles to command one after the other (0.01 deg): up and down over the joint's limits, `ROUNDS` times.

    It begins and ends at the lower limit, and each place is held for `HOLD_S`.
    """
    span_cdeg = servo.max_cdeg - servo.min_cdeg
    steps = max(ceil(span_cdeg / STEP_CDEG), LEAST_STEPS)
    up = [servo.min_cdeg + round(span_cdeg * step / steps) for step in range(steps + 1)]
    return (up[0], *(up[1:] + up[-2::-1]) * ROUNDS)


def arrivals(angles: Sequence[float]) -> tuple[int, ...]:
    """From which side each commanded angle is reached, as `ServoPoint.direction`; unknown until the
    joint moves."""
    directions = [0]
    for before, after in pairwise(angles):
        directions.append((after > before) - (after < before) or directions[-1])
    return tuple(directions[: len(angles)])
