"""docs/simulation-based-calibration.md: ranks of the truth, z and coverage, quantity by quantity."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import binom, kstest, norm

from tests.validation.calibration_proof.robots import Errors
from tests.validation.evaluation_proof.tables import csv_text, filled, percent, table
from tests.validation.simulation_based_calibration.drops import QUANTITIES, Judged
from tfsat_host.arrays import FloatArray

P_LEAST = 0.05
Z_RANGE = (0.9, 1.1)
CHANCE = 1e-3
"""Of a coverage outside of its binomial bounds."""
BINS = 20
_TEXT = """
Written by `make sbc-report`; do not edit. {drops} drops, seeds 1 to {drops}: masses, centers of mass, inertias, hinge
points and axes of the robot are drawn from the `[uncertainty]` of its file, the sensors' errors from the certificate's
covariance, each IMU's oscillator, the rates at the release and the maneuver (four strokes of 30 to 75 deg) too.
`evaluate` gets the recording, the file, the certificate and the schedule. If every ± is right, the truth stands at a
rank among draws from what was found that is uniform (S. Talts et al., Validating Bayesian Inference Algorithms with
Simulation-Based Calibration, 2018, arXiv 1804.06788). Posteriors are normal here, so the rank is its cumulative
probability.

Rank: least p of the Kolmogorov-Smirnov tests of a quantity's values, after Holm over all {tests} of the page; wanted
above 0.05. z: rms of the errors in stated standard deviations; wanted 0.9 to 1.1. Hold: how often 50 and 95 % intervals
hold the truth; wanted within what chance does in 99.9 % of cases. In {widened} drops the certificate was taken to be
worse than it says, in {withheld} something was withheld: chance makes a check fail once in ten thousand drops.
"""


@dataclass(frozen=True, slots=True)
class Row:
    """One quantity."""

    name: str
    values: int
    p: float
    z: float
    half: float
    most: float
    met: bool


def cells(drops: Sequence[Judged], quantity: str) -> Errors:
    """(n, k) of n drops and the k values of a quantity."""
    error = np.array([one.errors[quantity].error for one in drops])
    return Errors(error, np.array([one.errors[quantity].std for one in drops]))


def ranks(errors: Errors) -> FloatArray:
    """(n, k) cumulative probability of the truth."""
    return np.asarray(norm.cdf(-errors.error / errors.std))


def rows(drops: Sequence[Judged]) -> list[Row]:
    """Of each quantity, judged."""
    by_name = {name: cells(drops, name) for name in QUANTITIES}
    p_values = {
        name: [kstest(column[np.isfinite(column)], "uniform").pvalue for column in ranks(errors).T]
        for name, errors in by_name.items()
    }
    adjusted = iter(_holm(np.concatenate([np.array(one) for one in p_values.values()])))
    least = {name: min(next(adjusted) for _ in one) for name, one in p_values.items()}
    return [_row(name, errors, least[name]) for name, errors in by_name.items()]


def _holm(p_values: FloatArray) -> FloatArray:
    order = np.argsort(p_values)
    stepped = np.maximum.accumulate(p_values[order] * np.arange(len(p_values), 0, -1))
    found = np.empty_like(stepped)
    found[order] = np.minimum(stepped, 1.0)
    return found


def _row(name: str, errors: Errors, p: float) -> Row:
    known = np.isfinite(errors.error / errors.std)
    z = (errors.error / errors.std)[known]
    rms = float(np.sqrt(np.mean(z**2)))
    half, most = (float((np.abs(z) < norm.ppf(0.5 + share / 2)).mean()) for share in (0.5, 0.95))
    # Values of one drop hang together: chance is judged by the drops.
    drops = len(errors.error)
    bounds = [np.array(binom.interval(1.0 - CHANCE, drops, share)) / drops for share in (0.5, 0.95)]
    held = all(low <= share <= high for share, (low, high) in zip((half, most), bounds, strict=True))
    met = p > P_LEAST and Z_RANGE[0] <= rms <= Z_RANGE[1] and held
    return Row(name, int(known.sum()), p, rms, half, most, met)


def page(drops: Sequence[Judged]) -> str:
    """Text, table and the picture's name."""
    found = rows(drops)
    tests = sum(cells(drops[:1], name).error.shape[1] for name in QUANTITIES)
    text = filled(
        _TEXT.format(
            drops=len(drops),
            tests=tests,
            widened=sum(one.widened for one in drops),
            withheld=sum(bool(one.withheld) for one in drops),
        )
    )
    shown = [
        (
            row.name,
            str(row.values),
            f"{row.p:.2g}",
            f"{row.z:.3f}",
            percent(row.half),
            percent(row.most),
            "yes" if row.met else "**no**",
        )
        for row in found
    ]
    columns = ("quantity", "values", "rank", "z", "50 % hold", "95 % hold", "met")
    return (
        f"# Simulation-based calibration of the evaluation\n\n{text}\n{table(columns, shown)}\n"
        "![Rank histograms](simulation-based-calibration/ranks.svg)\n\n"
        "Each value's histogram: [ranks.csv](simulation-based-calibration/ranks.csv).\n"
    )


def histograms_csv(drops: Sequence[Judged]) -> str:
    """A row a value: how many drops in each of the bins."""
    lines = []
    for name in QUANTITIES:
        for k, column in enumerate(ranks(cells(drops, name)).T, 1):
            counts, _ = np.histogram(column[np.isfinite(column)], BINS, (0.0, 1.0))
            lines.append((name, str(k), *map(str, counts.tolist())))
    return csv_text(("quantity", "value", *(f"to {k / BINS:g}" for k in range(1, BINS + 1))), lines)


def picture(drops: Sequence[Judged]) -> str:
    """The histograms, and the band that 99 % of uniform ones keep to; SVG."""
    import matplotlib as mpl

    mpl.use("svg")
    mpl.rcParams["svg.hashsalt"] = "tfsat"
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(3, 4, figsize=(11.0, 6.0), sharex=True)
    for name, one in zip(QUANTITIES, axes.ravel(), strict=True):
        rank = ranks(cells(drops, name))
        counts, edges = np.histogram(rank[np.isfinite(rank)], BINS, (0.0, 1.0))
        expected = counts.sum() / BINS
        # As many independent values as there are drops.
        low, high = np.array(binom.interval(0.99, len(drops), 1.0 / BINS)) * counts.sum() / len(drops)
        one.axhspan(low / expected, high / expected, color="0.9")
        one.axhline(1.0, color="0.6", linewidth=0.8)
        one.stairs(counts / expected, edges, fill=True, color="#4477aa")
        one.set_title(name, fontsize=9)
        one.tick_params(labelsize=8)
    figure.supxlabel("rank of the truth", fontsize=9)
    figure.supylabel("drops, 1: as many as in a uniform histogram", fontsize=9)
    figure.tight_layout()
    with io.StringIO() as text:
        figure.savefig(text, format="svg", metadata={"Date": None})
        plt.close(figure)
        return text.getvalue()
