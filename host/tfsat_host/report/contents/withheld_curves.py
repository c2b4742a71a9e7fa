"""Curves of results that a failed check withholds: they are not drawn, and the chart names the check."""

from __future__ import annotations

from dataclasses import replace

from tfsat_host.evaluation.evaluated_drop import SENSED, Evaluation
from tfsat_host.report.contents.chart import WORDS, Chart, Kind

_MEASURED = {
    "euler": ("attitudes",),
    "rates": ("rates",),
    "joints": tuple(sorted(SENSED)),
    "forces": ("micro-gravity",),
}
"""Results that a chart's measured lines show. What adjacent gyros disagree about is the check's own evidence."""


def withhold_curves(chart: Chart, evaluation: Evaluation) -> Chart:
    """Return the chart without the curves that a failed check withholds, and without the numbers of its caption."""
    failed = {
        kind: check
        for kind in dict.fromkeys(line.kind for line in chart.lines)
        if (check := failed_check(evaluation, *_results(chart.id, kind)))
    }
    if not failed:
        return chart
    lines = tuple(line for line in chart.lines if line.kind not in failed)
    kinds = ", ".join(WORDS[kind] for kind in failed) + " " if lines else ""
    checks = ", ".join(f"“{name}”" for name in dict.fromkeys(failed.values()))
    return replace(chart, lines=lines, caption="", withheld=f"{kinds}withheld: {checks} (check failed)")


def failed_check(evaluation: Evaluation, *results: str) -> str | None:
    """Return the check that withholds one of these results; without names, what gyros and angle sensors measure."""
    return next(
        (evaluation.withheld[name] for name in results or sorted(SENSED) if not evaluation.is_given(name)),
        None,
    )


def _results(chart_id: str, kind: Kind) -> tuple[str, ...]:
    """Return the results that lines of this kind show; those that a chart only explains with are none."""
    if kind == "measured":
        return _MEASURED.get(chart_id, ("",))
    if kind == "commanded":
        return ("",)
    # The models are driven by the measured joint angles; the fitted one is the correction as well.
    return (*sorted(SENSED), *(("offsets",) if kind == "after" else ()))
