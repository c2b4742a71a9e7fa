"""A study of sensitivity as a document, as tables for people, and every sample as a row of a CSV file."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import simulation_result
from tfsat_host.output_files import OutputFile, check_may_write, write_all
from tfsat_host.plan.spread import Derivatives, LinearSpread, Summary, outputs_of
from tfsat_host.plan.study import Outcomes, Study
from tfsat_host.quantity import Column, Columns, Table

_SHOWN = 15  # parameters in the table for people; --json has them all
_BAR = 50
_ENOUGH = 100  # samples, for a standard deviation to be compared
_MARKER = b"sample,reorientation_deg,rotation_x_deg,rotation_y_deg,rotation_z_deg,attitude_error_deg"
_KINDS = {
    "mass": "masses",
    "com": "centers of mass",
    "inertia": "inertia tensors",
    "joint_point": "points of joint axes",
    "joint_axis": "directions of joint axes",
    "stroke": "ends of strokes",
    "servo_scale": "scales of servos",
    "servo_speed": "speeds of servos",
}
_OUTPUTS = {
    "reorientation_deg": "reorientation / deg",
    "rotation_x_deg": "rotation vector x / deg",
    "rotation_y_deg": "rotation vector y / deg",
    "rotation_z_deg": "rotation vector z / deg",
    "attitude_error_deg": "angle to the nominal attitude / deg",
    "moving_time_s": "time for the strokes / s",
    "end_s": "end of the last stroke / s",
}
_PARAMETERS: Columns = (
    Column("parameter", "parameter"),
    Column("value", "value", form=".4g"),
    Column("std", "±", form=".2g"),
    Column("unit", "unit"),
    Column("reorientation_deg_per_unit", "derivative of the reorientation / (deg / unit)", form="+.4f"),
    Column("contribution_deg", "gives"),
)
_KIND_COLUMNS: Columns = (
    Column("kind", "errors of"),
    Column("linear_deg", "give"),
    Column("linear_share", "of the variance", form=".1f", shown_in="percent"),
    Column("share", "by samples", form=".1f", shown_in="percent"),
    Column("most", "most of all"),
    Column("rank_correlation", "rank correlation", form="+.2f"),
)


def document(study: Study, derivatives: Derivatives, linear: LinearSpread, summed: Summary) -> dict[str, Any]:
    """Build the `--json` document, without the command's own entries."""
    sources = _rows(
        source=study.sources.names,
        kind=study.sources.kinds,
        std=study.sources.sigmas,
        linear_deg=linear.of_sources_deg,
        linear_share=linear.shares,
        share=summed.variance_shares,
        rank_correlation=summed.rank_correlation,
        end_rank_correlation=summed.end_rank_correlation,
    )
    parameters = _rows(
        parameter=study.parameters.names,
        value=study.parameters.nominal,
        std=study.sources.parameter_sigma,
        unit=study.parameters.units,
        reorientation_deg_per_unit=derivatives.of_reorientation,
        contribution_deg=linear.of_parameters_deg,
        rotation_vector_deg_per_unit=derivatives.of_rotation_vector,
    )
    return {
        "reorientation_deg": derivatives.reorientation_deg,
        "rotation_vector_deg": derivatives.rotation_vector_deg.tolist(),
        "quaternion_xyzw": derivatives.quaternion_xyzw.tolist(),
        # What contributes most first; of equal ones the steeper derivative.
        "parameters": sorted(
            parameters, key=lambda row: (-row["contribution_deg"], -abs(row["reorientation_deg_per_unit"]))
        ),
        "linear": {
            "reorientation_std_deg": linear.reorientation_deg,
            "rotation_vector_std_deg": linear.rotation_vector_deg.tolist(),
            "attitude_error_rms_deg": linear.attitude_deg,
        },
        "sources": sorted(sources, key=lambda row: -row["linear_share"]),
        "monte_carlo": {
            "samples": study.samples,
            "seed": study.seed,
            "outputs": {
                name: {
                    "mean": asdict(spread.mean),
                    "std": asdict(spread.std),
                    "percentiles": [
                        {"percent": percent, **asdict(estimate)}
                        for percent, estimate in spread.percentiles.items()
                    ],
                }
                for name, spread in summed.outputs.items()
            },
            "exceeded": [
                {
                    "limit": limit.name,
                    "quantity": limit.of,
                    "limit_s": limit.limit_s,
                    "share": estimate.value,
                    "standard_error": estimate.standard_error,
                }
                for limit, estimate in summed.exceeded
            ],
            "histogram": {
                "edges_deg": summed.histogram_edges_deg.tolist(),
                "samples": summed.histogram.astype(int).tolist(),
            },
        },
    }


def notices(linear: LinearSpread, summed: Summary, samples: int, error_deg: float) -> list[str]:
    """Return notices where the figures are doubtful, one sentence each.

    They tell of too large an integration error, and of first order differing from the samples by more than
    a quarter.
    """
    sentences = []
    if error_deg > simulation_result.ERROR_DEG:
        sentences.append(
            f"An attitude may be wrong by {error_deg:.2g} deg by the error of the integration: give a lower "
            "--initial-rate, or a maneuver that ends earlier."
        )
    sampled_std = summed.outputs["reorientation_deg"].std
    # First order fails where it differs by a quarter, and by more than four standard errors of chance.
    apart = abs(linear.reorientation_deg - sampled_std.value)
    if samples >= _ENOUGH and apart > 0.25 * sampled_std.value + 4.0 * sampled_std.standard_error:
        sentences.append(
            f"To first order the standard deviation is {linear.reorientation_deg:.3g} deg, by the samples "
            f"{sampled_std.value:.3g}: the errors are too large for first order, go by the samples."
        )
    return sentences


def _rows(**columns: FloatArray | tuple[str, ...]) -> list[dict[str, Any]]:
    """Objects of parallel sequences."""
    values = (column if isinstance(column, tuple) else column.tolist() for column in columns.values())
    return [dict(zip(columns, row, strict=True)) for row in zip(*values, strict=True)]


def lines(result: Mapping[str, Any]) -> Iterator[str | Table]:
    """Yield the report for people: the uncertainty, its sources and what to measure first."""
    monte_carlo = result["monte_carlo"]
    turned = monte_carlo["outputs"]["reorientation_deg"]
    yield f"Robot      {result['robot']}, followed by its {result['base']}"
    yield f"Nominal    {result['reorientation_deg']:.3f} deg"
    yield (
        f"Expected   {turned['mean']['value']:.3f} deg, standard deviation {turned['std']['value']:.3f} deg "
        f"({result['linear']['reorientation_std_deg']:.3f} to first order)"
    )
    yield ""
    hidden_count = len(result["parameters"][_SHOWN:])
    footnote = f"{hidden_count} more parameters give less; --json has them all." if hidden_count else ""
    yield Table("", _PARAMETERS, result["parameters"][:_SHOWN], footnote)
    yield Table("", _KIND_COLUMNS, _kinds(result["sources"]))
    percents = tuple(Column(f"{row['percent']:g}", f"{row['percent']:g} %") for row in turned["percentiles"])
    columns = (
        Column("output", "of all samples"),
        Column("mean", "mean"),
        Column("std", "standard deviation"),
    )
    yield Table(
        "", columns + percents, [_output(name, spread) for name, spread in monte_carlo["outputs"].items()]
    )
    edges, counts = monte_carlo["histogram"]["edges_deg"], monte_carlo["histogram"]["samples"]
    for count, low, high in zip(counts, edges[:-1], edges[1:], strict=True):
        yield f"{low:9.3f} to {high:8.3f} deg {count:7d} {'█' * round(_BAR * count / max(counts))}".rstrip()
    yield ""
    for row in monte_carlo["exceeded"]:
        late = (
            "the last stroke ends later than"
            if row["quantity"] == "end_s"
            else "the strokes take longer than"
        )
        yield (
            f"In {100 * row['share']:.2f} ± {100 * row['standard_error']:.2f} % of the samples {late} "
            f"{row['limit_s']:g} s ({row['limit']})."
        )
    yield f"{monte_carlo['samples']} samples in {result['seconds']:.1f} s, seed {monte_carlo['seed']}."
    yield from (f"Written    {path}" for path in result["files"].values())


def _output(name: str, spread: Mapping[str, Any]) -> dict[str, str | float]:
    estimates = {
        of: f"{spread[of]['value']:.3f} ± {spread[of]['standard_error']:.3f}" for of in ("mean", "std")
    }
    percents = {f"{row['percent']:g}": row["value"] for row in spread["percentiles"]}
    return {"output": _OUTPUTS[name], **estimates, **percents}


def _kinds(sources: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Sources of one kind together: independent, so their squares and their shares add up."""
    rows = []
    for kind, words in _KINDS.items():
        alike = [row for row in sources if row["kind"] == kind]
        # A kind that does nothing to this rotation has no row.
        if any(row["linear_deg"] or row["share"] for row in alike):
            rows.append(
                {
                    "kind": words,
                    "linear_deg": math.hypot(*(row["linear_deg"] for row in alike)),
                    "linear_share": sum(row["linear_share"] for row in alike),
                    "share": sum(row["share"] for row in alike),
                    # Sources come sorted by their share: the first of a kind gives most.
                    "most": f"{alike[0]['source']} ± {alike[0]['std']}",
                    "rank_correlation": alike[0]["rank_correlation"],
                }
            )
    return sorted(rows, key=lambda row: -float(row["linear_deg"]))


def check_samples_file(path: Path, *, force: bool) -> None:
    """Refuses, before anything is computed, a file that this command did not make.

    Raises:
        TfsatError: the file exists, or something is in the way.
    """
    check_may_write(path, marker=_MARKER, force=force)


def write_samples(
    study: Study, outcomes: Outcomes, nominal_xyzw: FloatArray, path: Path, *, force: bool
) -> None:
    """Write one row per sample: its number from 1, its outputs, its parameters with their units.

    Raises:
        TfsatError: the file exists and was not made by this command, or something is in the way.
    """

    def write(target: Path) -> None:
        outputs = outputs_of(outcomes, nominal_xyzw)
        named = zip(study.parameters.names, study.parameters.units, strict=True)
        # Draw the parameters again from the seed, as the chunks did.
        vectors = np.vstack([study.vectors(study.deviates(chunk)) for chunk in range(study.chunks)])
        rows = np.column_stack([*outputs.values(), vectors]).tolist()
        with target.open("w", encoding="utf-8", newline="\n") as file:
            file.write(
                ",".join(["sample", *outputs, *(_column(f"{name} {unit}") for name, unit in named)]) + "\n"
            )
            # `repr` is the shortest decimal that reads back to the same bits.
            file.writelines(f"{sample},{','.join(map(repr, row))}\n" for sample, row in enumerate(rows, 1))

    write_all([OutputFile(path, _MARKER, write)], force=force)


def _column(text: str) -> str:
    """Format a column name that needs no quotes anywhere: `body_1_com_x_mm`."""
    return re.sub(r"[^a-z0-9]+", "_", text.lower().replace("^", "")).strip("_")
