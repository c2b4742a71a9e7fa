"""Faults that no linear error describes: the sensors' residual with each of them put right."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import chain, combinations, permutations, product

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.checks.cause_evidence import Hypothesis
from tfsat_host.evaluation.checks.check import SensorColumn, gyro_column
from tfsat_host.evaluation.checks.consistency import Consistency, sensor_name
from tfsat_host.evaluation.checks.small_faults import LOOK, ROBOT, by_blocks, fixed_words, late
from tfsat_host.evaluation.checks.whole_residual import WholeResidual
from tfsat_host.evaluation.motion.gyro_signal import sheet_lag
from tfsat_host.next_step import Advice, NextStep

STUCK_S = 0.15
"""No sensor with noise repeats one reading for so long."""
_ANYHOW = 0.1
"""Size of errors of any kind, rad or rad/s."""
_ANYWHERE_RAD = 0.5
_MAX_DELAY_S = 0.1
_STEPS = 4
_DIFFERENCE_S = 1e-3
_REMOUNT = Advice("Compare the IMU's mounting ", ROBOT, "; then ", NextStep("calibrate misalignment"))
_REWIRE = Advice("Compare the IMUs' bus and address of each body ", ROBOT, "; then decode again")

Shifted = Callable[[float], FloatArray]


def gross_faults(residuals: WholeResidual) -> Iterator[Hypothesis]:
    """Yield all gross faults that can be tried on one drop."""
    data = residuals.data
    none = np.zeros((residuals.size, 0))
    put_right = chain(
        _exchanged_axes(data), _changed_misalignments(data), _wrong_orders(data), _exchanged_sensors(data)
    )
    for kind, sensor_residual, cause, next_step, sensor in put_right:
        left = residuals.with_sensors(sensor_residual)
        yield Hypothesis(kind, none, fixed_words(cause), next_step, left, sensor)
    for corrected_residual, cause, next_step in _other_low_passes(residuals):
        yield Hypothesis("low-pass", none, fixed_words(cause), next_step, corrected_residual)
    yield from _reversed_sensors(residuals)
    yield from _late_sensors(residuals)
    yield from _one_left_out(residuals)


Right = tuple[str, FloatArray, str, str, SensorColumn | None]
"""Kind, the sensors' residual with the fault put right, the cause in words, what to do, the sensor if it is one."""


def signed_exchanges() -> FloatArray:
    """(47, 3, 3) what shows instead of the truth: every exchange and reversal of axes but none at all."""
    # Six orders times eight signs, less the identity; half are reflections, which no mounting makes.
    orders, signs = permutations(range(3)), list(product((1.0, -1.0), repeat=3))
    matrices = np.array([np.diag(sign) @ np.eye(3)[list(order)] for order in orders for sign in signs])
    return np.asarray(matrices[(matrices != np.eye(3)).any(axis=(1, 2))])


def _in_words(exchange: FloatArray) -> str:
    """Format an exchange of axes, such as `x and y exchanged, z reversed`.

    `exchange` (3, 3) maps the true axes to the axes shown.
    """
    sources = np.abs(exchange).argmax(axis=1)
    minus = exchange[np.arange(3), sources] < 0.0
    moved = np.flatnonzero(sources != np.arange(3))
    # A cyclic exchange has no pair to name: list the axes one by one.
    if len(moved) == 3:
        return ", ".join(
            f"{'xyz'[axis]} shows {'-' if minus[axis] else ''}{'xyz'[sources[axis]]}" for axis in range(3)
        )
    parts = [f"{' and '.join('xyz'[axis] for axis in moved)} exchanged"] if len(moved) else []
    parts += (
        [f"{' and '.join('xyz'[axis] for axis in np.flatnonzero(minus))} reversed"] if minus.any() else []
    )
    return ", ".join(parts)


def _exchanged_axes(data: Consistency) -> Iterator[Right]:
    """Axes of a gyro exchanged in the data: its bias moves with them."""
    exchanges = signed_exchanges()
    for body in range(data.bodies):
        # What was shown is the exchange of the truth: its transpose undoes it.
        gyro, rest = (readings[..., body, :] @ exchanges for readings in (data.gyro_rad_s, data.rest_rad_s))
        yield from _reread(data, body, exchanges, gyro, rest)


def _changed_misalignments(data: Consistency) -> Iterator[Right]:
    """Yield gyros turned by a right angle since their calibration; the bias stays with the sensor."""
    exchanges = signed_exchanges()
    turns = exchanges[np.linalg.det(exchanges) > 0.0]
    for body, calibrated in enumerate(data.calibration.gyros):
        # Turn what the sensor felt, then let it show that with its own scale and bias.
        true = (data.gyro_rad_s[:, body] - calibrated.bias_rad_s) @ calibrated.inverse_response
        gyro = (true @ turns) @ calibrated.response + calibrated.bias_rad_s
        rest = np.broadcast_to(data.rest_rad_s[body], (len(turns), 3))
        yield from _reread(data, body, turns, gyro, rest)


def _reread(
    data: Consistency, body: int, exchanges: FloatArray, gyro: FloatArray, rest: FloatArray
) -> Iterator[Right]:
    # The residual is a sum over the gyros: replace the part of this one.
    others = data.residual - data.gyro_parts[body]
    for exchange, part in zip(exchanges, data.gyro_part(body, gyro, rest), strict=True):
        accused = gyro_column(body)
        yield "mounting", others + part, f"{accused.name}: {_in_words(exchange)}", _REMOUNT, accused


def _wrong_orders(data: Consistency) -> Iterator[Right]:
    """IMUs in another order."""
    gyro, rest = np.moveaxis(data.gyro_rad_s, 1, 0), data.rest_rad_s
    # [b][k]: what place k of the log adds as the gyro of body b.
    parts = [data.gyro_part(b, gyro, rest) for b in range(data.bodies)]
    # The angle sensors' part alone: it is the same in every order of the gyros.
    angles = data.residual - data.gyro_parts.sum(axis=0)
    for order in permutations(range(data.bodies)):
        moved = [b for b in range(data.bodies) if order[b] != b]
        if not moved:
            continue
        cause = f"IMUs of bodies {moved[0] + 1} and {moved[1] + 1} exchanged"
        if len(moved) > 2:
            stands = ", ".join(f"that of body {b + 1} in place {order[b] + 1}" for b in moved)
            cause = f"wrong order of the IMUs: {stands}"
        residual = angles + sum(parts[b][place] for b, place in enumerate(order))
        yield "order of the IMUs", residual, cause, _REWIRE, None


def _reversed_sensors(residuals: WholeResidual) -> Iterator[Hypothesis]:
    """Yield angle sensors that count backwards or were turned round on the shaft.

    Turning one round moves its zero point too.
    """
    data = residuals.data
    for joint, sensor in np.ndindex(data.joints, 2):
        cause = fixed_words(f"{sensor_name(joint, sensor)}: its direction is reversed")
        calibrate = NextStep("calibrate zero", ("--joint", str(joint + 1)))
        step = Advice("Compare its direction ", ROBOT, "; then ", calibrate)
        # Counting backwards negates the reading; turned round on its shaft a sensor negates the angle.
        in_counts = data.sensor_angles(joint, np.mod(-data.shown_rad, 2 * np.pi))[sensor]
        # Either moves the zero point: leave an offset free.
        offset = np.zeros((residuals.size, 1))
        offset[data.along(joint, sensor)] = _ANYWHERE_RAD
        for angle in (in_counts, -data.sensed_angles[joint][sensor]):
            corrected_residual = residuals.with_sensors(data.with_one(joint, sensor, angle))
            reversed_sensor = data.angle_sensor(joint, sensor)
            yield Hypothesis("reversed sensor", offset, cause, step, corrected_residual, reversed_sensor)


def _exchanged_sensors(data: Consistency) -> Iterator[Right]:
    """Angle sensors of different joints exchanged."""
    for first, second in combinations(np.ndindex(data.joints, 2), 2):
        if first[0] == second[0]:
            continue
        columns = [data.sensors(joint)[sensor] for joint, sensor in (first, second)]
        readings_rad = data.shown_rad.copy()
        readings_rad[:, columns] = readings_rad[:, columns[::-1]]
        sensed = list(data.sensed_angles)
        for joint, _ in (first, second):
            sensed[joint] = data.sensor_angles(joint, readings_rad)
        cause = f"{sensor_name(*first)} and {sensor_name(*second)} exchanged"
        step = Advice("Compare the cables of the angle sensors ", ROBOT)
        yield "exchanged sensors", data.residual_with_angles(sensed), cause, step, None


def _late_sensors(residuals: WholeResidual) -> Iterator[Hypothesis]:
    """Yield delays too large to linearize, of each sensor and of all gyros against all angle sensors."""
    data, by_delay = residuals.data, residuals.by_gyros.delay
    for body in range(data.bodies):
        gyro = gyro_column(body)
        fault = _late(residuals, gyro.name, _gyros_later(data, [body]), by_delay[:, [body]])
        yield fault._replace(sensor=gyro)
    slip, every = "clock slip: all gyros against the angle sensors", range(data.bodies)
    yield _late(residuals, slip, _gyros_later(data, every), by_delay.sum(axis=1, keepdims=True))
    for joint, sensor in np.ndindex(data.joints, 2):
        shifted = _sensor_later(data, joint, sensor)
        late_sensor = data.angle_sensor(joint, sensor)
        fault = _late(residuals, late_sensor.name, shifted, np.zeros((residuals.size, 1)))
        yield fault._replace(sensor=late_sensor)


def _gyros_later(data: Consistency, bodies: Sequence[int]) -> Shifted:
    others = data.residual - data.gyro_parts[list(bodies)].sum(axis=0)

    def vector(late_s: float) -> FloatArray:
        residual = others.copy()
        for body in bodies:
            # Undo the delay: what belongs to this time was shown later.
            columns = [np.interp(data.t_s + late_s, data.t_s, column) for column in data.rates[body].T]
            residual += data.rate_part(body, np.column_stack(columns), data.rotations)
            residual += data.rest_part(body, data.rest_rad_s[body])
        return np.asarray(residual)

    return vector


def _sensor_later(data: Consistency, joint: int, sensor: int) -> Shifted:
    angle = data.sensed_angles[joint][sensor]
    is_finite = np.isfinite(angle)

    def vector(late_s: float) -> FloatArray:
        shifted = np.full_like(angle, np.nan)
        if is_finite.any():
            shifted[is_finite] = np.interp(
                data.t_s[is_finite] + late_s, data.t_s[is_finite], angle[is_finite]
            )
        return data.with_one(joint, sensor, shifted)

    return vector


def _late(residuals: WholeResidual, name: str, shifted: Shifted, column: FloatArray) -> Hypothesis:
    """About the delay that fits the sensors best, by Gauss-Newton; `column` (size, 1) of a small one."""
    sensors, late_s, column = residuals.data.size, 0.0, column.copy()
    residual = shifted(late_s)
    for _ in range(_STEPS):
        # Slope by a finite delay; the whitened step is least squares in one unknown.
        slope = (shifted(late_s + _DIFFERENCE_S) - residual) / _DIFFERENCE_S
        column[:sensors, 0] = slope
        white, direction = (
            residuals.whiten(residuals.stack(vector)) for vector in (residual[:, None], slope[:, None])
        )
        length = float((direction**2).sum())
        if length == 0.0:
            break
        late_s = float(np.clip(late_s - (direction * white).sum() / length, -_MAX_DELAY_S, _MAX_DELAY_S))
        residual = shifted(late_s)
    # Carry the linearization back to zero delay, so that the number found is the whole delay.
    return late(name, column)._replace(left=residuals.with_sensors(residual - late_s * column[:sensors, 0]))


def _other_low_passes(residuals: WholeResidual) -> Iterator[tuple[FloatArray, str, str]]:
    """Another low-pass than the header's: the residual with it, the cause, what to do."""
    data = residuals.data
    angles = data.residual - data.gyro_parts.sum(axis=0)
    for setting in range(len(data.low_pass.parts[0].gyro_delay_us)):
        if setting == data.low_pass.dlpf_cfg:
            continue
        other = replace(data.low_pass, dlpf_cfg=setting)
        # Take the other setting's lag off the readings as they were shown.
        gyro, rest = sheet_lag(other).remove(data.t_s, data.lagging_rad_s), data.rest_rad_s
        corrected_residual = residuals.with_sensors(
            angles + sum(data.gyro_part(b, gyro[:, b], rest[b]) for b in range(data.bodies))
        )
        if residuals.model is not None:
            rates = [
                gyro_calibration.body_rates(gyro[:, b])
                for b, gyro_calibration in enumerate(data.calibration.gyros)
            ]
            # The model's rows follow the change of the rates to first order.
            rate_changes = np.stack(rates, axis=1) - np.stack(data.rates, axis=1)
            corrected_residual[data.size :] += residuals.model.by_gyros(rate_changes[None])[:, 0]
        cause = (
            f"the gyros lag by {1e3 * other.gyro_delay_s:.1f} ms as with DLPF_CFG {setting}, "
            f"but the header says DLPF_CFG {data.low_pass.dlpf_cfg}"
        )
        step = Advice("Set the low-pass and record again: ", NextStep("logger-settings"))
        yield corrected_residual, cause, step


def _one_left_out(residuals: WholeResidual) -> Iterator[Hypothesis]:
    """Yield faults of the last resort: one sensor is wrong in an unknown way, or the model is.

    All other sensors agree without that one.
    """
    data = residuals.data
    of_model = slice(data.size, residuals.size)
    for body in range(data.bodies):
        # Free every row that this gyro has a part in, and the model's.
        parts = [data.at_rest(body), of_model]
        for joint in range(data.joints):
            if body in data.pair(joint):
                parts += [data.off_axis(joint), data.along(joint, 0), data.along(joint, 1)]
        gyro = gyro_column(body)
        cause = _lies_with(data.t_s, gyro.name, data.lagging_rad_s[:, body])
        # Any errors of those rows, or any rate of the gyro that changes from block to block only.
        for columns in (_anyhow(residuals, parts), by_blocks(residuals, body)):
            yield Hypothesis("one sensor", columns, fixed_words(cause), LOOK, sensor=gyro)
    for joint, sensor in np.ndindex(data.joints, 2):
        # The joint's geometry rests on its other sensor then; the rows of this one are free.
        sensor_residual = data.with_one(joint, sensor, np.full(len(data.t_s), np.nan))
        readings_rad = data.shown_rad[:, data.sensors(joint)[sensor], None]
        angle_sensor = data.angle_sensor(joint, sensor)
        words = fixed_words(_lies_with(data.t_s, angle_sensor.name, readings_rad))
        columns, left = (
            _anyhow(residuals, [data.along(joint, sensor)]),
            residuals.with_sensors(sensor_residual),
        )
        yield Hypothesis("one sensor", columns, words, LOOK, left, angle_sensor)
    if residuals.model is not None:
        bounded = ", ".join(residuals.model.fit.bounded)
        cause = "unknown; it lies with the robot file, all sensors agree"
        if bounded:
            cause = f"the robot file: {bounded} would have to be off by more than its bound"
        yield Hypothesis(
            "robot file",
            _anyhow(residuals, [of_model]),
            fixed_words(cause),
            Advice("Weigh the bodies, compare ", ROBOT),
        )


def _anyhow(residuals: WholeResidual, parts: Sequence[slice]) -> FloatArray:
    """(size, k) any errors of the k rows in these parts."""
    return np.asarray(_ANYHOW * np.eye(residuals.size)[:, np.r_[*parts]])


def _lies_with(t_s: FloatArray, name: str, readings: FloatArray) -> str:
    stuck_s = _stuck_from_s(t_s, readings)
    if stuck_s is not None:
        return f"{name} repeats one reading from {stuck_s:.2f} s on"
    return f"unknown; it lies with the {name}, all the others agree without it"


def _stuck_from_s(t_s: FloatArray, readings: FloatArray) -> float | None:
    """Find when the longest run of equal readings (n, k) begins; None if it is too short to be a fault."""
    changed = np.flatnonzero((np.diff(readings, axis=0) != 0.0).any(axis=1))
    # Runs of equal readings lie between changes; the ends of the record close the outer ones.
    edges = np.concatenate([[-1], changed, [len(t_s) - 1]])
    longest = int(np.diff(edges).argmax())
    first, last = edges[longest] + 1, edges[longest + 1]
    return float(t_s[first]) if t_s[last] - t_s[first] > STUCK_S else None
