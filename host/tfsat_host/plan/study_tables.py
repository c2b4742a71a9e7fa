"""A study of sensitivity as columns: its JSON, one screen for people, and the tables of `--full`."""

from __future__ import annotations

from functools import partial

from tfsat_host.maneuver.schedule import STROKES as SCHEDULED
from tfsat_host.plan.spread import Estimate, Spread
from tfsat_host.plan.study_result import StudyResult
from tfsat_host.quantity import Column, Columns, Table, by_name, columns_of, fields

_MAX_SHOWN_PARAMETERS = 10
_MAX_MEASURED_FIRST = 2
_BAR_COLUMNS = 40
_OUTPUTS = {
    "reorientation_deg": "reorientation / deg",
    "rotation_x_deg": "rotation vector x / deg",
    "rotation_y_deg": "rotation vector y / deg",
    "rotation_z_deg": "rotation vector z / deg",
    "attitude_error_deg": "attitude error / deg",
    "moving_time_s": "time in which joints move / s",
    "end_s": "end of last stroke / s",
}


def _format_measured_first(result: StudyResult) -> str:
    sources = [source for source in result.sources[:_MAX_MEASURED_FIRST] if source.linear_share > 0.0]
    return ", ".join(
        f"{source.source} ± {source.std} ({100.0 * source.linear_share:.0f} % of the variance)"
        for source in sources
    )


FACTS: Columns = (
    Column("mean_deg", "Expected rotation", of="reorientation.mean.value", std="reorientation.std.value"),
    Column("nominal_deg", "Nominal rotation", of="derivatives.reorientation_deg"),
    Column(
        "",
        "Standard deviation",
        words=lambda result: (
            f"{result.reorientation.std.value:.3f} deg by {result.study.samples} samples, "
            f"{result.linear.reorientation_deg:.3f} deg to first order"
        ),
    ),
    Column("", "Measure first", words=_format_measured_first),
    Column(
        "",
        "Robot",
        words=lambda result: (
            f"{result.robot.name} ({result.robot.path.stem}), attitude of {result.robot.body_names[result.robot.base]}"
        ),
    ),
    Column("", "Servos as measured", words=lambda result: str(result.calibration or "")),
    Column("", "Samples", words=lambda result: f"seed {result.study.seed}, {result.seconds:.1f} s"),
    Column("", "Written", words=lambda result: "" if result.path is None else str(result.path)),
)
"""What the first screen says of a study."""
_PARAMETER: Columns = (
    Column("parameter", "parameter"),
    Column("value", "value", form=".4g"),
    Column("std", "±", form=".2g"),
    Column("unit", "unit"),
    Column("reorientation_deg_per_unit", "deg / unit", form="+.4f"),
    Column("contribution_deg", "contributes"),
    *fields("rotation_vector_deg_per_unit"),
)
_SOURCE: Columns = fields(
    "source kind std linear_deg linear_share share rank_correlation end_rank_correlation"
)
_KIND: Columns = (
    Column("kind", "errors of"),
    Column("linear_deg", "give"),
    Column("linear_share", "of the variance", form=".1f", shown_in="percent"),
    Column("share", "by samples", form=".1f", shown_in="percent"),
    Column("", "most of all", words=lambda effect: f"{effect.sources[0].source} ± {effect.sources[0].std}"),
    Column("", "rank correlation", of=lambda effect: effect.sources[0].rank_correlation, form="+.2f"),
)
_ESTIMATE: Columns = fields("value standard_error")
_PERCENTILE: Columns = (
    Column("percent", of=lambda row: row[0]),
    Column("value", of=lambda row: row[1].value),
    Column("standard_error", of=lambda row: row[1].standard_error),
)
_SPREAD: Columns = (
    Column("mean", columns=_ESTIMATE),
    Column("std", columns=_ESTIMATE),
    Column("percentiles", of=lambda spread: list(spread.percentiles.items()), columns=_PERCENTILE),
)
_LIMIT: Columns = (
    Column("limit", "time limit", of=lambda row: row[0].name),
    Column("quantity", of=lambda row: row[0].of),
    Column("limit_s", "at most", of=lambda row: row[0].limit_s, form="g"),
    Column(
        "",
        "samples beyond / %",
        of=lambda row: 100.0 * row[1].value,
        std=lambda row: 100.0 * row[1].standard_error,
    ),
    Column("share", of=lambda row: row[1].value),
    Column("standard_error", of=lambda row: row[1].standard_error),
)
_MONTE_CARLO: Columns = (
    *fields("samples=study.samples seed=study.seed"),
    Column("outputs", of="summary.outputs", columns=by_name(_SPREAD)),
    Column("exceeded", of="summary.exceeded", columns=_LIMIT),
    Column(
        "histogram",
        of="summary",
        columns=(
            *fields("edges_deg=histogram_edges_deg"),
            Column("samples", of=lambda summary: summary.histogram.astype(int)),
        ),
    ),
)
STUDY: Columns = (
    *columns_of("derivatives", fields("reorientation_deg rotation_vector_deg quaternion_xyzw")),
    Column("parameters", columns=_PARAMETER),
    Column(
        "linear",
        columns=fields(
            "reorientation_std_deg=reorientation_deg rotation_vector_std_deg=rotation_vector_deg "
            "attitude_error_rms_deg=attitude_deg"
        ),
    ),
    Column("sources", columns=_SOURCE),
    Column("monte_carlo", of=lambda result: result, columns=_MONTE_CARLO),
    *fields("robot=robot.name"),
    Column("calibration", of=lambda result: result.calibration and str(result.calibration)),
    Column("base", of=lambda result: result.robot.body_names[result.robot.base]),
    Column("schedule", of="schedule.strokes", columns=SCHEDULED),
    *fields("speed_deg_s=schedule.speed_deg_s initial_rate_deg_s"),
    Column("uncertainty", of=lambda result: result.stated.figures()),
    Column("notices", of=lambda result: (*result.schedule_notices, *result.doubts)),
    *fields("seconds integration_error_deg"),
    Column("files", of=lambda result: {} if result.path is None else {"csv": str(result.path)}),
)
"""The `--json` of `tfsat-host sensitivity`."""


def overview_tables(result: StudyResult) -> list[Table]:
    """Return the parameters that matter most, and how many samples keep to the times."""
    hidden_count = len(result.parameters) - _MAX_SHOWN_PARAMETERS
    caption = f"{hidden_count} more parameters contribute less (--json)." if hidden_count > 0 else ""
    return [
        Table("", _PARAMETER, result.parameters[:_MAX_SHOWN_PARAMETERS], caption),
        Table("", _LIMIT, result.summary.exceeded),
    ]


def detail_tables(result: StudyResult) -> list[Table]:
    """Return the kinds of errors, the spread of every output, and the histogram of the rotation angle."""
    output = Column("", "of all samples", of=lambda row: _OUTPUTS[row[0]])
    spread = (
        output,
        Column("", "mean", words=lambda row: _format_estimate(row[1].mean)),
        Column("", "standard deviation", words=lambda row: _format_estimate(row[1].std)),
    )
    quantiles = (
        output,
        *(
            Column("", f"{percent:g} %", of=partial(_percentile, percent))
            for percent in result.reorientation.percentiles
        ),
    )
    counts, edges = result.summary.histogram, result.summary.histogram_edges_deg
    bins = list(zip(edges[:-1], edges[1:], counts, _BAR_COLUMNS * counts / counts.max(), strict=True))
    histogram = (
        Column("", "reorientation / deg", words=lambda row: f"{row[0]:.3f} to {row[1]:.3f}"),
        Column("", "samples", of=lambda row: row[2], form=".0f"),
        Column("", " ", words=lambda row: "█" * round(row[3])),
    )
    outputs = list(result.summary.outputs.items())
    return [
        Table("", _KIND, result.kinds),
        Table("", spread, outputs),
        Table("", quantiles, outputs),
        Table("", histogram, bins),
    ]


def _percentile(percent: float, row: tuple[str, Spread]) -> float:
    return row[1].percentiles[percent].value


def _format_estimate(estimate: Estimate) -> str:
    return f"{estimate.value:.3f} ± {estimate.standard_error:.3f}"
