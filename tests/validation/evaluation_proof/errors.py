"""How far an evaluation is from the truth, number by number, next to how far it says that it may be."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.spatial.transform import Rotation

from tests.fixtures.emulated_drop import Drop
from tests.validation.calibration_proof.robots import Errors
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.motion.attitude import BodyMotion
from tfsat_host.evaluation.motion.motion import quiet_samples
from tfsat_host.evaluation.strokes import WINDOW, FlownStroke

LABELS = {
    "reorientation of body 1": ("",),
    "reorientation of bodies 2 to 4": ("body 2", "body 3", "body 4"),
    "final attitude of body 1": tuple("xyz"),
    "initial rate": tuple(f"body {body} {axis}" for body in range(1, 5) for axis in "xyz"),
    "joint angle": tuple(
        f"joint {joint} {when}" for joint in range(1, 4) for when in ("at first", "at last")
    ),
    "stroke": tuple(f"stroke {stroke}" for stroke in range(1, 7)),
    "CoM": tuple(f"body {body} {axis}" for body in range(1, 4) for axis in "xyz"),
    "measured less predicted": tuple("zyx"),
}
"""What each value of a quantity is of. The last is the attitude of body 1 next to that of the corrected model."""
BODY_2_Z = 5
"""Of the nine offsets, the one that the data tell worst."""
_RATES = 20
"""Where the rates begin in a row of truth."""


def errors_of(drop: Drop, evaluation: Evaluation) -> dict[str, Errors]:
    """Against the hidden truth: deg, deg/s, and mm of the centers of mass."""
    bodies, fit = evaluation.motion.bodies, evaluation.explained.fit
    # The fitted model's attitude error at the end of the fall.
    after = evaluation.explained.fitted.error
    turned = [_reorientation(drop, number, body) for number, body in enumerate(bodies, 1)]
    return {
        "reorientation of body 1": join_errors(turned[:1]),
        "reorientation of bodies 2 to 4": join_errors(turned[1:]),
        "final attitude of body 1": _attitude(drop, bodies[0]),
        "initial rate": _initial_rates(drop, evaluation),
        "joint angle": _joint_angles(drop, evaluation),
        "stroke": join_errors([_stroke(drop, stroke, evaluation.strokes) for stroke in evaluation.strokes]),
        "CoM": Errors(fit.values[:9] - drop.true_com_offsets_mm, fit.std[:9]),
        "measured less predicted": Errors(np.rad2deg(after.final_rad), np.rad2deg(after.std_rad[-1])),
    }


def join_errors(parts: Iterable[Errors]) -> Errors:
    """Concatenate the errors in order."""
    ones = list(parts)
    return Errors(
        np.concatenate([errors.error for errors in ones]), np.concatenate([errors.std for errors in ones])
    )


def _reorientation(drop: Drop, number: int, body: BodyMotion) -> Errors:
    angle, std = body.reorientation_rad()
    # The true rotation over the very samples that the evaluation integrated.
    true = drop.true_turn(number, body.t_s[0], body.t_s[-1]).magnitude()
    return Errors(np.rad2deg([angle - true]), np.rad2deg([std]))


def _attitude(drop: Drop, body: BodyMotion) -> Errors:
    true = drop.true_turn(1, body.t_s[0], body.t_s[-1])
    # Left difference: the covariance is in the frame of the release.
    last: Rotation = body.attitude[-1]
    return Errors(
        np.rad2deg((last * true.inv()).as_rotvec()), np.rad2deg(np.sqrt(np.diag(body.covariance())))
    )


def _initial_rates(drop: Drop, evaluation: Evaluation) -> Errors:
    """Next to the mean of the true rates over the same time."""
    t_s = evaluation.motion.bodies[0].t_s
    quiet = t_s[quiet_samples(t_s, float(evaluation.strokes[0].logged_s))]
    # Rates are estimated from the quiet time before the first stroke: compare with the same interval.
    rows = (drop.truth[:, 0] >= quiet[0]) & (drop.truth[:, 0] <= quiet[-1])
    true = drop.truth[rows, _RATES:].mean(axis=0)
    rate = np.concatenate([initial_rate.rate_rad_s for initial_rate in evaluation.initial_rates])
    std = np.concatenate([initial_rate.std_rad_s for initial_rate in evaluation.initial_rates])
    return Errors(np.rad2deg(rate - true), np.rad2deg(std))


def _joint_angles(drop: Drop, evaluation: Evaluation) -> Errors:
    """Compute the errors of the joint angles, in deg, at the first and the last sample of the fall."""
    motion = evaluation.motion
    # From the release, at t = 0, to the last sample before landing.
    ends = [int(np.searchsorted(motion.t_s, 0.0)), len(motion.t_s) - 1]
    error = motion.angles_rad - drop.true_angles_rad(motion.t_s)
    std = np.column_stack([joint.std_rad() for joint in motion.joints])
    return Errors(np.rad2deg(error[ends].T.ravel()), np.rad2deg(std[ends].T.ravel()))


def _stroke(drop: Drop, stroke: FlownStroke, strokes: tuple[FlownStroke, ...]) -> Errors:
    """Next to the true change from just before the stroke to just before its joint's next, or the end."""
    later = [
        other_stroke.logged_s
        for other_stroke in strokes
        if other_stroke.joint == stroke.joint and other_stroke.number > stroke.number
    ]
    # The stroke's size is a difference of two averaged windows: compare at the windows' centers.
    half_window_s = 0.5 * WINDOW / 280.0
    # The last window ends before the landing shock.
    until_s = min([*later, float(drop.landed_s) - 0.05])
    times = np.array([stroke.logged_s, until_s]) - half_window_s
    before, after = drop.true_angles_rad(times)[:, stroke.joint - 1]
    return Errors(np.rad2deg([stroke.size_rad - (after - before)]), np.rad2deg([stroke.size_std_rad]))
