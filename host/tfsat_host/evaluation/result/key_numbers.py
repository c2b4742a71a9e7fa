"""The numbers that one asks for first, each with its standard deviation."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.evaluation.com_fit.model_comparison import BODY_1
from tfsat_host.evaluation.com_fit.prediction import AttitudeError
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.reference_maneuver import fly_reference
from tfsat_host.evaluation.result.model_result import distance_words, withholding_factor, worth_of
from tfsat_host.quantity import Quantity, number
from tfsat_host.sdlog import DropLog
from tfsat_host.units import STANDARD_GRAVITY_M_S2

MM_S2 = "mm/s²"
MM_S2_PER_G = 1e3 * STANDARD_GRAVITY_M_S2
"""Thousandths of gravity would be taken for milligrams."""
_NONE = float("nan")
_WITHHELD = "withheld"
_CORRECTION = "Largest CoM correction"


def key_numbers_of(evaluation: Evaluation) -> list[Quantity]:
    """Return the key numbers in the order in which readers ask for them."""
    return [
        _reorientation(evaluation),
        *_gain(evaluation),
        attitude_error(
            "Attitude error, nominal model",
            evaluation.explained.nominal.error,
            is_given=evaluation.is_given(),
        ),
        attitude_error(
            "Attitude error, fitted model",
            evaluation.explained.fitted.error,
            is_given=np.isfinite(withholding_factor(evaluation)),
        ),
        _largest_correction(evaluation),
        *_initial_rates(evaluation),
        *_strokes(evaluation),
        *_release_velocity(evaluation),
        _fall(evaluation),
        _change_of_force(evaluation),
        _completeness(evaluation.log),
    ]


def _reorientation(evaluation: Evaluation) -> Quantity:
    turn, until_s = evaluation.reorientation, evaluation.motion.bodies[BODY_1].t_s[-1]
    note = f"of body 1, from the release to {until_s:.2f} s"
    if "attitudes" in evaluation.withheld:
        note = f"{_WITHHELD}: the check of {evaluation.withheld['attitudes']} failed"
    if turn.bridged:
        note += "; samples of its gyro are missing and were bridged"
    angle, std = np.rad2deg([turn.angle_rad, turn.std_rad])
    return Quantity(angle, std, "deg", label="Reorientation", note=note)


def _gain(evaluation: Evaluation) -> Iterator[Quantity]:
    """Yield what joints that moved together turned farther than one at a time; its std is the measurement's."""
    reference = fly_reference(evaluation)
    if reference is not None:
        turned, std = np.rad2deg([evaluation.reorientation.angle_rad, evaluation.reorientation.std_rad])
        alone = np.rad2deg(Rotation.from_matrix(reference.rotations()[BODY_1]).magnitude())
        note = f"59/70, one joint at a time: {alone:.3f} deg (nominal model, this drop's momentum, without ±)"
        yield Quantity(turned - alone, std, "deg", label="Gain over 59/70", note=note)


def attitude_error(label: str, error: AttitudeError, *, is_given: bool) -> Quantity:
    """Norm of the final Euler angles' error. Its std is that along the error, which tells how sure the norm is."""
    if not is_given:
        return Quantity(_NONE, unit="deg", label=label, note=_WITHHELD)
    norm = error.final_norm_rad
    # The gradient of the norm is its unit vector; at zero there is none, and no deviation is given.
    along = error.final_rad / norm if norm > 0.0 else np.zeros(3)
    std = float(np.sqrt(along @ error.covariance @ along)) if norm > 0.0 else float("nan")
    note = f"at the end, {distance_words(error)}; rms {number(np.rad2deg(error.rms_rad), '.2g')} deg"
    return Quantity(np.rad2deg(norm), np.rad2deg(std), "deg", label=label, note=note)


def _largest_correction(evaluation: Evaluation) -> Quantity:
    fit = evaluation.explained.fit
    # Among the centers of mass only: other offsets have other units.
    greatest = int(np.abs(fit.values[: fit.offsets.sought]).argmax())
    worth = worth_of(evaluation)
    if np.isnan(withholding_factor(evaluation)):
        return Quantity(_NONE, unit="mm", label=_CORRECTION, note=f"{_WITHHELD}: change nothing by it")
    note = fit.offsets.names[greatest] + ("; it stopped at its bound" if fit.at_bound[greatest] else "")
    if worth == "not called for":
        note += "; no correction is called for"
    if worth == "withheld":
        note += "; withheld: change nothing by it"
    value, std = (float(column[greatest]) for column in (fit.values, fit.std))
    return Quantity(value, std, "mm", "+.2f", _CORRECTION, note)


def _initial_rates(evaluation: Evaluation) -> Iterator[Quantity]:
    initial = evaluation.initial_rates[BODY_1]
    pairs = zip(np.rad2deg(initial.rate_rad_s), np.rad2deg(initial.std_rad_s), strict=True)
    group = "Initial rates of body 1, until the first stroke"
    for axis, (rate, std) in zip("xyz", pairs, strict=True):
        yield Quantity(rate, std, "deg/s", "+.2f", f"Initial rate {axis}", group=group)


def _strokes(evaluation: Evaluation) -> Iterator[Quantity]:
    for stroke in evaluation.strokes:
        commanded, size, std = np.rad2deg([stroke.commanded_rad, stroke.size_rad, stroke.size_std_rad])
        note = f"joint {stroke.joint}, {number(commanded, '+.2f')} deg commanded"
        yield Quantity(size, std, "deg", "+.2f", f"Stroke {stroke.number}", note, group="Strokes")


def _release_velocity(evaluation: Evaluation) -> Iterator[Quantity]:
    """Yield the release velocity and the transversal velocity; nothing without laser tracks."""
    velocity = evaluation.release_velocity
    if velocity is None:
        return
    down = velocity.downward
    note = f"downwards; {velocity.downward_judged} the facility's window"
    yield Quantity(down.value_mm_s, down.std_mm_s, "mm/s", label="Release velocity", note=note)
    if velocity.transversal_speed is not None:
        speed = velocity.transversal_speed
        note = f"sideways; {velocity.transversal_judged} what is permitted"
        yield Quantity(speed.value_mm_s, speed.std_mm_s, "mm/s", label="Transversal velocity", note=note)


def _fall(evaluation: Evaluation) -> Quantity:
    landing = evaluation.instants.landing
    if landing is None:
        return Quantity(_NONE, unit="s", label="Fall", note="no accelerometer felt a landing")
    # Both ends of the fall err, independently of one another.
    std = float(np.hypot(landing.std_s, evaluation.instants.release_std_s))
    note = "release (switches) to landing shock"
    return Quantity(landing.t_s, std, "s", label="Fall", note=note)


def _change_of_force(evaluation: Evaluation) -> Quantity:
    """Return the greatest change of force among the bodies between the two quiet windows.

    The zero-g output is in both windows, so it cannot hide a change.
    """
    changes, stds = evaluation.micro_gravity.changes_g, evaluation.micro_gravity.changes_std_g
    norms = np.linalg.norm(changes, axis=1)
    label = "Micro-gravity"
    if not evaluation.is_given("micro-gravity"):
        return Quantity(_NONE, unit=MM_S2, label=label, note=_WITHHELD)
    if not np.isfinite(norms).any():
        return Quantity(_NONE, unit=MM_S2, label=label, note="too few samples in one of the quiet windows")
    # The worst body decides; bodies without both windows are NaN and left out.
    body = int(np.nanargmax(norms))
    along = changes[body] / norms[body] if norms[body] > 0.0 else np.zeros(3)
    std = float(np.sqrt(((along * stds[body]) ** 2).sum()))
    note = (
        f"{number(1e3 * norms[body], '.2g')} · 10⁻³ of gravity: change from before the first stroke to "
        f"after the last, greatest at body {body + 1}"
    )
    return Quantity(MM_S2_PER_G * norms[body], MM_S2_PER_G * std, MM_S2, label=label, note=note)


def _completeness(log: DropLog) -> Quantity:
    total = len(log) + log.samples_lost
    note = f"{len(log)} of {total} samples; the recording is {log.verdict}"
    return Quantity(100.0 * len(log) / total, None, "%", ".4g", "Recording", note)
