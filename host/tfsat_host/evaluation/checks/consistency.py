"""Everything that the sensors of one robot must agree about, as one vector that is zero but for stated errors.

Two bodies at a joint turn with the same rate but for the joint's own, which lies along its axis and is what its angle
sensors see. A robot at rest shows biases and nothing else. So there are, from means over 0.1 s:

    off the axis      outer rate - (inner rate, turned by the joint's angle), two components a joint
    along the axis    what each angle sensor shows - the integral of that difference
    at rest           each gyro's mean reading - its bias

All of it is linear in the gyros' readings, and what each calibrated number may still be off makes of it is known: the
vector's covariance follows, and with it how surprising it is, as it stands and under any hypothesis of what is wrong.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.integrate import cumulative_trapezoid

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.sensors.joint_sensors import sensor_columns
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.dynamics.components import rotation_about
from tfsat_host.evaluation.motion.gyro_signal import BLOCK_S, Lag, sheet_lag
from tfsat_host.evaluation.motion.motion import Motion
from tfsat_host.evaluation.motion.samples import Blocks
from tfsat_host.evaluation.rest import Hanging
from tfsat_host.robot import RobotModel


@dataclass(frozen=True, eq=False)
class Readings:
    """What the sensors say.

    Attributes:
        gyro_rad_s: (n, 4, 3) in the fall, sensor axes, bias included, the low-pass taken off.
        shown_rad: (n, 6) angle sensors; NaN where one did not answer.
        rest_rad_s: (4, 3) mean of each gyro at rest; NaN without one.
    """

    gyro_rad_s: FloatArray
    shown_rad: FloatArray
    rest_rad_s: FloatArray


@dataclass(frozen=True, eq=False)
class Consistency:
    """The vector of a drop.

    Its rows in order: off the axis (joint, component, block), along the axis (joint, sensor, block), rest (body, axis).

    Attributes:
        t_s: (n,) samples of the fall.
        late_rad_s: (n, 4, 3) readings of the gyros before the low-pass was taken off, holes bridged.
        readings: As they are.
        answered: (n, 4).
        variance: (n, 4) of a gyro's sample.
        jacobian: (n, 4, 3, 9) of body rates by each gyro's parameters.
        parameter_covariance: (4, 9, 9) as stated of gyros that hang.
        fall_covariance: (4, 9, 9) of what they change by when they fall.
        rest: Before the release; None if the robot was not still.
        low_pass: As the header has it.
    """

    t_s: FloatArray
    late_rad_s: FloatArray
    readings: Readings
    answered: BoolArray
    variance: FloatArray
    jacobian: FloatArray
    parameter_covariance: FloatArray
    fall_covariance: FloatArray
    rest: Hanging | None
    low_pass: LowPass
    calibration: Calibration
    model: RobotModel

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

    def pair(self, joint: int) -> tuple[int, int]:
        """The outer and the inner body of a joint (index)."""
        return int(self.model.joint_outer[joint]), int(self.model.joint_inner[joint])

    def rows(self, *parts: slice) -> BoolArray:
        """(size,) whether each row is in one of the parts."""
        chosen = np.zeros(self.size, dtype=bool)
        for part in parts:
            chosen[part] = True
        return chosen

    def sensors(self, joint: int) -> list[int]:
        """Where in the log the angle sensors of a joint (index) stand."""
        return sensor_columns(self.model, joint + 1)

    def mean(self, values: FloatArray) -> FloatArray:
        """(..., blocks) means over blocks of (..., n)."""
        return np.asarray(np.add.reduceat(values, self.block.edges, axis=-1) / self.block.counts)

    def off_axis(self, joint: int) -> slice:
        """Rows of a joint (index) off its axis."""
        return slice(2 * self.blocks * joint, 2 * self.blocks * (joint + 1))

    def along(self, joint: int, sensor: int) -> slice:
        """Rows of one sensor (0 or 1) of a joint (index)."""
        first = self.blocks * (2 * self.joints + 2 * joint + sensor)
        return slice(first, first + self.blocks)

    def at_rest(self, body: int) -> slice:
        """Rows of the rest of a body (index)."""
        first = 4 * self.blocks * self.joints + 3 * body
        return slice(first, first + 3)

    @property
    def size(self) -> int:
        return 4 * self.blocks * self.joints + 3 * self.bodies

    def body_rates(self, body: int, readings_rad_s: FloatArray) -> FloatArray:
        """(..., n, 3) body axes, of readings of the gyro of a body (index)."""
        return self.calibration.gyros[body].body_rates(readings_rad_s)

    def sensed(self, joint: int, shown_rad: FloatArray) -> FloatArray:
        """(2, n) angle of a joint (index) by each of its sensors, of all (n, 6); NaN without a calibrated zero."""
        sensors = self.calibration.joints[joint]
        angles = sensors.each(shown_rad[:, self.sensors(joint)]).T
        return angles if sensors.zero_taken is not None else np.full_like(angles, np.nan)

    def of_body(self, body: int, rates_rad_s: FloatArray, turns: Sequence[FloatArray]) -> FloatArray:
        """(..., size) what the rates (..., n, 3) of one body (index), body axes, add to the vector."""
        out = np.zeros((*rates_rad_s.shape[:-2], self.size))
        for joint in range(self.joints):
            self._add(out, joint, body, rates_rad_s, turns[joint])
        return out

    def _add(self, out: FloatArray, joint: int, body: int, rates_rad_s: FloatArray, turn: FloatArray) -> None:
        """Of one joint, if the body is one of its two."""
        basis = self._bases[joint]
        if body == self.model.joint_outer[joint]:
            across, along = rates_rad_s @ basis[:2].T, rates_rad_s @ basis[2]
        elif body == self.model.joint_inner[joint]:
            carried = -turn @ basis.T
            seen = rates_rad_s[..., 0, None] * carried[:, 0]
            for axis in (1, 2):
                seen = seen + rates_rad_s[..., axis, None] * carried[:, axis]
            across, along = seen[..., :2], seen[..., 2]
        else:
            return
        lead = rates_rad_s.shape[:-2]
        out[..., self.off_axis(joint)] = self.mean(np.swapaxes(across, -1, -2)).reshape(*lead, -1)
        turned = self.mean(cumulative_trapezoid(along, self.t_s, axis=-1, initial=0))
        for sensor in range(2):
            out[..., self.along(joint, sensor)] = -turned

    def of_angles(self, sensed_rad: Sequence[FloatArray]) -> FloatArray:
        """(size,) what joint angles, (2, n) for each joint, add to the vector."""
        out = np.zeros(self.size)
        for joint, sensor in np.ndindex(self.joints, 2):
            out[self.along(joint, sensor)] = self.mean(self._without_holes(joint, sensed_rad[joint][sensor]))
        return out

    def _without_holes(self, joint: int, angle: FloatArray) -> FloatArray:
        """(n,) an angle sensor's angle; where it did not answer the joint went on as its gyros say.

        A straight line would miss a stroke that begins or ends in the hole, and the whole block with it.
        """
        known = np.isfinite(angle)
        if known.all() or not known.any():
            return np.nan_to_num(angle)
        turned = self.by_gyros(joint)
        return np.where(known, angle, turned + np.interp(self.t_s, self.t_s[known], (angle - turned)[known]))

    def of_rest(self, body: int, rest_rad_s: FloatArray) -> FloatArray:
        """(..., size) what the mean reading (..., 3) of one gyro at rest adds."""
        out = np.zeros((*rest_rad_s.shape[:-1], self.size))
        out[..., self.at_rest(body)] = np.nan_to_num(rest_rad_s - self.calibration.gyros[body].bias_rad_s)
        return out

    def of_readings(self, body: int, readings_rad_s: FloatArray, rest_rad_s: FloatArray) -> FloatArray:
        """(..., size) what the readings of one gyro add, in the fall (..., n, 3) and at rest (..., 3)."""
        rates = self.body_rates(body, readings_rad_s)
        return self.of_body(body, rates, self.own_turns) + self.of_rest(body, rest_rad_s)

    def turned_by(self, joint: int, pair: FloatArray) -> FloatArray:
        """(n, 3, 3) from the axes of a joint's outer body to those of the inner one, by its sensors (2, n)."""
        known = np.isfinite(pair)
        angle = np.where(known, pair, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
        either = known.any(axis=0)
        joint_angle = (
            np.interp(self.t_s, self.t_s[either], angle[either]) if either.any() else self.by_gyros(joint)
        )
        return np.moveaxis(rotation_about(self.model.joint_axis[joint][:, None], joint_angle), 2, 0)

    def by_gyros(self, joint: int) -> FloatArray:
        """(n,) angle of a joint by its own two gyros, for want of angle sensors: from where its servo holds it."""
        outer, inner = self.pair(joint)
        # What turns about the axis looks the same from both bodies.
        rate = (self.own_rates[outer] - self.own_rates[inner]) @ self.model.joint_axis[joint]
        return self.model.servos[joint].start_rad + cumulative_trapezoid(rate, self.t_s, initial=0)

    def with_sensed(self, sensed_rad: Sequence[FloatArray]) -> FloatArray:
        """(size,) the vector, were these the joints' angles: (2, n) for each, the own array where it is as it was."""
        left = self.own_vector - self.of_angles(self.own_sensed) + self.of_angles(sensed_rad)
        for joint, pair in enumerate(sensed_rad):
            if pair is self.own_sensed[joint]:
                continue
            rows, turn = self.off_axis(joint), self.turned_by(joint, pair)
            angles = [self.along(joint, sensor) for sensor in range(2)]
            for body in self.pair(joint):
                was, now = np.zeros(self.size), np.zeros(self.size)
                self._add(was, joint, body, self.own_rates[body], self.own_turns[joint])
                self._add(now, joint, body, self.own_rates[body], turn)
                for part in (rows, *angles):
                    left[part] += now[part] - was[part]
        return left

    @cached_property
    def _bases(self) -> tuple[FloatArray, ...]:
        return tuple(_across_and_along(axis) for axis in self.model.joint_axis)

    @cached_property
    def own_rates(self) -> tuple[FloatArray, ...]:
        """(n, 3) of each body, by the readings as they are."""
        return tuple(self.body_rates(b, self.readings.gyro_rad_s[:, b]) for b in range(self.bodies))

    @cached_property
    def own_sensed(self) -> tuple[FloatArray, ...]:
        """(2, n) of each joint, likewise."""
        return tuple(self.sensed(joint, self.readings.shown_rad) for joint in range(self.joints))

    @cached_property
    def own_turns(self) -> tuple[FloatArray, ...]:
        """(n, 3, 3) of each joint, likewise."""
        return tuple(self.turned_by(joint, pair) for joint, pair in enumerate(self.own_sensed))

    @cached_property
    def own_parts(self) -> FloatArray:
        """(4, size) what each gyro's readings as they are add to the vector."""
        readings = self.readings
        return np.stack(
            [
                self.of_readings(b, readings.gyro_rad_s[:, b], readings.rest_rad_s[b])
                for b in range(self.bodies)
            ]
        )

    @cached_property
    def own_vector(self) -> FloatArray:
        """(size,) of the readings as they are."""
        return np.asarray(self.own_parts.sum(axis=0) + self.of_angles(self.own_sensed))


def sensor_name(joint: int, sensor: int) -> str:
    """For people; both are indices."""
    return f"angle sensor {sensor + 1} of joint {joint + 1}"


def _across_and_along(axis: FloatArray) -> FloatArray:
    """(3, 3) two unit vectors square to an axis and to each other, and the axis."""
    first = np.cross(axis, np.eye(3)[int(np.abs(axis).argmin())])
    first = first / np.linalg.norm(first)
    return np.array([first, np.cross(axis, first), axis])


def consistency_of(
    motion: Motion, rest: Hanging | None, low_pass: LowPass, calibration: Calibration, model: RobotModel
) -> Consistency:
    """Of one drop.

    Args:
        motion: Its samples. Its lag is not used: a sensor that is wrong spoils that first.
        rest: Before the release.
        low_pass: As the header has it.
        calibration: That the samples were calibrated with.
        model: Joints and sensors.
    """
    samples, lag = motion.samples, sheet_lag(low_pass)
    late = np.stack([_readings(motion, lag, b, gyro) for b, gyro in enumerate(calibration.gyros)], axis=1)
    fall = samples.fall
    rested = np.full((len(calibration.gyros), 3), np.nan) if rest is None else rest.reading_rad_s
    return Consistency(
        samples.t_s[fall],
        late[fall],
        Readings(lag.removed(samples.t_s, late)[fall], samples.sensor_angle_rad[fall], rested),
        samples.answered[fall],
        motion.variance[fall],
        np.nan_to_num(samples.rate_jacobian[fall]),
        samples.hanging_covariance,
        samples.parameter_covariance - samples.hanging_covariance,
        rest,
        low_pass,
        calibration,
        model,
    )


def _readings(motion: Motion, lag: Lag, body: int, gyro: GyroCalibration) -> FloatArray:
    """(n, 3) of one gyro, sensor axes; where it did not answer what the others would have had it show.

    A straight line would miss a stroke that begins or ends in the hole, and blame a sensor for it.
    """
    own = motion.samples.rate_rad_s[:, body]
    others = lag.applied(motion.t_s, motion.fused.body_rates()[:, body])
    return np.asarray(gyro.readings(np.where(np.isfinite(own), own, others)) + gyro.bias_rad_s)
