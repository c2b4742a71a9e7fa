"""A drop of the emulated robot after a quiet wait in the releaser, and the biases that its gyros had."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from tests.fixtures.emulated_drop import drop
from tfsat_host.emulated.emulated_robot import DEFAULT_SEED, US_PER_S
from tfsat_host.emulated.imperfections import draw_as_built


@cache
def quiet_drop(
    seed: int, wait_us: int = 14_000_000, unix_us: int = 0, *, as_built: bool = False
) -> tuple[bytes, NDArray[np.float64]]:
    """Return the card of a drop after a quiet wait, and the true biases (4, 3) in rad/s.

    Args:
        seed: Seed of the noise, and of a robot that is not `as_built`.
        wait_us: Time from the start of the recording to the drop.
        unix_us: Time of day at the start of the recording; 0: the logger was not told it.
        as_built: Use the very robot that `calibrate --emulated` has on its bench.
    """
    built = draw_as_built(DEFAULT_SEED) if as_built else None
    emulated_drop = drop(
        imperfections=built, seed=seed, armed=False, wait_us=wait_us - US_PER_S, unix_us=unix_us
    )
    return emulated_drop.card, emulated_drop.imperfections.gyro_bias_rad_s
