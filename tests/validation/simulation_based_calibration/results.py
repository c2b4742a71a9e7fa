"""Ranks of the truth, z and coverage by quantity: the tables of docs/simulation-based-calibration.md."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import binom, kstest, norm

from tests.validation.calibration_proof.robots import Errors
from tests.validation.evaluation_proof.figures import percent
from tests.validation.simulation_based_calibration.drops import QUANTITIES, Judged
from tests.validation.tables import csv_text
from tfsat_host.arrays import FloatArray

P_LEAST = 0.05
Z_RANGE = (0.9, 1.1)
CHANCE = 1e-3
"""Of a coverage outside of its binomial bounds."""
BINS = 20
FIRST_DROPS = 10
"""So many stand one by one in a table, to be computed again."""


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


Drops = Mapping[str, Sequence[Judged]]
"""By the kind of maneuver."""


def cells(drops: Sequence[Judged], quantity: str) -> Errors:
    """(n, k) of n drops and the k values of a quantity."""
    error = np.array([drop.errors[quantity].error for drop in drops])
    return Errors(error, np.array([drop.errors[quantity].std for drop in drops]))


def ranks(errors: Errors) -> FloatArray:
    """(n, k) cumulative probability of the truth."""
    return np.asarray(norm.cdf(-errors.error / errors.std))


def rows(drops: Sequence[Judged]) -> list[Row]:
    """Judge each quantity and return its row."""
    by_name = {name: cells(drops, name) for name in QUANTITIES}
    p_values = {
        name: [kstest(column[np.isfinite(column)], "uniform").pvalue for column in ranks(errors).T]
        for name, errors in by_name.items()
    }
    adjusted = iter(_holm(np.concatenate([np.array(group) for group in p_values.values()])))
    least = {name: min(next(adjusted) for _ in group) for name, group in p_values.items()}
    return [_row(name, errors, least[name]) for name, errors in by_name.items()]


def _holm(p_values: FloatArray) -> FloatArray:
    order = np.argsort(p_values)
    stepped = np.maximum.accumulate(p_values[order] * np.arange(len(p_values), 0, -1))
    adjusted_p = np.empty_like(stepped)
    adjusted_p[order] = np.minimum(stepped, 1.0)
    return adjusted_p


def _row(name: str, errors: Errors, p: float) -> Row:
    is_finite = np.isfinite(errors.error / errors.std)
    z = (errors.error / errors.std)[is_finite]
    rms = float(np.sqrt(np.mean(z**2)))
    half, most = (float((np.abs(z) < norm.ppf(0.5 + share / 2)).mean()) for share in (0.5, 0.95))
    # Values of one drop hang together: chance is judged by the drops.
    drops = len(errors.error)
    bounds = [np.array(binom.interval(1.0 - CHANCE, drops, share)) / drops for share in (0.5, 0.95)]
    within_bounds = all(low <= share <= high for share, (low, high) in zip((half, most), bounds, strict=True))
    met = bool(p > P_LEAST and Z_RANGE[0] <= rms <= Z_RANGE[1] and within_bounds)
    return Row(name, int(is_finite.sum()), p, rms, half, most, met)


def make_tables(drops: Drops) -> dict[str, str]:
    """Return the text of each file by its name: the judgement, the histograms and their pictures."""
    judgement = [
        (
            kind,
            row.name,
            row.values,
            f"{row.p:.2g}",
            f"{row.z:.3f}",
            percent(row.half),
            percent(row.most),
            row.met,
        )
        for kind, judged in drops.items()
        for row in rows(judged)
    ]
    columns = ("maneuver", "quantity", "values", "rank", "z", "50 % hold", "95 % hold", "met")
    first = [
        (kind, seed, *(f"{z:.3f}" for z in list_z(drop)))
        for kind, judged in drops.items()
        for seed, drop in enumerate(judged[:FIRST_DROPS], 1)
    ]
    return {
        "quantities.csv": csv_text(columns, judgement),
        "first-drops.csv": csv_text(("maneuver", "seed", *QUANTITIES), first),
        "ranks.csv": histograms_csv(drops),
        **{f"ranks-{kind.replace(' ', '-')}.svg": picture(judged) for kind, judged in drops.items()},
    }


def list_z(drop: Judged) -> list[float]:
    """Return the rms of each quantity's errors in one drop, in stated standard deviations."""
    drop_errors = (drop.errors[name] for name in QUANTITIES)
    return [float(np.sqrt(np.mean((errors.error / errors.std) ** 2))) for errors in drop_errors]


def describe_campaign(drops: Drops) -> dict[str, object]:
    """Return how many drops and tests there were, and in how many drops something was widened or withheld."""
    every = [drop for judged in drops.values() for drop in judged]
    return {
        "drops of each kind of maneuver, seeds from 1": max(map(len, drops.values())),
        "rank tests": sum(
            cells(judged[:1], name).error.shape[1] for judged in drops.values() for name in QUANTITIES
        ),
        "drops whose certificate was taken to be worse than it says": sum(drop.widened for drop in every),
        "drops in which something was withheld": sum(bool(drop.withheld) for drop in every),
    }


def histograms_csv(drops: Drops) -> str:
    """Format the histograms as CSV: a row for each value with the number of drops in each bin."""
    lines = []
    for kind, judged in drops.items():
        for name in QUANTITIES:
            for k, column in enumerate(ranks(cells(judged, name)).T, 1):
                counts, _ = np.histogram(column[np.isfinite(column)], BINS, (0.0, 1.0))
                lines.append((kind, name, str(k), *map(str, counts.tolist())))
    return csv_text(
        ("maneuver", "quantity", "value", *(f"to {k / BINS:g}" for k in range(1, BINS + 1))), lines
    )


def picture(drops: Sequence[Judged]) -> str:
    """Draw the histograms and the band that 99 % of uniform ones keep to, as SVG."""
    import matplotlib as mpl

    mpl.use("svg")
    mpl.rcParams["svg.hashsalt"] = "tfsat"
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(3, 4, figsize=(11.0, 6.0), sharex=True)
    for name, panel in zip(QUANTITIES, axes.ravel(), strict=True):
        rank = ranks(cells(drops, name))
        counts, edges = np.histogram(rank[np.isfinite(rank)], BINS, (0.0, 1.0))
        expected = counts.sum() / BINS
        # As many independent values as there are drops.
        low, high = np.array(binom.interval(0.99, len(drops), 1.0 / BINS)) * counts.sum() / len(drops)
        panel.axhspan(low / expected, high / expected, color="0.9")
        panel.axhline(1.0, color="0.6", linewidth=0.8)
        panel.stairs(counts / expected, edges, fill=True, color="#4477aa")
        panel.set_title(name, fontsize=9)
        panel.tick_params(labelsize=8)
    figure.supxlabel("rank of the truth", fontsize=9)
    figure.supylabel("drops, 1: as many as in a uniform histogram", fontsize=9)
    figure.tight_layout()
    with io.StringIO() as text:
        figure.savefig(text, format="svg", metadata={"Date": None})
        plt.close(figure)
        return text.getvalue()
