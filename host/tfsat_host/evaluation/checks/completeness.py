"""Readings that the fall lacks: full scale, no answer, holes in time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.sensors.joint_sensors import sensor_columns
from tfsat_host.evaluation.checks.check import Check, judged
from tfsat_host.evaluation.checks.conserved import QUIET_RAD_S
from tfsat_host.evaluation.checks.stated_errors import LONGEST_HOLE_S
from tfsat_host.evaluation.checks.wrong_angles import sensor_name
from tfsat_host.evaluation.motion.motion import Motion
from tfsat_host.robot import RobotModel
from tfsat_host.sdlog import DropLog

BoolArray = NDArray[np.bool_]

MISSING_SHARE = 0.01
"""Of a sensor's readings; so many are bridged by its neighbours without a trace in any result."""

SERVO_DEG_S2 = 4000.0
"""As a servo speeds up; over a hole of h the trapezoid then misses this times h^2 / 12."""
_NEXT_S = 1e-4
"""A sample so near to the end of a hole is the one that ends it."""


def completeness_checks(log: DropLog, motion: Motion, model: RobotModel) -> Iterator[Check]:
    """Of the fall, from the release to just before the landing."""
    fall = (log.t_s >= 0.0) & (log.t_s <= motion.samples.until_s)
    yield _clipped(log, fall)
    yield _answered(log, fall, model)
    yield _holes(log, fall, motion)


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
    name, bridged = f"IMU of body {worst + 1}", "its neighbours and the angle sensors bridge it"
    if worst >= imus:
        joint = model.angle_sensors[worst - imus].joint
        pair = sensor_columns(model, joint + 1)
        name = sensor_name(joint, pair.index(worst - imus))
        silent = ~log.angle_valid[fall][:, pair].any(axis=1)
        bridged = "the joint's other sensor and the gyros go on without it"
        if silent.any():
            bridged = f"in {100.0 * silent.mean():.1f} % neither of the joint's did, and its gyros alone tell its angle"
    others = int((missing > 100.0 * MISSING_SHARE).sum()) - 1
    more = f" {others} more did not answer in over {100.0 * MISSING_SHARE:g} %." if others > 0 else ""
    sentence = (
        f"The {name} did not answer in {missing[worst]:.1f} % of the fall; {bridged}.{more}"
        if missing[worst] > 0.0
        else "All sensors answered throughout the fall."
    )
    check = judged("answers in the fall", float(missing[worst]), 100.0 * MISSING_SHARE, "%", sentence)
    return check.caused_by(f"{name}: cable, connector or bus", "Watch the sensor live: tfsat-host monitor")


def _holes(log: DropLog, fall: BoolArray, motion: Motion) -> Check:
    """Times without any gyro: a sample is lost, or none of the IMUs answered to it."""
    samples = motion.samples
    edges = np.concatenate([[0.0], samples.t_s[samples.fall], [samples.until_s]])
    holes = np.diff(edges)
    worst = int(holes.argmax())
    hole_s, from_s = float(holes[worst]), float(edges[worst])
    sentence = f"The longest time without any gyro is {1e3 * hole_s:.1f} ms, at {from_s:.2f} s."
    if hole_s > LONGEST_HOLE_S:
        sentence += f" {_cost(motion, from_s, from_s + hole_s)}"
    check = judged("holes in the fall", 1e3 * hole_s, 1e3 * LONGEST_HOLE_S, "ms", sentence)
    within = fall & (log.t_s > from_s + _NEXT_S) & (log.t_s < from_s + hole_s - _NEXT_S)
    if within.any():
        return check.caused_by(
            "no IMU answered although the logger sampled: what all IMUs share, their bus or their supply",
            "Watch the IMUs live: tfsat-host monitor",
        )
    if any(gap.samples for gap in log.gaps):
        return check.caused_by(
            "blocks of the recording are lost", "Fetch the recording's second copy: tfsat-host log fetch"
        )
    return check.caused_by("the logger took its samples late", "tfsat-host log list")


def _cost(motion: Motion, from_s: float, until_s: float) -> str:
    """What a hole does to the results."""
    ends = np.searchsorted(motion.t_s, [from_s, until_s]).clip(0, len(motion.t_s) - 1)
    rates = np.abs(motion.fused.joint_rate_rad_s[ends]).max(axis=0)
    turning = rates > QUIET_RAD_S
    if not turning.any():
        return "No joint moved at its ends: rates are taken to have changed evenly in it."
    off_deg = SERVO_DEG_S2 * (until_s - from_s) ** 2 / 12.0
    return (
        f"Joint {_numbers(turning)} moved at its ends: a servo that sped up or slowed down in it leaves its angle, "
        f"and every attitude from then on, off by up to {off_deg:.2f} deg where no angle sensor tells it."
    )


def _numbers(chosen: BoolArray) -> str:
    return ", ".join(str(b + 1) for b in np.flatnonzero(chosen))
