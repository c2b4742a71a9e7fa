"""Which angle sensor sits on which joint, and which way it counts: from three joints opened by hand, one by one.

A sensor is known by the joint that moves it and by the sign of what it shows: the two of a joint face each other.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tfsat_host.acceptance.wires import ANGLE_PINS, ANGLE_SENSORS, name_angle_sensor
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.steps.sensor_samples import SensorSamples
from tfsat_host.preflight.preflight_check import PreflightCheck, judge
from tfsat_host.robot import RobotModel

MIN_TRAVEL_DEG = 20.0
"""A sensor that shows more was moved."""
MAX_PAIR_DIFFERENCE_DEG = 4.0
"""Between the two sensors of a joint: twice what two poorly adjusted magnets make."""
MAX_RANGE_ERROR_DEG = 5.0
START_S = 0.3
"""So long from its beginning is a joint at rest, closed."""


def start_rad(samples: SensorSamples) -> FloatArray:
    """(6,) circular mean of each sensor's reading over the first `START_S`."""
    still = samples.sensor_angle_rad[samples.t_s <= samples.t_s[0] + START_S]
    return np.asarray(np.angle(np.exp(1j * still).mean(axis=0)))


def travel_deg(samples: SensorSamples) -> FloatArray:
    """(6,) how far each sensor showed its joint from where it began, at its farthest, in the sensor's own sense."""
    path = np.unwrap(samples.sensor_angle_rad, axis=0)
    path = np.rad2deg(path - path[samples.t_s <= samples.t_s[0] + START_S].mean(axis=0))
    return np.asarray(np.take_along_axis(path, np.abs(path).argmax(axis=0)[None], axis=0)[0])


def check_sensors(travels: Sequence[FloatArray], model: RobotModel) -> PreflightCheck:
    """Check that each sensor shows its joint, in its direction, and that the two of a joint agree.

    Args:
        travels: Of each joint that is there, opened one by one, what `travel_deg` gave.
        model: The robot by design; its joints open towards positive angles.
    """
    by_joint = np.array(travels)
    pins = range(2 * len(travels))
    sensor_at = [_identify(by_joint[:, pin], model) for pin in pins]
    wrong = []
    for pin, sensor in enumerate(sensor_at):
        if sensor is None:
            shown = np.abs(by_joint[:, pin]).max()
            wrong.append(
                f"{name_angle_sensor(pin)} follows no single joint ({shown:.0f} deg at most): "
                "its wire, magnet or supply"
            )
        elif sensor != pin and sensor_at[sensor] == pin:
            if pin < sensor:
                wrong.append(_swapped(pin, sensor))
        elif sensor != pin and sensor // 2 == pin // 2 and pin not in sensor_at:
            wrong.append(
                f"{name_angle_sensor(pin)} counts the wrong way: its magnet or its face is turned over"
            )
        elif sensor != pin:
            wrong.append(
                f"{name_angle_sensor(pin)} shows joint {sensor // 2 + 1}, as sensor {ANGLE_SENSORS[sensor]} should"
            )
    if not wrong:
        wrong = [
            f"the sensors of joint {joint + 1} differ by {difference:.1f} deg (limit {MAX_PAIR_DIFFERENCE_DEG:g})"
            for joint in range(len(travels))
            if (difference := _pair_difference(by_joint[joint], joint)) > MAX_PAIR_DIFFERENCE_DEG
        ]
    return judge(
        wrong,
        "Angle sensors: {}.",
        "Correct the wiring, then repeat the step.",
        "Angle sensors: each shows its joint, pairs agree within "
        f"{max(_pair_difference(row, joint) for joint, row in enumerate(by_joint)):.1f} deg.",
        travel_deg=by_joint.tolist(),
    )


def check_ranges(travels: Sequence[FloatArray], model: RobotModel) -> PreflightCheck:
    """Check that each joint opens as far as the robot file says."""
    opened = [float(np.abs(row).max()) for row in travels]
    limits_rad = model.joint_limits_rad[: len(opened)]
    spans = np.rad2deg(limits_rad[:, 1] - limits_rad[:, 0]).tolist()
    wrong = [
        f"joint {joint} opened by {angle:.0f} deg ({span:.0f} by the robot file)"
        for joint, (angle, span) in enumerate(zip(opened, spans, strict=True), 1)
        # Without a sensor that follows it, that is the finding.
        if angle > MIN_TRAVEL_DEG and abs(angle - span) > MAX_RANGE_ERROR_DEG
    ]
    return judge(
        wrong,
        "Joint ranges: {}.",
        "Move the joint to its end stop; if it was there, find what blocks it, or correct limits_deg.",
        f"Joint ranges: {', '.join(f'{angle:.0f}' for angle in opened)} deg.",
        opened_deg=opened,
    )


def _identify(shown_deg: FloatArray, model: RobotModel) -> int | None:
    """Return which sensor shows so much of joints 1 to 3; None: of none, or of several."""
    joints = np.flatnonzero(np.abs(shown_deg) > MIN_TRAVEL_DEG)
    if len(joints) != 1:
        return None
    direction = np.sign(shown_deg[joints[0]])
    of_joint = [k for k, sensor in enumerate(model.angle_sensors) if sensor.joint == joints[0]]
    return next((k for k in of_joint if model.angle_sensors[k].direction == direction), None)


def _swapped(pin: int, other: int) -> str:
    pins = f"Teensy pins {ANGLE_PINS[pin]} and {ANGLE_PINS[other]}"
    if pin // 2 == other // 2:
        return f"the wires of joint {pin // 2 + 1}'s sensors are swapped ({pins})"
    return f"the wires of sensors {ANGLE_SENSORS[pin]} and {ANGLE_SENSORS[other]} are swapped ({pins})"


def _pair_difference(travels: FloatArray, joint: int) -> float:
    return float(abs(abs(travels[2 * joint]) - abs(travels[2 * joint + 1])))
