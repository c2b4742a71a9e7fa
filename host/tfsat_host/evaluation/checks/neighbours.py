"""Neighbouring gyros and angle sensors against each other, joint by joint."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.checks.check import Check, judged, not_possible, rms_limit, z_limit
from tfsat_host.evaluation.checks.consistency import Consistency
from tfsat_host.evaluation.checks.stated_errors import StatedErrors
from tfsat_host.evaluation.motion.joints import JointMotion
from tfsat_host.evaluation.motion.lag import LEAST_STROKE_RAD

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

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
