"""One panel: lines of a chart, strokes behind them, a legend that names colors and styles once."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tfsat_host.report.contents.chart import NORM, Chart, Kind, Line
from tfsat_host.report.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

    from tfsat_host.report.document import Event

FloatArray = NDArray[np.float64]

KIND_WORDS: dict[Kind, str] = {
    "measured": "measured",
    "before": "before",
    "after": "after",
    "commanded": "commanded",
}


def draw_lines(
    axes: Axes,
    x: FloatArray,
    lines: Sequence[Line],
    styles: Mapping[Kind, style.LineStyle],
    banded: Collection[Kind] = ("measured", "after"),
) -> None:
    """Lines, and standard deviations of some kinds as bands behind them: of all they would hide each other."""
    for line in lines:
        color, drawn = style.COLORS[line.component], styles[line.kind]
        axes.plot(x, line.values, color=color, ls=drawn.dashes, lw=drawn.width, alpha=drawn.alpha)
        if line.kind in banded and line.std is not None:
            axes.fill_between(
                x, line.values - line.std, line.values + line.std, color=color, alpha=style.STD_ALPHA, lw=0.0
            )


def draw_raw(axes: Axes, x: FloatArray, lines: Sequence[Line]) -> None:
    """Every sample, thin, behind what is made of it."""
    for line in lines:
        color, raw = style.COLORS[line.component], style.RAW
        axes.plot(x, line.values, color=color, lw=raw.width, alpha=raw.alpha, zorder=1.5)


def over_time(axes: Axes, chart: Chart, events: Sequence[Event], window_s: tuple[float, float]) -> None:
    """The axis of time, with the strokes shaded."""
    for event in events:
        if event["kind"] == "stroke" and event["until_s"] is not None:
            axes.axvspan(
                event["t_s"],
                event["until_s"],
                color=style.STROKE_COLOR,
                alpha=style.STROKE_ALPHA,
                lw=0.0,
                zorder=0.5,
            )
    axes.set_xlim(*window_s)
    axes.set_xlabel(chart.x_label)
    axes.set_ylabel(chart.y_label)


def over_frequency(axes: Axes, chart: Chart) -> None:
    """Logarithmic axes, and the band below the cutoff shaded."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    if chart.x is not None:
        axes.set_xlim(float(chart.x[0]), float(chart.x[-1]))
    if chart.band is not None:
        axes.axvspan(*chart.band, color=style.BAND_COLOR, alpha=style.BAND_ALPHA, lw=0.0, zorder=0.5)
    axes.set_xlabel(chart.x_label)
    axes.set_ylabel(chart.y_label)


def legend(
    axes: Axes,
    names: Mapping[int, str],
    kinds: Mapping[Kind, style.LineStyle],
    others: Mapping[str, style.LineStyle] | None = None,
) -> None:
    """Above the panel, where it hides nothing: colors by component, styles by kind; a single kind needs no word.

    Args:
        axes: The panel.
        names: Of the components.
        kinds: Styles of the kinds.
        others: Further styles, such as thick and thin, by their words.
    """
    handles = [_handle(style.COLORS[component], style.PLAIN, name) for component, name in names.items()]
    if len(kinds) > 1:
        handles += [_handle("#555555", drawn, KIND_WORDS[kind]) for kind, drawn in kinds.items()]
    handles += [_handle("#555555", drawn, words) for words, drawn in (others or {}).items()]
    axes.legend(
        handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(handles), borderaxespad=0.1
    )


def components_of(lines: Sequence[Line], names: Sequence[str]) -> dict[int, str]:
    """Those that occur, by name; the norm is the fourth."""
    there = {line.component for line in lines}
    return {
        component: "norm" if component == NORM else names[component]
        for component in range(4)
        if component in there
    }


def _handle(color: str, drawn: style.LineStyle, label: str) -> Line2D:
    from matplotlib.lines import Line2D

    return Line2D([], [], color=color, ls=drawn.dashes, lw=drawn.width, alpha=drawn.alpha, label=label)
