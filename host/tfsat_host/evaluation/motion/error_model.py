"""Lasting errors of the sensors as one vector, its prior, and the Jacobians of rates and joint angles by it.

In it are the gyros' biases, mountings, scale factors and skews, two moments of their lag, how much slower than the
others the low-pass of each is and how much later its readings are, the tilts of the joints' axes, the joints' initial
angles, and the random walks of their integrated rates, each in standard deviations of its prior, so that all are
independent and of variance one. A gyro's error is in every rate, joint angle and attitude; as one vector it is counted
once. An axis that is tilted was so when the gyros were calibrated by it: its tilt is in their mountings, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import null_space

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.calibration.apply import split_shared
from tfsat_host.calibration.sensors.gyro import PARAMETERS
from tfsat_host.calibration.statistics import root_of
from tfsat_host.evaluation.motion.gyro_signal import READ_APART_STD_S, Lag, derivative
from tfsat_host.evaluation.motion.rate_fusion import FusedRates
from tfsat_host.evaluation.motion.samples import Holes, Samples, turned_from

OSCILLATOR = 0.01
"""Each chip's own is within 1 %, and with it its low-pass (PS-MPU-6000A rev. 3.4, clock from the gyros)."""
_CARRIED = 3
"""Rounds for the errors that wrong angles make in rates, and these in angles: each is a seventh of the one before."""


@dataclass(frozen=True, eq=False)
class ErrorJacobians:
    """By r independent errors of variance one, at n samples.

    Attributes:
        gyros: (n, 4, 3, r) each gyro's rate, its lag taken off; 0 where it did not answer.
        rates: (n, 6, r) base and joint rates from all gyros.
        bodies: (n, 4, 3, r) the bodies' rates that follow.
        angles: (n, 3, r) of the joints.
        covariance: (r, r) of the errors after the fusion.
    """

    gyros: FloatArray
    rates: FloatArray
    bodies: FloatArray
    angles: FloatArray
    covariance: FloatArray


@dataclass(frozen=True, eq=False)
class Prior:
    """Standard deviations before the fusion, and where each error stands in the vector.

    Attributes:
        gyro_root: (48, 48) of the covariance of the gyros' parameters, but for what the tilts do.
        gyros_by_tilts: (48, 6) what the gyros' parameters are off by tilts of one standard deviation: they were
            calibrated by the same axes.
        lag: (2,) standard deviations of the delay and of its second moment.
        apart: (4, 2, 6) what the gyros' differences add to the delay and to the second moment of each, in sum nothing:
            three errors by slower low-passes, three by later readings.
        tilt: (6,) of the axis of each joint about each of the two directions `across` it.
        start: (3,) of the angle of each joint at the release.
        walks: Of each joint.
    """

    gyro_root: FloatArray
    gyros_by_tilts: FloatArray
    lag: FloatArray
    apart: FloatArray
    tilt: FloatArray
    start: FloatArray
    walks: tuple[RandomWalk, ...]

    @classmethod
    def of(
        cls, samples: Samples, lag: Lag, axis_std_rad: float, start: FloatArray, walks: Sequence[RandomWalk]
    ) -> Prior:
        """Build the prior of one drop; `lag` is the data sheet's, `axis_std_rad` the robot file's."""
        gyros_by_tilts, covariance = split_shared(
            samples.parameter_covariance, samples.shared, exact_axes=axis_std_rad == 0.0
        )
        # The second moment is between one pole's (0) and a pure delay's (d^2 / 2): d^2 / 4 either way.
        moments = np.array([lag.delay_std_s, 0.25 * lag.delay_s**2])
        tilt = np.full(2 * len(start), axis_std_rad)
        # An orthonormal basis of differences that sum to zero, (4, 1, 3): what is common is in the moments.
        differ = null_space(np.ones((1, len(samples.shared))))[:, None]
        # A slow clock stretches the response: the second moment by twice as much as the delay.
        low_pass = OSCILLATOR * np.array([[lag.delay_s], [2.0 * lag.second_s2]])
        late = np.array([[READ_APART_STD_S], [0.0]])
        apart = np.concatenate([low_pass * differ, late * differ], axis=2)
        return cls(root_of(covariance), gyros_by_tilts, moments, apart, tilt, start, tuple(walks))

    @property
    def gyro(self) -> slice:
        """Of the gyros' parameters."""
        return slice(0, len(self.gyro_root))

    @property
    def moments(self) -> slice:
        """Of the lag's two moments, which angle sensors measure and neighbours do not."""
        return slice(self.gyro.stop, self.gyro.stop + len(self.lag))

    @property
    def slower(self) -> slice:
        """Of the differences between the gyros' lags."""
        return slice(self.moments.stop, self.moments.stop + self.apart.shape[2])

    @property
    def tilts(self) -> slice:
        """Of the joints' axes."""
        return slice(self.slower.stop, self.slower.stop + len(self.tilt))

    def as_late(self, t_s: FloatArray, gyro_rates: FloatArray, errors: FloatArray) -> FloatArray:
        """(n, 4, 3) what gyros with the mean lag would show of what they show with errors (r,)."""
        # One number a gyro, (4, 1): broadcast over samples and axes.
        by_delay, by_second = (self.apart @ errors[self.slower]).T[..., None]
        first = derivative(t_s, gyro_rates)
        return np.asarray(gyro_rates + by_delay * first + by_second * derivative(t_s, first))

    def tilt_of(self, errors: FloatArray) -> FloatArray:
        """(3, 2) tilts of the axes with errors (r,), rad."""
        return np.asarray((self.tilt * errors[self.tilts]).reshape(-1, 2))

    @property
    def starts(self) -> slice:
        """Of the joints."""
        return slice(self.tilts.stop, self.tilts.stop + len(self.start))

    def walk(self, joint: int) -> slice:
        """Return the slice of one joint's random walk among the errors; joints count from 0."""
        first = self.starts.stop + sum(walk.angle.shape[1] for walk in self.walks[:joint])
        return slice(first, first + self.walks[joint].angle.shape[1])

    def __len__(self) -> int:
        return int(self.walk(len(self.walks) - 1).stop)

    def parameters_of(self, errors: FloatArray) -> FloatArray:
        """(4, 12) what each gyro's parameters are off with errors (r,)."""
        off = self.gyro_root @ errors[self.gyro] + self.gyros_by_tilts @ errors[self.tilts]
        return np.asarray(off.reshape(-1, PARAMETERS))

    @property
    def own_units(self) -> FloatArray:
        """(r, r) the errors in physical units, as far as they are parameters of gyros."""
        units = np.eye(len(self))
        units[self.gyro, self.gyro], units[self.gyro, self.tilts] = self.gyro_root, self.gyros_by_tilts
        return units

    def lag_of(self, sheet: Lag, errors: FloatArray) -> Lag:
        """Return the data sheet's lag corrected by the errors (r,)."""
        delay, second = self.lag * errors[self.moments]
        return replace(sheet, delay_s=sheet.delay_s + float(delay), second_s2=sheet.second_s2 + float(second))

    def own_angles(self, errors: FloatArray) -> FloatArray:
        """(n, 3) joint angles from initial angles and random walks alone."""
        starts = self.start * errors[self.starts]
        walked = [walk.angle @ errors[self.walk(joint)] for joint, walk in enumerate(self.walks)]
        return np.asarray(starts + np.column_stack(walked))


def gyro_errors(
    prior: Prior, t_s: FloatArray, gyro_rates: FloatArray, by_parameters: FloatArray
) -> FloatArray:
    """(n, 4, 3, r) each gyro's rate, its lag taken off, by the errors.

    `gyro_rates` (n, 4, 3) is what the gyros show, body axes; `by_parameters` (n, 4, 3, 12) the same without
    its lag, by each gyro's parameters.
    """
    n, bodies = gyro_rates.shape[:2]
    errors = np.zeros((n, bodies, 3, len(prior)))
    for body in range(bodies):
        own = slice(PARAMETERS * body, PARAMETERS * (body + 1))
        errors[:, body, :, prior.gyro] = by_parameters[:, body] @ prior.gyro_root[own]
        errors[:, body, :, prior.tilts] = by_parameters[:, body] @ prior.gyros_by_tilts[own]
    first = derivative(t_s, gyro_rates)
    # Columns by the lag's moments: first and second derivative of what the gyro shows.
    moments = np.stack([first, derivative(t_s, first)], axis=-1)
    errors[..., prior.moments] = moments * prior.lag
    errors[..., prior.slower] = moments @ prior.apart
    return errors


def error_jacobians(
    prior: Prior,
    t_s: FloatArray,
    fused: FusedRates,
    gyros: FloatArray,
    by_angles: tuple[FloatArray, FloatArray],
    by_tilts: FloatArray,
    covariance: FloatArray,
) -> ErrorJacobians:
    """Compute the error Jacobians of all quantities that follow from the gyros.

    Args:
        prior: Of the errors.
        t_s: (n,) after the release.
        fused: Rates from all gyros.
        gyros: (n, 4, 3, r) by `gyro_errors`.
        by_angles: By `rates_by_angles`.
        by_tilts: By `bodies_by_tilts`.
        covariance: (r, r) of the errors.
    """
    n = len(t_s)
    gyros = np.where(fused.bridged[..., None, None], 0.0, gyros)
    # Errors reach the fused rates through the gains: those of gyros, and tilts that mislead the map.
    residual_by_errors = -gyros
    residual_by_errors[..., prior.tilts] += by_tilts * prior.tilt
    direct = -fused.gains @ residual_by_errors.reshape(n, -1, len(prior))
    # What the angles have apart from integrated rates: their starts and their walks.
    own = np.zeros((n, len(prior.start), len(prior)))
    for joint, walk in enumerate(prior.walks):
        direct[:, 3 + joint, prior.walk(joint)] += walk.rate
        own[:, joint, prior.starts][:, joint] = prior.start[joint]
        own[:, joint, prior.walk(joint)] = walk.angle
    # The walk's rate is in its angle already.
    walked = direct[:, 3:].copy()
    for joint in range(len(prior.walks)):
        walked[:, joint, prior.walk(joint)] -= prior.walks[joint].rate
    own += turned_from(t_s, walked)
    both_by_angles, bodies_by_angles = by_angles
    angles = carry_angles(t_s, own, both_by_angles)
    rates = direct + both_by_angles @ angles
    # The pose's columns hold the fused rates' own change: `direct` goes with them, not `rates`.
    by_both = np.concatenate([fused.gyro_map, bodies_by_angles], axis=-1).reshape(n, -1, 6 + len(prior.start))
    bodies = (by_both @ np.concatenate([direct, angles], axis=1)).reshape(gyros.shape)
    bodies[..., prior.tilts] += by_tilts * prior.tilt
    return ErrorJacobians(gyros, rates, bodies, angles, covariance)


def carry_angles(t_s: FloatArray, own: FloatArray, by_angles: FloatArray) -> FloatArray:
    """(n, joints, r) joint angles with own parts (n, joints, r) and fused rates by angles (n, 3 + joints, joints)."""
    angles = own
    # Fixed point: angles follow from rates, and the fused rates from angles.
    for _ in range(_CARRIED):
        angles = own + turned_from(t_s, by_angles[:, 3:] @ angles)
    return angles


KNOT_S = 0.2
"""The random walk of an integrated rate is followed so finely."""


@dataclass(frozen=True, eq=False)
class RandomWalk:
    """One joint's, as independent steps from knot to knot.

    Attributes:
        angle: (n, k) what a step of one standard deviation adds to the angle.
        rate: (n, k) and to the rate, where that follows from the angle sensors; else the noise of a sample counts.
    """

    angle: FloatArray
    rate: FloatArray


def random_walk(
    t_s: FloatArray,
    density_rad_s_rthz: float,
    unsensed: BoolArray,
    sensed_std_rad: float,
    fine_s: float,
    holes: Holes,
) -> RandomWalk:
    """Build the random walk of one joint.

    Args:
        t_s: (n,) after the release, where the walk begins.
        density_rad_s_rthz: One-sided noise density of the joint's rate by its gyros.
        unsensed: (n,) True where the rate is the angle sensors' slope.
        sensed_std_rad: Standard deviation of the integral of that slope from one knot to the next.
        fine_s: The slope's smoothing time, and the spacing of the knots where the slope is used.
        holes: Missing samples, with the rotation the joint may have made in them beyond what was carried over.
    """
    knots = _knots(t_s, unsensed, fine_s, holes)
    left_knots, right = knots[:-1], knots[1:]
    # Ramps (n, k): each step of the walk grows evenly from its knot to the next.
    angle = np.clip((t_s[:, None] - left_knots) / (right - left_knots), 0.0, 1.0)
    by_slope = np.interp(0.5 * (left_knots + right), t_s, unsensed.astype(float)) > 0.5
    # White rate noise of one-sided density N integrates to the variance N^2 dt / 2.
    variance = 0.5 * density_rad_s_rthz**2 * (right - left_knots)
    variance = variance + np.where(by_slope, sensed_std_rad**2, 0.0)
    # A hole lies between two knots of its own: what is missed in it is one step.
    variance = variance + holes.variance_between(left_knots, right)
    step = np.sqrt(variance)
    # Where the slope stands for the rate, a step of the angle is an error of the rate as well.
    inside = (t_s[:, None] >= left_knots) & (t_s[:, None] < right) & by_slope
    return RandomWalk(angle * step, np.where(inside, step / (right - left_knots), 0.0))


def _knots(t_s: FloatArray, unsensed: BoolArray, fine_s: float, holes: Holes) -> FloatArray:
    coarse = np.arange(0.0, t_s[-1] + KNOT_S, KNOT_S)
    fine = np.arange(0.0, t_s[-1], fine_s)
    # Finer knots only where the angle sensors' slope stands in for a gyro.
    fine = fine[np.interp(fine, t_s, unsensed.astype(float)) > 0.0]
    inner = np.concatenate([coarse, fine])
    # No knots inside a hole, where no sample tells steps apart; its ends are knots instead.
    in_hole = (inner[:, None] > holes.from_s) & (inner[:, None] < holes.until_s)
    edges = np.concatenate([holes.from_s, holes.until_s])
    knots = np.unique(np.concatenate([[0.0], inner[~in_hole.any(axis=1)], edges[edges > 0.0]]))
    # A knot just next to another would make a step that no sample distinguishes from it.
    return np.asarray(knots[np.concatenate([[True], np.diff(knots) > 1e-6])])
