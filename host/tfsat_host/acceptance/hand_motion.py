"""Whether hands did what a task asks: a motion that was not done must not be taken for a wrong wire."""

from __future__ import annotations

import numpy as np

from tfsat_host.acceptance.angle_wiring import MIN_TRAVEL_DEG, START_S, travel_deg
from tfsat_host.acceptance.imu_wiring import MIN_TURNED_RAD, MOVED_WITH, answering, turned_rad
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.steps.sensor_samples import SensorSamples
from tfsat_host.calibration.steps.step import bodies as body_words

MIN_MOTION_DEG = 45.0
"""What is opened or tilted by less shows too little."""
MAX_LEFT_OPEN_DEG = 10.0
"""So far from where it began may a motion end."""


def find_opening_mistake(joint: int, samples: SensorSamples) -> str:
    """Return what was wrong with the opening and closing of a joint (1 to 3); empty: nothing."""
    turned, travel = np.linalg.norm(turned_rad(samples), axis=1), np.abs(travel_deg(samples))
    answers = answering(samples)
    own_deg = float(np.median(travel[2 * joint - 2 : 2 * joint]))
    farthest_deg = max(own_deg, float(np.rad2deg(turned[answers].max(initial=0.0))))
    if farthest_deg < MIN_MOTION_DEG:
        return f"Joint {joint} was opened by {farthest_deg:.0f} deg only; open it to its end"
    # By the sensors that followed: an input without a wire shows anything.
    path = np.rad2deg(np.unwrap(samples.sensor_angle_rad, axis=0))
    left = np.abs(_mean_at_end(samples, path) - _mean_at_start(samples, path))[travel > MIN_TRAVEL_DEG]
    if len(left) and np.median(left) > MAX_LEFT_OPEN_DEG:
        return f"Joint {joint} was {np.median(left):.0f} deg open when the reading ended; begin and end with it closed"
    known = set((np.flatnonzero(answers) + 1).tolist())
    bodies = known & set((np.flatnonzero(turned > MIN_TURNED_RAD) + 1).tolist())
    joints = set((np.flatnonzero(travel > MIN_TRAVEL_DEG) // 2 + 1).tolist())
    # Of joint 2 exchanged buses look the same: the bodies of all three joints tell.
    if joint != 2 and joints == {joint} and bodies and bodies == known - set(MOVED_WITH[joint - 1]):
        return f"The other side of joint {joint} was moved; move {body_words(MOVED_WITH[joint - 1])}"
    # Bodies and sensors that agree on another joint were moved by it.
    for other, moved in enumerate(MOVED_WITH, 1):
        if other != joint and bodies and bodies == known & set(moved) and joints == {other}:
            return f"Joint {other} was opened, not joint {joint} (or the plugs of IMUs and angle sensors are exchanged)"
    return ""


def find_tilting_mistake(samples: SensorSamples) -> str:
    """Return what was wrong with the tilt of the whole robot; empty: nothing."""
    answers = answering(samples)
    if not answers.any():
        return ""
    tilted_deg = float(np.rad2deg(np.median(np.linalg.norm(turned_rad(samples)[answers], axis=1))))
    if tilted_deg < MIN_MOTION_DEG:
        return f"The robot was tilted by {tilted_deg:.0f} deg only"
    forces = samples.accel_m_s2[:, answers]
    # Gravity turns with the robot unless it was turned about the vertical.
    rates = samples.rate_rad_s[:, answers]
    path = np.cumsum(rates - rates.mean(axis=0), axis=0)
    tilted = forces[np.linalg.norm(path, axis=2).max(axis=1).argmax()]
    if _angle_deg(_mean_at_start(samples, forces), tilted) < MIN_MOTION_DEG / 2:
        return "The robot was turned about the vertical, not tilted"
    before, after = (mean(samples, forces) for mean in (_mean_at_start, _mean_at_end))
    left_deg = _angle_deg(before, after)
    if left_deg > MAX_LEFT_OPEN_DEG:
        return f"The robot stood {left_deg:.0f} deg from where it began when the reading ended"
    return ""


def _angle_deg(before: FloatArray, after: FloatArray) -> float:
    """Median angle between vectors (n, 3) and (n, 3)."""
    norms = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    cosine = np.clip((before * after).sum(axis=1) / norms, -1.0, 1.0)
    return float(np.rad2deg(np.arccos(np.median(cosine))))


def _mean_at_start(samples: SensorSamples, values: FloatArray) -> FloatArray:
    return np.asarray(values[samples.t_s <= samples.t_s[0] + START_S].mean(axis=0))


def _mean_at_end(samples: SensorSamples, values: FloatArray) -> FloatArray:
    return np.asarray(values[samples.t_s >= samples.t_s[-1] - START_S].mean(axis=0))
