"""From calibrated samples to what the robot did: joint angles, rates and attitudes of all bodies."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from tfsat_host.arrays import BoolArray, FloatArray, describe_fields
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.sensors.joint_sensors import sensor_columns
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.evaluation.motion.attitude import BodyMotion, Rates, body_motion
from tfsat_host.evaluation.motion.gyro_signal import Lag
from tfsat_host.evaluation.motion.joints import JointMotion, SensedJoint
from tfsat_host.evaluation.motion.rate_fusion import FusedRates
from tfsat_host.evaluation.motion.samples import MAX_GAP_S, Samples, bridge_missing, turned_from
from tfsat_host.evaluation.motion.sensor_fusion import FusionSolution, SensorFusion
from tfsat_host.robot import RobotModel
from tfsat_host.sdlog.log_summary import single_misses


@dataclass(frozen=True, eq=False)
class Motion:
    """What the robot did, at n samples from just before the release to just before the landing.

    Attributes:
        samples: What it follows from.
        densities_rad_s_rthz: (4,) noise of each gyro.
        fusion: All sensors together.
        solved: What they agree on.
        joints: Of joints 1 to 3.
        bodies: Of bodies 1 to 4, from the release on.
    """

    samples: Samples
    densities_rad_s_rthz: FloatArray
    fusion: SensorFusion
    solved: FusionSolution
    joints: tuple[JointMotion, ...]
    bodies: tuple[BodyMotion, ...]

    __repr__ = describe_fields

    @property
    def t_s(self) -> FloatArray:
        """(n,) after the release."""
        return self.samples.t_s

    @property
    def angles_rad(self) -> FloatArray:
        """(n, 3) of the joints."""
        return np.column_stack([joint.angle_rad for joint in self.joints])

    @property
    def lag(self) -> Lag:
        """Of the gyros' low-pass; taken off all rates and angles here."""
        return self.solved.lag

    @property
    def fused(self) -> FusedRates:
        """Rates from all gyros together."""
        return self.solved.fused

    @property
    def variance(self) -> FloatArray:
        """(n, 4) of a gyro's sample, mean over its axes."""
        return np.asarray(np.trace(self.fusion.noise, axis1=2, axis2=3) / 3.0)

    @property
    def contradicted(self) -> bool:
        """The sensors would have the gyros farther off than their calibration allows: none is corrected by another."""
        return self.solved.contradicted


def motion_of(
    samples: Samples, calibration: Calibration, model: RobotModel, densities: FloatArray, low_pass: LowPass
) -> Motion:
    """Joint angles, rates and attitudes of one drop, by the calibration that its samples were made with.

    `densities` (4,) is the noise of each gyro, rad/s/sqrt(Hz); `low_pass` is the gyros'.
    """
    # First decide which angle sensors to believe, by the gyros' integral and the servo's hold.
    sensed = tuple(
        SensedJoint.of(
            sensors,
            samples.sensor_angle_rad[:, sensor_columns(model, sensors.joint)],
            servo.start_rad,
            _turned_by_gyros(samples, model, sensors.joint - 1),
        )
        for sensors, servo in zip(calibration.joints, model.servos, strict=True)
    )
    fusion = SensorFusion.of(samples, sensed, calibration, model, densities, low_pass)
    solved = fusion.solve()
    smoothing_rad = fusion.smoothing_rad(solved.fused)
    joints = tuple(
        JointMotion.of(
            joint,
            solved.angles_rad[:, j],
            solved.jacobians.angles[:, j],
            solved.jacobians.covariance,
            smoothing_rad[:, j],
        )
        for j, joint in enumerate(sensed)
    )
    return Motion(samples, densities, fusion, solved, joints, _bodies(samples, solved, fusion.noise))


def _bodies(samples: Samples, solved: FusionSolution, noise: FloatArray) -> tuple[BodyMotion, ...]:
    """Compute the motion of each body by its own gyro, and by the others where that did not answer."""
    fused, jacobians = solved.fused, solved.jacobians
    bridge = fused.body_rates()
    body_motions = []
    for b in range(noise.shape[1]):
        bridged = fused.bridged[:, b]
        apart = bridged[:, None, None]
        # The own gyro where it answered, all gyros together elsewhere; errors and noise go with the choice.
        by_errors = np.where(apart, jacobians.bodies[:, b], jacobians.gyros[:, b])
        spread = fused.gyro_map[:, b] @ fused.covariance @ fused.gyro_map[:, b].swapaxes(1, 2)
        spread = np.where(apart, spread, noise[:, b])
        rate = np.where(bridged[:, None], bridge[:, b], solved.rates_rad_s[:, b])
        body_motions.append(
            body_motion(
                samples.t_s, Rates(rate, by_errors, spread, bridged), jacobians.covariance, samples.rate_hz
            )
        )
    return tuple(body_motions)


def _turned_by_gyros(samples: Samples, model: RobotModel, joint: int) -> FloatArray:
    """(n,) of one joint, by its own two gyros alone; NaN if one of them lacks more than it can be carried over."""
    outer, inner = int(model.joint_outer[joint]), int(model.joint_inner[joint])
    # What turns about the axis looks the same from both bodies.
    rate = (samples.rate_rad_s[:, outer] - samples.rate_rad_s[:, inner]) @ model.joint_axis[joint]
    is_finite = np.isfinite(rate)
    # The longest time without this rate, both ends of the record included, must be bridgeable.
    if (
        not is_finite.any()
        or np.diff(samples.t_s[is_finite], prepend=samples.t_s[0], append=samples.t_s[-1]).max() > MAX_GAP_S
    ):
        return np.full_like(rate, np.nan)
    return turned_from(samples.t_s, bridge_missing(samples.t_s, rate))


SETTLED_S = 0.03
"""After the release: before, the springs still push and the low-pass remembers the hold."""
BEFORE_STROKE_S = 0.02
MIN_SAMPLES = 5


@dataclass(frozen=True, eq=False)
class InitialRate:
    """Mean rate of one body over the quiet samples, body axes.

    Attributes:
        rate_rad_s: (3,).
        std_rad_s: (3,) from noise and the gyro's parameters.
    """

    rate_rad_s: FloatArray
    std_rad_s: FloatArray

    @classmethod
    def withheld(cls) -> InitialRate:
        """Return a withheld initial rate: NaN throughout."""
        return cls(np.full(3, np.nan), np.full(3, np.nan))


def quiet_samples(t_s: FloatArray, first_stroke_s: float) -> BoolArray:
    """(n,) after the release has settled and before the first stroke; at least a few."""
    quiet = (t_s >= SETTLED_S) & (t_s < first_stroke_s - BEFORE_STROKE_S)
    # An early stroke leaves too few quiet samples: take the first ones after settling all the same.
    if quiet.sum() < MIN_SAMPLES:
        first = int(np.searchsorted(t_s, SETTLED_S))
        quiet = np.zeros(len(t_s), bool)
        quiet[first : first + MIN_SAMPLES] = True
    return quiet


def initial_rates(motion: Motion, first_stroke_s: float) -> tuple[InitialRate, ...]:
    """Compute each body's initial mean rate as its turn over the time, with the turn's uncertainty."""
    rates = []
    for moved in motion.bodies:
        rows = np.flatnonzero(quiet_samples(moved.t_s, first_stroke_s))
        first, last = rows[0], rows[-1]
        # A mean rate is a turn over a time: difference the Jacobians, as the same errors are in both ends.
        by = moved.by_errors[last] - moved.by_errors[first]
        turned = by @ moved.error_covariance @ by.T
        # Noise accumulates: its share is the difference of two cumulative variances.
        turned = turned + moved.noise_covariance[last] - moved.noise_covariance[first]
        duration_s = moved.t_s[last] - moved.t_s[first]
        rate = moved.rate_rad_s[rows].mean(axis=0)
        rates.append(InitialRate(rate, np.sqrt(np.diag(turned)) / duration_s))
    return tuple(rates)


def notes_of(motion: Motion, absent: Collection[int] = ()) -> list[str]:
    """Format the notes on missing and doubtful data of one drop; `absent`: bodies (1 to 4) that have no IMU."""
    notes = []
    fall = motion.samples.fall
    answered = motion.samples.answered[fall]
    for body, bridged in enumerate((~answered).sum(axis=0), 1):
        # A few isolated misses are ordinary: no note.
        if body not in absent and not single_misses(answered[:, body - 1]):
            share = 100.0 * bridged / fall.sum()
            notes.append(
                f"The gyro of body {body} lacks {bridged} of {int(fall.sum())} samples ({share:.0f} %): they are "
                "bridged from its neighbours and the angle sensors, and its uncertainty is larger."
            )
    notes += [
        f"No angle sensor of joint {joint.joint} answered: its angle is counted from where its servo starts."
        for joint in motion.joints
        if not joint.sensed
    ]
    notes += [
        f"Angle sensor {sensed.distrusted + 1} of joint {sensed.sensors.joint} contradicts the other one, which agrees "
        "better with the gyros, or with where the servo held the joint: it is not used."
        for sensed in motion.fusion.joints
        if sensed.distrusted is not None
    ]
    if motion.lag.implausible_s is not None:
        notes.append(
            f"The strokes tell a delay of {1e3 * motion.lag.implausible_s:.1f} ms for the gyros, which no chip has "
            "with this low-pass: the data sheet's is taken off instead. The gyros contradict the angle sensors."
        )
    if motion.contradicted:
        notes.append(
            "The sensors would have the gyros farther off than their calibration allows: one of them is wrong, and "
            "none was corrected by another."
        )
    if motion.lag.implausible_s is None and not motion.lag.measured:
        notes.append("No joint moved far enough to measure the gyros' delay: the data sheet's is taken off.")
    return notes
