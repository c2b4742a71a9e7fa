"""Gyros and angle sensors against each other: joint by joint, in time, and by the attitude that they lead to."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses
from tfsat_host.evaluation.checks.check import Check, Kind, rms_limit, z_limit
from tfsat_host.evaluation.checks.consistency import Consistency
from tfsat_host.evaluation.checks.stated_errors import LONGEST_HOLE_S, StatedErrors
from tfsat_host.evaluation.motion.gyro_signal import DELAY_STD_S, LEAST_STROKE_RAD
from tfsat_host.evaluation.motion.joints import JointMotion
from tfsat_host.evaluation.motion.motion import Motion
from tfsat_host.robot import RobotModel

STATED = "stated errors"
"""Unit of a root mean square that is counted in what calibration and data sheets allow."""
_RATES, _ANGLES = ("rates", "attitudes", "strokes", "offsets"), ("strokes", "offsets")
AS_STATED = Kind("gyros and axes as stated", STATED, _RATES)
LAG = Kind("lag of the gyros", "ms", _RATES)
LAG_STDS = 3.0
"""Of what a chip may be from its sheet, and its readings from their time stamps: settings are 1 to 5 ms apart."""
ATTITUDES = Kind("attitude by each gyro", "deg", ("attitudes", "offsets"))
ATTITUDE_FLOOR_RAD = np.deg2rad(0.1)
"""Of each axis: what frames give, and the 0.2 % by which a gyro's scale bends, over strokes of 70 deg and back."""


def neighbour_checks(data: Consistency, stated: StatedErrors) -> Iterator[Check]:
    """Off its axis a joint does not turn: there its two gyros must agree."""
    for joint in range(data.joints):
        inner, outer = sorted(body + 1 for body in data.pair(joint))
        kind = Kind(f"gyros of bodies {inner} and {outer}", STATED, _RATES)
        rows = data.rows(data.off_axis(joint))
        chi_square, count = stated.chi_square_of(data.residual, rows)
        if not count:
            yield kind.not_possible(f"One of the {kind.name} did not answer.")
            continue
        rms = np.rad2deg(np.sqrt((data.residual[rows & stated.known] ** 2).mean()))
        value = float(np.sqrt(chi_square / count))
        sentence = (
            f"Off the axis of joint {joint + 1} the {kind.name} differ by {rms:.3f} deg/s rms, "
            f"{value:.2g} times what their stated errors allow."
        )
        yield kind.judged(value, rms_limit(count), sentence)


def stated_check(motion: Motion, calibration: Calibration) -> Check:
    """What the fusion corrects gyros and axes by, against what certificate and robot file state of them."""
    if not (_zeros_calibrated(calibration) and all(gyro.axes for gyro in calibration.gyros)):
        return AS_STATED.not_possible(
            "Not all mountings and zero points were measured: little is stated of them."
        )
    squares, determined = motion.solved.squares
    value = float(np.sqrt(squares / determined))
    sentence = (
        f"Gyros and joint axes are off by {value:.2f} times what certificate and robot file state of them."
    )
    return AS_STATED.judged(value, rms_limit(determined), sentence)


def pair_checks(data: Consistency, stated: StatedErrors) -> Iterator[Check]:
    """The two angle sensors of a joint."""
    for joint in range(data.joints):
        kind = Kind(f"angle sensors of joint {joint + 1}", "deg", _ANGLES)
        first, second = (np.flatnonzero(data.rows(data.along(joint, k))) for k in range(2))
        both = stated.sensed[first] & stated.sensed[second]
        if not both.any():
            yield kind.not_possible(
                f"One of the two {kind.name} did not answer, or its zero was never calibrated."
            )
            continue
        apart = np.rad2deg((data.residual[first] - data.residual[second])[both])
        a, b = first[both], second[both]
        variance = np.diag(stated.covariance)
        std = np.rad2deg(np.sqrt(variance[a] + variance[b] - 2.0 * stated.covariance[a, b]))
        worst = int((np.abs(apart) / std).argmax())
        at_s = data.t_s[data.block.edges[both][worst]]
        sentence = f"The two {kind.name} differ by {apart[worst]:+.3f} deg at {at_s:.1f} s."
        yield kind.judged(float(abs(apart[worst])), float(z_limit(len(apart)) * std[worst]), sentence)


def sensed_checks(
    data: Consistency, stated: StatedErrors, joints: tuple[JointMotion, ...]
) -> Iterator[Check]:
    """The angle sensors of a joint, and what its gyros have turned."""
    for joint, motion in enumerate(joints):
        kind = Kind(f"angle sensors and gyros of joint {joint + 1}", STATED, _ANGLES)
        chi_square, count = stated.chi_square_of(
            data.residual, data.rows(data.along(joint, 0), data.along(joint, 1))
        )
        if not count:
            yield kind.not_possible(
                f"Not all {kind.name} answered throughout the fall, or were ever calibrated."
            )
            continue
        value = float(np.sqrt(chi_square / count))
        greatest = np.rad2deg(np.nanmax([sensor.greatest_rad for sensor in motion.sensors]))
        sentence = (
            f"The {kind.name} differ by {value:.2g} times what their stated errors allow; "
            f"from the angle fused of both a sensor is off by {greatest:.3f} deg at most."
        )
        yield kind.judged(value, rms_limit(count), sentence)


def scale_checks(data: Consistency, stated: StatedErrors) -> Iterator[Check]:
    """How far a joint turned by its gyros over how far by its angle sensors."""
    turned = np.sum([data.rate_part(b, rates, data.rotations) for b, rates in enumerate(data.rates)], axis=0)
    for joint in range(data.joints):
        kind = Kind(f"gyro scale at joint {joint + 1}", "%", _RATES)
        rows = data.rows(data.along(joint, 0), data.along(joint, 1)) & stated.known
        if not rows.any():
            yield kind.not_possible(
                f"Not all sensors of joint {joint + 1} answered throughout the fall, or were ever calibrated."
            )
        elif np.ptp(turned[rows]) < LEAST_STROKE_RAD:
            yield kind.not_possible(f"Joint {joint + 1} moved too little to tell a scale.")
        else:
            weighted = np.linalg.solve(stated.among(rows), turned[rows])
            information = float(weighted @ turned[rows])
            off = 100.0 * float(weighted @ data.residual[rows]) / information
            sentence = f"The gyros at joint {joint + 1} show {off:+.2f} % more than its angle sensors."
            yield kind.judged(abs(off), 100.0 * z_limit(data.joints) / information**0.5, sentence)


def lag_check(motion: Motion, calibration: Calibration) -> Check:
    """Measured against the angle sensors, compared with the data sheet for the setting in the header."""
    lag = motion.lag
    if np.diff(motion.t_s[motion.samples.fall]).max() > LONGEST_HOLE_S:
        return LAG.not_possible("Across a hole in the samples nothing tells how late the gyros are.")
    if not lag.measured and lag.implausible_s is None:
        return LAG.not_possible(
            "No joint with angle sensors moved far enough to tell how late the gyros are."
        )
    if not _zeros_calibrated(calibration):
        return LAG.not_possible("Angle sensors without a calibrated zero do not tell how late the gyros are.")
    delay_s = lag.delay_s if lag.implausible_s is None else lag.implausible_s
    sentence = (
        f"The gyros are {1e3 * delay_s:.2f} ms behind the angle sensors; "
        f"their low-pass accounts for {1e3 * lag.expected_s:.2f} ms."
    )
    return LAG.judged(1e3 * abs(delay_s - lag.expected_s), 1e3 * LAG_STDS * DELAY_STD_S, sentence)


def attitude_check(motion: Motion, calibration: Calibration, model: RobotModel) -> Check:
    """The base's attitude at the end by its own gyro against each of the others, carried through the joints."""
    if not _zeros_calibrated(calibration):
        why = "Without calibrated zero points of all joints no attitude can be carried from body to body."
        return ATTITUDES.not_possible(why)
    tree = Multibody.of(model)
    answered = [b for b, one in enumerate(motion.bodies) if not one.bridged.all()]
    others = [b for b in answered if b != tree.base]
    if tree.base not in answered or not others:
        return ATTITUDES.not_possible("Too few gyros answered for a second opinion on the attitude.")
    start, end = poses(tree, motion.angles_rad[motion.samples.fall][[0, -1]])[0]
    first = int(np.flatnonzero(motion.samples.fall)[0])
    bent = sum(joint.difference_std_rad(first, -1) ** 2 for joint in motion.joints) + ATTITUDE_FLOOR_RAD**2
    found = [(_apart(motion, tree.base, b, start[b], end[b], bent), b) for b in others]
    (ratio, angle, std), worst = max(found, key=lambda one: one[0][0])
    sentence = (
        f"At the end of the fall the gyros of bodies {worst + 1} and {tree.base + 1} differ by {np.rad2deg(angle):.3f} "
        "deg in the base's attitude."
    )
    limit = z_limit(3 * len(others)) * (angle / ratio if ratio > 0.0 else std)
    return ATTITUDES.judged(float(np.rad2deg(angle)), float(np.rad2deg(limit)), sentence)


def _apart(
    motion: Motion, of_base: int, of_other: int, start: FloatArray, end: FloatArray, bent: float
) -> tuple[float, float, float]:
    """How far the base's attitude by another gyro is off: in its deviations, in rad, and a deviation of an axis."""
    base, other = motion.bodies[of_base], motion.bodies[of_other]
    by = Rotation.from_matrix(start @ other.attitude[-1].as_matrix() @ end.T)
    apart = (by * base.attitude[-1].inv()).as_rotvec()
    covariance = start @ other.covariance() @ start.T + base.covariance() + bent * np.eye(3)
    ratio = float(np.sqrt(apart @ np.linalg.solve(covariance, apart)))
    return ratio, float(np.linalg.norm(apart)), float(np.sqrt(np.trace(covariance) / 3.0))


def _zeros_calibrated(calibration: Calibration) -> bool:
    return all(sensors.zero_taken is not None for sensors in calibration.joints)
