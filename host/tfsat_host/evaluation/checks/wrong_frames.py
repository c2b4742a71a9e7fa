"""Hypotheses that keep every reading, but not whose it is: gyros' axes exchanged or reversed, IMUs in a wrong order."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.checks.axes import in_words, right_angled_turns, signed_exchanges
from tfsat_host.evaluation.checks.consistency import Consistency
from tfsat_host.evaluation.checks.hypothesis import Hypothesis, fixed

FloatArray = NDArray[np.float64]

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
