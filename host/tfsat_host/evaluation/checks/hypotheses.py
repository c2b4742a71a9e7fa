"""What may be wrong with a sensor, and how the consistency vector would look if that were put right."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import combinations, permutations, product

import numpy as np

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.evaluation.checks.consistency import Consistency
from tfsat_host.evaluation.checks.stated_errors import StatedErrors
from tfsat_host.evaluation.motion.gyro_signal import sheet_lag


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One thing that may be wrong, put right.

    Attributes:
        family: What it is, and of which sensor: two of one family are the same cause to a person.
        left: (size,) the vector then.
        free: (size, q) what q unknown numbers add to it.
        said: The cause in words, by those numbers (q,) as they fit best.
        next_step: What to do about it.
    """

    family: tuple[str, ...]
    left: FloatArray
    free: FloatArray
    said: Callable[[FloatArray], str]
    next_step: str


def fixed(family: tuple[str, ...], left: FloatArray, cause: str, next_step: str) -> Hypothesis:
    """One without unknown numbers."""
    return Hypothesis(family, left, np.zeros((len(left), 0)), lambda _: cause, next_step)


def signed_exchanges() -> FloatArray:
    """(47, 3, 3) what shows instead of the truth: every exchange and reversal of axes but none at all."""
    found = [
        np.diag(signs) @ np.eye(3)[list(order)]
        for order in permutations(range(3))
        for signs in product((1.0, -1.0), repeat=3)
    ]
    return np.array([one for one in found if not np.array_equal(one, np.eye(3))])


def right_angled_turns() -> FloatArray:
    """(23, 3, 3) those that a sensor can be mounted by: without a mirror."""
    every = signed_exchanges()
    return np.asarray(every[np.linalg.det(every) > 0.0])


def in_words(exchange: FloatArray) -> str:
    """Such as `x and y exchanged, z reversed`; `exchange` (3, 3) makes what is shown of what is true."""
    sources = np.abs(exchange).argmax(axis=1)
    signs = exchange[np.arange(3), sources]
    moved = [axis for axis in range(3) if sources[axis] != axis]
    parts = []
    if len(moved) == 3:
        parts.append(
            ", ".join(
                f"{'xyz'[axis]} shows {'-' if signs[axis] < 0 else ''}{'xyz'[sources[axis]]}"
                for axis in range(3)
            )
        )
        return parts[0]
    if moved:
        parts.append(f"{'xyz'[moved[0]]} and {'xyz'[moved[1]]} exchanged")
    reversed_axes = ["xyz"[axis] for axis in range(3) if signs[axis] < 0]
    if reversed_axes:
        parts.append(f"{' and '.join(reversed_axes)} reversed")
    return ", ".join(parts)


def sensor_name(joint: int, sensor: int) -> str:
    """For people; both are indices."""
    return f"angle sensor {sensor + 1} of joint {joint + 1}"


def own_offset(of: Consistency, joint: int, sensor: int) -> FloatArray:
    """(size, 1) what a wrong zero point of one sensor adds."""
    column = np.zeros((of.size, 1))
    column[of.along(joint, sensor)] = 1.0
    return column


def with_one(of: Consistency, joint: int, sensor: int, angle_rad: FloatArray) -> FloatArray:
    """(size,) the vector, were that (n,) what one sensor says of its joint's angle."""
    sensed = list(of.own_sensed)
    sensed[joint] = sensed[joint].copy()
    sensed[joint][sensor] = angle_rad
    return of.with_sensed(sensed)


def reversed_sensors(of: Consistency) -> Iterator[Hypothesis]:
    """Each sensor reversed, in its counts or on its shaft."""
    for joint, sensor in np.ndindex(of.joints, 2):

        def reversed_(_: FloatArray, joint: int = joint, sensor: int = sensor) -> str:
            return f"{sensor_name(joint, sensor)}: its direction is reversed"

        again = f"tfsat-host calibrate zero --joint {joint + 1}"
        step = f"Compare its direction with the robot file: tfsat-host robot; then {again}"
        in_counts = of.sensed(joint, np.mod(-of.readings.shown_rad, 2 * np.pi))[sensor]
        for angle in (in_counts, -of.own_sensed[joint][sensor]):
            # A sensor that was turned round has another zero point, too.
            yield Hypothesis(
                ("reversed", str(joint), str(sensor)),
                with_one(of, joint, sensor, angle),
                own_offset(of, joint, sensor),
                reversed_,
                step,
            )


def moved_zeros(of: Consistency) -> Iterator[Hypothesis]:
    """Of each joint: which of its two sensors has moved the other one cannot tell."""
    for joint in range(of.joints):

        def moved(numbers: FloatArray, joint: int = joint) -> str:
            return (
                f"angle sensors of joint {joint + 1}: stale calibration, the zero point of one has moved "
                f"by {abs(np.rad2deg(numbers[0])):.2f} deg against the other's"
            )

        step = f"tfsat-host calibrate zero --joint {joint + 1}"
        yield Hypothesis(("zero", str(joint)), of.own_vector, own_offset(of, joint, 0), moved, step)


def exchanged_sensors(of: Consistency) -> Iterator[Hypothesis]:
    """Every two of different joints; those of one joint tell the same."""
    places = [(joint, sensor) for joint in range(of.joints) for sensor in range(2)]
    for first, second in combinations(places, 2):
        if first[0] == second[0]:
            continue
        columns = [of.sensors(joint)[sensor] for joint, sensor in (first, second)]
        shown = of.readings.shown_rad.copy()
        shown[:, columns] = shown[:, columns[::-1]]
        sensed = list(of.own_sensed)
        for joint, _ in (first, second):
            sensed[joint] = of.sensed(joint, shown)
        yield fixed(
            ("sensors", *map(str, columns)),
            of.with_sensed(sensed),
            f"{sensor_name(*first)} and {sensor_name(*second)} exchanged",
            "Compare the cables of the angle sensors with the robot file: tfsat-host robot",
        )


REWIRE = (
    "Compare the IMUs' bus and address of each body with the robot file: tfsat-host robot; then decode again"
)
REMOUNT = (
    "Compare the IMU's mounting with the robot file: tfsat-host robot; then tfsat-host calibrate misalignment"
)


def exchanged_axes(of: Consistency) -> Iterator[Hypothesis]:
    """Of each gyro, in the data: its bias moves with the axes."""
    shown_for = signed_exchanges()
    for body in range(4):
        # What was shown is the exchange of the truth: its transpose undoes it.
        gyro = of.readings.gyro_rad_s[:, body] @ shown_for
        rest = of.readings.rest_rad_s[body] @ shown_for
        yield from _named(of, body, shown_for, gyro, rest)


def turned_mountings(of: Consistency) -> Iterator[Hypothesis]:
    """Of each gyro, by a right angle since it was calibrated: its bias stays with the sensor."""
    turns = right_angled_turns()
    for body, calibrated in enumerate(of.calibration.gyros):
        true = (of.readings.gyro_rad_s[:, body] - calibrated.bias_rad_s) / calibrated.scale
        gyro = (true @ turns) * calibrated.scale + calibrated.bias_rad_s
        rest = np.broadcast_to(of.readings.rest_rad_s[body], (len(turns), 3))
        yield from _named(of, body, turns, gyro, rest)


def _named(
    of: Consistency, body: int, exchanges: FloatArray, gyro: FloatArray, rest: FloatArray
) -> Iterator[Hypothesis]:
    others = of.own_vector - of.own_parts[body]
    for one, part in zip(exchanges, of.of_readings(body, gyro, rest), strict=True):
        cause = f"gyro of body {body + 1}: {in_words(one)}"
        yield fixed(("frame", cause), others + part, cause, REMOUNT)


def wrong_orders(of: Consistency) -> Iterator[Hypothesis]:
    """Every order of the four IMUs but the right one."""
    gyro, rest = np.moveaxis(of.readings.gyro_rad_s, 1, 0), of.readings.rest_rad_s
    # What place k of the log adds if it is body b's.
    parts = [of.of_readings(b, gyro, rest) for b in range(4)]
    angles = of.own_vector - of.own_parts.sum(axis=0)
    for order in permutations(range(4)):
        moved = [b for b in range(4) if order[b] != b]
        if not moved:
            continue
        cause = f"IMUs of bodies {moved[0] + 1} and {moved[1] + 1} exchanged"
        if len(moved) > 2:
            stands = ", ".join(f"that of body {b + 1} in place {order[b] + 1}" for b in moved)
            cause = f"wrong order of the IMUs: {stands}"
        left = angles + sum(parts[b][order[b]] for b in range(4))
        yield fixed(("order", *map(str, order)), left, cause, REWIRE)


_LOOK = "Look at its samples: tfsat-host decode; leave the sensor out or repair it before the next drop"
STUCK_S = 0.15
"""No sensor with noise repeats one reading for so long."""


def one_left_out(of: Consistency) -> Iterator[Hypothesis]:
    """Each gyro, and each angle sensor."""
    for body in range(4):
        rows = np.zeros(of.size, dtype=bool)
        rows[of.at_rest(body)] = True
        for joint in range(of.joints):
            if body in (int(of.model.joint_inner[joint]), int(of.model.joint_outer[joint])):
                rows[of.off_axis(joint)] = True
                rows[of.along(joint, 0)] = rows[of.along(joint, 1)] = True
        name = f"gyro of body {body + 1}"
        stuck = _stuck_from_s(of.t_s, of.late_rad_s[:, body])
        yield _without(("gyro", str(body)), name, of.own_vector, rows, stuck)
    for joint, sensor in np.ndindex(of.joints, 2):
        shown = of.readings.shown_rad[:, of.sensors(joint)[sensor], None]
        rows = np.zeros(of.size, dtype=bool)
        rows[of.along(joint, sensor)] = True
        left = with_one(of, joint, sensor, np.full(len(of.t_s), np.nan))
        stuck = _stuck_from_s(of.t_s, shown)
        yield _without(("angle", str(joint), str(sensor)), sensor_name(joint, sensor), left, rows, stuck)


def _stuck_from_s(t_s: FloatArray, readings: FloatArray) -> float | None:
    """When the longest row of equal readings (n, k) begins, if it is long enough to be a fault."""
    changed = np.flatnonzero((np.diff(readings, axis=0) != 0.0).any(axis=1))
    edges = np.concatenate([[-1], changed, [len(t_s) - 1]])
    longest = int(np.diff(edges).argmax())
    first, last = edges[longest] + 1, edges[longest + 1]
    return float(t_s[first]) if t_s[last] - t_s[first] > STUCK_S else None


def _without(
    family: tuple[str, ...], name: str, left: FloatArray, rows: BoolArray, stuck_s: float | None
) -> Hypothesis:
    cause = f"unknown; it lies with the {name}, all the others agree without it"
    if stuck_s is not None:
        cause = f"{name} repeats one reading from {stuck_s:.2f} s on"
    return Hypothesis(family, left, np.eye(len(rows))[:, rows], lambda _: cause, _LOOK)


Shifted = Callable[[float], FloatArray]

_MOST_S = 0.1
_STEPS = 4
_DIFFERENCE_S = 1e-3
_CLOCK = "Look at the late samples: tfsat-host decode; check the logger: tfsat-host status"


def late_sensors(of: Consistency, stated: StatedErrors) -> Iterator[Hypothesis]:
    """One after the other, and all gyros against all angle sensors."""
    for body in range(4):
        yield _late(("late gyro", str(body)), f"gyro of body {body + 1}", stated, _gyro(of, [body]))
    yield _late(
        ("late gyros",), "clock slip: all gyros against the angle sensors", stated, _gyro(of, range(4))
    )
    for joint, sensor in np.ndindex(of.joints, 2):
        shifted = _sensor(of, joint, sensor)
        yield _late(("late sensor", str(joint), str(sensor)), sensor_name(joint, sensor), stated, shifted)


def other_low_passes(of: Consistency) -> Iterator[Hypothesis]:
    """Every setting but the header's."""
    angles = of.own_vector - of.own_parts.sum(axis=0)
    for setting in range(len(of.low_pass.parts[0].gyro_delay_us)):
        if setting == of.low_pass.dlpf_cfg:
            continue
        other = replace(of.low_pass, dlpf_cfg=setting)
        gyro = sheet_lag(other).removed(of.t_s, of.late_rad_s)
        yield fixed(
            ("low-pass", str(setting)),
            angles + sum(of.of_readings(b, gyro[:, b], of.readings.rest_rad_s[b]) for b in range(4)),
            f"the gyros lag by {1e3 * other.gyro_delay_s:.1f} ms as with DLPF_CFG {setting}, "
            f"but the header says DLPF_CFG {of.low_pass.dlpf_cfg}",
            "Set the low-pass and record again: tfsat-host logger-settings",
        )


def _gyro(of: Consistency, bodies: list[int] | range) -> Shifted:
    others = of.own_vector - of.own_parts[list(bodies)].sum(axis=0)

    def vector(late_s: float) -> FloatArray:
        left = others.copy()
        for body in bodies:
            at_rest = of.of_rest(body, of.readings.rest_rad_s[body])
            left += of.of_body(body, _earlier(of.t_s, of.own_rates[body], late_s), of.own_turns) + at_rest
        return np.asarray(left)

    return vector


def _sensor(of: Consistency, joint: int, sensor: int) -> Shifted:
    angle = of.own_sensed[joint][sensor]
    known = np.isfinite(angle)

    def vector(late_s: float) -> FloatArray:
        shifted = np.full_like(angle, np.nan)
        if known.any():
            shifted[known] = np.interp(of.t_s[known] + late_s, of.t_s[known], angle[known])
        return with_one(of, joint, sensor, shifted)

    return vector


def _earlier(t_s: FloatArray, values: FloatArray, late_s: float) -> FloatArray:
    """(n, k) what was shown `late_s` too late."""
    return np.column_stack([np.interp(t_s + late_s, t_s, column) for column in values.T])


def _late(family: tuple[str, ...], name: str, stated: StatedErrors, shifted: Shifted) -> Hypothesis:
    """With the delay that fits best, by Gauss and Newton."""
    late_s = 0.0
    left = shifted(late_s)
    slope = (shifted(_DIFFERENCE_S) - left) / _DIFFERENCE_S
    for _ in range(_STEPS):
        white, direction = stated.whitened(left), stated.whitened(slope)
        length = float(direction @ direction)
        if length == 0.0:
            break
        late_s = float(np.clip(late_s - direction @ white / length, -_MOST_S, _MOST_S))
        left = shifted(late_s)
        slope = (shifted(late_s + _DIFFERENCE_S) - left) / _DIFFERENCE_S

    def said(numbers: FloatArray) -> str:
        ms = 1e3 * (late_s + float(numbers[0]))
        return f"{name} late by {ms:.1f} ms" if ms > 0.0 else f"{name} early by {-ms:.1f} ms"

    return Hypothesis(family, left, slope[:, None], said, _CLOCK)


def changed_gyros(of: Consistency, stated: StatedErrors) -> Iterator[Hypothesis]:
    """Three numbers each."""
    for body in range(4):
        gyro = f"gyro of body {body + 1}"
        taken = of.calibration.gyros[body].bias_taken
        since = f" since {taken:%Y-%m-%d %H:%M} UTC" if taken else ""

        def biased(numbers: FloatArray, gyro: str = gyro, since: str = since) -> str:
            return f"{gyro}: stale calibration, its bias has changed by {_listed(np.rad2deg(numbers))} deg/s{since}"

        def jumped(numbers: FloatArray, gyro: str = gyro) -> str:
            return f"{gyro}: its bias jumped by {_listed(np.rad2deg(numbers))} deg/s at the release"

        def scaled(numbers: FloatArray, gyro: str = gyro) -> str:
            # The columns were taken at the rates as shown, which are too large by the very factor.
            percent = _listed(100.0 * numbers / (1.0 - numbers))
            return f"{gyro}: its scale factor is {percent} % beside the calibrated one"

        def turned(numbers: FloatArray, gyro: str = gyro) -> str:
            angle = np.rad2deg(np.linalg.norm(numbers))
            return f"{gyro}: stale calibration, its mounting has turned by {angle:.2f} deg"

        columns = stated.by_gyros[:, body]
        number = str(body)
        left = of.own_vector
        yield Hypothesis(("bias", number), left, columns[:, :3], biased, "tfsat-host calibrate bias")
        in_fall = columns[:, :3].copy()
        in_fall[of.at_rest(body)] = 0.0
        yield Hypothesis(
            ("jump", number), left, in_fall, jumped, "Leave this gyro out: it did not bear the release"
        )
        yield Hypothesis(
            ("mounting", number), left, columns[:, 3:6], turned, "tfsat-host calibrate misalignment"
        )
        again = "tfsat-host calibrate scale"
        yield Hypothesis(("scale", number), left, columns[:, 6:], scaled, again)
        # Where the reading as a whole is scaled, as by a wrong range, its bias is too.
        calibrated = of.calibration.gyros[body]
        whole = columns[:, 6:] + columns[:, :3] * (calibrated.bias_rad_s / calibrated.scale)
        yield Hypothesis(("scale", number), left, whole, scaled, again)


def _listed(numbers: FloatArray) -> str:
    # Adding zero takes the sign off a zero.
    return "/".join(f"{round(float(number), 2) + 0.0:+.2f}" for number in numbers) + " (x/y/z)"
