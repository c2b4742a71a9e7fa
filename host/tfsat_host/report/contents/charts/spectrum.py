"""Amplitude spectra before and after the correction as a chart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.spectra import Compared, Spectrum
from tfsat_host.report.contents.chart import Chart, Kind, Line
from tfsat_host.report.contents.charts.words import WORDS

FloatArray = NDArray[np.float64]

FREQUENCY = "frequency (Hz)"


def spectrum_chart(
    chart_id: str,
    title: str,
    unit: str,
    compared: Compared,
    names: Sequence[str],
    components: Sequence[int] = (0, 1, 2),
) -> Chart:
    """Without the mean at 0 Hz, which a logarithmic axis has no place for.

    Args:
        chart_id: Of the chart.
        title: For people.
        unit: Of the amplitudes.
        compared: Of three components.
        names: Theirs.
        components: Their colors.
    """
    sides: tuple[tuple[Kind, Spectrum], ...] = (("before", compared.before), ("after", compared.after))
    lines = [
        Line(f"{name} {WORDS[kind]}", _positive(spectrum.amplitude[1:, column]), components[column], kind)
        for column, name in enumerate(names)
        for kind, spectrum in sides
    ]
    return Chart(
        chart_id,
        title,
        f"amplitude ({unit})",
        tuple(lines),
        _caption(compared, unit),
        x=compared.before.frequency_hz[1:],
        x_label=FREQUENCY,
        log_x=True,
        log_y=True,
        band=(float(compared.before.frequency_hz[1]), compared.cutoff_hz),
    )


def _caption(compared: Compared, unit: str) -> str:
    window = "Rectangular" if compared.before.window == "rectangular" else f"{compared.before.window}'s"
    left = f": {100.0 * compared.left:.0f} % are left" if np.isfinite(compared.left) else ""
    return (
        f"{window} window; a sine of amplitude a shows a. Below {compared.cutoff_hz:g} Hz, shaded, "
        f"{compared.rms_before:.3g} {unit} rms before the correction and {compared.rms_after:.3g} after{left}."
    )


def _positive(amplitude: FloatArray) -> FloatArray:
    """A logarithmic axis has no zero."""
    return np.where(amplitude > 0.0, amplitude, np.nan)
