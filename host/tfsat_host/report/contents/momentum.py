"""The robot's angular momentum in inertial axes: constant, were model and measurement exact."""

from __future__ import annotations

import numpy as np

from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.model_fit.momentum import (
    PAPER_SIZE,
    Averaged,
    averaged_momentum,
    inertial_momentum,
)
from tfsat_host.evaluation.spectra import compare_spectra
from tfsat_host.report.contents.chart import AXES, Chart, Kind, Side, lines_of, padded, spectrum_chart

PER_KG_M2_S = 1e3
"""Of one kg m²/s, which is one N m s."""
UNIT = "mN m s"
_NAMES = [f"h{axis}" for axis in AXES]


def bodies_of(found: Evaluation) -> tuple[tuple[Kind, Multibody], ...]:
    """The model as its file has it, and corrected."""
    explained = found.explained
    offsets = explained.driven.offsets
    return ("before", offsets.body), ("after", offsets.corrected(explained.fit.values))


def momentum_chart(found: Evaluation) -> Chart:
    """As it is, every sample."""
    flown = found.explained.driven.flown
    rows = found.motion.t_s >= flown.t_s[0]
    sides: list[Side] = [
        (kind, padded(rows, PER_KG_M2_S * inertial_momentum(body, flown)), None)
        for kind, body in bodies_of(found)
    ]
    return Chart(
        "momentum_raw",
        "Angular momentum, every sample",
        f"momentum ({UNIT})",
        tuple(lines_of(_NAMES, sides, by_side=True)),
        "What the moving average is made of: the gyros' noise, and what they show while joints speed up.",
    )


def averaged_momentum_chart(found: Evaluation) -> Chart:
    """By the paper's moving average."""
    averages = dict(averages_of(found))
    sides: list[Side] = [
        (kind, padded(np.isin(found.motion.t_s, average.t_s), PER_KG_M2_S * average.values), None)
        for kind, average in averages.items()
    ]
    cutoff = averages["before"].cutoff_hz
    strayed = [1e6 * float(average.strayed.mean()) for average in averages.values()]
    return Chart(
        "momentum",
        "Angular momentum of all bodies",
        f"momentum ({UNIT})",
        tuple(lines_of(_NAMES, sides, by_side=True)),
        f"In inertial axes, moving average over {PAPER_SIZE} samples (cutoff {cutoff:.1f} Hz). From its first value it "
        f"strays by {strayed[0]:.3g} µN m s on average with the model as filed, by {strayed[1]:.3g} "
        "with the corrected one.",
    )


def averages_of(found: Evaluation) -> tuple[tuple[Kind, Averaged], ...]:
    """The momentum by either model, averaged as in the paper or over what there is."""
    flown = found.explained.driven.flown
    size = min(PAPER_SIZE, len(flown.t_s))
    return tuple((kind, averaged_momentum(body, flown, size)) for kind, body in bodies_of(found))


def momentum_spectrum_chart(found: Evaluation) -> Chart:
    """Of every sample."""
    flown = found.explained.driven.flown
    before, after = (PER_KG_M2_S * inertial_momentum(body, flown) for _, body in bodies_of(found))
    return spectrum_chart(
        "momentum_spectrum",
        "Spectrum of the momentum",
        UNIT,
        compare_spectra(flown.t_s, before, after),
        _NAMES,
    )
