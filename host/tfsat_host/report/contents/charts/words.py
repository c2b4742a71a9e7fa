"""How the kinds of lines are called."""

from __future__ import annotations

from tfsat_host.report.contents.chart import Kind

WORDS: dict[Kind, str] = {
    "measured": "measured",
    "before": "model as filed",
    "after": "model corrected",
    "commanded": "commanded",
}
