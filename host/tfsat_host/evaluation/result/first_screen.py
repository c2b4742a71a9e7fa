"""What decides about the next drop: prediction against measurement, what to change, the strokes in short."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.evaluation.com_fit.model_comparison import BODY_1, ComparedModel
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.result.drop_result import STROKES
from tfsat_host.evaluation.result.key_numbers import attitude_error
from tfsat_host.evaluation.result.model_result import correction_sentences, offsets, withholding_factor
from tfsat_host.quantity import Column, Columns, Quantity, Table, plus_minus

MAX_CHANGES = 3
"""Numbers that are named in one sentence."""
MIN_CHANGE_STDS = 2.0
"""A change that is less sure than this is not named."""
_STROKE_KEYS = ("stroke", "commanded_deg", "size_deg", "start_s", "end_s")


class PredictionRow(NamedTuple):
    """Measurement, or a model's prediction."""

    name: str
    turn: Quantity | str
    error: Quantity | str


_PREDICTION: Columns = (
    Column("name", "body 1"),
    Column("", "reorientation", shown_in="deg", words=lambda row: row.turn),
    Column("", "attitude error", shown_in="deg", words=lambda row: row.error),
)


def prediction_table(evaluation: Evaluation) -> Table:
    """Build the table of the reorientation as measured and as both models predict it, with their attitude errors."""
    turn, until_s = evaluation.reorientation, evaluation.motion.bodies[BODY_1].t_s[-1]
    measured = Quantity(float(np.rad2deg(turn.angle_rad)), float(np.rad2deg(turn.std_rad)), "deg")
    rows = [PredictionRow("measured", measured if evaluation.is_given("attitudes") else "withheld", "")]
    explained = evaluation.explained
    for name, side, is_given in (
        ("nominal model", explained.nominal, evaluation.is_given()),
        ("fitted model", explained.fitted, np.isfinite(withholding_factor(evaluation))),
    ):
        if is_given:
            predicted = Quantity(float(np.rad2deg(_predicted_turn_rad(evaluation, side))), None, "deg")
            rows.append(PredictionRow(name, predicted, attitude_error(name, side.error, is_given=True)))
        else:
            rows.append(PredictionRow(name, "withheld", "withheld"))
    return Table(f"Prediction and measurement, release to {until_s:.2f} s", _PREDICTION, rows)


def _predicted_turn_rad(evaluation: Evaluation, side: ComparedModel) -> float:
    """Return the angle by which body 1 has turned since the release in a model's prediction."""
    # The attitude error compares both as the gyros see them; what is left of the measured angles is predicted.
    predicted_zyx_rad = evaluation.reorientation.euler_zyx_rad - side.error.final_rad
    return float(Rotation.from_euler("ZYX", predicted_zyx_rad).magnitude())


def change_sentence(evaluation: Evaluation) -> str:
    """Return what to change in the robot file, in one sentence with a few numbers, or why nothing."""
    others = correction_sentences(evaluation)
    if others:
        return others[0]
    rows = offsets(evaluation.explained.fit)
    sure = [row for row in rows if abs(row.value) > MIN_CHANGE_STDS * row.std]
    sure.sort(key=lambda row: -abs(row.value) / row.std)
    named = ", ".join(
        f"{row.name} {plus_minus(row.value, row.std, sign=True)} {row.unit}" for row in sure[:MAX_CHANGES]
    )
    if not named:
        return (
            "Correction: no single number significant, all fitted numbers together "
            "(to write them: --corrected-robot FILE)."
        )
    return f"Correction: {named}; {len(rows)} numbers in all (to write them: --corrected-robot FILE)."


def stroke_summary(evaluation: Evaluation) -> Table:
    """Build a line for each stroke: commanded and flown angle, begin and end."""
    columns = tuple(column for column in STROKES if column.key in _STROKE_KEYS)
    remarks = [f"Stroke {stroke.number}: {stroke.remark}" for stroke in evaluation.strokes if stroke.remark]
    return Table("Strokes", columns, evaluation.strokes, " ".join(remarks))
