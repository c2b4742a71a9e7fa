"""Whether hands did what a task asks: a motion that was not done must not be taken for a wrong wire."""

from __future__ import annotations

import numpy as np

from tfsat_host.acceptance.angle_wiring import MIN_TRAVEL_DEG, START_S, travel_deg
from tfsat_host.acceptance.imu_wiring import MIN_TURNED_RAD, MOVED_WITH, check_answers, turned_rad
from tfsat_host.calibration.steps.sensor_samples import SensorSamples

MIN_MOTION_DEG = 45.0
"""What is opened or tilted by less shows too little."""
MAX_LEFT_OPEN_DEG = 10.0
"""So far from where it began may a motion end."""


def find_opening_mistake(joint: int, samples: SensorSamples) -> str:
    """Return what was wrong with the opening and closing of a joint (1 to 3); empty: nothing."""
    turned, travel = np.linalg.norm(turned_rad(samples), axis=1), np.abs(travel_deg(samples))
    farthest_deg = max(float(np.rad2deg(turned.max())), float(travel.max()))
    if farthest_deg < MIN_MOTION_DEG:
        return f"Joint {joint} was opened by {farthest_deg:.0f} deg only; open it to its end"
    path = np.rad2deg(np.unwrap(samples.sensor_angle_rad, axis=0))
    left_deg = float(np.abs(_mean_at_end(samples, path) - _mean_at_start(samples, path)).max())
    if left_deg > MAX_LEFT_OPEN_DEG:
        return (
            f"Joint {joint} was {left_deg:.0f} deg open when the reading ended; begin and end with it closed"
        )
    # Bodies and sensors that agree on another joint were moved by it.
    bodies = set((np.flatnonzero(turned > MIN_TURNED_RAD) + 1).tolist())
    joints = set((np.flatnonzero(travel > MIN_TRAVEL_DEG) // 2 + 1).tolist())
    for other, moved in enumerate(MOVED_WITH, 1):
        if other != joint and bodies == set(moved) and joints == {other}:
            return f"Joint {other} was opened, not joint {joint}"
    return ""


def find_tilting_mistake(samples: SensorSamples) -> str:
    """Return what was wrong with the tilt of the whole robot; empty: nothing."""
    _, answers = check_answers(samples)
    if not answers.any():
        return ""
    tilted_deg = float(np.rad2deg(np.median(np.linalg.norm(turned_rad(samples)[answers], axis=1))))
    if tilted_deg < MIN_MOTION_DEG:
        return f"The robot was tilted by {tilted_deg:.0f} deg only"
    forces = samples.accel_m_s2[:, answers]
    before, after = (mean(samples, forces) for mean in (_mean_at_start, _mean_at_end))
    cosine = (before * after).sum(axis=1) / (np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1))
    left_deg = float(np.rad2deg(np.arccos(np.clip(np.median(cosine), -1.0, 1.0))))
    if left_deg > MAX_LEFT_OPEN_DEG:
        return f"The robot stood {left_deg:.0f} deg from where it began when the reading ended"
    return ""


def _mean_at_start(samples: SensorSamples, values: np.ndarray) -> np.ndarray:
    return np.asarray(values[samples.t_s <= samples.t_s[0] + START_S].mean(axis=0))


def _mean_at_end(samples: SensorSamples, values: np.ndarray) -> np.ndarray:
    return np.asarray(values[samples.t_s >= samples.t_s[-1] - START_S].mean(axis=0))
