"""Readings that the fall lacks: full scale, no answer, holes in time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.joints.joint_sensors import sensor_columns
from tfsat_host.evaluation.checks.check import Check, judged
from tfsat_host.evaluation.checks.stated_errors import LONGEST_HOLE_S
from tfsat_host.evaluation.checks.wrong_angles import sensor_name
from tfsat_host.evaluation.motion.samples import Samples
from tfsat_host.robot import RobotModel
from tfsat_host.sdlog import DropLog

BoolArray = NDArray[np.bool_]

MISSING_SHARE = 0.01
"""Of a sensor's readings; so many are bridged by its neighbours without a trace in any result."""


def completeness_checks(log: DropLog, samples: Samples, model: RobotModel) -> Iterator[Check]:
    """Of the fall, from the release to just before the landing."""
    fall = (log.t_s >= 0.0) & (log.t_s <= samples.until_s)
    yield _clipped(log, fall)
    yield _answered(log, fall, model)
    yield _holes(log, fall, samples)


def _clipped(log: DropLog, fall: BoolArray) -> Check:
    count = (log.clipped & log.imu_valid)[fall].sum(axis=0)
    bodies = _numbers(count > 0)
    sentence = (
        f"{int(count.sum())} readings of the IMU of body {bodies} were at full scale and were not used."
        if count.any()
        else "No IMU was at full scale in the fall."
    )
    return judged("full scale in the fall", float(count.sum()), 0.0, "readings", sentence).caused_by(
        f"a knock, or a range that is too small, at the IMU of body {bodies}",
        "Compare the ranges with the strokes' rates: tfsat-host logger-settings",
    )


def _answered(log: DropLog, fall: BoolArray, model: RobotModel) -> Check:
    valid = np.concatenate([log.imu_valid[fall], log.angle_valid[fall]], axis=1)
    missing = 100.0 * (1.0 - valid.mean(axis=0))
    worst = int(missing.argmax())
    imus = log.imu_valid.shape[1]
    name = f"IMU of body {worst + 1}"
    if worst >= imus:
        joint = model.angle_sensors[worst - imus].joint
        name = sensor_name(joint, sensor_columns(model, joint + 1).index(worst - imus))
    sentence = (
        f"The {name} did not answer in {missing[worst]:.1f} % of the fall; its neighbours bridge an IMU."
        if missing[worst] > 0.0
        else "All sensors answered throughout the fall."
    )
    check = judged("answers in the fall", float(missing[worst]), 100.0 * MISSING_SHARE, "%", sentence)
    return check.caused_by(f"{name}: cable, connector or bus", "Watch the sensor live: tfsat-host monitor")


def _holes(log: DropLog, fall: BoolArray, samples: Samples) -> Check:
    edges = np.concatenate([[0.0], log.t_s[fall], [samples.until_s]])
    holes = np.diff(edges)
    worst = int(holes.argmax())
    sentence = f"The longest time without a sample is {1e3 * holes[worst]:.1f} ms, at {edges[worst]:.2f} s."
    lost = any(gap.samples for gap in log.gaps)
    return judged(
        "holes in the fall", float(1e3 * holes[worst]), 1e3 * LONGEST_HOLE_S, "ms", sentence
    ).caused_by(
        "blocks of the recording are lost" if lost else "the logger took its samples late",
        "Fetch the recording's second copy: tfsat-host log fetch" if lost else "tfsat-host log list",
    )


def _numbers(chosen: BoolArray) -> str:
    return ", ".join(str(b + 1) for b in np.flatnonzero(chosen))
