"""One drop with everything drawn from what the evaluation takes for granted, and how far each of its numbers is off."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import logm

from tests.validation.calibration_proof.robots import Errors
from tests.validation.evaluation_proof.errors import errors_of
from tests.validation.evaluation_proof.hidden import drop_hidden
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.apply import BENT_STD
from tfsat_host.dynamics.multibody import Multibody, across
from tfsat_host.evaluation.com_fit.offsets import Offsets, Parameter
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.maneuver import Maneuver, Schedule, Stroke, four_stroke, schedule_maneuver
from tfsat_host.maneuver.maneuver import DEFAULT_PAUSE_S
from tfsat_host.rehearsal.hidden import draw_hidden
from tfsat_host.rehearsal.truth import Truth
from tfsat_host.robot import RobotModel, load_robot

FILED = load_robot()
CHIPS = "imu-clocks=1"
"""Each IMU's oscillator is off by up to 1 %, as the evaluation allows."""
BENT_AT_RAD_S = np.deg2rad(170.0)
"""Rate at which the evaluation takes the scale factors to be bent by `BENT_STD`."""
MIN_A_DEG, MIN_B_DEG, ROOM_DEG = 30.0, 30.0, 45.0
SPEED_DEG_S, SERVO_LATE_S, WAIT_S = 170.0, 0.05, 0.3
"""Average speed of a servo, what it may be late, and how long a stroke waits at most."""
QUANTITIES = (
    "CoM",
    "CoM of body 4",
    "mass",
    "inertia",
    "hinge point",
    "hinge axis",
    "reorientation of body 1",
    "final attitude of body 1",
    "initial rate",
    "joint angle",
    "stroke",
    "measured less predicted",
)


@dataclass(frozen=True, eq=False)
class Judged:
    """One drop.

    Attributes:
        errors: By quantity, one value a parameter.
        withheld: Results that were not given.
        widened: The certificate was taken to be worse than it says.
    """

    errors: Mapping[str, Errors]
    withheld: tuple[str, ...]
    widened: bool


def judge_drop(kind: str, seed: int) -> Judged:
    """Draws robot, certificate, release and maneuver, flies and evaluates it; two seconds.

    Args:
        kind: Of `MANEUVERS`.
        seed: Of all that is drawn.
    """
    truth = _bend_scale(draw_hidden(FILED, seed), seed)
    drop, calibration = drop_hidden(truth, MANEUVERS[kind](seed), FILED, [CHIPS])
    evaluation = evaluate(drop.log, FILED, calibration, drop.schedule)
    errors = dict(errors_of(drop, evaluation))
    fit = evaluation.explained.fit
    p = len(fit.offsets)
    off = fit.values - true_offsets(fit.offsets, drop.flown)
    for name, rows in rows_of(fit.offsets).items():
        errors[name] = Errors(off[rows], np.sqrt(np.diag(fit.covariance)[:p])[rows])
    errors["hinge axis"] = _axes(evaluation, drop.flown)
    return Judged(
        {name: errors[name] for name in QUANTITIES}, tuple(evaluation.withheld), evaluation.widening > 1.0
    )


def _bend_scale(truth: Truth, seed: int) -> Truth:
    """Return the robot with scale factors that change with the rate, as the evaluation expects of such gyros."""
    was = truth.imperfections
    bends = (
        BENT_STD / BENT_AT_RAD_S * np.random.default_rng([seed, 32]).standard_normal(was.gyro_bend_s.shape)
    )
    return replace(truth, imperfections=replace(was, gyro_bend_s=bends))


def draw_one_at_a_time(seed: int) -> Schedule:
    """Return a maneuver of four strokes, drawn so that no two seeds give the same."""
    a_deg, b_deg = np.round(np.random.default_rng([seed, 31]).uniform(0.0, ROOM_DEG, 2), 2)
    return schedule_maneuver(four_stroke(MIN_A_DEG + a_deg, MIN_B_DEG + b_deg))


def draw_together(seed: int) -> Schedule:
    """Return a maneuver in which three joints each move out and back at drawn times, overlapping as these fall."""
    random, strokes = np.random.default_rng([seed, 33]), list[Stroke]()
    for joint in (1, 2, 3):
        size_deg = round(MIN_A_DEG + random.uniform(0.0, ROOM_DEG), 2)
        out_s = round(DEFAULT_PAUSE_S + random.uniform(0.0, WAIT_S), 2)
        # The way back begins when the servo has arrived, or later.
        back_s = round(out_s + size_deg / SPEED_DEG_S + SERVO_LATE_S + random.uniform(0.0, WAIT_S), 2)
        strokes += (Stroke(joint, size_deg, out_s), Stroke(joint, -size_deg, back_s))
    return schedule_maneuver(Maneuver(tuple(sorted(strokes, key=lambda stroke: stroke.t_s or 0.0))))


MANEUVERS: Mapping[str, Callable[[int], Schedule]] = {
    "one joint at a time": draw_one_at_a_time,
    "joints together": draw_together,
}
"""How the maneuver of a seed is drawn."""


def rows_of(offsets: Offsets) -> dict[str, list[int]]:
    """Return the indices of the parameters that belong to each quantity."""
    rows: dict[str, list[int]] = {}
    names = {"com": "CoM", "mass": "mass", "inertia": "inertia", "point": "hinge point"}
    for k, parameter in enumerate(offsets.parameters):
        name = "CoM of body 4" if parameter.kind == "com" and k >= offsets.sought else names[parameter.kind]
        rows.setdefault(name, []).append(k)
    return rows


def true_offsets(offsets: Offsets, true_model: RobotModel) -> FloatArray:
    """(p,) what the parameters should be, in their units."""
    return np.array(
        [
            _true(parameter, offsets.body, Multibody.of(true_model)) / parameter.si
            for parameter in offsets.parameters
        ]
    )


def _true(parameter: Parameter, filed: Multibody, true_multibody: Multibody) -> float:
    k = parameter.of
    if parameter.kind == "mass":
        return float(np.log(true_multibody.mass_kg[k] / filed.mass_kg[k]))
    if parameter.kind == "inertia":
        entry = _strain(filed.inertia_kg_m2[k], true_multibody.inertia_kg_m2[k]) * parameter.shape
        return float(entry.sum() / parameter.shape.sum())
    moved = (
        true_multibody.com_m[k] - filed.com_m[k]
        if parameter.kind == "com"
        else true_multibody.joint_point_m[k] - filed.joint_point_m[k]
    )
    return float(parameter.shape @ moved)


def _strain(filed: FloatArray, true_inertia: FloatArray) -> FloatArray:
    """E of S' = L e^E L^T, with L of the principal axes of S, as the fit has it."""
    moments, axes = np.linalg.eigh(_second_moments(filed))
    back = np.linalg.inv(axes * np.sqrt(moments))
    return np.asarray(logm(back @ _second_moments(true_inertia) @ back.T).real)


def _second_moments(inertia: FloatArray) -> FloatArray:
    return np.asarray(0.5 * np.trace(inertia) * np.eye(3) - inertia)


def _axes(evaluation: Evaluation, true_model: RobotModel) -> Errors:
    """Tilts about the two directions across each axis, deg."""
    fit, driven = evaluation.explained.fit, evaluation.explained.driven.flown
    first = len(fit.offsets) + 3
    tilt = driven.correct(fit.errors).tilt_rad.ravel()
    by_errors = driven.tilt_errors.reshape(len(tilt), -1)
    std = np.sqrt(np.diag(by_errors @ fit.covariance[first:, first:] @ by_errors.T))
    true = [
        across(a) @ np.cross(a, b)
        for a, b in zip(evaluation.model.joint_axis, true_model.joint_axis, strict=True)
    ]
    return Errors(np.rad2deg(tilt - np.concatenate(true)), np.rad2deg(std))
