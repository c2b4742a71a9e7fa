"""What a gyro's errors do to the attitude that is integrated from its rates.

An error e(t) of the rate, in body axes, turns the final attitude by the integral of R(t) e(t) over the drop to first
order, R(t) being the attitude. The exact numbers come from integrating rates that are wrong.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tfsat_host.dynamics import Multibody, connection, moved, quaternion
from tfsat_host.dynamics.flying import timed_moves
from tfsat_host.evaluation.budget.attitude_errors import Turned, exactly, to_first_order
from tfsat_host.maneuver import Schedule
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]

_DRAWS = 4000  # leave 1 % of an effect along one axis
_SEED = 1
_SENSES = (1.0, -1.0)


@dataclass(frozen=True, eq=False)
class Fall:
    """What a faultless gyro reads from the release on.

    Attributes:
        t_s: (m,) at the logger's rate.
        rate_rad_s: (m, 3) of one body, in its own axes.
        sensor_to_body: (3, 3) by design.
        attitude: (4, m) integrated from these rates, to the axes at the release.
    """

    t_s: FloatArray
    rate_rad_s: FloatArray
    sensor_to_body: FloatArray
    attitude: FloatArray

    @classmethod
    def of(cls, t_s: FloatArray, rate_rad_s: FloatArray, sensor_to_body: FloatArray) -> Fall:
        """With its attitudes."""
        attitudes = integrated(t_s, rate_rad_s[:, :, None, None])
        return cls(t_s, rate_rad_s, sensor_to_body, np.stack(attitudes, axis=1)[:, :, 0, 0])

    @property
    def weights_s(self) -> FloatArray:
        """(m,) of the trapezoidal rule."""
        before, after = np.diff(self.t_s, prepend=self.t_s[0]), np.diff(self.t_s, append=self.t_s[-1])
        return np.asarray(0.5 * (before + after))

    def turned_by(self, errors_rad_s: FloatArray) -> FloatArray:
        """(k, 3) by how much rate errors (k, m, 3), body axes, turn the final attitude, to first order."""
        to_release = Rotation.from_quat(self.attitude.T).as_matrix()
        return np.asarray(np.einsum("m,mij,kmj->ki", self.weights_s, to_release, errors_rad_s))


def fall_of(robot: RobotModel, schedule: Schedule, body: int, rate_hz: float, until_s: float) -> Fall:
    """The rates of a body (1 to n) in a drop without angular momentum, from the model."""
    start = np.array([servo.start_rad for servo in robot.servos])
    history = moved(robot, timed_moves(schedule), start_rad=start, end_s=until_s)
    t_s = np.arange(int(until_s * rate_hz) + 1) / rate_hz
    seen_from_it = Multibody.of(robot, body - 1)
    rate = np.einsum(
        "mij,mj->mi", connection(seen_from_it, history.angles_rad(t_s)), history.rates_rad_s(t_s)
    )
    imu = next(imu for imu in robot.imus if imu.body == body - 1)
    return Fall.of(t_s, rate, imu.sensor_to_body)


def integrated(t_s: FloatArray, rate_rad_s: FloatArray) -> list[FloatArray]:
    """Attitudes (4, d, k) at m times, as `attitude.integrate_rates`, of many gyros at once.

    Args:
        t_s: (m,) or (m, d, k).
        rate_rad_s: (m, 3, d, k).
    """
    lengths_s = np.diff(t_s, axis=0)
    attitudes = [quaternion.identity(rate_rad_s.shape[2:])]
    for length_s, rate, next_rate in zip(lengths_s, rate_rad_s[:-1], rate_rad_s[1:], strict=True):
        turn = quaternion.exponential(0.5 * (rate + next_rate) * length_s)
        attitudes.append(quaternion.product(attitudes[-1], turn))
    return attitudes


def bias(fall: Fall, size_rad_s: float) -> tuple[Turned, Turned]:
    """Of each axis of the gyro by itself: to first order, and exactly; so all functions below."""
    errors = np.broadcast_to(fall.sensor_to_body.T[:, None], (3, *fall.rate_rad_s.shape))
    return _both(fall, size_rad_s, errors, lambda sense: fall.rate_rad_s + sense * size_rad_s * errors)


def scale(fall: Fall, size: float) -> tuple[Turned, Turned]:
    """Of each axis of the gyro by itself."""
    read = fall.rate_rad_s @ fall.sensor_to_body
    errors = read.T[:, :, None] * fall.sensor_to_body.T[:, None]
    return _both(fall, size, errors, lambda sense: fall.rate_rad_s + sense * size * errors)


def misalignment(fall: Fall, size_rad: float) -> tuple[Turned, Turned]:
    """About each axis of the body by itself."""
    errors = np.cross(np.eye(3)[:, None], fall.rate_rad_s)

    def wrong(sense: float) -> FloatArray:
        turns = Rotation.from_rotvec(sense * size_rad * np.eye(3)).as_matrix()
        return np.asarray(np.einsum("kij,mj->kmi", turns, fall.rate_rad_s))

    return _both(fall, size_rad, errors, wrong)


def noise(fall: Fall, density_rad_s_sqrt_hz: float) -> tuple[Turned, Turned]:
    """White noise of a one-sided density, in all axes."""
    step_s = float(np.diff(fall.t_s).mean())
    size = density_rad_s_sqrt_hz / (2.0 * step_s) ** 0.5
    # A rotation leaves such noise as it is, so one sample turns the attitude by its weight about each axis.
    turns = size * (fall.weights_s[:, None, None] * np.eye(3)).reshape(-1, 3)
    rng = np.random.default_rng(_SEED)
    drawn = size * rng.normal(size=(len(fall.t_s), 3, _DRAWS, 1))
    finals = integrated(fall.t_s, fall.rate_rad_s[:, :, None, None] + drawn)[-1]
    return _compared(fall, turns, finals)


def timing(fall: Fall, size_s: float) -> tuple[Turned, Turned]:
    """Of the time of each sample by itself."""
    # A sample that is late lengthens the step before it and shortens the one after.
    before, after = (np.roll(fall.rate_rad_s, shift, axis=0) for shift in (1, -1))
    before[0], after[-1] = -fall.rate_rad_s[0], -fall.rate_rad_s[-1]
    lever = 0.5 * (before - after)
    turns = size_s * Rotation.from_quat(fall.attitude.T).apply(lever)
    rng = np.random.default_rng(_SEED)
    t_s = fall.t_s[:, None, None] + size_s * rng.normal(size=(len(fall.t_s), _DRAWS, 1))
    return _compared(fall, turns, integrated(t_s, fall.rate_rad_s[:, :, None, None])[-1])


def _both(
    fall: Fall, size: float, unit_errors: FloatArray, wrong_rates: Callable[[float], FloatArray]
) -> tuple[Turned, Turned]:
    """`unit_errors` (k, m, 3) of the rate; `wrong_rates` (k, m, 3) in one sense or the other."""
    rates = np.stack([wrong_rates(sense) for sense in _SENSES])  # (2, k, m, 3)
    finals = integrated(fall.t_s, np.moveaxis(rates, (2, 3), (0, 1)))[-1]
    return _compared(fall, size * fall.turned_by(unit_errors), finals)


def _compared(fall: Fall, turns_rad: FloatArray, finals: FloatArray) -> tuple[Turned, Turned]:
    true = fall.attitude[:, -1]
    return to_first_order(turns_rad, true), exactly(finals, true)
