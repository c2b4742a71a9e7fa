"""A study of sensitivity as JSON, and as tables for people."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show_rows
from tfsat_host.quantity import Column, Columns, fields

if TYPE_CHECKING:
    from tfsat_host.plan.statistics import Summary
    from tfsat_host.plan.study import Derivatives, LinearSpread, Study

_SHOWN = 15  # parameters in the table for people; --json has them all
_BAR = 50
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
    Column("rotation_vector_deg_per_unit"),
)
_SOURCES = fields("source kind std linear_deg linear_share share rank_correlation end_rank_correlation")
_KIND_COLUMNS: Columns = (
    Column("kind", "errors of"),
    Column("linear_deg", "give"),
    Column("linear_share", "of the variance", form=".1f", shown_in="percent"),
    Column("share", "by samples", form=".1f", shown_in="percent"),
    Column("most", "most of all"),
    Column("rank_correlation", "rank correlation", form="+.2f"),
)


def result_of(study: Study, found: Derivatives, linear: LinearSpread, summed: Summary) -> dict[str, Any]:
    """The object of `--json`, less what the command knows besides."""
    return {
        "reorientation_deg": found.reorientation_deg,
        "rotation_vector_deg": found.rotation_vector_deg.tolist(),
        "quaternion_xyzw": found.quaternion_xyzw.tolist(),
        "parameters": _parameters(study, found, linear),
        "linear": {
            "reorientation_std_deg": linear.reorientation_deg,
            "rotation_vector_std_deg": linear.rotation_vector_deg.tolist(),
            "attitude_error_rms_deg": linear.attitude_deg,
        },
        "sources": _sources(study, linear, summed),
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
                    "quantity": "end_s" if limit.of_end else "moving_time_s",
                    "limit_s": limit.limit_s,
                    "share": estimate.value,
                    "standard_error": estimate.standard_error,
                }
                for limit, estimate in summed.exceeded
            ],
            "histogram": {
                "edges_deg": summed.histogram_edges_deg.tolist(),
                "samples": [int(count) for count in summed.histogram],
            },
        },
    }


def _parameters(study: Study, found: Derivatives, linear: LinearSpread) -> list[dict[str, Any]]:
    """All parameters, the one that contributes most first; in equal ones the steeper derivative."""
    rows = _rows(
        _PARAMETERS,
        study.parameters.names,
        study.parameters.nominal.tolist(),
        study.sources.parameter_sigma.tolist(),
        study.parameters.units,
        found.of_reorientation.tolist(),
        linear.of_parameters_deg.tolist(),
        found.of_rotation_vector.tolist(),
    )
    return sorted(rows, key=lambda row: (-row["contribution_deg"], -abs(row["reorientation_deg_per_unit"])))


def _sources(study: Study, linear: LinearSpread, summed: Summary) -> list[dict[str, Any]]:
    rows = _rows(
        _SOURCES,
        study.sources.names,
        study.sources.kinds,
        study.sources.sigmas,
        linear.of_sources_deg.tolist(),
        linear.shares.tolist(),
        summed.variance_shares.tolist(),
        summed.rank_correlation.tolist(),
        summed.end_rank_correlation.tolist(),
    )
    return sorted(rows, key=lambda row: -row["linear_share"])


def _rows(columns: Columns, *values: Iterable[Any]) -> list[dict[str, Any]]:
    """JSON of parallel sequences, one for each column."""
    keys = [column.key for column in columns]
    return [dict(zip(keys, row, strict=True)) for row in zip(*values, strict=True)]


def show(result: Mapping[str, Any], out: Output) -> None:
    """What a person wants to know: how sure, because of what, and what to measure first."""
    outputs, samples = result["monte_carlo"]["outputs"], result["monte_carlo"]["samples"]
    turned = outputs["reorientation_deg"]
    out.line(f"Robot      {result['robot']}, followed by its {result['base']}")
    out.line(f"Nominal    {result['reorientation_deg']:.3f} deg")
    out.line(
        f"Expected   {turned['mean']['value']:.3f} deg, standard deviation {turned['std']['value']:.3f} deg "
        f"({result['linear']['reorientation_std_deg']:.3f} to first order)"
    )
    out.line()
    _show_parameters(result["parameters"], out)
    _show_kinds(result, out)
    _show_outputs(outputs, out)
    _show_histogram(result["monte_carlo"]["histogram"], out)
    for row in result["monte_carlo"]["exceeded"]:
        what = (
            "the last stroke ends later than"
            if row["quantity"] == "end_s"
            else "the strokes take longer than"
        )
        out.line(
            f"In {100 * row['share']:.2f} ± {100 * row['standard_error']:.2f} % of the samples {what} "
            f"{row['limit_s']:g} s ({row['limit']})."
        )
    out.line(f"{samples} samples in {result['seconds']:.1f} s, seed {result['monte_carlo']['seed']}.")
    for path in result["files"].values():
        out.line(f"Written    {path}")


def _show_parameters(parameters: Sequence[Mapping[str, Any]], out: Output) -> None:
    show_rows(_PARAMETERS, parameters[:_SHOWN], out)
    if left := len(parameters[_SHOWN:]):
        out.line(f"{left} more parameters give less; --json has them all.")
        out.line()


def _show_kinds(result: Mapping[str, Any], out: Output) -> None:
    """Sources of one kind together: independent, so their squares and their shares add up."""
    rows = []
    for kind, words in _KINDS.items():
        sources = [row for row in result["sources"] if row["kind"] == kind]
        if not any(row["linear_deg"] or row["share"] for row in sources):
            continue
        most = sources[0]
        rows.append(
            {
                "kind": words,
                "linear_deg": math.hypot(*(row["linear_deg"] for row in sources)),
                "linear_share": sum(row["linear_share"] for row in sources),
                "share": sum(row["share"] for row in sources),
                "most": f"{most['source']} ± {most['std']}",
                "rank_correlation": most["rank_correlation"],
            }
        )
    show_rows(_KIND_COLUMNS, sorted(rows, key=lambda row: -float(row["linear_deg"])), out)


def _show_outputs(outputs: Mapping[str, Any], out: Output) -> None:
    percents = [f"{row['percent']:g} %" for row in outputs["reorientation_deg"]["percentiles"]]
    rows = [
        (
            _OUTPUTS[name],
            *(_estimate(spread[of]) for of in ("mean", "std")),
            *(f"{row['value']:.3f}" for row in spread["percentiles"]),
        )
        for name, spread in outputs.items()
    ]
    out.table(("of all samples", "mean", "standard deviation", *percents), rows)


def _show_histogram(histogram: Mapping[str, Any], out: Output) -> None:
    counts, edges = histogram["samples"], histogram["edges_deg"]
    for count, low, high in zip(counts, edges[:-1], edges[1:], strict=True):
        bar = "█" * round(_BAR * count / max(counts))
        out.line(f"{low:9.3f} to {high:8.3f} deg {count:7d} {bar}".rstrip())
    out.line()


def _estimate(estimate: Mapping[str, float]) -> str:
    return f"{estimate['value']:.3f} ± {estimate['standard_error']:.3f}"
