"""What may be wrong with a sensor: the residual of a drop with that fault put right."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations, permutations, product
from typing import NamedTuple

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.checks.consistency import Consistency, sensor_name
from tfsat_host.evaluation.checks.stated_errors import StatedErrors
from tfsat_host.evaluation.motion.gyro_signal import sheet_lag

STUCK_S = 0.15
"""No sensor with noise repeats one reading for so long."""
_MOST_LATE_S = 0.1
_STEPS = 4
_DIFFERENCE_S = 1e-3
_ROBOT = "with the robot file: tfsat-host robot"
_REMOUNT = f"Compare the IMU's mounting {_ROBOT}; then tfsat-host calibrate misalignment"
_REWIRE = f"Compare the IMUs' bus and address of each body {_ROBOT}; then decode again"
_CLOCK = "Look at the late samples: tfsat-host decode; check the logger: tfsat-host status"
_LOOK = "Look at its samples: tfsat-host decode; leave the sensor out or repair it before the next drop"

Cause = Callable[[FloatArray], str]
Shifted = Callable[[float], FloatArray]


class Hypothesis(NamedTuple):
    """One fault, put right.

    Attributes:
        family: Kind of fault and sensor: two of one family are the same cause to a reader.
        residual: (size,) without the fault.
        jacobian: (size, q) of it by the fault's q unknown numbers.
        cause: In words, by those numbers (q,) at their best fit.
        next_step: What to do about it.
    """

    family: tuple[str, ...]
    residual: FloatArray
    jacobian: FloatArray
    cause: Cause
    next_step: str


def hypotheses(data: Consistency, stated: StatedErrors) -> Iterator[Hypothesis]:
    """All that can be tried on one drop."""
    yield from _exchanged_axes(data)
    yield from _turned_mountings(data)
    yield from _wrong_orders(data)
    yield from _changed_gyros(data, stated)
    yield from _reversed_sensors(data)
    yield from _moved_zeros(data)
    yield from _exchanged_sensors(data)
    yield from _late_sensors(data, stated)
    yield from _other_low_passes(data)
    yield from _one_left_out(data)


def _fixed(family: tuple[str, ...], left: FloatArray, cause: str, next_step: str) -> Hypothesis:
    """One without unknown numbers."""
    return Hypothesis(family, left, np.zeros((len(left), 0)), lambda _: cause, next_step)


def _filled(template: str, shown: Callable[[FloatArray], object]) -> Cause:
    return lambda numbers: template.format(shown(numbers))


def signed_exchanges() -> FloatArray:
    """(47, 3, 3) what shows instead of the truth: every exchange and reversal of axes but none at all."""
    orders, signs = permutations(range(3)), list(product((1.0, -1.0), repeat=3))
    found = np.array([np.diag(sign) @ np.eye(3)[list(order)] for order in orders for sign in signs])
    return np.asarray(found[(found != np.eye(3)).any(axis=(1, 2))])


def _in_words(exchange: FloatArray) -> str:
    """Such as `x and y exchanged, z reversed`; `exchange` (3, 3) makes what is shown of what is true."""
    sources = np.abs(exchange).argmax(axis=1)
    minus = exchange[np.arange(3), sources] < 0.0
    moved = np.flatnonzero(sources != np.arange(3))
    if len(moved) == 3:
        return ", ".join(
            f"{'xyz'[axis]} shows {'-' if minus[axis] else ''}{'xyz'[sources[axis]]}" for axis in range(3)
        )
    parts = [f"{' and '.join('xyz'[axis] for axis in moved)} exchanged"] if len(moved) else []
    parts += (
        [f"{' and '.join('xyz'[axis] for axis in np.flatnonzero(minus))} reversed"] if minus.any() else []
    )
    return ", ".join(parts)


def _exchanged_axes(data: Consistency) -> Iterator[Hypothesis]:
    """Axes of a gyro exchanged in the data: its bias moves with them."""
    exchanges = signed_exchanges()
    for body in range(data.bodies):
        # What was shown is the exchange of the truth: its transpose undoes it.
        gyro, rest = (readings[..., body, :] @ exchanges for readings in (data.gyro_rad_s, data.rest_rad_s))
        yield from _reread(data, body, exchanges, gyro, rest)


def _turned_mountings(data: Consistency) -> Iterator[Hypothesis]:
    """A gyro turned by a right angle since its calibration: its bias stays with the sensor."""
    exchanges = signed_exchanges()
    turns = exchanges[np.linalg.det(exchanges) > 0.0]
    for body, calibrated in enumerate(data.calibration.gyros):
        true = (data.gyro_rad_s[:, body] - calibrated.bias_rad_s) / calibrated.scale
        gyro = (true @ turns) * calibrated.scale + calibrated.bias_rad_s
        rest = np.broadcast_to(data.rest_rad_s[body], (len(turns), 3))
        yield from _reread(data, body, turns, gyro, rest)


def _reread(
    data: Consistency, body: int, exchanges: FloatArray, gyro: FloatArray, rest: FloatArray
) -> Iterator[Hypothesis]:
    others = data.residual - data.gyro_parts[body]
    for one, part in zip(exchanges, data.gyro_part(body, gyro, rest), strict=True):
        cause = f"gyro of body {body + 1}: {_in_words(one)}"
        yield _fixed(("frame", cause), others + part, cause, _REMOUNT)


def _wrong_orders(data: Consistency) -> Iterator[Hypothesis]:
    """IMUs in another order."""
    gyro, rest = np.moveaxis(data.gyro_rad_s, 1, 0), data.rest_rad_s
    # [b][k]: what place k of the log adds as the gyro of body b.
    parts = [data.gyro_part(b, gyro, rest) for b in range(data.bodies)]
    angles = data.residual - data.gyro_parts.sum(axis=0)
    for order in permutations(range(data.bodies)):
        moved = [b for b in range(data.bodies) if order[b] != b]
        if not moved:
            continue
        cause = f"IMUs of bodies {moved[0] + 1} and {moved[1] + 1} exchanged"
        if len(moved) > 2:
            stands = ", ".join(f"that of body {b + 1} in place {order[b] + 1}" for b in moved)
            cause = f"wrong order of the IMUs: {stands}"
        left = angles + sum(parts[b][place] for b, place in enumerate(order))
        yield _fixed(("order", *map(str, order)), left, cause, _REWIRE)


def _changed_gyros(data: Consistency, stated: StatedErrors) -> Iterator[Hypothesis]:
    """Another bias, a jump of it at the release, another mounting or scale: three numbers each."""
    for body, calibrated in enumerate(data.calibration.gyros):
        taken, columns = calibrated.bias_taken, stated.gyro_jacobian[:, body]
        gyro, since = f"gyro of body {body + 1}:", f" since {taken:%Y-%m-%d %H:%M} UTC" if taken else ""
        in_fall = columns[:, :3].copy()
        in_fall[data.at_rest(body)] = 0.0
        # A wrong range scales the whole reading, its bias too.
        whole = columns[:, 6:] + columns[:, :3] * (calibrated.bias_rad_s / calibrated.scale)
        # The Jacobian is taken at the rates as shown, which are off by the same factor.
        scaled = _filled(
            f"{gyro} its scale factor is {{}} % off the calibrated one",
            lambda numbers: _listed(100.0 * numbers / (1.0 - numbers)),
        )
        for kind, free, cause, step in (
            (
                "bias",
                columns[:, :3],
                _filled(f"{gyro} stale calibration, its bias has changed by {{}} deg/s{since}", _listed_deg),
                "tfsat-host calibrate bias",
            ),
            (
                "jump",
                in_fall,
                _filled(f"{gyro} its bias jumped by {{}} deg/s at the release", _listed_deg),
                "Leave this gyro out: it did not bear the release",
            ),
            (
                "mounting",
                columns[:, 3:6],
                _filled(
                    f"{gyro} stale calibration, its mounting has turned by {{:.2f}} deg",
                    lambda numbers: np.rad2deg(np.linalg.norm(numbers)),
                ),
                "tfsat-host calibrate misalignment",
            ),
            ("scale", columns[:, 6:], scaled, "tfsat-host calibrate scale"),
            ("scale", whole, scaled, "tfsat-host calibrate scale"),
        ):
            yield Hypothesis((kind, str(body)), data.residual, free, cause, step)


def _listed(numbers: FloatArray) -> str:
    # Adding zero takes the sign off a zero.
    return "/".join(f"{round(float(number), 2) + 0.0:+.2f}" for number in numbers) + " (x/y/z)"


def _listed_deg(numbers: FloatArray) -> str:
    return _listed(np.rad2deg(numbers))


def _offset(data: Consistency, joint: int, sensor: int) -> FloatArray:
    """(size, 1) the residual by the zero point of one sensor."""
    column = np.zeros((data.size, 1))
    column[data.along(joint, sensor)] = 1.0
    return column


def _with_one(data: Consistency, joint: int, sensor: int, angle_rad: FloatArray) -> FloatArray:
    """(size,) the residual if one sensor showed the joint angle (n,)."""
    sensed = list(data.sensed_angles)
    sensed[joint] = sensed[joint].copy()
    sensed[joint][sensor] = angle_rad
    return data.residual_with_angles(sensed)


def _reversed_sensors(data: Consistency) -> Iterator[Hypothesis]:
    """A sensor that counts backwards, or was turned round on its shaft, which moves its zero point too."""
    for joint, sensor in np.ndindex(data.joints, 2):
        cause = _filled(f"{sensor_name(joint, sensor)}: its direction is reversed", str)
        step = f"Compare its direction {_ROBOT}; then tfsat-host calibrate zero --joint {joint + 1}"
        in_counts = data.sensed(joint, np.mod(-data.shown_rad, 2 * np.pi))[sensor]
        for angle in (in_counts, -data.sensed_angles[joint][sensor]):
            left = _with_one(data, joint, sensor, angle)
            family = ("reversed", str(joint), str(sensor))
            yield Hypothesis(family, left, _offset(data, joint, sensor), cause, step)


def _moved_zeros(data: Consistency) -> Iterator[Hypothesis]:
    """A zero point moved; which of a joint's two sensors it is, is not observable."""
    for joint in range(data.joints):
        cause = _filled(
            f"angle sensors of joint {joint + 1}: stale calibration, the zero point of one has moved by {{:.2f}} deg "
            "against the other's",
            lambda numbers: abs(np.rad2deg(numbers[0])),
        )
        step = f"tfsat-host calibrate zero --joint {joint + 1}"
        yield Hypothesis(("zero", str(joint)), data.residual, _offset(data, joint, 0), cause, step)


def _exchanged_sensors(data: Consistency) -> Iterator[Hypothesis]:
    """Angle sensors of different joints exchanged."""
    for first, second in combinations(np.ndindex(data.joints, 2), 2):
        if first[0] == second[0]:
            continue
        columns = [data.sensors(joint)[sensor] for joint, sensor in (first, second)]
        shown = data.shown_rad.copy()
        shown[:, columns] = shown[:, columns[::-1]]
        sensed = list(data.sensed_angles)
        for joint, _ in (first, second):
            sensed[joint] = data.sensed(joint, shown)
        yield _fixed(
            ("sensors", *map(str, columns)),
            data.residual_with_angles(sensed),
            f"{sensor_name(*first)} and {sensor_name(*second)} exchanged",
            f"Compare the cables of the angle sensors {_ROBOT}",
        )


def _late_sensors(data: Consistency, stated: StatedErrors) -> Iterator[Hypothesis]:
    """Each sensor delayed, and all gyros against all angle sensors."""
    for body in range(data.bodies):
        yield _late(("late gyro", str(body)), f"gyro of body {body + 1}", stated, _gyros_later(data, [body]))
    slip, every = "clock slip: all gyros against the angle sensors", range(data.bodies)
    yield _late(("late gyros",), slip, stated, _gyros_later(data, every))
    for joint, sensor in np.ndindex(data.joints, 2):
        family = ("late sensor", str(joint), str(sensor))
        yield _late(family, sensor_name(joint, sensor), stated, _sensor_later(data, joint, sensor))


def _gyros_later(data: Consistency, bodies: Sequence[int]) -> Shifted:
    others = data.residual - data.gyro_parts[list(bodies)].sum(axis=0)

    def vector(late_s: float) -> FloatArray:
        left = others.copy()
        for body in bodies:
            columns = [np.interp(data.t_s + late_s, data.t_s, column) for column in data.rates[body].T]
            left += data.rate_part(body, np.column_stack(columns), data.rotations)
            left += data.rest_part(body, data.rest_rad_s[body])
        return np.asarray(left)

    return vector


def _sensor_later(data: Consistency, joint: int, sensor: int) -> Shifted:
    angle = data.sensed_angles[joint][sensor]
    known = np.isfinite(angle)

    def vector(late_s: float) -> FloatArray:
        shifted = np.full_like(angle, np.nan)
        if known.any():
            shifted[known] = np.interp(data.t_s[known] + late_s, data.t_s[known], angle[known])
        return _with_one(data, joint, sensor, shifted)

    return vector


def _late(family: tuple[str, ...], name: str, stated: StatedErrors, shifted: Shifted) -> Hypothesis:
    """With the delay that fits best, by Gauss-Newton."""

    def at(late_s: float) -> tuple[FloatArray, FloatArray]:
        left = shifted(late_s)
        return left, (shifted(late_s + _DIFFERENCE_S) - left) / _DIFFERENCE_S

    late_s = 0.0
    left, slope = at(late_s)
    for _ in range(_STEPS):
        white, direction = stated.whitened(left), stated.whitened(slope)
        length = float(direction @ direction)
        if length == 0.0:
            break
        late_s = float(np.clip(late_s - direction @ white / length, -_MOST_LATE_S, _MOST_LATE_S))
        left, slope = at(late_s)

    def cause(numbers: FloatArray) -> str:
        ms = 1e3 * (late_s + float(numbers[0]))
        return f"{name} {'late' if ms > 0.0 else 'early'} by {abs(ms):.1f} ms"

    return Hypothesis(family, left, slope[:, None], cause, _CLOCK)


def _other_low_passes(data: Consistency) -> Iterator[Hypothesis]:
    """Another low-pass than the header's."""
    angles = data.residual - data.gyro_parts.sum(axis=0)
    for setting in range(len(data.low_pass.parts[0].gyro_delay_us)):
        if setting == data.low_pass.dlpf_cfg:
            continue
        other = replace(data.low_pass, dlpf_cfg=setting)
        gyro, rest = sheet_lag(other).removed(data.t_s, data.lagging_rad_s), data.rest_rad_s
        yield _fixed(
            ("low-pass", str(setting)),
            angles + sum(data.gyro_part(b, gyro[:, b], rest[b]) for b in range(data.bodies)),
            f"the gyros lag by {1e3 * other.gyro_delay_s:.1f} ms as with DLPF_CFG {setting}, "
            f"but the header says DLPF_CFG {data.low_pass.dlpf_cfg}",
            "Set the low-pass and record again: tfsat-host logger-settings",
        )


def _one_left_out(data: Consistency) -> Iterator[Hypothesis]:
    """The last resort: one sensor is wrong in an unknown way, and all the others agree without it."""
    for body in range(data.bodies):
        parts = [data.at_rest(body)]
        for joint in range(data.joints):
            if body in data.pair(joint):
                parts += [data.off_axis(joint), data.along(joint, 0), data.along(joint, 1)]
        readings = data.lagging_rad_s[:, body]
        yield _without(data, ("gyro", str(body)), f"gyro of body {body + 1}", data.residual, parts, readings)
    for joint, sensor in np.ndindex(data.joints, 2):
        family, name = ("angle", str(joint), str(sensor)), sensor_name(joint, sensor)
        left = _with_one(data, joint, sensor, np.full(len(data.t_s), np.nan))
        shown = data.shown_rad[:, data.sensors(joint)[sensor], None]
        yield _without(data, family, name, left, [data.along(joint, sensor)], shown)


def _without(
    data: Consistency,
    family: tuple[str, ...],
    name: str,
    left: FloatArray,
    parts: Sequence[slice],
    readings: FloatArray,
) -> Hypothesis:
    stuck_s = _stuck_from_s(data.t_s, readings)
    cause = f"unknown; it lies with the {name}, all the others agree without it"
    if stuck_s is not None:
        cause = f"{name} repeats one reading from {stuck_s:.2f} s on"
    return Hypothesis(family, left, np.eye(data.size)[:, data.rows(*parts)], lambda _: cause, _LOOK)


def _stuck_from_s(t_s: FloatArray, readings: FloatArray) -> float | None:
    """When the longest run of equal readings (n, k) begins, if it is long enough to be a fault."""
    changed = np.flatnonzero((np.diff(readings, axis=0) != 0.0).any(axis=1))
    edges = np.concatenate([[-1], changed, [len(t_s) - 1]])
    longest = int(np.diff(edges).argmax())
    first, last = edges[longest] + 1, edges[longest + 1]
    return float(t_s[first]) if t_s[last] - t_s[first] > STUCK_S else None
