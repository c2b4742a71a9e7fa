"""How much later than the sample's time each IMU is really read, in emulated drops, and what the log says."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

from tests.evaluation.drops import Drop, drop
from tests.logger_proof.broken import Broken
from tfsat_host.emulated.imperfections import ideal
from tfsat_host.robot import load_robot

FloatArray = NDArray[np.float64]

BUSES_KHZ = (400, 100)
FALL_S = (0.3, 2.2)
"""After the release: strokes, and nothing of the landing."""
MOST_DELAY_S = 0.02
MOST_OFF_US = 100
"""A chip renews its registers each 1000 us, and 280 Hz meets seven phases of that, 143 us apart."""


@dataclass(frozen=True, slots=True)
class Offset:
    """Of one IMU at one clock of the buses, in microseconds.

    Attributes:
        told: By the log's header.
        measured: By how much earlier than IMU 1's its readings show the motion, as they stand in their samples.
    """

    bus_khz: int
    imu: int
    told: int
    measured: float


def measure_offsets(folder: Path, buses_khz: tuple[int, ...] = BUSES_KHZ) -> list[Offset]:
    """Of all IMUs at each clock. Raises Broken if the log tells another one."""
    found = []
    model = load_robot()
    for bus_khz in buses_khz:
        one = drop(folder / str(bus_khz), model, model, ideal(), seed=1, bus_khz=bus_khz)
        delays_us = [1e6 * _delay_s(one, body) for body in range(4)]
        for i, told in enumerate(one.log.header.imu_offset_us):
            found.append(Offset(bus_khz, i + 1, told, delays_us[0] - delays_us[i]))
    for offset in found:
        if abs(offset.told - offset.measured) > MOST_OFF_US:
            raise Broken(
                f"IMU {offset.imu} is read {offset.measured:.0f} us after the sample's time at {offset.bus_khz} kHz, "
                f"the log says {offset.told}"
            )
    return found


def _delay_s(one: Drop, body: int) -> float:
    """From the true angular speed to the one that a body's gyro shows, the low-pass and half a reading's age in it."""
    true_s = one.truth[:, 0]
    attitudes = Rotation.from_quat(one.truth[:, 4 + 4 * body : 8 + 4 * body])
    speeds = (attitudes[:-1].inv() * attitudes[1:]).magnitude() / np.diff(true_s)
    middles_s = (true_s[:-1] + true_s[1:]) / 2
    rows = (one.log.t_s > FALL_S[0]) & (one.log.t_s < FALL_S[1])
    t_s, shown = one.log.t_s[rows], np.linalg.norm(one.log.rate_rad_s[rows, body], axis=1)

    def off(delay_s: float) -> float:
        return float(np.sum((shown - np.interp(t_s - delay_s, middles_s, speeds)) ** 2))

    found = minimize_scalar(off, bounds=(0.0, MOST_DELAY_S), method="bounded", options={"xatol": 1e-7})
    return float(found.x)
