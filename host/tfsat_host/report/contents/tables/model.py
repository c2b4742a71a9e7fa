"""What of the model should be corrected, what the data cannot tell of it, and the attitude error of either model."""

from __future__ import annotations

import numpy as np

from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.report.contents.correction import correction_sentences
from tfsat_host.report.contents.tables.cells import decimals_of, number, significant, with_std
from tfsat_host.report.document import Table


def offset_table(found: Evaluation) -> Table:
    """Each offset with its standard deviation."""
    fit, swarm = found.explained.fit, found.swarm
    rows = []
    for index, (name, unit) in enumerate(zip(fit.offsets.names, fit.offsets.units, strict=True)):
        std, prior = float(fit.std[index]), float(fit.offsets.prior_std[index])
        rows.append(
            [
                name,
                unit,
                with_std(fit.values[index], std, signed=True),
                f"± {significant(prior)}",
                f"{100.0 * std / prior:.0f} %",
                *([] if swarm is None else [with_std(swarm.values[index], swarm.spread[index], signed=True)]),
            ]
        )
    return Table(
        title="Correction of the model",
        columns=[
            *("what", "unit", "correction", "allowed before", "of that left"),
            *([] if swarm is None else ["paper's swarm ± its spread"]),
        ],
        rows=rows,
        caption=" ".join([*correction_sentences(found), *_stuck(found), *found.identifiability.sentences()]),
    )


def _stuck(found: Evaluation) -> list[str]:
    fit = found.explained.fit
    names = [name for name, at in zip(fit.offsets.names, fit.at_bound, strict=True) if at]
    return [f"Stopped at its bound: {', '.join(names)}."] if names else []


def error_table(found: Evaluation) -> Table:
    """Measured less predicted attitude of body 1 at the end."""
    rows = []
    for name, sides in (("as filed", found.explained.before), ("corrected", found.explained.after)):
        error = sides.error
        final, std = np.rad2deg(error.final_rad), np.rad2deg(error.std_rad[-1])
        digits = decimals_of(float(std.min()))
        rows.append(
            [
                name,
                *(with_std(value, spread, signed=True) for value, spread in zip(final, std, strict=True)),
                number(np.rad2deg(error.final_norm_rad), digits),
                number(np.rad2deg(error.rms_rad), digits),
                ", ".join(number(score, 1, signed=True) for score in error.z_scores),
            ]
        )
    return Table(
        title="Attitude error of the model",
        columns=[
            "model",
            "φz (deg)",
            "φy (deg)",
            "φx (deg)",
            "norm (deg)",
            "rms over time (deg)",
            "z-scores",
        ],
        rows=rows,
        caption="Measured less predicted z-y-x Euler angles of body 1 at the end. z-scores: in units of the standard "
        "deviation, the same order.",
    )
