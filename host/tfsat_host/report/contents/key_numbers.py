"""The numbers at the top of the report, each with its standard deviation."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.model_fit.comparison import AttitudeError
from tfsat_host.evaluation.model_fit.explained import BODY_1
from tfsat_host.report.contents.chart import AXES
from tfsat_host.report.contents.correction import distance_words, worth_of
from tfsat_host.report.contents.tables.cells import number, significant
from tfsat_host.report.document import KeyNumber
from tfsat_host.sdlog import DropLog
from tfsat_host.units import STANDARD_GRAVITY_M_S2

MM_S2 = "mm/s²"
MM_S2_PER_G = 1e3 * STANDARD_GRAVITY_M_S2
"""Thousandths of gravity would be taken for milligrams."""


def key_numbers_of(found: Evaluation) -> list[KeyNumber]:
    """In the order in which one asks for them."""
    return [
        _reorientation(found),
        _error("Attitude error, model as filed", found.explained.before.error),
        _error("Attitude error, model corrected", found.explained.after.error),
        _largest_correction(found),
        *_initial_rates(found),
        *_strokes(found),
        *_release_velocity(found),
        _fall(found),
        _change_of_force(found),
        _completeness(found.log),
    ]


def _number(
    label: str, value: float, std: float | None, unit: str, note: str, row: str | None = None
) -> KeyNumber:
    known = np.isfinite(value)
    made = KeyNumber(
        label=label,
        value=float(value) if known else None,
        std=float(std) if known and std is not None and np.isfinite(std) else None,
        unit=unit,
        note=note,
    )
    if row is not None:
        made["row"] = row
    return made


def _reorientation(found: Evaluation) -> KeyNumber:
    turn, until_s = found.reorientation, found.motion.bodies[BODY_1].t_s[-1]
    note = f"of body 1, from the release to {until_s:.2f} s"
    if turn.bridged:
        note += "; samples of its gyro are missing and were bridged"
    return _number("Reorientation", np.rad2deg(turn.angle_rad), np.rad2deg(turn.std_rad), "deg", note)


def _error(label: str, error: AttitudeError) -> KeyNumber:
    """Norm of the final Euler angles' error. Its std is that along the error, which tells how sure the norm is."""
    norm = error.final_norm_rad
    along = error.final_rad / norm if norm > 0.0 else np.zeros(3)
    std = float(np.sqrt(along @ error.covariance @ along)) if norm > 0.0 else float("nan")
    note = f"at the end, {distance_words(error)}; rms {significant(np.rad2deg(error.rms_rad), 2)} deg"
    return _number(label, np.rad2deg(norm), np.rad2deg(std), "deg", note)


def _largest_correction(found: Evaluation) -> KeyNumber:
    fit = found.explained.fit
    of_com = [index for index, kind in enumerate(fit.offsets.kinds) if kind == "com"]
    if not of_com:
        return _number("Largest CoM correction", float("nan"), None, "mm", "none was free")
    greatest = max(of_com, key=lambda index: abs(fit.values[index]))
    worth = worth_of(found)
    note = fit.offsets.names[greatest] + ("; it stopped at its bound" if fit.at_bound[greatest] else "")
    if worth != "to be made":
        note += (
            "; no correction is called for"
            if worth == "not called for"
            else "; withheld: change nothing by it"
        )
    return _number("Largest CoM correction", fit.values[greatest], fit.std[greatest], "mm", note)


def _initial_rates(found: Evaluation) -> Iterator[KeyNumber]:
    initial = found.initial_rates[BODY_1]
    for axis, rate, std in zip(
        AXES, np.rad2deg(initial.rate_rad_s), np.rad2deg(initial.std_rad_s), strict=True
    ):
        yield _number(
            f"Initial rate {axis}",
            rate,
            std,
            "deg/s",
            "",
            row="Initial rates of body 1, until the first stroke",
        )


def _strokes(found: Evaluation) -> Iterator[KeyNumber]:
    for stroke in found.strokes:
        note = (
            f"joint {stroke.joint}, {number(np.rad2deg(stroke.commanded_rad), 2, signed=True)} deg commanded"
        )
        yield _number(
            f"Stroke {stroke.number}",
            np.rad2deg(stroke.size_rad),
            np.rad2deg(stroke.size_std_rad),
            "deg",
            note,
            row="Strokes",
        )


def _release_velocity(found: Evaluation) -> Iterator[KeyNumber]:
    """Only with laser tracks."""
    velocity = found.release_velocity
    if velocity is None:
        return
    down = velocity.downward
    note = f"downwards; {velocity.downward_judged} the facility's window"
    yield _number("Release velocity", down.value_mm_s, down.std_mm_s, "mm/s", note)
    if velocity.transversal_speed is not None:
        speed = velocity.transversal_speed
        note = f"sideways; {velocity.transversal_judged} what is permitted"
        yield _number("Transversal velocity", speed.value_mm_s, speed.std_mm_s, "mm/s", note)


def _fall(found: Evaluation) -> KeyNumber:
    landing = found.instants.landing
    if landing is None:
        return _number("Fall", float("nan"), None, "s", "no accelerometer felt a landing")
    std = float(np.hypot(landing.std_s, found.instants.release_std_s))
    return _number(
        "Fall", landing.t_s, std, "s", "from the release by the switches to the shock that is felt"
    )


def _change_of_force(found: Evaluation) -> KeyNumber:
    """The greatest of the bodies: what the zero-g output, which is in both windows, cannot hide."""
    changes, stds = found.micro_gravity.changes_g, found.micro_gravity.changes_std_g
    norms = np.linalg.norm(changes, axis=1)
    label = "Micro-gravity"
    if not np.isfinite(norms).any():
        return _number(label, float("nan"), None, MM_S2, "too few samples in one of the quiet windows")
    body = int(np.nanargmax(norms))
    along = changes[body] / norms[body] if norms[body] > 0.0 else np.zeros(3)
    std = float(np.sqrt(((along * stds[body]) ** 2).sum()))
    note = (
        f"{significant(1e3 * norms[body], 2)} · 10⁻³ of gravity: change from before the first stroke to "
        f"after the last, greatest at body {body + 1}"
    )
    return _number(label, MM_S2_PER_G * norms[body], MM_S2_PER_G * std, MM_S2, note)


def _completeness(log: DropLog) -> KeyNumber:
    total = len(log) + log.samples_lost
    note = f"{len(log)} of {total} samples; the recording is {log.verdict}"
    return _number("Recording", 100.0 * len(log) / total, None, "%", note)
