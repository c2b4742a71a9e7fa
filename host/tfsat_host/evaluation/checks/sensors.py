"""Gyros and angle sensors against each other: joint by joint, in time, and by the attitude that they lead to."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import BoolArray
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses
from tfsat_host.evaluation.checks.check import Check, judged, not_possible, rms_limit, z_limit
from tfsat_host.evaluation.checks.consistency import Consistency
from tfsat_host.evaluation.checks.stated_errors import LONGEST_HOLE_S, StatedErrors
from tfsat_host.evaluation.motion.gyro_signal import DELAY_STD_S, LEAST_STROKE_RAD
from tfsat_host.evaluation.motion.joints import JointMotion
from tfsat_host.evaluation.motion.motion import Motion
from tfsat_host.robot import RobotModel

STATED = "stated errors"
"""Unit of a root mean square that is counted in what calibration and data sheets allow."""


def neighbour_checks(of: Consistency, stated: StatedErrors) -> Iterator[Check]:
    """Off its axis a joint does not turn: there its two gyros must agree."""
    for joint in range(of.joints):
        inner, outer = sorted((int(of.model.joint_inner[joint]) + 1, int(of.model.joint_outer[joint]) + 1))
        name = f"gyros of bodies {inner} and {outer}"
        rows = _rows(of, of.off_axis(joint))
        chi_square, count = stated.surprise(of.own_vector, rows)
        if not count:
            yield not_possible(name, STATED, f"One of the {name} did not answer.")
            continue
        rms = np.rad2deg(np.sqrt((of.own_vector[rows & stated.known] ** 2).mean()))
        value = float(np.sqrt(chi_square / count))
        sentence = (
            f"Off the axis of joint {joint + 1} the {name} differ by {rms:.3f} deg/s rms, "
            f"{value:.2g} times what their stated errors allow."
        )
        yield judged(name, value, rms_limit(count), STATED, sentence)


def pair_checks(of: Consistency, stated: StatedErrors) -> Iterator[Check]:
    """The two angle sensors of a joint."""
    for joint in range(of.joints):
        name = f"angle sensors of joint {joint + 1}"
        first, second = (np.arange(of.size)[of.along(joint, k)] for k in range(2))
        both = stated.sensed[first] & stated.sensed[second]
        if not both.any():
            yield not_possible(
                name, "deg", f"One of the two {name} did not answer, or its zero was never calibrated."
            )
            continue
        apart = np.rad2deg((of.own_vector[first] - of.own_vector[second])[both])
        a, b = first[both], second[both]
        variance = np.diag(stated.covariance)
        std = np.rad2deg(np.sqrt(variance[a] + variance[b] - 2.0 * stated.covariance[a, b]))
        worst = int((np.abs(apart) / std).argmax())
        at_s = of.t_s[of.edges[both][worst]]
        sentence = f"The two {name} differ by {apart[worst]:+.3f} deg at {at_s:.1f} s."
        yield judged(name, float(abs(apart[worst])), float(z_limit(len(apart)) * std[worst]), "deg", sentence)


def sensed_checks(of: Consistency, stated: StatedErrors, joints: tuple[JointMotion, ...]) -> Iterator[Check]:
    """The angle sensors of a joint, and what its gyros have turned."""
    for joint, motion in enumerate(joints):
        name = f"angle sensors and gyros of joint {joint + 1}"
        rows = _rows(of, of.along(joint, 0), of.along(joint, 1))
        chi_square, count = stated.surprise(of.own_vector, rows)
        if not count:
            yield not_possible(
                name, STATED, f"Not all {name} answered throughout the fall, or were ever calibrated."
            )
            continue
        value = float(np.sqrt(chi_square / count))
        greatest = np.rad2deg(np.nanmax([sensor.greatest_rad for sensor in motion.sensors]))
        sentence = (
            f"The {name} differ by {value:.2g} times what their stated errors allow; "
            f"from the angle fused of both a sensor is off by {greatest:.3f} deg at most."
        )
        yield judged(name, value, rms_limit(count), STATED, sentence)


def scale_checks(of: Consistency, stated: StatedErrors) -> Iterator[Check]:
    """How far a joint turned by its gyros over how far by its angle sensors."""
    for joint in range(of.joints):
        name = f"gyro scale at joint {joint + 1}"
        rows = _rows(of, of.along(joint, 0), of.along(joint, 1)) & stated.known
        turned = np.sum([of.of_body(b, rates, of.own_turns) for b, rates in enumerate(of.own_rates)], axis=0)
        if not rows.any():
            yield not_possible(
                name,
                "%",
                f"Not all sensors of joint {joint + 1} answered throughout the fall, or were ever calibrated.",
            )
            continue
        if np.ptp(turned[rows]) < LEAST_STROKE_RAD:
            yield not_possible(name, "%", f"Joint {joint + 1} moved too little to tell a scale.")
            continue
        weighted = np.linalg.solve(stated.among(rows), turned[rows])
        information = float(weighted @ turned[rows])
        off = 100.0 * float(weighted @ of.own_vector[rows]) / information
        limit = 100.0 * z_limit(of.joints) / information**0.5
        sentence = f"The gyros at joint {joint + 1} show {off:+.2f} % more than its angle sensors."
        yield judged(name, abs(off), limit, "%", sentence)


def _rows(of: Consistency, *parts: slice) -> BoolArray:
    rows = np.zeros(of.size, dtype=bool)
    for part in parts:
        rows[part] = True
    return rows


LAG = "lag of the gyros"
LAG_STDS = 3.0
"""Of what a chip may be from its sheet, and its readings from their time stamps: settings are 1 to 5 ms apart."""


def lag_check(motion: Motion, calibration: Calibration) -> Check:
    """Measured against the angle sensors, beside the data sheet for the setting in the header."""
    lag = motion.lag
    if np.diff(motion.t_s[motion.samples.fall]).max() > LONGEST_HOLE_S:
        return not_possible(LAG, "ms", "Across a hole in the samples nothing tells how late the gyros are.")
    if not lag.measured and lag.implausible_s is None:
        return not_possible(
            LAG, "ms", "No joint with angle sensors moved far enough to tell how late the gyros are."
        )
    if any(sensors.zero_taken is None for sensors in calibration.joints):
        return not_possible(
            LAG, "ms", "Angle sensors without a calibrated zero do not tell how late the gyros are."
        )
    delay_s = lag.delay_s if lag.implausible_s is None else lag.implausible_s
    off_ms = 1e3 * (delay_s - lag.expected_s)
    sentence = (
        f"The gyros are {1e3 * delay_s:.2f} ms behind the angle sensors; "
        f"their low-pass accounts for {1e3 * lag.expected_s:.2f} ms."
    )
    return judged(LAG, abs(off_ms), 1e3 * LAG_STDS * DELAY_STD_S, "ms", sentence)


ATTITUDES = "attitude by each gyro"
ATTITUDE_FLOOR_RAD = np.deg2rad(0.1)
"""Of each axis: what frames give, and the 0.2 % by which a gyro's scale bends, over strokes of 70 deg and back."""


def attitude_check(motion: Motion, calibration: Calibration, model: RobotModel) -> Check:
    """The base's own gyro beside each of the others, carried through the joints."""
    if any(sensors.zero_taken is None for sensors in calibration.joints):
        why = "Without calibrated zero points of all joints no attitude can be carried from body to body."
        return not_possible(ATTITUDES, "deg", why)
    body = Multibody.of(model)
    angles = motion.angles_rad[motion.samples.fall]
    start, end = poses(body, angles[[0, -1]])[0]
    own = [b for b, one in enumerate(motion.bodies) if not one.bridged.all()]
    if body.base not in own or len(own) < 2:
        return not_possible(ATTITUDES, "deg", "Too few gyros answered for a second opinion on the attitude.")
    base = motion.bodies[body.base]
    worst: tuple[float, float, float, int] | None = None
    first = int(np.flatnonzero(motion.samples.fall)[0])
    bent = sum(joint.difference_std_rad(first, -1) ** 2 for joint in motion.joints) + ATTITUDE_FLOOR_RAD**2
    for b in (b for b in own if b != body.base):
        by = Rotation.from_matrix(start[b] @ motion.bodies[b].attitude[-1].as_matrix() @ end[b].T)
        apart = (by * base.attitude[-1].inv()).as_rotvec()
        covariance = (
            start[b] @ motion.bodies[b].covariance() @ start[b].T + base.covariance() + bent * np.eye(3)
        )
        angle = float(np.linalg.norm(apart))
        ratio = float(np.sqrt(apart @ np.linalg.solve(covariance, apart)))
        std = angle / ratio if ratio > 0.0 else float(np.sqrt(np.trace(covariance) / 3.0))
        if worst is None or ratio > worst[0]:
            worst = (ratio, angle, z_limit(3 * (len(own) - 1)) * std, b)
    if worst is None:
        return not_possible(ATTITUDES, "deg", "No gyro but the base's answered.")
    _, angle, limit, b = worst
    sentence = (
        f"At the end of the fall the gyros of bodies {b + 1} and {body.base + 1} differ by {np.rad2deg(angle):.3f} deg "
        "in the base's attitude."
    )
    return judged(ATTITUDES, float(np.rad2deg(angle)), float(np.rad2deg(limit)), "deg", sentence)
