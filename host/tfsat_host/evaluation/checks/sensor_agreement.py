"""Gyros and angle sensors against each other: joint by joint, in time, and by the attitude that they lead to."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.sensors.gyro import PARAMETERS
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses
from tfsat_host.evaluation.checks.check import Check, Kind, rms_limit, z_limit
from tfsat_host.evaluation.checks.consistency import Consistency
from tfsat_host.evaluation.checks.stated_errors import MAX_HOLE_S, StatedErrors
from tfsat_host.evaluation.motion.gyro_signal import DELAY_STD_S, MIN_STROKE_RAD
from tfsat_host.evaluation.motion.joints import JointMotion, Squares
from tfsat_host.evaluation.motion.motion import Motion
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.robot import RobotModel

STATED = "stated errors"
"""Unit of a root mean square that is counted in what calibration and data sheets allow."""
_RATES, _ANGLES = ("rates", "attitudes", "strokes", "offsets"), ("strokes", "offsets")
AS_STATED = Kind("sensors as stated", STATED, _RATES)
AXES = Kind("axes as stated", STATED, ("offsets",))
WEIGHT = Kind("gyros without their weight", STATED, ("rates", "attitudes", "offsets"))
LITTLE_STATED = "Not all misalignments and zero points were measured."
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
            f"Difference off the axis of joint {joint + 1}: {rms:.3f} deg/s rms, {value:.2g} times stated."
        )
        yield kind.judge(value, rms_limit(count), sentence)


def stated_check(motion: Motion, calibration: Calibration) -> Check:
    """Check the fusion's corrections of gyros and angle sensors against what their certificate states."""
    if not is_measured(calibration):
        return AS_STATED.not_possible(LITTLE_STATED)
    # The many errors that are as stated must not hide the few that are not.
    pairs = map(_by_stated, motion.solved.stated[:2])
    value, limit = max(pairs, key=lambda pair: pair[0] / pair[1])
    sentence = f"Errors of gyros and angle sensors: {value:.2f} times their certificate's."
    return AS_STATED.judge(value, limit, sentence)


def axes_check(motion: Motion, calibration: Calibration) -> Check:
    """Check the fusion's corrections of the joints' axes against what the robot file states.

    The sensors measure these axes, and a failure here is no fault of a sensor.
    """
    if not is_measured(calibration):
        return AXES.not_possible(LITTLE_STATED)
    value, limit = _by_stated(motion.solved.stated[2])
    sentence = f"Tilt of the joints' axes: {value:.2f} times the robot file's uncertainty."
    return AXES.judge(value, limit, sentence).caused_by(
        "the robot file: the axis of a joint leans by more than it states",
        Advice("Measure the hinges, and compare their axes: ", NextStep("robot")),
    )


def weight_check(motion: Motion, data: Consistency) -> Check:
    """Check the change of the gyros' biases from hanging under their weight to falling.

    A gyro more g-sensitive than its data sheet states also shows false rates in each stroke, which no bias
    removes.
    """
    if motion.contradicted or not np.isfinite(data.rest_rad_s).all():
        return WEIGHT.not_possible("The gyros' biases are not known both hanging and in the fall.")
    prior, after = motion.fusion.prior, motion.solved.jacobians.covariance
    # Root of the covariance of the biases alone, three rows of each gyro's.
    root = prior.gyro_root.reshape(data.bodies, PARAMETERS, -1)[:, :3].reshape(3 * data.bodies, -1)
    hanging = data.residual[data.rows(*map(data.at_rest, range(data.bodies)))]
    # Bias by the fall less bias by the rest: both are relative to the certificate's.
    change = prior.parameters_of(motion.solved.errors)[:, :3].ravel() - hanging
    # What the fall leaves open, what a gyro may feel of its weight, and the noise of the rest.
    covariance = root @ after[prior.gyro, prior.gyro] @ root.T
    covariance += block_diag(*data.fall_covariance[:, :3, :3])
    if data.rest is not None:
        covariance += np.diag(np.nan_to_num(data.rest.reading_std_rad_s).ravel() ** 2)
    value = float(np.sqrt(change @ np.linalg.solve(covariance, change) / len(change)))
    sentence = (
        f"Bias change from hanging to falling: {np.rad2deg(np.sqrt((change**2).mean())):.2f} deg/s rms, "
        f"{value:.2g} times the stated g-sensitivity."
    )
    return WEIGHT.judge(value, rms_limit(len(change)), sentence).caused_by(
        f"g-sensitivity: the gyros feel forces {value:.2g} times as much as their data sheet says",
        Advice(
            "Turn the robot over on the bench and compare the biases: ",
            NextStep("monitor"),
            "; replace such a gyro",
        ),
    )


def is_measured(calibration: Calibration) -> bool:
    """Return whether all sensors have measured errors, not only those of their data sheets."""
    return _zeros_calibrated(calibration) and all(gyro.axes for gyro in calibration.present_gyros)


def _by_stated(squares: Squares) -> tuple[float, float]:
    """Root mean square of what a drop tells, and what it may be."""
    if squares.determined <= 0.0:
        return 0.0, 1.0
    return float(np.sqrt(squares.sum / squares.determined)), rms_limit(squares.determined)


def pair_checks(data: Consistency, stated: StatedErrors) -> Iterator[Check]:
    """Check the two angle sensors of each joint against each other."""
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
        # The gyros' integral is in both rows: their covariance takes it out of the difference.
        std = np.rad2deg(np.sqrt(variance[a] + variance[b] - 2.0 * stated.covariance[a, b]))
        worst = int((np.abs(apart) / std).argmax())
        at_s = data.t_s[data.block.edges[both][worst]]
        sentence = f"Largest difference of the two {kind.name}: {apart[worst]:+.3f} deg at {at_s:.1f} s."
        yield kind.judge(float(abs(apart[worst])), float(z_limit(len(apart)) * std[worst]), sentence)


def sensed_checks(
    data: Consistency, stated: StatedErrors, joints: tuple[JointMotion, ...]
) -> Iterator[Check]:
    """Check the angle sensors of each joint against the rotation that its gyros measured."""
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
        sentence = f"Difference of the {kind.name}: {value:.2g} times stated, max. {greatest:.3f} deg."
        yield kind.judge(value, rms_limit(count), sentence)


def scale_checks(data: Consistency, stated: StatedErrors) -> Iterator[Check]:
    """Check the ratio of each joint's rotation by its gyros to that by its angle sensors."""
    turned = np.sum([data.rate_part(b, rates, data.rotations) for b, rates in enumerate(data.rates)], axis=0)
    for joint in range(data.joints):
        kind = Kind(f"gyro scale at joint {joint + 1}", "%", _RATES)
        rows = data.rows(data.along(joint, 0), data.along(joint, 1)) & stated.known
        if not rows.any():
            yield kind.not_possible(
                f"Not all sensors of joint {joint + 1} answered throughout the fall, or were ever calibrated."
            )
        elif np.ptp(turned[rows]) < MIN_STROKE_RAD:
            yield kind.not_possible(f"Joint {joint + 1} moved too little to tell a scale.")
        else:
            # Generalized least squares of one number: the residual against the gyros' integral.
            weighted = np.linalg.solve(stated.among(rows), turned[rows])
            information = float(weighted @ turned[rows])
            off = 100.0 * float(weighted @ data.residual[rows]) / information
            sentence = f"Gyros relative to the angle sensors of joint {joint + 1}: {off:+.2f} %."
            yield kind.judge(abs(off), 100.0 * z_limit(data.joints) / information**0.5, sentence)


def lag_check(motion: Motion, calibration: Calibration) -> Check:
    """Measured against the angle sensors, compared with the data sheet for the setting in the header."""
    lag = motion.lag
    if np.diff(motion.t_s[motion.samples.fall]).max() > MAX_HOLE_S:
        return LAG.not_possible("Across a hole in the samples nothing tells how late the gyros are.")
    if not lag.measured and lag.implausible_s is None:
        return LAG.not_possible(
            "No joint with angle sensors moved far enough to tell how late the gyros are."
        )
    if not _zeros_calibrated(calibration):
        return LAG.not_possible("Angle sensors without a calibrated zero do not tell how late the gyros are.")
    # Judge what the strokes gave even where the fusion refused it.
    delay_s = lag.delay_s if lag.implausible_s is None else lag.implausible_s
    sentence = (
        f"Gyro delay relative to the angle sensors: {1e3 * delay_s:.2f} ms "
        f"(data sheet: {1e3 * lag.expected_s:.2f} ms)."
    )
    return LAG.judge(1e3 * abs(delay_s - lag.expected_s), 1e3 * LAG_STDS * DELAY_STD_S, sentence)


def attitude_check(motion: Motion, calibration: Calibration, model: RobotModel) -> Check:
    """Check the base's final attitude by its own gyro against each other gyro, carried through the joints."""
    if not _zeros_calibrated(calibration):
        why = "Without calibrated zero points of all joints no attitude can be carried from body to body."
        return ATTITUDES.not_possible(why)
    tree = Multibody.of(model)
    answered = [b for b, body in enumerate(motion.bodies) if not body.bridged.all()]
    others = [b for b in answered if b != tree.base]
    if tree.base not in answered or not others:
        return ATTITUDES.not_possible("Too few gyros answered for a second opinion on the attitude.")
    start, end = poses(tree, motion.angles_rad[motion.samples.fall][[0, -1]])[0]
    first = int(np.flatnonzero(motion.samples.fall)[0])
    # Joint angles carry another body's attitude to the base: what their changes are off by, and a floor.
    bent = sum(joint.difference_std_rad(first, -1) ** 2 for joint in motion.joints) + ATTITUDE_FLOOR_RAD**2
    differences = [(_apart(motion, tree.base, b, start[b], end[b], bent), b) for b in others]
    (ratio, angle, std), worst = max(differences, key=lambda difference: difference[0][0])
    sentence = (
        f"The base's attitude at the end by the gyros of bodies {worst + 1} and {tree.base + 1} differs by "
        f"{np.rad2deg(angle):.3f} deg."
    )
    # In rad along this very difference, whose standard deviation is angle over ratio.
    limit = z_limit(3 * len(others)) * (angle / ratio if ratio > 0.0 else std)
    return ATTITUDES.judge(float(np.rad2deg(angle)), float(np.rad2deg(limit)), sentence)


def _apart(
    motion: Motion, of_base: int, of_other: int, start: FloatArray, end: FloatArray, bent: float
) -> tuple[float, float, float]:
    """Compare the base's attitude by its own gyro with that by another.

    The result is the difference in standard deviations and in rad, and the standard deviation of an axis.
    """
    base, other = motion.bodies[of_base], motion.bodies[of_other]
    # Out to the other body by the pose at the release, along with it, and back by the pose at the end.
    by = Rotation.from_matrix(start @ other.attitude[-1].as_matrix() @ end.T)
    apart = (by * base.attitude[-1].inv()).as_rotvec()
    covariance = start @ other.covariance() @ start.T + base.covariance() + bent * np.eye(3)
    ratio = float(np.sqrt(apart @ np.linalg.solve(covariance, apart)))
    return ratio, float(np.linalg.norm(apart)), float(np.sqrt(np.trace(covariance) / 3.0))


def _zeros_calibrated(calibration: Calibration) -> bool:
    return all(sensors.has_zero for sensors in calibration.joints)
