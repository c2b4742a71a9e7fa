"""The samples of one drop in body axes and SI units: from just before the release to just before the landing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.integrate import cumulative_trapezoid

from tfsat_host.arrays import BoolArray, FloatArray, IntArray
from tfsat_host.calibration.apply import apply_calibration, weightless
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.calibration.steps.sensor_samples import SensorSamples
from tfsat_host.errors import TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.limits import FALL_US, SAMPLE_RATE_HZ
from tfsat_host.robot import RobotModel
from tfsat_host.sdlog import DropLog
from tfsat_host.sdlog.droplog import rows_of


class EvaluationError(TfsatError):
    """The recording does not hold what an evaluation needs."""


LEAD_S = 0.3
"""So much before the release belongs to it: differences of neighbouring samples need some on either side. The robot
still hangs then, and a gyro that feels its weight has another bias: its rates tell nothing of that in the fall."""
LANDING_GUARD_S = 0.05
"""The evaluation ends so long before the landing, as the release springs and the cushion are not the model's."""
MIN_DURATION_S = 0.05
"""Less of a fall is not evaluated."""
SATURATED_DELAYS = 7.0
"""Times the low-pass's delay: what it holds of a rate is below a thousandth then. Its input is cut off as long before
its output is at full scale, and no longer when that leaves it."""
MAX_GAP_S = 0.1
"""Over a longer hole in all gyros nothing is carried: a stroke turns the robot by 20 deg meanwhile."""


class Blocks(NamedTuple):
    """Samples in blocks of time: the first sample of each, and how many it holds; (blocks,) each."""

    edges: IntArray
    counts: IntArray

    @classmethod
    def of(cls, t_s: FloatArray, length_s: float) -> Blocks:
        """Build the blocks of n ascending times; blocks without a sample are left out."""
        # A new block begins where the number of whole lengths changes.
        edges = np.flatnonzero(np.diff(np.floor(t_s / length_s), prepend=-np.inf))
        return cls(edges, np.diff(edges, append=len(t_s)))

    def mean(self, values: FloatArray) -> FloatArray:
        """(blocks, ...) of values (n, ...)."""
        counts = self.counts.reshape(-1, *[1] * (values.ndim - 1))
        return np.asarray(np.add.reduceat(values, self.edges, axis=0) / counts)

    def excess(self, rows: FloatArray, residuals: FloatArray, normal: FloatArray, prior: FloatArray) -> float:
        """Compute the ratio of a least-squares solution's variance to that expected from unit noise.

        Residuals count as far as they move the solution, block by block: frames that ring after each stroke look
        like a gyro's lag or scale, however small their means are. If all is noise the blocks' pulls on the solution
        add up to its covariance (P. Huber, Proc. 5th Berkeley Symp. 1, 1967, the "sandwich").

        Args:
            rows: (n, k, r) slopes of the numbers by the solved parameters.
            residuals: (n, k) residuals.
            normal: (r, r) information in the rows, rows^T rows.
            prior: (r, r) information from elsewhere.
        """
        # Gradient of each block, (blocks, r): correlated samples add up before they are squared.
        pulls = np.add.reduceat((residuals[:, None] @ rows)[:, 0], self.edges, axis=0)
        gain = np.linalg.inv(normal + prior)
        # Expectation of that sum if all were unit noise.
        degrees_of_freedom = float((gain * normal).sum())
        return float(((pulls @ gain) * pulls).sum()) / degrees_of_freedom if degrees_of_freedom > 0.0 else 0.0


@dataclass(frozen=True, eq=False)
class Samples:
    """n samples at which at least one gyro answered; NaN where a sensor did not.

    Attributes:
        t_s: (n,) after the release, increasing; the true sample times.
        rate_rad_s: (n, 4, 3) body axes, as the gyros show it: late by their low-pass.
        rate_jacobian: (n, 4, 3, 12) by bias, rotation vector, scale and skew of each gyro.
        parameter_covariance: (4, 12, 12) of those in the fall.
        hanging_covariance: (4, 12, 12) of those while the robot hangs, where a bias holds what its weight makes a gyro
            show, as it did when it was taken.
        shared: (4, 12, SHARED) see `GyroCalibration`.
        sensor_angle_rad: (n, 6) what the angle sensors show.
        answered: (n, 4) the gyro answered and was not clipped.
        rate_hz: Sampling rate as commanded.
        until_s: The end of the evaluation, after the release.
    """

    t_s: FloatArray
    rate_rad_s: FloatArray
    rate_jacobian: FloatArray
    parameter_covariance: FloatArray
    hanging_covariance: FloatArray
    shared: FloatArray
    sensor_angle_rad: FloatArray
    answered: BoolArray
    rate_hz: float
    until_s: float

    def __len__(self) -> int:
        return len(self.t_s)

    @property
    def fall(self) -> BoolArray:
        """(n,) after the release."""
        return self.t_s >= 0.0


def samples_of(log: DropLog, calibration: Calibration, model: RobotModel) -> Samples:
    """Cuts the drop out of a decoded recording and calibrates it.

    Raises:
        EvaluationError: the recording holds no release, nothing of the fall, or a hole that no attitude can bridge.
    """
    if log.release_us is None:
        raise EvaluationError(
            what="The recording has no release.",
            meaning="No drop, or the release is lost: no maneuver can be evaluated.",
            next_step=Advice("Events of the recording: ", NextStep("decode")),
        )
    until_s = end_of_fall_s(log) - LANDING_GUARD_S
    if until_s < MIN_DURATION_S:
        raise EvaluationError(
            what=f"The recording ends {until_s + LANDING_GUARD_S:.3f} s after the release.",
            meaning="Nothing of the fall is recorded: nothing to evaluate.",
            next_step=Advice(
                "Events of the recording: ",
                NextStep("decode"),
                "; to fetch it again: ",
                NextStep("log fetch"),
            ),
        )
    # Keep a lead: derivatives at the release need neighbours before it.
    first, last = np.searchsorted(log.t_s, [-LEAD_S, until_s], side="right")
    part = rows_of(log, slice(int(first), int(last)))
    answered = part.imu_valid & ~_find_saturated(part)
    # A sample counts if any gyro answered: the others are bridged.
    sample_rows = np.flatnonzero(answered.any(axis=1))
    _require_no_hole(part.t_s[sample_rows], until_s)
    counts = Counts.from_log(part)
    calibrated = apply_calibration(counts, calibration, model)
    # At the samples' times, which those of `DropLog` are not.
    sensor_angles_rad = np.where(part.angle_valid, SensorSamples.from_counts(counts).sensor_angle_rad, np.nan)
    # Silent and saturated gyros are NaN from here on.
    rates = np.where(answered[..., None], calibrated.rate_rad_s, np.nan)
    return Samples(
        part.t_s[sample_rows],
        rates[sample_rows],
        calibrated.rate_jacobian[sample_rows],
        weightless(calibrated.parameter_covariance),
        calibrated.parameter_covariance,
        calibrated.shared,
        sensor_angles_rad[sample_rows],
        answered[sample_rows],
        float(log.header.rate_hz or SAMPLE_RATE_HZ),
        until_s,
    )


def _find_saturated(log: DropLog) -> BoolArray:
    """(n, 4) the gyro was at full scale so lately or so soon that its low-pass still holds what was cut off."""
    memory_s = SATURATED_DELAYS * LowPass.of(log.header).gyro_delay_s
    out = log.clipped.copy()
    for row in np.flatnonzero(log.clipped.any(axis=1)):
        # Before full scale, too: the input was cut off while the filter's output still rose.
        first, last = np.searchsorted(log.t_s, log.t_s[row] + np.array([-memory_s, memory_s]))
        out[first:last] |= log.clipped[row]
    return out


def end_of_fall_s(log: DropLog) -> float:
    """Return the fall's end after the release: the logged landing, the longest fall or the last sample.

    The earliest of them counts.
    """
    landings = [log.seconds(event.t_us) for event in log.events if event.name == "landing"]
    return float(min([FALL_US * 1e-6, float(log.t_s[-1]), *(t_s for t_s in landings if t_s > 0.0)]))


def _require_no_hole(t_s: FloatArray, until_s: float) -> None:
    # Release and end are edges as well: nothing may be missing next to them.
    edges = np.concatenate([[0.0], t_s[t_s > 0.0], [until_s]])
    holes = np.diff(edges)
    if len(t_s) < 2 or holes.max() > MAX_GAP_S:
        worst = int(holes.argmax())
        raise EvaluationError(
            what=f"No gyro has a sample between {edges[worst]:.3f} s and {edges[worst + 1]:.3f} s after the release.",
            meaning=f"Over more than {MAX_GAP_S:g} s no attitude can be carried: nothing can be evaluated.",
            next_step=Advice(
                "Look at the gaps: ",
                NextStep("decode"),
                "; fetch the recording's second copy: ",
                NextStep("log fetch"),
            ),
        )


GAP_PERIODS = 1.5
"""A step longer than so many sampling periods has samples missing in it."""
_NEAR_S = 0.1


@dataclass(frozen=True, eq=False)
class Holes:
    """Of one rate.

    Attributes:
        from_s: (h,) last sample before each.
        until_s: (h,) first sample after it.
        variance: (h,) of the turn in it, rad^2.
    """

    from_s: FloatArray
    until_s: FloatArray
    variance: FloatArray

    def variance_between(self, left_s: FloatArray, right_s: FloatArray) -> FloatArray:
        """(k,) of all holes between times (k,)."""
        # A nanosecond for rounding: intervals may end exactly where a hole does.
        within = (self.from_s >= left_s[:, None] - 1e-9) & (self.until_s <= right_s[:, None] + 1e-9)
        return np.asarray((within * self.variance).sum(axis=1))


def holes_of(t_s: FloatArray, rate_rad_s: FloatArray, rate_hz: float) -> Holes:
    """Find the holes of a rate (n,) or (n, 3) that is integrated by straight lines between its samples.

    In a hole of length g the integral of a rate that bends once by its acceleration a is off by a g^2 / 12;
    that of a rate that jumps anywhere in it between the values at its sides, by their difference times
    g / sqrt(12).
    """
    steps = np.diff(t_s)
    first = np.flatnonzero(steps > GAP_PERIODS / rate_hz)
    rate = rate_rad_s.reshape(len(t_s), -1)
    slope = np.linalg.norm(np.diff(rate, axis=0), axis=1) / steps
    variance = []
    for gap in first:
        # The acceleration in the hole is unknown: take the greatest one nearby.
        near = np.abs(t_s[:-1] - t_s[gap]) < _NEAR_S + steps[gap]
        jumped = slope[gap] * steps[gap] ** 2 / np.sqrt(12.0)
        bent = slope[near].max() * steps[gap] ** 2 / 12.0
        variance.append(max(jumped, bent) ** 2)
    return Holes(t_s[first], t_s[first + 1], np.array(variance))


def turned_from(t_s: FloatArray, rate_rad_s: FloatArray) -> FloatArray:
    """(n, ...) integral of rates by straight lines between samples, zero up to the first sample after the release.

    Servos hold the joints until then: no gyro, of another bias while it hangs, is asked whether they stand.
    """
    total: FloatArray = cumulative_trapezoid(rate_rad_s, t_s, axis=0, initial=0)
    released = int(np.searchsorted(t_s, 0.0))
    total = total - total[released]
    total[:released] = 0.0
    return total


_NEIGHBOURS = 2
"""Taking off the lag needs so many on either side."""


@dataclass(frozen=True, eq=False)
class Readings:
    """Of all gyros at n samples.

    Attributes:
        gyros: As calibrated.
        reading_rad_s: (n, 4, 3) sensor axes, late by their low-pass, without NaN.
        usable: (n, 4) its neighbours are there as well; at least one gyro at every sample.
    """

    gyros: tuple[GyroCalibration, ...]
    reading_rad_s: FloatArray
    usable: BoolArray

    @classmethod
    def of(cls, samples: Samples, gyros: Sequence[GyroCalibration]) -> Readings:
        """Build the readings of one drop, calibrated with `gyros`."""
        # Back to raw readings, bias included: errors found later act on those, in sensor axes.
        own = [g.readings(samples.rate_rad_s[:, b]) + g.bias_rad_s for b, g in enumerate(gyros)]
        bridged = np.apply_along_axis(partial(bridge_missing, samples.t_s), 0, np.stack(own, axis=1))
        return cls(tuple(gyros), bridged, _away_from_holes(samples.answered))

    def without(self, parameters: FloatArray) -> tuple[GyroCalibration, ...]:
        """Return the gyros with the errors (4, 12) of their parameters removed."""
        return tuple(gyro.add_errors(off) for gyro, off in zip(self.gyros, parameters, strict=True))

    def rates(self, gyros: Sequence[GyroCalibration]) -> FloatArray:
        """(n, 4, 3) rates in body axes by such gyros."""
        return np.stack([g.body_rates(self.reading_rad_s[:, b]) for b, g in enumerate(gyros)], axis=1)


def bridge_missing(t_s: FloatArray, values: FloatArray) -> FloatArray:
    """(n,) without NaN, by straight lines in time, so that neighbours of a lost sample still have a derivative."""
    is_finite = np.isfinite(values)
    if not is_finite.any():
        return np.zeros_like(values)
    return np.interp(t_s, t_s[is_finite], values[is_finite])


def _away_from_holes(answered: BoolArray) -> BoolArray:
    near = ~answered
    for shift in range(1, _NEIGHBOURS + 1):
        near[shift:] |= ~answered[:-shift]
        near[:-shift] |= ~answered[shift:]
    # Where that would leave no gyro at all, those that answered have to do.
    none = np.logical_and.reduce(near, axis=1)
    return np.where(none[:, None], answered, ~near)
