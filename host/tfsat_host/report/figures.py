"""Figures for a paper, in the arrangement of the drop test's own, as files: the same bytes for the same drop.

Columns of a two-column journal; colors that every eye and every printer keeps apart. Needs matplotlib, the extra
`figures`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.plotting import load_matplotlib
from tfsat_host.report.contents.chart import AXES, WORDS, Chart, Kind, Line
from tfsat_host.report.contents.charts import charts_of
from tfsat_host.report.contents.event_marks import EventMark, events_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D


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


BANDED = ("measured", "after")

FORMATS = ("pdf", "png")
MARKER = b"made by tfsat-host report"
"""Stands in every file: how the command knows its own."""
_SHOWN_FROM_S = 0.0
_ANGLES = [f"$\\varphi_{axis}$" for axis in AXES]
_ANGLE_ERRORS = [f"$\\delta\\varphi_{axis}$" for axis in AXES]
_RATES = [f"$\\omega_{axis}$" for axis in AXES]
_RATE_ERRORS = [f"$\\delta\\omega_{axis}$" for axis in AXES]
_MOMENTA = [f"$h_{axis}$" for axis in AXES]
_JOINTS = ["joint 1", "joint 2", "joint 3"]
_LETTERS = "abcd"


@dataclass(frozen=True, eq=False)
class FigureData:
    """What figures are made of.

    Attributes:
        charts: By id, see `charts_of`.
        events: Strokes are shaded.
        t_s: (n,) of the charts over time.
        window_s: What of it is shown.
    """

    charts: Mapping[str, Chart]
    events: Sequence[EventMark]
    t_s: FloatArray
    window_s: tuple[float, float]


def motion_figure(content: FigureData) -> Figure:
    """Draw attitude, rates, joint angles, momentum of the nominal model (the paper's fig. euler_omg)."""
    figure, panels = _panels(2, 2, PAGE_MM, 112.0)
    _draw_panel(panels[0], content, "euler", _ANGLES, _styles("measured", "before", "after"))
    _draw_panel(panels[1], content, "rates", _RATES, _styles("measured"))
    _draw_panel(panels[2], content, "joints", _JOINTS, _styles("measured", "commanded"))
    _draw_momentum(panels[3], content, "before")
    return figure


def momentum_figure(content: FigureData) -> Figure:
    """Draw the momentum above its spectrum, nominal and fitted model (fig. amfft)."""
    figure, panels = _panels(2, 2, PAGE_MM, 112.0)
    sides: tuple[Kind, Kind] = ("before", "after")
    for column, kind in enumerate(sides):
        _draw_momentum(panels[column], content, kind)
        panels[column].set_title(f"({_LETTERS[column]}) {WORDS[kind]}", loc="left")
        spectrum = panels[2 + column]
        _draw_panel(spectrum, content, "momentum_spectrum", _MOMENTA, {kind: SPECTRA["after"]})
    for row in (0, 2):
        # The same scale on both sides: that is what the figure compares.
        low, high = zip(*(panel.get_ylim() for panel in panels[row : row + 2]), strict=True)
        for panel in panels[row : row + 2]:
            panel.set_ylim(min(low), max(high))
    return figure


def rate_error_figure(content: FigureData) -> Figure:
    """Draw the spectrum of the rate error, nominal and fitted model (fig. omgfft)."""
    figure, panels = _panels(1, 1, COLUMN_MM, 66.0)
    _draw_panel(panels[0], content, "rate_spectrum", _RATE_ERRORS, SPECTRA)
    return figure


def attitude_error_figure(content: FigureData) -> Figure:
    """Draw the Euler angles' error over time, nominal and fitted model (fig. deuler)."""
    figure, panels = _panels(1, 1, COLUMN_MM, 66.0)
    styles: dict[Kind, LineStyle] = {"before": OVER_TIME["before"], "after": PLAIN}
    _draw_panel(panels[0], content, "attitude_error", _ANGLE_ERRORS, styles)
    return figure


FIGURES: dict[str, Callable[[FigureData], Figure]] = {
    "motion": motion_figure,
    "momentum": momentum_figure,
    "rate-error": rate_error_figure,
    "attitude-error": attitude_error_figure,
}
"""By the name of their files."""


def _panels(rows: int, columns: int, width_mm: float, height_mm: float) -> tuple[Figure, list[Axes]]:
    """Panels row by row, lettered if there are several."""
    from matplotlib.figure import Figure

    size = (width_mm / MM_PER_INCH, height_mm / MM_PER_INCH)
    # A bare Figure, without pyplot: no backend and no global state.
    figure = Figure(figsize=size, layout="constrained")
    panels = list(np.ravel(figure.subplots(rows, columns, squeeze=False)))
    if len(panels) > 1:
        for letter, panel in zip(_LETTERS, panels, strict=False):
            panel.set_title(f"({letter})", loc="left")
    return figure, panels


def _styles(*kinds: Kind) -> dict[Kind, LineStyle]:
    return {kind: OVER_TIME[kind] for kind in kinds}


def _draw_momentum(axes: Axes, content: FigureData, kind: Kind) -> None:
    """Draw the averaged momentum of a model before all its samples."""
    for line in content.charts["momentum_raw"].of_kind(kind):
        color = COLORS[line.component]
        # Order 1.5 is above matplotlib's patches (1) and below its lines (2).
        axes.plot(content.t_s, line.values, color=color, lw=RAW.width, alpha=RAW.alpha, zorder=1.5)
    _draw_panel(axes, content, "momentum", _MOMENTA, {kind: PLAIN}, {"averaged": PLAIN, "samples": RAW})


def _draw_panel(
    axes: Axes,
    content: FigureData,
    chart_id: str,
    names: Sequence[str],
    styles: Mapping[Kind, LineStyle],
    others: Mapping[str, LineStyle] | None = None,
) -> None:
    """Draw lines of a chart, over time with the strokes shaded, over frequency with the band below the cutoff.

    `names` are of the components to draw, `styles` of the kinds, as far as the chart has them; `others` are
    further styles, such as thick and thin, by their words.
    """
    chart = content.charts[chart_id]
    lines = [line for line in chart.of_kind(*styles) if line.component < len(names)]
    draw_lines(axes, content.t_s if chart.x is None else chart.x, lines, styles)
    if chart.log_x:
        over_frequency(axes, chart)
    else:
        over_time(axes, content.events, content.window_s)
    axes.set_xlabel(chart.x_label)
    axes.set_ylabel(chart.y_label)
    if chart.withheld:
        axes.text(0.5, 0.5, chart.withheld, transform=axes.transAxes, ha="center", va="center", wrap=True)
    components = sorted({line.component for line in lines})
    kinds = {kind: style for kind, style in styles.items() if any(line.kind == kind for line in lines)}
    legend(axes, {component: names[component] for component in components}, kinds, others or {})


def drawn_of(evaluation: Evaluation) -> FigureData:
    """Collect the data from which a drop's figures are drawn."""
    return FigureData(
        charts_of(evaluation),
        events_of(evaluation),
        evaluation.motion.t_s,
        (_SHOWN_FROM_S, evaluation.motion.samples.until_s),
    )


def write_figure(name: str, content: FigureData, file_format: str, path: Path) -> None:
    """Write one of `FIGURES` to a file in one of `FORMATS`."""
    mpl = load_matplotlib()
    # Whatever matplotlibrc a computer has: the figures look the same.
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(RC)
        text = MARKER.decode()
        # Without dates, and without the library's version, which changes nothing that one sees.
        metadata: dict[str, str | None] = {"Software": text}
        if file_format == "pdf":
            metadata = {"Creator": text, "Producer": None, "CreationDate": None}
        FIGURES[name](content).savefig(path, format=file_format, dpi=PNG_DPI, metadata=metadata)


def draw_lines(
    axes: Axes,
    x: FloatArray,
    lines: Sequence[Line],
    styles: Mapping[Kind, LineStyle],
) -> None:
    """Draw lines, and standard deviations of some kinds as bands behind them: of all they would hide each other."""
    for line in lines:
        color, style = COLORS[line.component], styles[line.kind]
        axes.plot(x, line.values, color=color, ls=style.dashes, lw=style.width, alpha=style.alpha)
        if line.kind in BANDED and line.std is not None:
            axes.fill_between(
                x, line.values - line.std, line.values + line.std, color=color, alpha=STD_ALPHA, lw=0.0
            )


def over_time(axes: Axes, events: Sequence[EventMark], window_s: tuple[float, float]) -> None:
    """Format the time axis and shade the strokes."""
    # Spans lie below the lines and their bands.
    for event in events:
        if event.kind == "stroke" and event.until_s is not None:
            axes.axvspan(event.t_s, event.until_s, color=STROKE_COLOR, alpha=STROKE_ALPHA, lw=0.0, zorder=0.5)
    axes.set_xlim(*window_s)


def over_frequency(axes: Axes, chart: Chart) -> None:
    """Format logarithmic axes, and shade the band below the cutoff."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    if chart.x is not None:
        axes.set_xlim(float(chart.x[0]), float(chart.x[-1]))
    if chart.band is not None:
        axes.axvspan(*chart.band, color=BAND_COLOR, alpha=BAND_ALPHA, lw=0.0, zorder=0.5)


def legend(
    axes: Axes,
    names: Mapping[int, str],
    kinds: Mapping[Kind, LineStyle],
    others: Mapping[str, LineStyle],
) -> None:
    """Place the legend above the panel: colors by component, styles by kind; a single kind needs no word.

    `others` are further styles, such as thick and thin, by their words.
    """
    handles = [_handle(COLORS[component], PLAIN, name) for component, name in names.items()]
    if len(kinds) > 1:
        handles += [
            _handle("#555555", style, WORDS[kind].removesuffix(" model")) for kind, style in kinds.items()
        ]
    handles += [_handle("#555555", style, words) for words, style in others.items()]
    axes.legend(
        handles=handles,
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
        ncols=max(len(handles), 1),
        borderaxespad=0.1,
    )


def _handle(color: str, style: LineStyle, label: str) -> Line2D:
    from matplotlib.lines import Line2D

    return Line2D([], [], color=color, ls=style.dashes, lw=style.width, alpha=style.alpha, label=label)
