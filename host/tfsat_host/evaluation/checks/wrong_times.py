"""Hypotheses of sensors that are late: a gyro, an angle sensor, all gyros, or by a low-pass other than the header's."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.checks.consistency import Consistency
from tfsat_host.evaluation.checks.hypothesis import Hypothesis, fixed
from tfsat_host.evaluation.checks.stated_errors import StatedErrors
from tfsat_host.evaluation.checks.wrong_angles import sensor_name, with_one
from tfsat_host.evaluation.motion.lag import sheet_lag

FloatArray = NDArray[np.float64]
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
