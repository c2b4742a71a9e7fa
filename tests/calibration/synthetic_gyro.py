"""A gyro with known errors, for the estimators alone: bias, scale, mounting, white noise, low-pass, counts.

Noise and sensitivity of the MPU-6050 (PS-MPU-6000A rev. 3.4, section 6.1); the low-pass is one pole at 5 Hz.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.sensors.gyro import SKEW_STD, response_matrix

RATE_HZ = 280.0
_NOISE_RAD_S = np.radians(0.005) * np.sqrt(RATE_HZ / 2.0)
_COUNT_RAD_S = np.radians(1.0 / 65.5)
_ANGLE_COUNT_RAD = 2.0 * np.pi / 4096


@dataclass(frozen=True, eq=False)
class Gyro:
    """Errors of one gyro: `mounting` (3, 3) from sensor to body axes, `scale` (3,), `bias_rad_s` (3,), `skew` (3,)."""

    mounting: FloatArray
    scale: FloatArray
    bias_rad_s: FloatArray
    skew: FloatArray = field(default_factory=lambda: np.zeros(3))

    @classmethod
    def draw_random(cls, rng: np.random.Generator) -> Gyro:
        """Mounted along any axes of the body, to 5 deg; scale to 3 %; bias to 5 deg/s; skew by the data sheet."""
        right = Rotation.create_group("O").as_matrix()[rng.integers(24)]
        off = rng.normal(size=3)
        # A random direction, then a random angle up to 5 deg.
        off *= np.radians(5.0) * rng.uniform() / np.linalg.norm(off)
        return cls(
            Rotation.from_rotvec(off).as_matrix() @ right,
            rng.uniform(0.97, 1.03, 3),
            np.radians(rng.uniform(-5.0, 5.0, 3)),
            SKEW_STD * rng.standard_normal(3),
        )

    @property
    def response(self) -> FloatArray:
        """(3, 3) reading over true rate, sensor axes."""
        return response_matrix(self.scale, self.skew)

    @property
    def nominal(self) -> FloatArray:
        """(3, 3) the mounting along axes of the body that was meant."""
        right = Rotation.create_group("O").as_matrix()
        # The right-angled orientation next to the drawn one: the largest trace is the smallest angle.
        return np.asarray(max(right, key=lambda turn: float(np.trace(turn.T @ self.mounting))))

    def reads(self, rate_body_rad_s: FloatArray, rng: np.random.Generator) -> FloatArray:
        """(n, 3) readings of body rates (n, 3)."""
        true = (rate_body_rad_s @ self.mounting) @ self.response
        # The bias is added behind the low-pass: it does not settle.
        filtered = low_passed(true + _NOISE_RAD_S * rng.normal(size=true.shape), 5.0) + self.bias_rad_s
        return np.asarray(np.round(filtered / _COUNT_RAD_S) * _COUNT_RAD_S)


def low_passed(values: FloatArray, cutoff_hz: float) -> FloatArray:
    """Filter the values (n, d) with a single pole, initialized at the first of them."""
    keep = np.exp(-2.0 * np.pi * cutoff_hz / RATE_HZ)
    # Initialized at the first value: no start-up transient.
    filtered, _ = lfilter([1.0 - keep], [1.0, -keep], values, axis=0, zi=keep * values[:1])
    return np.asarray(filtered, dtype=np.float64)


def swings(rng: np.random.Generator, duration_s: float) -> tuple[FloatArray, FloatArray]:
    """(n,) joint angles of a hand that swings 60 deg and back about every two seconds, and (n, 3) sway of the bench."""
    n = int(duration_s * RATE_HZ)
    # The phase wanders: no two swings of a hand take equally long.
    phase = 2.0 * np.pi * np.arange(n) / (2.0 * RATE_HZ) + 0.3 * np.cumsum(rng.normal(size=n)) / np.sqrt(
        RATE_HZ
    )
    return np.radians(30.0) * (1.0 - np.cos(phase)), sway(rng, n)


def sway(rng: np.random.Generator, n: int) -> FloatArray:
    """(n, 3) rates of a body that is held, but not quite still: some tenths of a deg/s below 1 Hz."""
    # Low-passed noise, scaled to 0.3 deg/s.
    return np.asarray(np.radians(0.3) * low_passed(8.0 * rng.normal(size=(n, 3)), 1.0))


def sway_between(rests: list[slice], rng: np.random.Generator, n: int) -> FloatArray:
    """(n, 3) the same between rests, and back at each rest to where it was at the one before."""
    swaying, rates = sway(rng, n), np.zeros((n, 3))
    for before, after in pairwise(rests):
        leg = slice(before.stop, after.start)
        # Without its mean: at each rest the body is back where it was.
        rates[leg] = swaying[leg] - swaying[leg].mean(axis=0)
    return rates


def sweeps(count: int, angle_rad: float) -> tuple[FloatArray, list[slice]]:
    """(n,) angles of `count` sweeps out and back with rests of 1.5 s, and the rests' quiet middles."""
    angles, rests, now, at = [], list[slice](), 0, 0.0
    rest_n, sweep_n = int(1.5 * RATE_HZ), int(2.0 * RATE_HZ)
    for number in range(count + 1):
        angles.append(np.full(rest_n, at))
        # The middle of a rest, without the settling behind a sweep.
        rests.append(slice(now + int(0.5 * RATE_HZ), now + rest_n - int(0.2 * RATE_HZ)))
        now += rest_n
        if number < count:
            share = np.linspace(0.0, 1.0, sweep_n)
            there = angle_rad - at
            # A cycloid: speed and acceleration are zero at both ends.
            angles.append(at + (there - at) * (share - np.sin(2.0 * np.pi * share) / (2.0 * np.pi)))
            now, at = now + sweep_n, there
    return np.concatenate(angles), rests


def angle_reading(angles_rad: FloatArray, rng: np.random.Generator) -> float:
    """Mean of both absolute sensors over samples (n,): 12 bits and 0.05 deg of noise each."""
    noisy = angles_rad + np.radians(0.05) * rng.normal(size=(2, len(angles_rad)))
    return float(np.mean(np.round(noisy / _ANGLE_COUNT_RAD) * _ANGLE_COUNT_RAD))
