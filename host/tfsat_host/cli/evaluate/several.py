"""Several drops of one robot beside each other, and each judged by the others."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.evaluate.phrases import number, plus_minus, printable, sentences
from tfsat_host.cli.output import Output

if TYPE_CHECKING:
    from tfsat_host.cli.evaluate.one_run import EvaluatedRun
    from tfsat_host.evaluation.model_fit.cross_validation import Combined, LeftOut

Json = dict[str, Any]


class Comparison:
    """Two or more evaluated drops.

    Attributes:
        runs: The drops.
        combined: The offsets of all of them together whose correction is not withheld; None: it is in every drop.
        left_out: For each drop that others can judge, how their offsets do in it.
        doubts: Why the combination is not to be trusted: the drops contradict each other; sentences.
        remarks: These, and which drops correct no other, and why; sentences.
    """

    def __init__(self, runs: Sequence[EvaluatedRun]) -> None:
        from tfsat_host.evaluation.model_fit.cross_validation import (
            combine,
            cross_validate,
            left_aside,
            trusted,
        )

        self.runs = tuple(runs)
        drops = [_fitted(run) for run in runs]
        fits = [drop.fit for drop in trusted(drops)]
        self.combined: Combined | None = combine(fits) if fits else None
        self.left_out: tuple[LeftOut, ...] = cross_validate(drops)
        doubt = "" if self.combined is None else self.combined.doubt()
        self.doubts: tuple[str, ...] = (doubt,) if doubt else ()
        self.remarks: tuple[str, ...] = (*self.doubts, *left_aside(drops))


def _fitted(run: EvaluatedRun) -> Any:
    import numpy as np

    from tfsat_host.evaluation.model_fit.cross_validation import FittedDrop

    explained = run.found.explained

    def error_deg(values: Any) -> float:
        return float(np.rad2deg(explained.driven.beside(values).error.final_norm_rad))

    against = (*_failures(run), *explained.withheld)
    return FittedDrop(str(run.place), explained.driven.flown, explained.fit, error_deg, against)


def _failures(run: EvaluatedRun) -> tuple[str, ...]:
    names = ", ".join(check.name for check in run.found.failed_checks)
    return (f"Checks failed: {names}.",) if names else ()


def comparison_as_dict(found: Comparison) -> Json:
    """For `--json`, under `comparison`."""
    offsets, combined = found.runs[0].found.explained.fit.offsets, found.combined
    return {
        "offsets": None
        if combined is None
        else [
            {"name": name, "unit": unit, "value": float(value), "std": float(std)}
            for name, unit, value, std in zip(
                offsets.names, offsets.units, combined.values, combined.std, strict=True
            )
        ],
        "agreement": None
        if combined is None
        else {
            "agree": combined.agree,
            "chi_square": combined.chi_square,
            "degrees_of_freedom": combined.degrees_of_freedom,
            "widened_by": combined.widened_by,
        },
        "remarks": list(found.remarks),
        "cross_validation": [
            {
                "drop": one.name,
                "error_before_deg": one.error_before,
                "error_after_deg": one.error_after,
                "error_own_deg": one.error_own,
                "improved": one.improved,
                "objective_before_kg_m2_s": one.objective_before,
                "objective_after_kg_m2_s": one.objective_after,
                "own_off_stds": one.own_off_std,
            }
            for one in found.left_out
        ],
    }


def show_table(rows: Sequence[tuple[object, ...]], out: Output) -> None:
    """A line for each drop."""
    columns = ("drop", "verdict", "reorientation / deg", "model off / deg", "corrected / deg")
    out.table(columns, rows, title="All drops")


def row_of(run: EvaluatedRun) -> tuple[object, ...]:
    """The line of a drop that was evaluated."""
    import numpy as np

    turn, explained = run.found.reorientation, run.found.explained
    return (
        printable(run.place),
        run.verdict.level,
        plus_minus(*np.rad2deg([turn.angle_rad, turn.std_rad])),
        number(np.rad2deg(explained.before.error.final_norm_rad), 3),
        number(np.rad2deg(explained.after.error.final_norm_rad), 3),
    )


def show_comparison(found: Comparison, out: Output, numbers: Sequence[int] = ()) -> None:
    """What the drops say together, and of each other; `numbers` are theirs, from 1 by default."""
    from tfsat_host.report.contents.tables.together import INDEPENDENT

    if found.combined is None:
        out.line("No correction of all drops together: that of each drop is withheld.")
    else:
        _show_combined(found, found.combined, numbers or range(1, len(found.runs) + 1), out)
        _show_left_out(found.left_out, out)
    sentences((*found.remarks, INDEPENDENT), out)


def _show_combined(found: Comparison, combined: Combined, numbers: Sequence[int], out: Output) -> None:
    offsets = found.runs[0].found.explained.fit.offsets
    rows: list[tuple[object, ...]] = [
        (name, unit, plus_minus(float(value), float(std), sign=True), *_each(found, index))
        for index, (name, unit, value, std) in enumerate(
            zip(offsets.names, offsets.units, combined.values, combined.std, strict=True)
        )
    ]
    together = "all drops" if combined.agree else "all, DOUBTFUL"
    columns = ("offset", "unit", together, *[f"drop {n}" for n in numbers])
    out.table(columns, rows, title="Corrections of the model")


def _show_left_out(left_out: Sequence[LeftOut], out: Output) -> None:
    out.table(
        ("left out", "model / deg", "with the others' / deg", "with its own / deg", "own off / stds"),
        [
            (
                printable(one.name),
                number(one.error_before, 3),
                number(one.error_after, 3),
                number(one.error_own, 3),
                number(one.own_off_std, 1),
            )
            for one in left_out
        ],
        title="Attitude error at the end with the corrections of the other drops",
    )
    better = sum(one.improved for one in left_out)
    out.line(f"The other drops' corrections made the model better in {better} of {len(left_out)} drops.")


def _each(found: Comparison, index: int) -> list[str]:
    fits = (run.found.explained.fit for run in found.runs)
    return [plus_minus(float(fit.values[index]), float(fit.std[index]), sign=True) for fit in fits]
