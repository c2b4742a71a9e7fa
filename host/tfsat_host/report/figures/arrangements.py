"""The paper's figures (section Result): motion, momentum and its spectra, rate error, attitude error."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tfsat_host.report.contents.chart import AXES, Chart, Kind
from tfsat_host.report.figures import style
from tfsat_host.report.figures.panels import (
    components_of,
    draw_lines,
    draw_raw,
    legend,
    over_frequency,
    over_time,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from tfsat_host.report.contents.chart import FloatArray
    from tfsat_host.report.document import Event

_ANGLES = [f"$\\varphi_{axis}$" for axis in AXES]
_ANGLE_ERRORS = [f"$\\delta\\varphi_{axis}$" for axis in AXES]
_RATES = [f"$\\omega_{axis}$" for axis in AXES]
_RATE_ERRORS = [f"$\\delta\\omega_{axis}$" for axis in AXES]
_MOMENTA = [f"$h_{axis}$" for axis in AXES]
_JOINTS = ["joint 1", "joint 2", "joint 3"]
_LETTERS = "abcd"


@dataclass(frozen=True, eq=False)
class Drawn:
    """What figures are made of.

    Attributes:
        charts: By id, see `charts_of`.
        events: Strokes are shaded.
        t_s: (n,) of the charts over time.
        window_s: What of it is shown.
    """

    charts: Mapping[str, Chart]
    events: Sequence[Event]
    t_s: FloatArray
    window_s: tuple[float, float]


def motion_figure(drawn: Drawn) -> Figure:
    """Attitude, rates, joint angles, momentum of the model as filed (the paper's fig. euler_omg)."""
    figure, panels = _panels(2, 2, style.PAGE_MM, 112.0)
    euler, rates, joints = (drawn.charts[name] for name in ("euler", "rates", "joints"))
    _time_panel(panels[0], drawn, euler, _ANGLES, ("measured", "before", "after"))
    _time_panel(panels[1], drawn, rates, _RATES, ("measured",))
    _time_panel(panels[2], drawn, joints, _JOINTS, ("measured", "commanded"))
    _momentum_panel(panels[3], drawn, "before")
    return figure


def momentum_figure(drawn: Drawn) -> Figure:
    """Momentum above its spectrum, before and after the correction (fig. amfft)."""
    figure, panels = _panels(2, 2, style.PAGE_MM, 112.0)
    sides: tuple[Kind, Kind] = ("before", "after")
    for column, kind in enumerate(sides):
        _momentum_panel(panels[column], drawn, kind)
        panels[column].set_title(f"({_LETTERS[column]}) model {kind} correction", loc="left")
        _spectrum_panel(
            panels[2 + column],
            drawn.charts["momentum_spectrum"],
            _MOMENTA,
            (kind,),
            {kind: style.SPECTRA["after"]},
        )
    for row in (0, 2):
        # The same scale on both sides: that is what the figure compares.
        low, high = zip(*(panel.get_ylim() for panel in panels[row : row + 2]), strict=True)
        for panel in panels[row : row + 2]:
            panel.set_ylim(min(low), max(high))
    return figure


def rate_error_figure(drawn: Drawn) -> Figure:
    """Spectrum of the rate error before and after the correction (fig. omgfft)."""
    figure, panels = _panels(1, 1, style.COLUMN_MM, 66.0)
    _spectrum_panel(
        panels[0], drawn.charts["rate_spectrum"], _RATE_ERRORS, ("before", "after"), style.SPECTRA
    )
    return figure


def attitude_error_figure(drawn: Drawn) -> Figure:
    """Euler angles' error over time, before and after the correction (fig. deuler)."""
    figure, panels = _panels(1, 1, style.COLUMN_MM, 66.0)
    chart = drawn.charts["attitude_error"]
    lines = [line for line in chart.lines if line.component < len(AXES)]
    styles: dict[Kind, style.LineStyle] = {"before": style.OVER_TIME["before"], "after": style.PLAIN}
    draw_lines(panels[0], drawn.t_s, lines, styles)
    over_time(panels[0], chart, drawn.events, drawn.window_s)
    legend(panels[0], components_of(lines, _ANGLE_ERRORS), styles)
    return figure


FIGURES: dict[str, Callable[[Drawn], Figure]] = {
    "motion": motion_figure,
    "momentum": momentum_figure,
    "rate-error": rate_error_figure,
    "attitude-error": attitude_error_figure,
}
"""By the name of their files."""


def _panels(rows: int, columns: int, width_mm: float, height_mm: float) -> tuple[Figure, list[Axes]]:
    """Panels row by row, lettered if there are several."""
    from matplotlib.figure import Figure

    size = (style.inches(width_mm), style.inches(height_mm))
    figure = Figure(figsize=size, layout="constrained")
    panels = list(np.ravel(figure.subplots(rows, columns, squeeze=False)))
    if len(panels) > 1:
        for letter, panel in zip(_LETTERS, panels, strict=False):
            panel.set_title(f"({letter})", loc="left")
    return figure, panels


def _time_panel(
    axes: Axes, drawn: Drawn, chart: Chart, names: Sequence[str], kinds: tuple[Kind, ...]
) -> None:
    lines = chart.of_kind(*kinds)
    styles = {kind: style.OVER_TIME[kind] for kind in kinds if chart.of_kind(kind)}
    draw_lines(axes, drawn.t_s, lines, styles)
    over_time(axes, chart, drawn.events, drawn.window_s)
    legend(axes, components_of(lines, names), styles)


def _momentum_panel(axes: Axes, drawn: Drawn, kind: Kind) -> None:
    chart = drawn.charts["momentum"]
    lines = chart.of_kind(kind)
    draw_raw(axes, drawn.t_s, drawn.charts["momentum_raw"].of_kind(kind))
    draw_lines(axes, drawn.t_s, lines, {kind: style.PLAIN})
    over_time(axes, chart, drawn.events, drawn.window_s)
    legend(
        axes,
        components_of(lines, _MOMENTA),
        {kind: style.PLAIN},
        {"averaged": style.PLAIN, "samples": style.RAW},
    )


def _spectrum_panel(
    axes: Axes,
    chart: Chart,
    names: Sequence[str],
    kinds: tuple[Kind, ...],
    styles: Mapping[Kind, style.LineStyle],
) -> None:
    lines = chart.of_kind(*kinds)
    if chart.x is not None:
        draw_lines(axes, chart.x, lines, styles)
    over_frequency(axes, chart)
    legend(axes, components_of(lines, names), styles)
