"""The spectrum of the attitude error, which does not end where it began; and what the windows do to any spectrum."""

from __future__ import annotations

import numpy as np

from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.spectra import WINDOWS, compare_spectra, leakage
from tfsat_host.report.contents.chart import AXES, Chart, Line
from tfsat_host.report.contents.charts.attitude import ZYX
from tfsat_host.report.contents.charts.spectrum import spectrum_chart

SHOWN_HZ = 5.0
_FLOOR = 1e-6


def attitude_spectrum_chart(found: Evaluation) -> Chart:
    """Of measured less predicted Euler angles."""
    sides = found.explained.before.error, found.explained.after.error
    before, after = (np.rad2deg(error.euler_zyx_rad) for error in sides)
    return spectrum_chart(
        "attitude_spectrum",
        "Spectrum of the attitude error",
        "deg",
        compare_spectra(sides[0].t_s, before, after, window="Hann"),
        [f"δφ{AXES[axis]}" for axis in ZYX],
        ZYX,
    )


def window_chart(found: Evaluation) -> Chart:
    """What the spectra show of a pure sine."""
    t_s = found.explained.driven.flown.t_s
    shares = {window: leakage(t_s, window, SHOWN_HZ) for window in WINDOWS}
    lines = [
        Line(f"{window} window", np.maximum(share, _FLOOR), 3 if window == "Hann" else 0, "measured")
        for window, (_, share) in shares.items()
    ]
    return Chart(
        "window",
        "What the spectra's windows leak",
        "share of the amplitude",
        tuple(lines),
        "What a spectrum of these samples shows of one sine, by the distance from its frequency.",
        x=shares["rectangular"][0],
        x_label="distance in frequency (Hz)",
        log_y=True,
    )
