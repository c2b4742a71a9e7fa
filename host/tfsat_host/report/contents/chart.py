"""Lines over a common x: what page and figures draw, as arrays in the units in which people read them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tfsat_host.report.document import Plot, Series

FloatArray = NDArray[np.float64]

Kind = Literal["measured", "before", "after", "commanded"]

TIME = "time after release (s)"
NORM = 3
AXES = "xyz"


@dataclass(frozen=True, eq=False)
class Line:
    """One line.

    Attributes:
        label: For people; no other line of the chart has the same.
        values: (n,) NaN where there is nothing.
        component: 0 to 2 for x, y, z or joints 1 to 3, 3 for a norm or the fourth of something: the color.
        kind: The style.
        std: (n,) standard deviation, or None.
    """

    label: str
    values: FloatArray
    component: int
    kind: Kind
    std: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class Chart:
    """Some lines.

    Attributes:
        id: Names it in every drop.
        title: For people.
        y_label: With the unit.
        lines: All of the length of `x`, or of the drop's times.
        caption: What one sees.
        x: (n,) or None for the drop's times.
        x_label: With the unit.
        log_x, log_y: Logarithmic axes.
        band: A range of x to point out.
    """

    id: str
    title: str
    y_label: str
    lines: tuple[Line, ...]
    caption: str = ""
    x: FloatArray | None = None
    x_label: str = TIME
    log_x: bool = False
    log_y: bool = False
    band: tuple[float, float] | None = None

    def of_kind(self, *kinds: Kind) -> tuple[Line, ...]:
        """Those lines only."""
        return tuple(line for line in self.lines if line.kind in kinds)


def plot_of(chart: Chart) -> Plot:
    """The same as a part of the document."""
    return Plot(
        id=chart.id,
        title=chart.title,
        x_label=chart.x_label,
        y_label=chart.y_label,
        x=None if chart.x is None else chart.x.tolist(),
        log_x=chart.log_x,
        log_y=chart.log_y,
        band=None if chart.band is None else list(chart.band),
        caption=chart.caption,
        series=[_series(line) for line in chart.lines],
    )


def numbers(values: FloatArray) -> list[float | None]:
    """As JSON has them: None for what is no number."""
    found = values.astype(object)
    found[~np.isfinite(values)] = None
    return list(found.tolist())


def _series(line: Line) -> Series:
    return Series(
        label=line.label,
        values=numbers(line.values),
        std=None if line.std is None else numbers(line.std),
        component=line.component,
        kind=line.kind,
    )


def padded(rows: NDArray[np.bool_], values: FloatArray) -> FloatArray:
    """(n, ...) with `values` (m, ...) where m of the n rows are True, NaN elsewhere."""
    whole = np.full((len(rows), *values.shape[1:]), np.nan)
    whole[rows] = values
    return whole
