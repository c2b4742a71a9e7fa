"""Hypotheses of angle sensors: reversed, moved on their shafts, exchanged."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.checks.consistency import Consistency
from tfsat_host.evaluation.checks.hypothesis import Hypothesis, fixed

FloatArray = NDArray[np.float64]


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
