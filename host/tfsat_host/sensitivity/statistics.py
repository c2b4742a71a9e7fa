"""What the samples of a study say, each figure with its standard error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tfsat_host.dynamics.components import FloatArray

PERCENTILES = (2.5, 16.0, 50.0, 84.0, 97.5)
_LEVEL = 1e-9  # a spread below this share of the values is rounding


@dataclass(frozen=True, slots=True)
class Estimate:
    """A figure and its standard error."""

    value: float
    standard_error: float


@dataclass(frozen=True, slots=True)
class Spread:
    """Of one output.

    Attributes:
        mean, std: With standard errors; that of `std` follows from the fourth moment, not from a normal distribution.
        percentiles: By percent; standard errors from the ranks within which a percentile lies.
    """

    mean: Estimate
    std: Estimate
    percentiles: dict[float, Estimate]


def spread(values: FloatArray) -> Spread:
    """Of samples (s,), s >= 2."""
    count, mean = len(values), float(values.mean())
    squared = (values - mean) ** 2
    std = float(np.sqrt(squared.sum() / (count - 1)))
    fourth = float((squared**2).mean())
    of_std = np.sqrt(max(fourth - std**4, 0.0) / count) / (2.0 * std) if std > 0.0 else 0.0
    ordered = np.sort(values)
    return Spread(
        mean=Estimate(mean, std / np.sqrt(count)),
        std=Estimate(std, float(of_std)),
        percentiles={percent: _percentile(ordered, percent) for percent in PERCENTILES},
    )


def share(hits: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> Estimate:
    """The share of true samples (s,).

    The standard error is the one of all shares that may have led to these samples (Laplace's rule of succession): even
    without a single hit it is not 0.
    """
    count, found = len(hits), int(hits.sum())
    likely = (found + 1) / (count + 2)
    return Estimate(found / count, float(np.sqrt(likely * (1.0 - likely) / (count + 3))))


def variance_shares(output: FloatArray, deviates: FloatArray) -> FloatArray:
    """(d,) share of the variance of `output` (s,) that each of the independent deviates (s, d) explains linearly.

    0 for an output without spread. Independent deviates correlate by chance, by about 1 / s in the square.
    """
    return np.asarray(_correlation(output, deviates) ** 2)


def rank_correlation(output: FloatArray, deviates: FloatArray) -> FloatArray:
    """(d,) Spearman's correlation of `output` (s,) with each of the deviates (s, d); 0 without spread."""
    if _is_level(output):
        return np.zeros(deviates.shape[1])
    return _correlation(_ranks(output), np.column_stack([_ranks(column) for column in deviates.T]))


def _correlation(output: FloatArray, deviates: FloatArray) -> FloatArray:
    if _is_level(output):
        return np.zeros(deviates.shape[1])
    centered, others = output - output.mean(), deviates - deviates.mean(axis=0)
    scale = np.sqrt((centered**2).sum() * (others**2).sum(axis=0))
    return np.asarray((centered[:, None] * others).sum(axis=0) / scale)


def _is_level(values: FloatArray) -> bool:
    return bool(np.ptp(values) <= _LEVEL * np.abs(values).max(initial=0.0))


def _ranks(values: FloatArray) -> FloatArray:
    """(s,) ranks from 0; equal values share the middle of theirs."""
    _, group, counts = np.unique(values, return_inverse=True, return_counts=True)
    middle = np.cumsum(counts) - 0.5 * (counts + 1)
    return np.asarray(middle[group])


def _percentile(ordered: FloatArray, percent: float) -> Estimate:
    count, part = len(ordered), percent / 100.0
    away = np.sqrt(count * part * (1.0 - part))
    low, high = (int(np.clip(round(count * part + by), 0, count - 1)) for by in (-away, away))
    value = float(np.interp(part * (count - 1), np.arange(count), ordered))
    return Estimate(value, float(ordered[high] - ordered[low]) / 2.0)
