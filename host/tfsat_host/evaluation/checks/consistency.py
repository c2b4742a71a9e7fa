"""The residual of a drop: everything that the sensors of one robot must agree about, as one vector.

Two bodies at a joint turn with the same rate but for the joint's own, which lies along its axis and is what its angle
sensors show. A robot at rest shows biases and nothing else. From means over 0.1 s:

    off the axis      outer rate - (inner rate, turned by the joint's angle), two components a joint
    along the axis    what each angle sensor shows - the integral of that difference
    at rest           each gyro's mean reading - its bias

All of it is linear in the gyros' readings, so its covariance follows from the stated errors (`stated_errors.py`); a
hypothesis about a fault (`hypotheses.py`) is the residual with that fault put right.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.integrate import cumulative_trapezoid

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.sensors.joint_sensors import sensor_columns
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.dynamics.components import rotation_about
from tfsat_host.dynamics.multibody import Multibody, across
from tfsat_host.evaluation.checks.check import SensorColumn
from tfsat_host.evaluation.motion.gyro_signal import BLOCK_S, Lag, sheet_lag
from tfsat_host.evaluation.motion.motion import Motion
from tfsat_host.evaluation.motion.samples import Blocks
from tfsat_host.evaluation.rest import RestBeforeRelease
from tfsat_host.robot import RobotModel

_TILT_STEP_RAD = 1e-4


@dataclass(frozen=True, eq=False)
class Consistency:
    """The residual of a drop, and what it is made of.

    Its rows in order: off the axis (joint, component, block), along the axis (joint, sensor, block), rest (body, axis).
    All joints, bodies and sensors are counted from 0.

    Attributes:
        t_s: (n,) samples of the fall.
        gyro_rad_s: (n, 4, 3) readings of the gyros, sensor axes, bias included, the low-pass taken off, holes bridged.
        lagging_rad_s: (n, 4, 3) the same with the low-pass in them.
        shown_rad: (n, 6) angle sensors; NaN where one did not answer.
        rest_rad_s: (4, 3) mean of each gyro at rest; NaN without one.
        answered: (n, 4).
        variance: (n, 4) of a gyro's sample.
        jacobian: (n, 4, 3, 12) of body rates by each gyro's parameters.
        parameter_covariance: (4, 12, 12) as stated of gyros that hang.
        fall_covariance: (4, 12, 12) of what they change by when they fall.
        rest: Before the release; None if the robot was not still.
        low_pass: As the header has it.
        model: The robot with the axes of its joints as they were found.
        tilt_rad: (3, 2) by which they were tilted for it.
    """

    t_s: FloatArray
    gyro_rad_s: FloatArray
    lagging_rad_s: FloatArray
    shown_rad: FloatArray
    rest_rad_s: FloatArray
    answered: BoolArray
    variance: FloatArray
    jacobian: FloatArray
    parameter_covariance: FloatArray
    fall_covariance: FloatArray
    rest: RestBeforeRelease | None
    low_pass: LowPass
    calibration: Calibration
    model: RobotModel
    tilt_rad: FloatArray

    @cached_property
    def block(self) -> Blocks:
        """Over which means are taken."""
        return Blocks.of(self.t_s, BLOCK_S)

    @property
    def blocks(self) -> int:
        return len(self.block.edges)

    @property
    def joints(self) -> int:
        return len(self.model.joint_names)

    @property
    def bodies(self) -> int:
        return len(self.calibration.gyros)

    @property
    def size(self) -> int:
        return 4 * self.blocks * self.joints + 3 * self.bodies

    def off_axis(self, joint: int) -> slice:
        """Rows of a joint off its axis."""
        return slice(2 * self.blocks * joint, 2 * self.blocks * (joint + 1))

    def along(self, joint: int, sensor: int) -> slice:
        """Rows of one sensor of a joint."""
        first = self.blocks * (2 * self.joints + 2 * joint + sensor)
        return slice(first, first + self.blocks)

    def at_rest(self, body: int) -> slice:
        """Rows of a body at rest."""
        first = 4 * self.blocks * self.joints + 3 * body
        return slice(first, first + 3)

    def rows(self, *parts: slice) -> BoolArray:
        """(size,) whether each row is in one of the parts."""
        chosen = np.zeros(self.size, dtype=bool)
        for part in parts:
            chosen[part] = True
        return chosen

    def pair(self, joint: int) -> tuple[int, int]:
        """Return the outer and the inner body of a joint."""
        return int(self.model.joint_outer[joint]), int(self.model.joint_inner[joint])

    def sensors(self, joint: int) -> list[int]:
        """Return the log's column indices of a joint's angle sensors."""
        return sensor_columns(self.model, joint + 1)

    def angle_sensor(self, joint: int, sensor: int) -> SensorColumn:
        """Return one angle sensor of a joint as a column of the log."""
        return SensorColumn(sensor_name(joint, sensor), "angle sensor", self.sensors(joint)[sensor])

    def mean(self, values: FloatArray) -> FloatArray:
        """(..., blocks) means over blocks of (..., n)."""
        return np.asarray(np.add.reduceat(values, self.block.edges, axis=-1) / self.block.counts)

    @cached_property
    def rates(self) -> tuple[FloatArray, ...]:
        """(n, 3) of each body by its gyro, body axes."""
        return tuple(gyro.body_rates(self.gyro_rad_s[:, b]) for b, gyro in enumerate(self.calibration.gyros))

    @cached_property
    def sensed_angles(self) -> tuple[FloatArray, ...]:
        """(2, n) of each joint by its sensors."""
        return tuple(self.sensor_angles(joint, self.shown_rad) for joint in range(self.joints))

    @cached_property
    def rotations(self) -> tuple[FloatArray, ...]:
        """(n, 3, 3) of each joint by those, see `rotation_by`."""
        return tuple(self.rotation_by(joint, pair) for joint, pair in enumerate(self.sensed_angles))

    @cached_property
    def gyro_parts(self) -> FloatArray:
        """(4, size) what each gyro adds to the residual."""
        parts = [self.gyro_part(b, self.gyro_rad_s[:, b], self.rest_rad_s[b]) for b in range(self.bodies)]
        return np.stack(parts)

    @cached_property
    def residual(self) -> FloatArray:
        """(size,)."""
        return np.asarray(self.gyro_parts.sum(axis=0) + self.angle_part(self.sensed_angles))

    def gyro_part(self, body: int, readings_rad_s: FloatArray, rest_rad_s: FloatArray) -> FloatArray:
        """(..., size) what one gyro adds with readings in the fall (..., n, 3) and at rest (..., 3)."""
        rates = self.calibration.gyros[body].body_rates(readings_rad_s)
        return self.rate_part(body, rates, self.rotations) + self.rest_part(body, rest_rad_s)

    def rest_part(self, body: int, rest_rad_s: FloatArray) -> FloatArray:
        """(..., size) what the mean reading (..., 3) of one gyro at rest adds."""
        out = np.zeros((*rest_rad_s.shape[:-1], self.size))
        out[..., self.at_rest(body)] = np.nan_to_num(rest_rad_s - self.calibration.gyros[body].bias_rad_s)
        return out

    def rate_part(self, body: int, rates_rad_s: FloatArray, rotations: Sequence[FloatArray]) -> FloatArray:
        """(..., size) what the rates (..., n, 3) of one body, body axes, add with such rotations of the joints."""
        lead = rates_rad_s.shape[:-2]
        out = np.zeros((*lead, self.size))
        # A gyro is in the joints of its body: with plus where that is the outer one, with minus the inner.
        for joint, basis in enumerate(self._bases):
            outer, inner = self.pair(joint)
            if body == outer:
                parts = rates_rad_s @ basis.T
            elif body == inner:
                # Row vectors: times R into the outer body's axes, times B^T onto across and along.
                parts = np.einsum("...ni,nij->...nj", rates_rad_s, -rotations[joint] @ basis.T)
            else:
                continue
            across = self.mean(np.swapaxes(parts[..., :2], -1, -2))
            out[..., self.off_axis(joint)] = across.reshape(*lead, -1)
            # Along the axis the sensors show angles: integrate, and average like their readings.
            turned = self.mean(cumulative_trapezoid(parts[..., 2], self.t_s, axis=-1, initial=0))
            for sensor in range(2):
                out[..., self.along(joint, sensor)] = -turned
        return out

    def angle_part(self, sensed_rad: Sequence[FloatArray]) -> FloatArray:
        """(size,) what joint angles, (2, n) for each joint, add to the residual."""
        out = np.zeros(self.size)
        for joint, sensor in np.ndindex(self.joints, 2):
            out[self.along(joint, sensor)] = self.mean(
                self._bridge_by_gyros(joint, sensed_rad[joint][sensor])
            )
        # Linear in the tilts from those that were found on: as if the axes were as filed.
        return out - self.tilt_jacobian @ self.tilt_rad.ravel() if self.tilt_rad.any() else out

    @property
    def shared(self) -> FloatArray:
        """(4, 12, SHARED) see `GyroCalibration`."""
        return np.array([gyro.shared for gyro in self.calibration.gyros])

    @cached_property
    def tilt_jacobian(self) -> FloatArray:
        """(size, 6) the residual by tilts of the joints' axes, about the two directions across each."""
        # One-sided differences: one robot with axes as filed, and six with one axis tilted in each.
        tilts = _TILT_STEP_RAD * np.eye(2 * self.joints).reshape(-1, self.joints, 2)
        axes = [self.model.joint_axis, *Multibody.of(self.model).tilt_hinges(tilts).joint_axis]
        nominal_residual, *ends = (
            replace(
                self, model=replace(self.model, joint_axis=axis), tilt_rad=np.zeros_like(self.tilt_rad)
            ).residual
            for axis in axes
        )
        return np.stack([end - nominal_residual for end in ends], axis=1) / _TILT_STEP_RAD

    def residual_with_angles(self, sensed_rad: Sequence[FloatArray]) -> FloatArray:
        """(size,) the residual with other joint angles: (2, n) for each joint, the same array where unchanged."""
        # Recompute the rotations of changed joints only: the array's identity tells which those are.
        rotations = [
            self.rotations[joint] if pair is self.sensed_angles[joint] else self.rotation_by(joint, pair)
            for joint, pair in enumerate(sensed_rad)
        ]
        parts = [self.rate_part(body, rates, rotations) for body, rates in enumerate(self.rates)]
        parts += [self.rest_part(body, rest) for body, rest in enumerate(self.rest_rad_s)]
        return np.asarray(np.sum(parts, axis=0) + self.angle_part(sensed_rad))

    def with_one(self, joint: int, sensor: int, angle_rad: FloatArray) -> FloatArray:
        """(size,) the residual if one sensor showed the joint angle (n,)."""
        sensed = list(self.sensed_angles)
        sensed[joint] = sensed[joint].copy()
        sensed[joint][sensor] = angle_rad
        return self.residual_with_angles(sensed)

    def sensor_angles(self, joint: int, shown_rad: FloatArray) -> FloatArray:
        """(2, n) angle of a joint by each of its sensors, of all (n, 6); NaN without a calibrated zero."""
        sensors = self.calibration.joints[joint]
        angles = sensors.each(shown_rad[:, self.sensors(joint)]).T
        return angles if sensors.has_zero else np.full_like(angles, np.nan)

    def rotation_by(self, joint: int, pair: FloatArray) -> FloatArray:
        """(n, 3, 3) from the axes of a joint's outer body to those of the inner one, by its sensors (2, n)."""
        is_finite = np.isfinite(pair)
        # The mean of the sensors that answered; where neither did, a straight line in time.
        angle = np.where(is_finite, pair, 0.0).sum(axis=0) / np.maximum(is_finite.sum(axis=0), 1)
        either = is_finite.any(axis=0)
        angle = np.interp(self.t_s, self.t_s[either], angle[either]) if either.any() else self.by_gyros(joint)
        return np.moveaxis(rotation_about(self.model.joint_axis[joint][:, None], angle), 2, 0)

    def by_gyros(self, joint: int) -> FloatArray:
        """(n,) angle of a joint by its own two gyros, for want of angle sensors: from where its servo holds it."""
        outer, inner = self.pair(joint)
        # A rate about the axis is the same in both bodies' axes.
        rate = (self.rates[outer] - self.rates[inner]) @ self.model.joint_axis[joint]
        return self.model.servos[joint].start_rad + cumulative_trapezoid(rate, self.t_s, initial=0)

    def _bridge_by_gyros(self, joint: int, angle: FloatArray) -> FloatArray:
        """(n,) an angle sensor's angle; where it did not answer the joint went on by its gyros.

        A straight line would miss a stroke that begins or ends in the hole, and spoil the whole block.
        """
        is_finite = np.isfinite(angle)
        if is_finite.all() or not is_finite.any():
            return np.nan_to_num(angle)
        turned = self.by_gyros(joint)
        # The gyros give the motion in the hole; their difference to the sensor goes on in a straight line.
        return np.where(
            is_finite, angle, turned + np.interp(self.t_s, self.t_s[is_finite], (angle - turned)[is_finite])
        )

    @cached_property
    def _bases(self) -> tuple[FloatArray, ...]:
        # Rows: the two directions across each axis, and the axis.
        return tuple(np.vstack([across(axis), axis]) for axis in self.model.joint_axis)


def sensor_name(joint: int, sensor: int) -> str:
    """Format an angle sensor's name for people; both arguments are indices."""
    return f"angle sensor {sensor + 1} of joint {joint + 1}"


def consistency_of(
    motion: Motion,
    rest: RestBeforeRelease | None,
    low_pass: LowPass,
    calibration: Calibration,
    model: RobotModel,
) -> Consistency:
    """Build the consistency data of one drop; `calibration` is the one that its samples were calibrated with.

    The motion's lag is not used, because a faulty sensor corrupts that first.
    """
    # The data sheet's lag: a faulty sensor would have corrupted the measured one.
    samples, lag, solved = motion.samples, sheet_lag(low_pass), motion.solved
    # Rotate with the axes as they were found; `angle_part` takes their effect back to the filed ones.
    tilt = motion.fusion.prior.tilt_of(solved.errors)
    late = np.stack([_readings(motion, lag, b, gyro) for b, gyro in enumerate(calibration.gyros)], axis=1)
    fall = samples.fall
    gyro_rad_s = lag.remove(samples.t_s, late)[fall]
    # An error in proportion to the rate goes with the rate without its lag. What the others bridge has no own errors.
    jacobian = np.stack([gyro.jacobian(gyro_rad_s[:, b]) for b, gyro in enumerate(calibration.gyros)], axis=1)
    rested = np.full((len(calibration.gyros), 3), np.nan) if rest is None else rest.reading_rad_s
    return Consistency(
        samples.t_s[fall],
        gyro_rad_s,
        late[fall],
        samples.sensor_angle_rad[fall],
        rested,
        samples.answered[fall],
        motion.variance[fall],
        np.where(samples.answered[fall][..., None, None], jacobian, 0.0),
        samples.hanging_covariance,
        samples.parameter_covariance - samples.hanging_covariance,
        rest,
        low_pass,
        calibration,
        replace(model, joint_axis=Multibody.of(model).tilt_hinges(tilt).joint_axis),
        tilt,
    )


def _readings(motion: Motion, lag: Lag, body: int, gyro: GyroCalibration) -> FloatArray:
    """(n, 3) of one gyro, sensor axes; where it did not answer, what the other gyros make of its rate.

    A straight line would miss a stroke that begins or ends in the hole, and blame a sensor for it.
    """
    own = motion.samples.rate_rad_s[:, body]
    others = lag.apply(motion.t_s, motion.fused.body_rates()[:, body])
    return np.asarray(gyro.readings(np.where(np.isfinite(own), own, others)) + gyro.bias_rad_s)
