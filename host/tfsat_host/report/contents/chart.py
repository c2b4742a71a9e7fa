"""Lines over a common x: what page and figures draw, as arrays in the units in which people read them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Literal

import numpy as np

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.evaluation.spectra import ComparedSpectra
from tfsat_host.quantity import Column, Columns, fields
from tfsat_host.report.document_rounding import round_line, round_to_digits

Kind = Literal["measured", "before", "after", "commanded"]

TIME = "time after release (s)"
NORM = 3
AXES = "xyz"
FREQUENCY = "frequency (Hz)"
WORDS: dict[Kind, str] = {
    "measured": "measured",
    "before": "nominal model",
    "after": "fitted model",
    "commanded": "commanded",
}
Side = tuple[Kind, FloatArray, FloatArray | None]
"""A kind of line, (n, k) values and their standard deviations."""


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
        withheld: Which lines are not drawn because a check failed, and the check; empty: none.
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
    withheld: str = ""

    def of_kind(self, *kinds: Kind) -> tuple[Line, ...]:
        """Return the lines of these kinds only."""
        return tuple(line for line in self.lines if line.kind in kinds)


def lines_of(
    names: Sequence[str],
    sides: Sequence[Side],
    components: Sequence[int] = (0, 1, 2),
    *,
    by_side: bool = False,
) -> list[Line]:
    """Build a line for each of the k columns and each side, ordered by column or, with `by_side`, by side.

    `names` and `components`, their color indices, are the columns'.
    """
    columns = list(enumerate(names))
    pairs = (
        product(sides, columns) if by_side else ((side, column) for column, side in product(columns, sides))
    )
    return [
        Line(
            f"{name} {WORDS[kind]}",
            values[:, column],
            components[column],
            kind,
            None if std is None else std[:, column],
        )
        for (kind, values, std), (column, name) in pairs
    ]


def spectrum_chart(
    chart_id: str,
    title: str,
    unit: str,
    compared: ComparedSpectra,
    names: Sequence[str],
    components: Sequence[int] = (0, 1, 2),
) -> Chart:
    """Amplitudes before and after the correction, without the mean at 0 Hz: a logarithmic axis has no place for it.

    Three components are compared; `names` and `components`, their color indices, are theirs. `unit` is of the
    amplitudes.
    """
    # Without bin 0, the mean, and without zeros: a logarithmic axis has a place for neither.
    before, after = (
        np.where(spectrum.amplitude[1:] > 0.0, spectrum.amplitude[1:], np.nan)
        for spectrum in (compared.before, compared.after)
    )
    remainder_text = f"; {100.0 * compared.left:.0f} % of it left" if np.isfinite(compared.left) else ""
    return Chart(
        chart_id,
        title,
        f"amplitude ({unit})",
        tuple(lines_of(names, [("before", before, None), ("after", after, None)], components)),
        f"Window: {compared.before.window}; a sine of amplitude a shows a. Rms below {compared.cutoff_hz:g} Hz "
        f"(shaded): {compared.rms_before:.3g} {unit} (nominal model), {compared.rms_after:.3g} {unit} "
        f"(fitted model{remainder_text}).",
        x=compared.before.frequency_hz[1:],
        x_label=FREQUENCY,
        log_x=True,
        log_y=True,
        band=(float(compared.before.frequency_hz[1]), compared.cutoff_hz),
    )


def numbers(values: FloatArray) -> list[Any]:
    """Convert (n, ...) values to lists for JSON, with None for NaN and infinity."""
    # As objects: an array of floats cannot hold None.
    json_values = values.astype(object)
    # Whole numbers without their ".0": a joint that rests is a quarter of a line's text.
    whole = np.isfinite(values) & (values == values.round())
    json_values[whole] = values[whole].astype(np.int64)
    json_values[~np.isfinite(values)] = None
    return list(json_values.tolist())


def pad_rows(rows: BoolArray, values: FloatArray) -> FloatArray:
    """(n, ...) with `values` (m, ...) where m of the n rows are True, NaN elsewhere."""
    padded_values = np.full((len(rows), *values.shape[1:]), np.nan)
    padded_values[rows] = values
    return padded_values


def _rounded_lines(chart: Chart) -> list[Line]:
    """Return the lines with as many digits as a plot can show."""
    rounded = ((line, *round_line(line.values, line.std, log=chart.log_y)) for line in chart.lines)
    return [replace(line, values=values, std=std) for line, values, std in rounded]


_LINE: Columns = (
    *fields("label component kind"),
    Column("values", of=lambda line: numbers(line.values)),
    Column("std", of=lambda line: None if line.std is None else numbers(line.std)),
)
PLOT: Columns = (
    *fields("id title x_label y_label log_x log_y band caption withheld"),
    Column("x", of=lambda chart: None if chart.x is None else round_to_digits(chart.x)),
    Column("series", of=_rounded_lines, columns=_LINE),
)
"""Of a chart, for the page: plots of the same `id` are laid over each other when there are several drops.

Without `x` they are over the drop's `t_s`, and share cursor and zoom.
"""
