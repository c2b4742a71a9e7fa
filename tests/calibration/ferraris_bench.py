"""The data of a Ferraris calibration: an IMU in a box that is laid on its six sides and turned on three of them.

Six rests show gravity along either sense of every axis. Then, on the sides where x, y and z point up, the box is
turned by 360 deg about the vertical and back, three times, with rests between (Ferraris, Grimaldi, Parvis, "Procedure
for effortless in-field calibration of three-axis rate gyros and accelerometers", Sensors and Materials 7, 1995).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tests.calibration.synthetic_gyro import RATE_HZ, Gyro, low_passed, sweeps
from tfsat_host.arrays import FloatArray

GRAVITY_M_S2 = 9.80665
TURN_RAD = 2.0 * np.pi
ROUNDS = 3
_STATIC_S = 10.0
_ACCEL_NOISE_M_S2 = 400e-6 * GRAVITY_M_S2 * np.sqrt(RATE_HZ / 2.0)  # PS-MPU-6000A rev. 3.4, section 6.2
_ACCEL_COUNT_M_S2 = GRAVITY_M_S2 / 8192.0  # range of 4 g


@dataclass(frozen=True, eq=False)
class Turns:
    """All turns about one body axis, as read.

    Attributes:
        rate_rad_s, accel_m_s2: (n, 3), sensor axes.
        angle_rad: (n,) of the box on its table.
        rests: Stretches in which nothing moved, one more than turns; turns with even numbers go in the positive sense.
    """

    rate_rad_s: FloatArray
    accel_m_s2: FloatArray
    angle_rad: FloatArray
    rests: list[slice]

    def forward(self, values: FloatArray) -> FloatArray:
        """Return the samples of the positive turns alone, concatenated, each from rest to rest."""
        # From the middle of one rest to the middle of the next, so that the whole turn is inside.
        middles = [(rest.start + rest.stop) // 2 for rest in self.rests]
        # Even turns go in the positive sense, the others come back.
        return np.concatenate([values[middles[turn] : middles[turn + 1]] for turn in range(0, 2 * ROUNDS, 2)])


@dataclass(frozen=True, eq=False)
class Ferraris:
    """One calibration, raw: `up` and `down` are (rates, accelerations) of the rests for each axis."""

    up: tuple[tuple[FloatArray, FloatArray], ...]
    down: tuple[tuple[FloatArray, FloatArray], ...]
    turns: tuple[Turns, ...]


@dataclass(frozen=True, eq=False)
class Imu:
    """A gyro, and an accelerometer on the same chip with errors of its own."""

    gyro: Gyro
    accel_scale: FloatArray
    accel_offset_m_s2: FloatArray

    @classmethod
    def draw_random(cls, rng: np.random.Generator) -> Imu:
        """Gyro as everywhere; accelerometer to 3 % and 50 mg."""
        return cls(
            Gyro.draw_random(rng), rng.uniform(0.97, 1.03, 3), rng.uniform(-0.05, 0.05, 3) * GRAVITY_M_S2
        )

    def feels(self, force_body_m_s2: FloatArray, rng: np.random.Generator) -> FloatArray:
        """(n, 3) readings of specific forces in body axes (n, 3)."""
        # Specific force in sensor axes: row vectors times the mounting.
        true = self.accel_scale * (force_body_m_s2 @ self.gyro.mounting)
        # The offset is constant: it passes the low-pass unchanged.
        noisy = low_passed(true + _ACCEL_NOISE_M_S2 * rng.normal(size=true.shape), 5.0)
        return np.asarray(np.round((noisy + self.accel_offset_m_s2) / _ACCEL_COUNT_M_S2) * _ACCEL_COUNT_M_S2)

    def calibration_data(self, rng: np.random.Generator) -> Ferraris:
        """Simulate the whole Ferraris procedure."""
        return Ferraris(
            tuple(self._lies(axis, rng) for axis in np.eye(3)),
            tuple(self._lies(-axis, rng) for axis in np.eye(3)),
            tuple(self._turns(axis, rng) for axis in np.eye(3)),
        )

    def _lies(self, up: FloatArray, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
        n = int(_STATIC_S * RATE_HZ)
        return self.gyro.reads(np.zeros((n, 3)), rng), self.feels(np.tile(GRAVITY_M_S2 * up, (n, 1)), rng)

    def _turns(self, axis: FloatArray, rng: np.random.Generator) -> Turns:
        # Three turns out and three back, with rests between.
        angle, rests = sweeps(2 * ROUNDS, TURN_RAD)
        rate = np.gradient(angle, 1.0 / RATE_HZ)
        reads = self.gyro.reads(rate[:, None] * axis, rng)
        return Turns(reads, self.feels(np.tile(GRAVITY_M_S2 * axis, (len(angle), 1)), rng), angle, rests)
