"""Scale factors and the bend of the angle sensors, from sweeps of a joint between rests: both fitted at once.

Between rests the integral of a gyro, T, and the angles s by the joint's two sensors (freed of their directions) obey

    s1 = g T + b t + c1 + h(shown1) a1,    s2 = g T + b t + c2 + h(shown2) a2

with g the inverse of the gyro's response, b t what is left of its bias, and a the amplitudes of the first two
harmonics h of a sensor's error. A sensor's bend over the joint's range cannot wholly be separated from a scale, so
the amplitudes have the robot file's `nonlinearity_deg` as their prior; what remains doubtful is in the covariance.
The mean and the half difference of both sensors are fitted instead of each: what sways is common to both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.response import Response, rest_means
from tfsat_host.calibration.sensors.joint_sensors import harmonics
from tfsat_host.calibration.statistics import student_t_factor
from tfsat_host.calibration.steps.sensor_samples import find_rests
from tfsat_host.calibration.steps.step_motion import Motion
from tfsat_host.next_step import Advice, NextStep

MIN_RESTS = 6
MAX_TIME_CORRELATION = 0.95
"""Correlation of angle with time: beyond it what is left of the bias cannot be separated from the scale factor."""
MAX_NONLINEARITY_SIGMAS = 4.5
"""Of a sensor's four amplitudes together: beyond it lie 0.05 % of the sensors that are as the robot file says."""
# Passes of reweighting with the two deviations that the residuals show.
_ROUNDS = 4


@dataclass(frozen=True, eq=False)
class Rests:
    """One gyro over one sweep, at k rests.

    Attributes:
        body: 1 to 4.
        turned: (k,) integral of the reading along its direction, as the joint opens.
        time_s: (k,) about their mean.
        by_sensor_rad: (k, 2) joint angle by each sensor, directions taken off.
        curves: (k, 2, 4) harmonics of what each shows, times its direction.
        weight: Of its mean equations: gyros of one sweep share the sensors' errors.
    """

    body: int
    turned: FloatArray
    time_s: FloatArray
    by_sensor_rad: FloatArray
    curves: FloatArray
    weight: float


def rests_of_sweep(motion: Motion, body: int, response: Response) -> Rests:
    """Compute one gyro's integrated rate and the angle sensors' readings at the rests of a sweep.

    Raises:
        CalibrationError: there are too few rests, or the joint went one way only.
    """
    t_s, joint = motion.recording.t_s, motion.step.moving_joint
    # Rate along the response: its integral is the angle turned times the response's length.
    along = motion.sense() * motion.readings(body) @ (response.reading / response.length)
    rests = find_rests(t_s, along)
    if len(rests) < MIN_RESTS:
        raise CalibrationError(
            what=f"The sweep of joint {joint} has {len(rests)} rests; at least {MIN_RESTS} are needed.",
            meaning="Only from rest to rest does a gyro's filter not falsify the scale factor.",
            next_step="Move the joint to 30, 60, 90 deg and back, resting a second at each, and run this "
            "command again.",
        )
    times, turned = rest_means(t_s, rests), rest_means(cumulative_trapezoid(along, t_s, initial=0), rests)
    if abs(np.corrcoef(turned, times)[0, 1]) > MAX_TIME_CORRELATION:
        raise CalibrationError(
            what=f"The sweep of joint {joint} went one way only.",
            meaning="A drift of the gyro's bias would be taken for a scale factor.",
            next_step="Move the joint to 30, 60, 90 deg and back in the same steps, resting a second at each, and "
            "run this command again.",
        )
    # Unwrap before averaging: a rest at a sensor's wrap would have no meaningful mean.
    rest_angles_rad = rest_means(np.unwrap(motion.sensors_shown(), axis=0), rests)
    direction = motion.joints[joint - 1].direction
    # (k, 2, 4): the bend is an error of the angle shown; the direction turns it into one of the joint.
    curves = np.stack([direction[k] * harmonics(rest_angles_rad[:, k]) for k in range(2)], axis=1)
    # Gyros of one sweep see the same errors of the angle sensors: together they count once.
    weight = 1.0 / len(motion.step.moved)
    return Rests(body, turned, times - times.mean(), direction * rest_angles_rad, curves, weight)


def fit_sweeps(
    joint: int,
    sweeps: Sequence[Rests],
    nonlinearity_rad: FloatArray,
    known_lengths: Sequence[tuple[float, float] | None],
) -> tuple[dict[int, tuple[float, float]], FloatArray, FloatArray]:
    """Lengths of the responses and the sensors' bend.

    Args:
        joint: 1 to 3.
        sweeps: Of one or several gyros; a body may come in one sweep only.
        nonlinearity_rad: (2,) standard deviation of each amplitude of each sensor.
        known_lengths: For each of `sweeps` the length that a turn by hand gave, with its deviation, or None.

    Returns:
        Body to length of its response (reading per rate) and standard deviation; (2, 4) amplitudes, rad; and their
        covariance (8, 8).

    Raises:
        CalibrationError: the sensors bend much more than the robot file says.
    """
    # The inverse lengths are the unknowns: so the model is linear in all parameters.
    design, target, of_mean, weights = _equations(sweeps)
    prior, prior_target = _priors(nonlinearity_rad, known_lengths, design.shape[1])
    solution, covariance = _fit_weighted(design, target, of_mean, weights, prior, prior_target)
    bend = solution[-8:].reshape(2, 4)
    # All four of a sensor together: over a joint's range they can seldom be separated.
    sizes = np.linalg.norm(bend, axis=1)
    sigmas = sizes / nonlinearity_rad
    if sigmas.max() > MAX_NONLINEARITY_SIGMAS:
        worst = int(np.argmax(sigmas))
        raise CalibrationError(
            what=f"Nonlinearity of angle sensor {worst + 1} of joint {joint}: at least {np.rad2deg(sizes[worst]):.2f} "
            f"deg, {sigmas[worst]:.0f} times the standard deviation in the robot file.",
            meaning="A scale factor that is measured against it would be as wrong.",
            next_step=Advice(
                "Adjust its magnet, or state nonlinearity_deg in the robot file as its data sheet does "
                "and turn the robot by hand as well: ",
                NextStep("calibrate scale", ("--turn", "x", "360")),
            ),
        )
    # Length = 1/g; by the delta method its deviation is that of g over g squared.
    inverse, std = solution[:-8:4], np.sqrt(np.diag(covariance)[:-8:4])
    lengths = zip((1.0 / inverse).tolist(), (std / inverse**2).tolist(), strict=True)
    return dict(zip((sweep.body for sweep in sweeps), lengths, strict=True)), bend, covariance[-8:, -8:]


def _fit_weighted(
    design: FloatArray,
    target: FloatArray,
    of_mean: NDArray[np.bool_],
    weights: FloatArray,
    prior: FloatArray,
    prior_target: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Solution and its covariance; the deviation of each class of equations is estimated along with it."""
    solution, covariance, freedom = np.zeros(len(prior)), prior, np.zeros(2)
    # Starting values: each pass takes new ones from the residuals of mean and difference rows.
    deviations = np.full(2, np.deg2rad(0.05))
    for _ in range(_ROUNDS):
        std = np.where(of_mean, deviations[0], deviations[1]) / np.sqrt(weights)
        # Whitened rows of the measurement; the priors enter by their normal matrix.
        scaled = design / std[:, None]
        covariance = np.asarray(np.linalg.inv(scaled.T @ scaled + prior))
        solution = covariance @ (scaled.T @ (target / std) + prior_target)
        residuals = target - design @ solution
        # Each equation takes its leverage off its own class's degrees of freedom.
        leverage = np.einsum("ni,ij,nj->n", scaled, covariance, scaled)
        classes = (of_mean, ~of_mean)
        # Effective degrees of freedom; at least three, for Student's t has no variance with fewer.
        freedom = np.array([max(3.0, float((weights * (1.0 - leverage))[rows].sum())) for rows in classes])
        squares = np.array([float((weights * residuals**2)[rows].sum()) for rows in classes])
        deviations = np.sqrt(squares / freedom)
    # Only what was estimated from few numbers is widened, not the prior.
    std = np.where(
        of_mean, *(deviations * np.sqrt([student_t_factor(max(3, round(count))) for count in freedom]))
    )
    scaled = design * np.sqrt(weights)[:, None] / std[:, None]
    return solution, np.asarray(np.linalg.inv(scaled.T @ scaled + prior))


def _equations(
    sweeps: Sequence[Rests],
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_], FloatArray]:
    """Rows of mean and half difference.

    Unknown are for each sweep g, b, c, e (offset of the difference), then 8 amplitudes.
    """
    n = 4 * len(sweeps) + 8
    rows, targets, is_mean, weights = [], [], [], []
    for index, sweep in enumerate(sweeps):
        k = len(sweep.turned)
        # Means see rate, bias and both bends; half differences see only the bends and an offset.
        mean, half = np.zeros((k, n)), np.zeros((k, n))
        mean[:, 4 * index : 4 * index + 3] = np.column_stack([sweep.turned, sweep.time_s, np.ones(k)])
        half[:, 4 * index + 3] = 1.0
        first, second = 0.5 * sweep.curves[:, 0], 0.5 * sweep.curves[:, 1]
        mean[:, -8:] = np.hstack([first, second])
        half[:, -8:] = np.hstack([first, -second])
        rows += [mean, half]
        targets += [
            sweep.by_sensor_rad.mean(axis=1),
            0.5 * (sweep.by_sensor_rad[:, 0] - sweep.by_sensor_rad[:, 1]),
        ]
        is_mean += [np.ones(k, dtype=bool), np.zeros(k, dtype=bool)]
        weights += [np.full(2 * k, sweep.weight)]
    return np.vstack(rows), np.concatenate(targets), np.concatenate(is_mean), np.concatenate(weights)


def _priors(
    nonlinearity_rad: FloatArray, known_lengths: Sequence[tuple[float, float] | None], n: int
) -> tuple[FloatArray, FloatArray]:
    """Normal matrix (n, n) and right side (n,) of what is known before."""
    normal, right = np.zeros((n, n)), np.zeros(n)
    # Amplitudes are zero within what the robot file says of the sensor.
    normal[-8:, -8:] = np.diag(1.0 / np.repeat(nonlinearity_rad, 4) ** 2)
    for index, length in enumerate(known_lengths):
        if length is not None:
            # A turn by hand measured this length: a pseudo-observation of its inverse.
            g, std = 1.0 / length[0], length[1] / length[0] ** 2
            normal[4 * index, 4 * index] += 1.0 / std**2
            right[4 * index] += g / std**2
    return normal, right
