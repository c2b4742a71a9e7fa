"""Rates: of body 1, of what the models miss of it, and of the base beside constant momentum."""

from __future__ import annotations

import numpy as np

from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.model_fit.momentum import unexplained
from tfsat_host.evaluation.model_fit.prediction import BODY_1
from tfsat_host.evaluation.spectra import compare_spectra
from tfsat_host.report.contents.chart import AXES, Chart, FloatArray, Kind, Line, padded
from tfsat_host.report.contents.charts.spectrum import spectrum_chart
from tfsat_host.report.contents.charts.words import WORDS

_NAMES = [f"ω{axis}" for axis in AXES]


def rate_chart(found: Evaluation) -> Chart:
    """Of body 1, by its own gyro."""
    moved, fall = found.motion.bodies[BODY_1], found.motion.samples.fall
    rates = np.rad2deg(padded(fall, moved.rate_rad_s))
    lag = found.motion.lag
    how = "measured against the angle sensors" if lag.measured else "by the data sheet"
    return Chart(
        "rates",
        "Angular velocity of body 1",
        "rate (deg/s)",
        tuple(Line(name, rates[:, axis], axis, "measured") for axis, name in enumerate(_NAMES)),
        f"Body axes. The gyros' delay of {1e3 * lag.delay_s:.2f} ± {1e3 * lag.delay_std_s:.2f} ms, {how}, is taken "
        "off.",
    )


def rate_spectrum_chart(found: Evaluation) -> Chart:
    """Of measured less predicted rate of body 1."""
    sides = found.explained.before.error, found.explained.after.error
    before, after = (np.rad2deg(error.rate_rad_s) for error in sides)
    return spectrum_chart(
        "rate_spectrum",
        "Spectrum of the rate error of body 1",
        "deg/s",
        compare_spectra(sides[0].t_s, before, after),
        [f"δ{name}" for name in _NAMES],
    )


def unexplained_chart(found: Evaluation) -> Chart:
    """What constant momentum does not explain of the base's rate."""
    explained, flown = found.explained, found.explained.driven.flown
    rows = found.motion.t_s >= flown.t_s[0]
    before = unexplained(explained.driven.offsets.body, flown, explained.before.prediction.momentum_kg_m2_s)
    sides: tuple[tuple[Kind, FloatArray], ...] = (
        ("before", before),
        ("after", explained.fit.left_over_rad_s),
    )
    lines = []
    for kind, rates in sides:
        values = np.rad2deg(padded(rows, rates))
        lines += [
            Line(f"{name} {WORDS[kind]}", values[:, axis], axis, kind) for axis, name in enumerate(_NAMES)
        ]
    return Chart(
        "unexplained",
        f"Rate of {found.model.body_names[found.model.base]} that nothing explains",
        "rate (deg/s)",
        tuple(lines),
        "Measured rate less the one that keeps the momentum constant; with the corrected model also less what the "
        f"fit holds for errors of the sensors. What is left varies {explained.fit.excess:.2g} times as much as their "
        "noise.",
    )
