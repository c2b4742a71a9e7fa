"""How the bodies turned between the release and the first stroke."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.motion.motion import Motion

FloatArray = NDArray[np.float64]

SETTLED_S = 0.03
"""After the release: before, the springs still push and the low-pass remembers the hold."""
BEFORE_STROKE_S = 0.02
LEAST_SAMPLES = 5


@dataclass(frozen=True, eq=False)
class InitialRate:
    """Mean rate of one body over the quiet samples, body axes.

    Attributes:
        rate_rad_s: (3,).
        std_rad_s: (3,) from noise and the gyro's parameters.
    """

    rate_rad_s: FloatArray
    std_rad_s: FloatArray


def quiet_samples(t_s: FloatArray, first_stroke_s: float) -> NDArray[np.bool_]:
    """(n,) after the release has settled and before the first stroke; at least a few."""
    quiet = (t_s >= SETTLED_S) & (t_s < first_stroke_s - BEFORE_STROKE_S)
    if quiet.sum() < LEAST_SAMPLES:
        first = int(np.searchsorted(t_s, SETTLED_S))
        quiet = np.zeros(len(t_s), bool)
        quiet[first : first + LEAST_SAMPLES] = True
    return quiet


def initial_rates(motion: Motion, first_stroke_s: float) -> tuple[InitialRate, ...]:
    """Of each body: the mean rate is what it turned over the time, and as uncertain as that."""
    found = []
    for moved in motion.bodies:
        rows = np.flatnonzero(quiet_samples(moved.t_s, first_stroke_s))
        first, last = rows[0], rows[-1]
        by = moved.by_errors[last] - moved.by_errors[first]
        turned = by @ moved.error_covariance @ by.T
        turned = turned + moved.noise_covariance[last] - moved.noise_covariance[first]
        duration_s = moved.t_s[last] - moved.t_s[first]
        rate = moved.rate_rad_s[rows].mean(axis=0)
        found.append(InitialRate(rate, np.sqrt(np.diag(turned)) / duration_s))
    return tuple(found)
