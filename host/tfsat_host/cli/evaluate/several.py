"""Several drops of one robot beside each other, and each judged by the others."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tfsat_host.present.output import Output
from tfsat_host.present.terminal import sentences, show_table
from tfsat_host.quantity import Column, Columns, record

if TYPE_CHECKING:
    from tfsat_host.run.evaluated import EvaluatedRun
    from tfsat_host.run.several import Comparison


def comparison_as_dict(found: Comparison) -> dict[str, Any]:
    """For `--json`, under `comparison`."""
    from tfsat_host.evaluation.result.model import comparison

    return comparison([run.found for run in found.runs], found.combined, found.left_out, found.remarks)


def _angle(key: str, label: str, of: str, std: str = "") -> Column:
    return Column(key, label, of=f"found.{of}", std=f"found.{std}" if std else "")


DROPS: Columns = (
    Column("drop", "drop", of=lambda run: str(run.place)),
    Column("verdict", "verdict", of="verdict.level"),
    _angle("reorientation_deg", "reorientation", "reorientation.angle_rad", "reorientation.std_rad"),
    _angle("before_deg", "model off", "explained.before.error.final_norm_rad"),
    _angle("after_deg", "corrected", "explained.after.error.final_norm_rad"),
)


def row_of(drop: object, run: EvaluatedRun | None) -> dict[str, Any]:
    """The line of a drop; None: it was refused."""
    refused = dict.fromkeys(column.key for column in DROPS) | {"verdict": "failed"}
    return {**(refused if run is None else record(DROPS, run)), "drop": str(drop)}


def show_comparison(found: Comparison, out: Output, numbers: Sequence[int] = ()) -> None:
    """What the drops say together, and of each other; `numbers` are theirs, from 1 by default."""
    from tfsat_host.evaluation.result.model import comparison_tables

    if found.combined is None:
        out.line("No correction of all drops together: that of each drop is withheld.")
        sentences(found.remarks, out)
        return
    names = [f"drop {number}" for number in numbers or range(1, len(found.runs) + 1)]
    drops = {name: run.found for name, run in zip(names, found.runs, strict=True)}
    for table in comparison_tables(drops, found.combined, found.left_out, found.remarks):
        show_table(table, out)
