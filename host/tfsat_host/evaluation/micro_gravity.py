"""How well the robot floated: what the accelerometers show while nothing moves.

An accelerometer without calibration shows anything within 50 mg (80 mg along z) in free fall
(PS-MPU-6000A rev. 3.4, section 6.2): the mean of a quiet window says no more than that about gravity. But what it shows
*is* its zero-g output, so two things are known far better: how much the force changes from one window to the other,
and whether gravity before the release, less that output, is 1 g as the scale has it (3 %).

Off the center of mass a turning body feels f = α × r + ω × (ω × r); that is taken off.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.calibration.apply import ACCEL_SCALE_STD, CalibratedSamples
from tfsat_host.evaluation.laser_velocity import PUSHED_OFF_S
from tfsat_host.units import STANDARD_GRAVITY_M_S2

SETTLE_S = 0.1
"""After the last stroke servos still swing and the low-pass still remembers."""
BEFORE_LANDING_S = 0.02
AT_REST_S = (-0.95, -0.1)
"""Before the release: the crane has stopped, and the lift's end is long past."""
TOUCHED_G = 0.02
"""Root mean square beyond the sensor's own: the robot touched something, or something loose swings."""


@dataclass(frozen=True, eq=False)
class QuietWindow:
    """Part of the fall in which no joint moves.

    Attributes:
        name: For people.
        from_s, until_s: After the release.
        arms_m: (4, 3) from the robot's CoM to each IMU, axes of its body, see `arms.sensor_arms_m`.
    """

    name: str
    from_s: float
    until_s: float
    arms_m: FloatArray


@dataclass(frozen=True, eq=False)
class BodyQuiet:
    """What one body's accelerometer shows in a quiet window, g, body axes.

    Attributes:
        body: 1 to 4.
        samples: That were valid.
        mean_g: (3,) as shown, zero-g output and all.
        rotation_g: (3,) the share of it that the turning makes; NaN if no gyro tells.
        residual_g: (3,) `mean_g` less `rotation_g`, if that is known.
        residual_std_g: (3,) mostly the zero-g output's.
        noise_std_g: (3,) of the mean, without what is the same in all windows.
        rms_g: Root mean square of the force about its mean, all axes.
        rest_rms_g: The same before the release: what is the sensor's own. NaN if it gave nothing then.
    """

    body: int
    samples: int
    mean_g: FloatArray
    rotation_g: FloatArray
    residual_g: FloatArray
    residual_std_g: FloatArray
    noise_std_g: FloatArray
    rms_g: float
    rest_rms_g: float

    @property
    def motion_rms_g(self) -> float:
        """Root mean square beyond the sensor's own; 0 if it is not above that."""
        return float(np.sqrt(max(self.rms_g**2 - np.nan_to_num(self.rest_rms_g) ** 2, 0.0)))


@dataclass(frozen=True, eq=False)
class WindowQuality:
    """One window; bodies without enough valid samples are left out."""

    window: QuietWindow
    bodies: tuple[BodyQuiet, ...]


@dataclass(frozen=True, eq=False)
class MicroGravity:
    """Quality of the fall.

    Attributes:
        windows: Those that hold enough samples.
        changes_g: (4, 3) `residual_g` of the last window less that of the first; NaN where one is missing, or its
            turning was not taken off.
        changes_std_g: (4, 3) of it: only noise, for the zero-g output is in both.
        gravity: One for each body that was valid before the release.
        findings: What is not as it should be, one sentence each.
        notes: What could not be used.
    """

    windows: tuple[WindowQuality, ...]
    changes_g: FloatArray
    changes_std_g: FloatArray
    gravity: tuple[GravityCheck, ...]
    findings: tuple[str, ...]
    notes: tuple[str, ...]


def expected_specific_force(
    rate_rad_s: FloatArray, acceleration_rad_s2: FloatArray, arm_m: FloatArray
) -> FloatArray:
    """(..., 3) m/s² at a point that keeps its place in a body which falls freely: α × r + ω × (ω × r).

    All (..., 3), body axes; `arm_m` leads from the center of mass of all that falls to the point.
    """
    # In free fall gravity is not felt: only the centripetal and the tangential term are left.
    centripetal = np.cross(rate_rad_s, np.cross(rate_rad_s, arm_m))
    return np.asarray(np.cross(acceleration_rad_s2, arm_m) + centripetal)


def quiet_windows(
    first_stroke_s: float,
    last_end_s: float,
    landing_s: float,
    arms_before_m: FloatArray,
    arms_after_m: FloatArray,
) -> tuple[QuietWindow, QuietWindow]:
    """Return the quiet windows from the push to the first stroke and from the last stroke to the landing.

    Times are after the release. Arms: (4, 3) with the joints as they stand in each window.
    """
    return (
        QuietWindow("before the first stroke", PUSHED_OFF_S, first_stroke_s, arms_before_m),
        QuietWindow(
            "after the last stroke", last_end_s + SETTLE_S, landing_s - BEFORE_LANDING_S, arms_after_m
        ),
    )


def micro_gravity(
    samples: CalibratedSamples,
    t_s: FloatArray,
    windows: Sequence[QuietWindow],
    sensed: Collection[int] = (1, 2, 3, 4),
) -> MicroGravity:
    """Forces in the quiet windows, and gravity before the release.

    `samples` are in body axes, `t_s` (n,) their times after the release, as `DropLog.t_s`. Windows, one at
    least, are in the order of time; `sensed` bodies (1 to 4) have an IMU.
    """
    rest = (t_s >= AT_REST_S[0]) & (t_s < AT_REST_S[1])
    at_rest = [AtRest.of(samples, rest, index) for index in range(samples.clipped.shape[1])]
    notes: list[str] = []
    qualities = tuple(_quality(samples, t_s, window, at_rest, notes, sensed) for window in windows)
    # The zero-g output dominates each mean but is the same in all windows: differences cancel it.
    changes, changes_std = _changes(qualities, len(at_rest))
    gravity = tuple(
        _gravity(body, before, qualities) for body, before in enumerate(at_rest, 1) if before is not None
    )
    notes += [
        f"Body {body}'s accelerometer gave too little before the release: gravity there is unchecked."
        for body, before in enumerate(at_rest, 1)
        if before is None and body in sensed
    ]
    return MicroGravity(qualities, changes, changes_std, gravity, _findings(qualities, gravity), tuple(notes))


def _quality(
    samples: CalibratedSamples,
    t_s: FloatArray,
    window: QuietWindow,
    at_rest: Sequence[AtRest | None],
    notes: list[str],
    sensed: Collection[int],
) -> WindowQuality:
    rows = (t_s >= window.from_s) & (t_s < window.until_s)
    bodies = []
    for index, before in enumerate(at_rest):
        if index + 1 not in sensed:
            continue
        force, std = forces_g(samples, rows, index)
        if len(force) < MIN_SAMPLES:
            notes.append(f"Body {index + 1} has {len(force)} valid forces {window.name}: too few to judge.")
            continue
        # A reading at full scale is a lower bound, and a straight line through it is none.
        rates = np.where(samples.clipped[rows, index, None], np.nan, samples.rate_rad_s[rows, index])
        # The IMUs sit off the robot's CoM: what its turning makes them feel is no residual gravity.
        turning = _turning_g(rates, t_s[rows], window.arms_m[index])
        if np.isnan(turning).any():
            notes.append(
                f"Body {index + 1}'s gyro gave nothing {window.name}: its turning was not taken off."
            )
        # The low-pass correlates neighbours: divide by the equivalent number of independent samples.
        noise = force.std(axis=0, ddof=1) / _independent(force) ** 0.5
        mean = force.mean(axis=0)
        bodies.append(
            BodyQuiet(
                body=index + 1,
                samples=len(force),
                mean_g=mean,
                rotation_g=turning,
                # Without a gyro the turning stays in the residual; the note above says so.
                residual_g=mean - np.nan_to_num(turning),
                # The data sheet's share is common to all samples and does not average out; noise does.
                residual_std_g=np.hypot(std.mean(axis=0), noise),
                noise_std_g=noise,
                rms_g=rms_g(force),
                rest_rms_g=before.rms_g if before else float("nan"),
            )
        )
    return WindowQuality(window, tuple(bodies))


def _turning_g(rate_rad_s: FloatArray, t_s: FloatArray, arm_m: FloatArray) -> FloatArray:
    """(3,) mean of what the turning makes: rates on a straight line, whose slope is the acceleration."""
    is_finite = np.isfinite(rate_rad_s).all(axis=1)
    if is_finite.sum() < MIN_SAMPLES:
        return np.full(3, np.nan)
    # In centred time the line's constant is the mean rate and its slope the angular acceleration.
    since = t_s[is_finite] - t_s[is_finite].mean()
    slope, mean = np.polynomial.polynomial.polyfit(since, rate_rad_s[is_finite], 1)[::-1]
    # The centripetal term is quadratic in the rate: average the force, not the rate.
    force = expected_specific_force(mean + np.outer(since, slope), slope, arm_m)
    return np.asarray(force.mean(axis=0) / STANDARD_GRAVITY_M_S2)


def _independent(force: FloatArray) -> float:
    """Estimate the equivalent number of independent samples.

    A low-pass correlates neighbours; the correlation is modelled as first-order, from lag 1.
    """
    away = force - force.mean(axis=0)
    power = float((away**2).sum())
    # Lag-1 autocorrelation, pooled over the three axes.
    alike = float((away[1:] * away[:-1]).sum()) / power if power > 0.0 else 0.0
    alike = min(max(alike, 0.0), 0.98)
    # Equivalent sample size of a first-order autoregressive process.
    return max(len(force) * (1.0 - alike) / (1.0 + alike), 1.0)


def _changes(qualities: Sequence[WindowQuality], bodies: int) -> tuple[FloatArray, FloatArray]:
    changes, stds = np.full((bodies, 3), np.nan), np.full((bodies, 3), np.nan)
    first, last = (
        {body_quality.body: body_quality for body_quality in quality.bodies}
        for quality in (qualities[0], qualities[-1])
    )
    # A single window has nothing to differ from: all stays NaN.
    for body in first.keys() & last.keys() if len(qualities) > 1 else ():
        turned = last[body].rotation_g - first[body].rotation_g
        changes[body - 1] = last[body].mean_g - first[body].mean_g - turned
        stds[body - 1] = np.hypot(last[body].noise_std_g, first[body].noise_std_g)
    return changes, stds


def _gravity(body: int, before: AtRest, qualities: Sequence[WindowQuality]) -> GravityCheck:
    quiet = (in_window for quality in qualities for in_window in quality.bodies if in_window.body == body)
    return check_gravity(body, before, next(quiet, None))


def _findings(qualities: Sequence[WindowQuality], gravity: Sequence[GravityCheck]) -> tuple[str, ...]:
    findings = []
    for quality in qualities:
        for body_quality in quality.bodies:
            name = f"Body {body_quality.body} {quality.window.name}"
            # A steady force beyond the zero-g output's tolerance is no free fall, or no sound sensor.
            if (np.abs(body_quality.residual_g) > ALARM_STDS * body_quality.residual_std_g).any():
                findings.append(
                    f"{name} feels {np.linalg.norm(body_quality.residual_g):.3f} g, more than its "
                    "accelerometer's zero-g "
                    "output explains: the robot did not float, or the sensor is damaged."
                )
            if body_quality.motion_rms_g > TOUCHED_G:
                findings.append(
                    f"{name}: vibration {body_quality.motion_rms_g:.3f} g rms. Likely cause: contact or a loose part."
                )
    findings += [
        f"Body {check.body} {check.describe()}: it did not hang still, or its accelerometer's scale is wrong."
        for check in gravity
        if not check.passes
    ]
    return tuple(findings)


MIN_SAMPLES = 8
"""Fewer forces are no mean."""
ALARM_STDS = 3.0


@dataclass(frozen=True, eq=False)
class AtRest:
    """One body before the release: (3,) mean and deviation of the force, and its root mean square; g."""

    mean_g: FloatArray
    std_g: FloatArray
    rms_g: float

    @classmethod
    def of(cls, samples: CalibratedSamples, rows: BoolArray, index: int) -> AtRest | None:
        """Compute the rest values of the IMU with that index; None without enough valid samples."""
        force, std = forces_g(samples, rows, index)
        if len(force) < MIN_SAMPLES:
            return None
        return cls(force.mean(axis=0), std.mean(axis=0), rms_g(force))


def forces_g(samples: CalibratedSamples, rows: BoolArray, index: int) -> tuple[FloatArray, FloatArray]:
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
        norm_g: Length of the force as shown.
        norm_std_g: Of it, by the data sheet: zero-g output and scale.
        less_fall_norm_g: Length of that force less what the sensor shows in the fall; NaN without a quiet window.
        less_fall_std_g: Of it: the scale's share.
    """

    body: int
    norm_g: float
    norm_std_g: float
    less_fall_norm_g: float
    less_fall_std_g: float

    @property
    def passes(self) -> bool:
        """1 g within three standard deviations, both ways of looking at it."""
        return (
            # Negated, so that NaN, for want of a quiet window, does not fail.
            self._as_shown_passes and not abs(self.less_fall_norm_g - 1.0) > ALARM_STDS * self.less_fall_std_g
        )

    def describe(self) -> str:
        """Format the worse of the two results as the end of a sentence about the body."""
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


def check_gravity(body: int, before: AtRest, in_fall: BodyQuiet | None = None) -> GravityCheck:
    """Check the gravity that one body's accelerometer felt; `in_fall` is None without a quiet window."""
    norm = float(np.linalg.norm(before.mean_g))
    # The gradient of a norm is its unit vector: it carries the axes' deviations over.
    direction = before.mean_g / norm if norm > 0.0 else np.zeros(3)
    less_fall, std = float("nan"), float("nan")
    if in_fall is not None:
        # Less the reading in free fall the zero-g output is gone: what is left to err is the scale.
        less_fall = float(np.linalg.norm(before.mean_g - in_fall.residual_g))
        std = float(np.hypot(ACCEL_SCALE_STD * less_fall, np.linalg.norm(in_fall.noise_std_g)))
    return GravityCheck(body, norm, float(np.linalg.norm(direction * before.std_g)), less_fall, std)
