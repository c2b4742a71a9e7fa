"""How the figures look: columns of a two-column journal, colors that every eye and every printer keeps apart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tfsat_host.report.contents.chart import Kind

MM_PER_INCH = 25.4
COLUMN_MM = 89.0
PAGE_MM = 183.0
"""Widths of one column and of two."""
PNG_DPI = 300

VERMILION, GREEN, BLUE, BLACK = "#D55E00", "#009E73", "#0072B2", "#000000"
COLORS = (VERMILION, GREEN, BLUE, BLACK)
"""By component; Okabe and Ito, Color universal design, 2008. As on the page: x, y, z, norm."""
STROKE_COLOR = "#56B4E9"
STROKE_ALPHA = 0.14
BAND_COLOR = "#E69F00"
BAND_ALPHA = 0.16
STD_ALPHA = 0.2

RC: dict[Any, Any] = {
    "font.family": "DejaVu Sans",  # comes with matplotlib: the same everywhere, with Greek
    "font.size": 7.0,
    "axes.titlesize": 7.0,
    "axes.labelsize": 7.0,
    "xtick.labelsize": 6.5,
    "ytick.labelsize": 6.5,
    "legend.fontsize": 6.0,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "axes.grid": True,
    "grid.color": "#d9d9d9",
    "grid.linewidth": 0.4,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "legend.borderpad": 0.1,
    "legend.handlelength": 1.6,
    "legend.handletextpad": 0.5,
    "legend.columnspacing": 0.8,
    "legend.labelspacing": 0.25,
    "pdf.fonttype": 42,  # embedded as TrueType: text stays text
    "axes.formatter.use_mathtext": True,
    "path.simplify": True,
    "svg.hashsalt": "tfsat",
}


@dataclass(frozen=True, slots=True)
class LineStyle:
    """How a line is drawn; widths in points."""

    dashes: str | tuple[float, tuple[float, ...]]
    width: float
    alpha: float = 1.0


OVER_TIME: dict[Kind, LineStyle] = {
    "measured": LineStyle("-", 1.0),
    "before": LineStyle((0.0, (4.0, 1.6)), 0.9),
    "after": LineStyle((0.0, (5.0, 1.2, 1.0, 1.2)), 0.9),
    "commanded": LineStyle((0.0, (1.0, 1.4)), 0.9),
}
SPECTRA: dict[Kind, LineStyle] = {
    "before": LineStyle((0.0, (3.0, 1.0)), 0.7),
    "after": LineStyle("-", 0.6),
}
"""Thin: a spectrum has teeth."""
PLAIN = LineStyle("-", 1.0)
RAW = LineStyle("-", 0.4, 0.45)
"""Every sample, behind its average."""


def inches(millimeters: float) -> float:
    """As matplotlib counts."""
    return millimeters / MM_PER_INCH
