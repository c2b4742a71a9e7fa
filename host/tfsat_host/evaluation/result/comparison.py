"""What several drops say of the model together, and how the others' corrections do in each of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.model_fit.cross_validation import Combined, LeftOut
from tfsat_host.evaluation.result.model import combined_columns, offsets
from tfsat_host.quantity import Column, Columns, Table, fields, nested, records

INDEPENDENT = (
    "Standard deviations of all drops together take the drops as independent: errors of a calibration that they share "
    "are not made smaller."
)
_AGREEMENT = fields("agree chi_square degrees_of_freedom widened_by")
LEFT_OUT: Columns = (
    Column("drop", "left out", of="name"),
    Column("error_before_deg", "model as filed", of="error_before"),
    Column("error_after_deg", "with the others'", of="error_after"),
    Column("error_own_deg", "with its own", of="error_own"),
    Column("own_off_stds", "own off (stds)", of="own_off_std", form=".1f"),
    *fields("improved objective_before_kg_m2_s=objective_before objective_after_kg_m2_s=objective_after"),
)


def comparison(
    found: Sequence[Evaluation],
    combined: Combined | None,
    left_out: Sequence[LeftOut],
    remarks: Sequence[str],
) -> dict[str, Any]:
    """For JSON; the arguments are those of `comparison_tables`."""
    free = found[0].explained.fit.offsets
    return {
        "offsets": None
        if combined is None
        else [
            {"name": name, "unit": unit, "value": value, "std": std}
            for name, unit, value, std in zip(
                free.names, free.units, combined.values.tolist(), combined.std.tolist(), strict=True
            )
        ],
        "agreement": nested(_AGREEMENT, combined),
        "remarks": list(remarks),
        "cross_validation": records(LEFT_OUT, left_out),
    }


def comparison_tables(
    found: Mapping[str, Evaluation], combined: Combined, left_out: Sequence[LeftOut], remarks: Sequence[str]
) -> list[Table]:
    """The common correction, and each drop judged by the others.

    Args:
        found: The drops by what they are called.
        combined: All of them together.
        left_out: Each drop that others can judge.
        remarks: What of it to take with care; sentences.
    """
    fits = {name: one.explained.fit for name, one in found.items()}
    label = "all drops" if combined.agree else "all drops, DOUBTFUL"
    columns = combined_columns(label, combined.values.tolist(), combined.std.tolist(), fits)
    better = sum(one.improved for one in left_out)
    return [
        Table(
            "Correction of the model, by all drops together",
            columns,
            offsets(next(iter(fits.values()))),
            " ".join([*remarks, INDEPENDENT]),
        ),
        Table(
            "Each drop by the corrections of the others",
            LEFT_OUT,
            left_out,
            "Attitude error of body 1 at the end, norm. The other drops' corrections made the model better in "
            f"{better} of {len(left_out)} drops. Own off: its own offsets less the others', in standard deviations of "
            "that difference; about 1 where drops agree.",
        ),
    ]
