"""From calibrated samples to what the robot did: joint angles, rates and attitudes of all bodies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.signal import savgol_filter

from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.joints.joint_sensors import sensor_columns
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.evaluation.motion.body_motion import BodyMotion, Rates, body_motion
from tfsat_host.evaluation.motion.fusion import Fused, fuse
from tfsat_host.evaluation.motion.joints import (
    GyroPart,
    JointMotion,
    joint_motion,
    sample_noise_rad,
    turned_from,
)
from tfsat_host.evaluation.motion.lag import Lag, derivative, measured_lag, sheet_lag
from tfsat_host.evaluation.motion.noise import sample_variance
from tfsat_host.evaluation.motion.samples import Samples
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_NEIGHBOURS = 2
_SMOOTHING_ORDER = 3
_SMOOTHED = 9
"""Over so many samples a cubic is laid through a joint's sensed angles: a servo's ramp takes a dozen."""
_PASSES = 10
_CLOSE_RAD = 1e-3
"""Each pass leaves a seventh of the angles' error: the next one would be below what the sensors tell."""
_UNSENSED_VARIANCE = np.deg2rad(200.0) ** 2
"""Of the rate of a joint that nothing tells: servos turn no faster."""


@dataclass(frozen=True, eq=False)
class Motion:
    """What the robot did, at n samples from just before the release to just before the landing.

    Attributes:
        samples: What it follows from.
        lag: Of the gyros' low-pass; taken off all rates and angles here.
        densities_rad_s_rthz: (4,) noise of each gyro.
        joints: Of joints 1 to 3.
        fused: Rates from all gyros together.
        variance: (n, 4) of each axis of a gyro's sample.
        sensed_rate_rad_s: (n, 3) joint rates by the angle sensors, for samples without a gyro.
        sensed_variance: (3,) of those.
        bodies: Of bodies 1 to 4, from the release on.
    """

    samples: Samples
    lag: Lag
    densities_rad_s_rthz: FloatArray
    joints: tuple[JointMotion, ...]
    fused: Fused
    variance: FloatArray
    sensed_rate_rad_s: FloatArray
    sensed_variance: FloatArray
    bodies: tuple[BodyMotion, ...]

    @property
    def t_s(self) -> FloatArray:
        """(n,) after the release."""
        return self.samples.t_s

    @property
    def angles_rad(self) -> FloatArray:
        """(n, 3) of the joints."""
        return np.column_stack([joint.angle_rad for joint in self.joints])


def motion_of(
    samples: Samples, calibration: Calibration, model: RobotModel, densities: FloatArray, dlpf_cfg: int
) -> Motion:
    """Joint angles, rates and attitudes.

    Args:
        samples: Of one drop.
        calibration: That they were calibrated with.
        model: Joints and bodies.
        densities: (4,) noise of each gyro, rad/s/sqrt(Hz).
        dlpf_cfg: Setting of the gyros' low-pass.
    """
    body = Multibody.of(model)
    sheet = sheet_lag(dlpf_cfg)
    t = samples.t_s
    shown = _bridged_over(t, samples.rate_rad_s)
    variance = sample_variance(densities, t, shown, samples.rate_hz, dlpf_cfg)
    sensed = _sensed_angles(samples, calibration, model)
    slopes, slope_variance = _slopes(t, sensed, samples.rate_hz)

    def fused(angles: FloatArray, rates: FloatArray) -> Fused:
        return fuse(body, angles, rates, variance, slopes, slope_variance)

    late = fused(_geometry(t, sensed, model, sheet.delay_s), samples.rate_rad_s)
    turned = turned_from(t, late.joint_rate_rad_s)
    told = [joint for joint in range(model.n_joints) if _pair_answered(samples, model, joint)]
    lag = measured_lag(
        sheet,
        t,
        [turned[:, joint] for joint in told],
        [sensed[:, joint] for joint in told],
        [sample_noise_rad(sensed[:, joint]) for joint in told],
    )
    rates = np.where(_away_from_holes(samples)[..., None], lag.removed(t, shown), np.nan)
    angles = _geometry(t, sensed, model, 0.0)
    joints: tuple[JointMotion, ...] = ()
    # A joint whose angle sensors are silent stands still in the first pass; its gyros turn it in the next ones.
    for _ in range(_PASSES):
        joints = _joints(samples, calibration, model, fused(angles, rates), densities)
        before, angles = angles, np.column_stack([joint.angle_rad for joint in joints])
        if np.abs(angles - before).max() < _CLOSE_RAD:
            break
    final = fused(angles, rates)
    bodies = _bodies(samples, final, rates, variance)
    return Motion(samples, lag, densities, joints, final, variance, slopes, slope_variance, bodies)


def _bridged_over(t_s: FloatArray, rates: FloatArray) -> FloatArray:
    """Without NaN, by straight lines in time, so that neighbours of a lost sample still have a derivative."""
    filled = rates.copy()
    for index in np.ndindex(rates.shape[1:]):
        column = rates[(slice(None), *index)]
        known = np.isfinite(column)
        filled[(slice(None), *index)] = np.interp(t_s, t_s[known], column[known]) if known.any() else 0.0
    return filled


def _pair_answered(samples: Samples, model: RobotModel, joint: int) -> bool:
    """Whether both gyros beside a joint answered all the time, so that its rate is theirs."""
    pair = [int(model.joint_outer[joint]), int(model.joint_inner[joint])]
    return bool(samples.answered[:, pair].all())


def _away_from_holes(samples: Samples) -> BoolArray:
    """(n, 4) where a gyro's rate has both neighbours, which taking off the lag needs; at least one gyro everywhere."""
    near = ~samples.answered
    for shift in range(1, _NEIGHBOURS + 1):
        near[shift:] |= ~samples.answered[:-shift]
        near[:-shift] |= ~samples.answered[shift:]
    nobody = np.logical_and.reduce(near, axis=1)
    return np.where(nobody[:, None], samples.answered, ~near)


def _sensed_angles(samples: Samples, calibration: Calibration, model: RobotModel) -> FloatArray:
    """(n, 3) by those angle sensors that answered; NaN where none did."""
    columns = []
    for sensors in calibration.joints:
        each = sensors.each(samples.sensor_angle_rad[:, sensor_columns(model, sensors.joint)])
        answered = np.isfinite(each)
        total = np.where(answered, each, 0.0).sum(axis=1)
        columns.append(np.where(answered.any(axis=1), total / np.maximum(answered.sum(axis=1), 1), np.nan))
    return np.column_stack(columns)


def _geometry(t_s: FloatArray, sensed: FloatArray, model: RobotModel, late_s: float) -> FloatArray:
    """(n, 3) joint angles good enough to turn rates from body to body, `late_s` ago."""
    columns = []
    for joint, angle in enumerate(sensed.T):
        known = np.isfinite(angle)
        start = model.servos[joint].start_rad
        columns.append(
            np.interp(t_s - late_s, t_s[known], angle[known]) if known.any() else np.full_like(t_s, start)
        )
    return np.column_stack(columns)


def _slopes(t_s: FloatArray, sensed: FloatArray, rate_hz: float) -> tuple[FloatArray, FloatArray]:
    """(n, 3) joint rates by the angle sensors, and their (3,) variances; none to speak of where none answered."""
    slopes, variances = np.zeros_like(sensed), np.full(sensed.shape[1], _UNSENSED_VARIANCE)
    for joint, angle in enumerate(sensed.T):
        known = np.isfinite(angle)
        if known.sum() > _SMOOTHED:
            smooth = savgol_filter(np.interp(t_s, t_s[known], angle[known]), _SMOOTHED, _SMOOTHING_ORDER)
            slopes[:, joint] = derivative(t_s, smooth)
            # The slope between two samples m steps apart has the variance 2 (sigma / (m step))^2.
            variances[joint] = 2.0 * (sample_noise_rad(angle) * rate_hz / _SMOOTHED) ** 2
    return slopes, variances


def _joints(
    samples: Samples, calibration: Calibration, model: RobotModel, fused: Fused, densities: FloatArray
) -> tuple[JointMotion, ...]:
    turned = turned_from(samples.t_s, fused.joint_rate_rad_s)
    found = []
    for j, sensors in enumerate(calibration.joints):
        pair = [int(model.joint_outer[j]), int(model.joint_inner[j])]
        bias = float(np.sqrt(sum(np.diag(samples.parameter_covariance[b])[:3].mean() for b in pair)))
        axis = int(np.abs(model.joint_axis[j]).argmax())
        scale = max(calibration.gyros[b].scale_about(axis)[1] for b in pair)
        density = float(np.sqrt((densities[pair] ** 2).sum()))
        if not _pair_answered(samples, model, j):
            # The rate has holes that the angle sensors filled: nothing binds its integral but they.
            bias, scale = max(bias, np.deg2rad(1.0)), max(scale, 0.02)
            density = max(density, np.deg2rad(0.05))
        part = GyroPart(turned[:, j], density, bias, scale)
        shown = samples.sensor_angle_rad[:, sensor_columns(model, sensors.joint)]
        found.append(joint_motion(samples.t_s, part, shown, sensors, model.servos[j].start_rad))
    return tuple(found)


def _bodies(
    samples: Samples, fused: Fused, rates: FloatArray, variance: FloatArray
) -> tuple[BodyMotion, ...]:
    """Each by its own gyro, and where that did not answer by the others."""
    n, bodies = variance.shape
    covariance = np.asarray(block_diag(*samples.parameter_covariance))
    own = np.zeros((n, bodies, 3, 9 * bodies))
    for b in range(bodies):
        own[:, b, :, 9 * b : 9 * b + 9] = samples.rate_jacobian[:, b]
    own = np.nan_to_num(own)
    together = fused.gains @ own.reshape(n, 3 * bodies, -1)
    bridge = fused.body_rates()
    found = []
    for b in range(bodies):
        bridged = fused.bridged[:, b]
        apart = bridged[:, None, None]
        jacobian = np.where(apart, fused.seen[:, b] @ together, own[:, b])
        spread = fused.seen[:, b] @ fused.covariance @ fused.seen[:, b].swapaxes(1, 2)
        spread = np.where(apart, spread, variance[:, b, None, None] * np.eye(3))
        rate = np.where(bridged[:, None], bridge[:, b], rates[:, b])
        found.append(
            body_motion(samples.t_s, Rates(rate, jacobian, spread, bridged), covariance, samples.rate_hz)
        )
    return tuple(found)
