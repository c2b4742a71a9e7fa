"""The correction of several drops together, and each drop judged by the others, for tables and JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tfsat_host.evaluation.com_fit.com_fit import ModelFit
from tfsat_host.evaluation.com_fit.cross_validation import CombinedOffsets, LeftOut
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.result.model_result import OFFSETS, Offset, offset_rows, offsets, other_correction
from tfsat_host.quantity import Column, Columns, Table, fields

INDEPENDENT = (
    "Standard deviations of all drops together take the drops as independent: errors of a calibration that they share "
    "are not made smaller."
)
_AGREEMENT = fields("agree chi_square degrees_of_freedom widened_by")
LEFT_OUT: Columns = (
    Column("drop", "left out", of="name"),
    Column("error_before_deg", "nominal", of="error_before"),
    Column("error_after_deg", "fitted to the others", of="error_after"),
    Column("error_own_deg", "fitted to itself", of="error_own"),
    Column("own_off_stds", "deviation (σ)", of="own_off_std", form=".1f"),
    *fields("improved objective_before_kg_m2_s=objective_before objective_after_kg_m2_s=objective_after"),
)


COMPARISON: Columns = (
    Column(
        "offsets",
        of=lambda several: _combined_offsets(several.combined),
        columns=fields("name unit value std"),
    ),
    Column("agreement", of="combined", columns=_AGREEMENT),
    *fields("remarks"),
    Column("cross_validation", of="left_out", columns=LEFT_OUT),
)
"""Of several drops: an object with `combined`, `left_out` and `remarks`, as the arguments of `comparison_tables`."""


def _combined_offsets(combined: CombinedOffsets | None) -> list[Offset] | None:
    if combined is None:
        return None
    return offset_rows(combined.offsets, combined.values, combined.std, np.zeros(len(combined.values), bool))


def comparison_tables(
    evaluations: Mapping[str, Evaluation],
    combined: CombinedOffsets,
    left_out: Sequence[LeftOut],
    remarks: Sequence[str],
) -> list[Table]:
    """Build the tables of the common correction and of each drop judged by the others; drops are by name.

    `remarks` are sentences: cautions about the result.
    """
    fits = {name: evaluation.explained.fit for name, evaluation in evaluations.items()}
    label = "all drops" if combined.agree else "all drops, DOUBTFUL"
    columns = combined_columns(label, combined.values.tolist(), combined.std.tolist(), fits)
    first = next(iter(fits.values()))
    # Only a drop that was left out shows that a correction is the robot's, not the recording's.
    better = sum(prediction.improved for prediction in left_out)
    return [
        Table(
            "Correction of the model, by all drops together",
            columns,
            offsets(first)[: first.offsets.sought],
            " ".join([*remarks, INDEPENDENT]),
        ),
        Table(
            "Cross-validation: each drop with the corrections of the others",
            LEFT_OUT,
            left_out,
            "Attitude error of body 1 at the end, norm. The other drops' corrections made the model better in "
            f"{better} of {len(left_out)} drops. Deviation: own correction − that of the others, rms in σ of the "
            "difference; about 1 where drops agree.",
        ),
    ]


def combined_columns(
    label: str, values: Sequence[float], std: Sequence[float], fits: dict[str, ModelFit]
) -> Columns:
    """Build the columns of the common correction (`label`, values (n,)) and of each drop's own under its name."""
    names = next(iter(fits.values())).offsets.names

    def of(label: str, values: Sequence[float], std: Sequence[float]) -> Column:
        return other_correction(label, dict(zip(names, zip(values, std, strict=True), strict=True)))

    drops = (of(name, fit.values.tolist(), fit.std.tolist()) for name, fit in fits.items())
    return (*OFFSETS[:2], of(label, values, std), *drops)
