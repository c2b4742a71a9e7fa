"""Gravity before the release: the one force that everybody knows, to try the accelerometers on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.apply import ACCEL_SCALE_STD, Calibrated
from tfsat_host.units import STANDARD_GRAVITY_M_S2

FloatArray = NDArray[np.float64]

LEAST_SAMPLES = 8
"""Fewer forces are no mean."""
ALARM_STDS = 3.0


@dataclass(frozen=True, eq=False)
class AtRest:
    """One body before the release: (3,) mean and deviation of the force, and its root mean square; g."""

    mean_g: FloatArray
    std_g: FloatArray
    rms_g: float

    @classmethod
    def of(cls, samples: Calibrated, rows: NDArray[np.bool_], index: int) -> AtRest | None:
        """Of the IMU with that index; None without enough valid samples."""
        force, std = forces_g(samples, rows, index)
        if len(force) < LEAST_SAMPLES:
            return None
        return cls(force.mean(axis=0), std.mean(axis=0), rms_g(force))


def forces_g(samples: Calibrated, rows: NDArray[np.bool_], index: int) -> tuple[FloatArray, FloatArray]:
    """(k, 3) valid forces of a body that are not clipped, and their deviations, g."""
    force = samples.specific_force_m_s2[:, index]
    good = rows & np.isfinite(force).all(axis=1) & ~samples.clipped[:, index]
    per_g = STANDARD_GRAVITY_M_S2
    return force[good] / per_g, samples.specific_force_std_m_s2[good, index] / per_g


def rms_g(force: FloatArray) -> float:
    """Root mean square of forces (k, 3) about their mean."""
    return float(np.sqrt((force.var(axis=0, ddof=1)).sum()))


@dataclass(frozen=True, eq=False)
class GravityCheck:
    """Gravity before the release, by one body.

    Attributes:
        body: 1 to 4.
        force_g: (3,) as shown, body axes.
        norm_g: Its length.
        norm_std_g: Of it, by the data sheet: zero-g output and scale.
        less_fall_norm_g: Length of `force_g` less what the sensor shows in the fall; NaN without a quiet window.
        less_fall_std_g: Of it: the scale's share.
    """

    body: int
    force_g: FloatArray
    norm_g: float
    norm_std_g: float
    less_fall_norm_g: float
    less_fall_std_g: float

    @property
    def passes(self) -> bool:
        """1 g within three standard deviations, both ways of looking at it."""
        return (
            self._as_shown_passes and not abs(self.less_fall_norm_g - 1.0) > ALARM_STDS * self.less_fall_std_g
        )

    def felt(self) -> str:
        """The worse of the two, as the end of a sentence about the body."""
        if self._as_shown_passes:
            return (
                f"felt {self.less_fall_norm_g:.3f} g more before the release than in the fall "
                f"instead of 1 ± {ALARM_STDS * self.less_fall_std_g:.2f} g"
            )
        return (
            f"felt {self.norm_g:.3f} g before the release instead of 1 ± {ALARM_STDS * self.norm_std_g:.2f} g"
        )

    @property
    def _as_shown_passes(self) -> bool:
        return abs(self.norm_g - 1.0) <= ALARM_STDS * self.norm_std_g


def check_gravity(
    body: int, before: AtRest, in_fall_g: FloatArray | None, in_fall_noise_g: FloatArray | None
) -> GravityCheck:
    """Of one body, 1 to 4.

    Args:
        body: 1 to 4.
        before: What it showed before the release.
        in_fall_g: (3,) what its accelerometer shows in a quiet window, its turning taken off; None without one.
        in_fall_noise_g: (3,) of that.
    """
    norm = float(np.linalg.norm(before.mean_g))
    direction = before.mean_g / norm if norm > 0.0 else np.zeros(3)
    less_fall, std = float("nan"), float("nan")
    if in_fall_g is not None and in_fall_noise_g is not None:
        less_fall = float(np.linalg.norm(before.mean_g - in_fall_g))
        std = float(np.hypot(ACCEL_SCALE_STD * less_fall, np.linalg.norm(in_fall_noise_g)))
    return GravityCheck(
        body, before.mean_g, norm, float(np.linalg.norm(direction * before.std_g)), less_fall, std
    )
