"""What several drops say of the model together, and how the others' corrections do in each of them."""

from __future__ import annotations

from collections.abc import Sequence

from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.model_fit.cross_validation import Combined, LeftOut
from tfsat_host.report.contents.tables.cells import number, with_std
from tfsat_host.report.document import Table

INDEPENDENT = (
    "Standard deviations of all drops together take the drops as independent: errors of a calibration that they share "
    "are not made smaller."
)


def combined_table(
    found: Sequence[Evaluation], names: Sequence[str], combined: Combined, remarks: Sequence[str]
) -> Table:
    """The common correction beside that of each drop.

    Args:
        found: The drops.
        names: What they are called.
        combined: All of them together.
        remarks: What of it to take with care; sentences.
    """
    offsets = found[0].explained.fit.offsets
    rows = [
        [
            name,
            unit,
            with_std(combined.values[i], combined.std[i], signed=True),
            *(with_std(one.explained.fit.values[i], one.explained.fit.std[i], signed=True) for one in found),
        ]
        for i, (name, unit) in enumerate(zip(offsets.names, offsets.units, strict=True))
    ]
    return Table(
        title="Correction of the model, by all drops together",
        columns=["what", "unit", "all drops", *names],
        rows=rows,
        caption=" ".join([*remarks, INDEPENDENT]),
    )


def cross_validation_table(left_out: Sequence[LeftOut], names: Sequence[str]) -> Table:
    """Each drop left out in turn and judged by the others.

    Args:
        left_out: Each drop.
        names: What they are called, in the same order.
    """
    better = sum(one.improved for one in left_out)
    rows = []
    for one, name in zip(left_out, names, strict=True):
        errors = (one.error_before, one.error_after, one.error_own)
        rows.append([name, *(number(error, 3) for error in errors), number(one.own_off_std, 1)])
    return Table(
        title="Each drop by the corrections of the others",
        columns=[
            "left out",
            "model as filed (deg)",
            "with the others' (deg)",
            "with its own (deg)",
            "own off (stds)",
        ],
        rows=rows,
        caption="Attitude error of body 1 at the end, norm. The other drops' corrections made the model better in "
        f"{better} of {len(left_out)} drops. Own off: its own offsets less the others', in standard deviations of that "
        "difference; about 1 where drops agree.",
    )
