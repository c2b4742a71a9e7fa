"""Offset and rate of one clock against the logger's, from events that both have timed.

With t of the clock, logger = offset + t / (1 + rate): a clock that runs faster counts more between two events. The
slope 1 / (1 + rate) of a board's clock has a prior of 1 ± 0.5 %, so that a single event still gives an answer, and
which two dozen microseconds outweigh a thousandfold: a clock that is off by 1 % is measured as that. That of a video
may be anything, as in slow motion, unless somebody knows it.

An event that the others contradict is left out and named. Which ones agree is found by trying the line through each
two of them (and, with the prior's slope, through each one): the most events win, then the least sum of squares.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np

from tfsat_host.arrays import BoolArray, FloatArray

RATE_PRIOR = 5e-3
"""Standard deviation of the rate before anything is measured: the tolerance of a ceramic resonator."""
MIN_SLOPE = 1e-3
"""Time does not run backwards, and no video is a thousand times as fast as what it shows."""
GATE_STDS = 4.0
"""An event further from the line than this is not explained: chance does that once in 16,000."""
_ROUNDS = 5


class SlopePrior(NamedTuple):
    """What is known of a clock's slope before anything is measured."""

    slope: float = 1.0
    std: float = RATE_PRIOR


# A deviation of 1e3 is as good as no prior, and keeps the normal equations regular with one event.
OF_A_BOARD, UNKNOWN_SLOPE = SlopePrior(), SlopePrior(1.0, 1e3)


@dataclass(frozen=True, slots=True)
class Pair:
    """One event on two clocks.

    Attributes:
        event: `release`, `stroke 1` and so on, `landing`.
        clock_s: On the clock that is fitted.
        logger_s: On the logger's, as `DropLog.t_s`.
        std_s: Of both readings together, above zero.
    """

    event: str
    clock_s: float
    logger_s: float
    std_s: float


@dataclass(frozen=True, slots=True)
class Residual:
    """What the fit leaves of one event.

    Attributes:
        pair: The event.
        residual_s: Its time by the logger less its time by the fit.
        std_s: Standard deviation of `residual_s` if the event is what it is taken for.
        used: Whether it took part in the fit; if not, the others contradict it.
    """

    pair: Pair
    residual_s: float
    std_s: float
    used: bool


@dataclass(frozen=True, eq=False)
class ClockFit:
    """A clock as the logger's clock has it.

    Attributes:
        name: Whose clock.
        offset_s: The logger's time at zero of the clock, as `DropLog.t_s`.
        rate_ppm: By how much the clock runs faster than the logger's.
        covariance: (2, 2) of `offset_s` and of the slope 1 / (1 + rate).
        residuals: One for each event, by time.
        findings: What does not fit, one sentence each.
        ambiguous: Other events, as many, lie on a line of another slope as well.
    """

    name: str
    offset_s: float
    rate_ppm: float
    covariance: FloatArray
    residuals: tuple[Residual, ...]
    findings: tuple[str, ...] = ()
    ambiguous: bool = False

    @property
    def slope(self) -> float:
        """Seconds of the logger's clock in one of this clock."""
        return 1.0 / (1.0 + 1e-6 * self.rate_ppm)

    @property
    def offset_std_s(self) -> float:
        """Standard deviation of `offset_s`."""
        return float(np.sqrt(self.covariance[0, 0]))

    @property
    def rate_ppm_std(self) -> float:
        """Standard deviation of `rate_ppm`."""
        return float(1e6 * np.sqrt(self.covariance[1, 1]) / self.slope**2)

    def to_logger_s(self, t_s: FloatArray | float) -> FloatArray:
        """Times of this clock on the scale of `DropLog.t_s`, of the shape of `t_s`."""
        return self.offset_s + np.asarray(t_s, dtype=np.float64) * self.slope


def fit_clock(name: str, pairs: Sequence[Pair], prior: SlopePrior = OF_A_BOARD) -> ClockFit:
    """Fit a clock's offset and rate by weighted least squares over the events that agree, of one at least.

    `name` is what the findings call the clock.
    """
    if not pairs:
        raise ValueError("a clock needs an event that both have seen")
    pairs = sorted(pairs, key=lambda pair: pair.logger_s)
    clock, logger, std = np.array([(p.clock_s, p.logger_s, p.std_s) for p in pairs]).T
    # Begin at the largest consensus: least squares over all is bent by a single swapped event.
    agreeing, others = _find_inliers(clock, logger, std, prior)
    judged = _judge(clock, logger, std, agreeing, prior)
    # Admit and drop events by the gate of the current line, until the set is stable.
    for _ in range(_ROUNDS):
        if not judged.within.any() or (judged.within == judged.used).all():
            break
        judged = _judge(clock, logger, std, judged.within, prior)
    residuals = tuple(
        Residual(pair, *row)
        for pair, *row in zip(
            pairs, judged.residual.tolist(), judged.residual_std.tolist(), judged.used.tolist(), strict=True
        )
    )
    offset, slope = judged.line.tolist()
    return ClockFit(
        name,
        offset,
        1e6 * (1.0 / slope - 1.0),
        judged.covariance,
        residuals,
        _findings(residuals),
        # A board's prior slope decides between sets of equal size; without a prior nothing does.
        ambiguous=others and prior is UNKNOWN_SLOPE,
    )


class _LineFit(NamedTuple):
    """A line through the events in use, and what it leaves of all n."""

    used: BoolArray
    line: FloatArray
    covariance: FloatArray
    residual: FloatArray
    residual_std: FloatArray
    within: BoolArray


def _judge(
    clock: FloatArray, logger: FloatArray, std: FloatArray, is_used: BoolArray, prior: SlopePrior
) -> _LineFit:
    line, covariance = _solve(clock[is_used], logger[is_used], std[is_used], prior)
    # Of a used event the fit has taken a part of the error over; of another it adds its own.
    of_line = _line_variance(clock, covariance)
    # The floor keeps the deviation positive where an event determines the line all by itself.
    residual_std = np.sqrt(np.where(is_used, np.maximum(std**2 - of_line, 1e-2 * std**2), std**2 + of_line))
    residual = logger - line[0] - line[1] * clock
    return _LineFit(
        is_used, line, covariance, residual, residual_std, np.abs(residual) <= GATE_STDS * residual_std
    )


def _solve(
    clock: FloatArray, logger: FloatArray, std: FloatArray, prior: SlopePrior
) -> tuple[FloatArray, FloatArray]:
    """(2,) offset and slope with the slope's prior, and their covariance; about the mean, to lose no digits."""
    weight = std**-2
    # About the weighted mean, offset and slope are uncorrelated, and large clock readings cancel.
    mean = float(weight @ clock / weight.sum())
    away = clock - mean
    slope_information = float(weight @ away**2) + prior.std**-2
    residual = logger - prior.slope * away
    slope = max(prior.slope + float(weight @ (away * residual)) / slope_information, MIN_SLOPE)
    at_mean = float(weight @ (logger - slope * away) / weight.sum())
    of_mean, of_slope = 1.0 / float(weight.sum()), 1.0 / slope_information
    # Carry the uncorrelated pair over to the offset at zero of the clock and the slope.
    covariance = np.array([[of_mean + mean**2 * of_slope, -mean * of_slope], [-mean * of_slope, of_slope]])
    return np.array([at_mean - slope * mean, slope]), covariance


def _line_variance(clock: FloatArray, covariance: FloatArray) -> FloatArray:
    variance = covariance[0, 0] + 2.0 * clock * covariance[0, 1] + clock**2 * covariance[1, 1]
    return np.asarray(np.maximum(variance, 0.0))


def _find_inliers(
    clock: FloatArray, logger: FloatArray, std: FloatArray, prior: SlopePrior
) -> tuple[BoolArray, bool]:
    """(n,) the events that one line explains; whether another line explains others, as many."""
    best, best_score = np.ones(len(clock), bool), (0, -np.inf)
    sets: set[tuple[bool, ...]] = set()
    # Exhaustive search over minimal sets of one or two events: there are few, no sampling is needed.
    for i, k in [*((i, i) for i in range(len(clock))), *combinations(range(len(clock)), 2)]:
        # Two events at the same reading define no slope: one of them has to do, with the prior.
        ends = np.array([i, k]) if clock[k] != clock[i] else np.array([i])
        line, covariance = _solve(clock[ends], logger[ends], std[ends], prior)
        agree = _within(line, covariance, clock, logger, std)
        if not agree.any():
            continue
        # A line through two events may pass near others that it cannot pass near all at once.
        again, covariance = _solve(clock[agree], logger[agree], std[agree], prior)
        agree &= _within(again, covariance, clock, logger, std)
        scaled_residual = (logger - again[0] - again[1] * clock)[agree] / std[agree]
        # Most inliers win; of as many, the least cost, that of the slope's prior included.
        score = (
            int(agree.sum()),
            -float(scaled_residual @ scaled_residual) - float(((again[1] - prior.slope) / prior.std) ** 2),
        )
        sets.add(tuple(agree.tolist()))
        if score > best_score:
            best, best_score = agree, score
    # A second set of the same size means that the majority is not unique.
    return best, sum(sum(inliers) == best_score[0] for inliers in sets) > 1


def _within(
    line: FloatArray, covariance: FloatArray, clock: FloatArray, logger: FloatArray, std: FloatArray
) -> BoolArray:
    """(n,) whether each event is explained by a line that is known so well."""
    spread = np.sqrt(std**2 + _line_variance(clock, covariance))
    return np.asarray(np.abs(logger - line[0] - line[1] * clock) <= GATE_STDS * spread)


def _findings(residuals: tuple[Residual, ...]) -> tuple[str, ...]:
    """Format a sentence for each event that the others contradict, or for two events that were swapped."""
    left_out = [residual for residual in residuals if not residual.used]
    findings = []
    while left_out:
        residual = left_out.pop(0)
        # Two events that each lie where the other is expected were exchanged when they were read off.
        other = next((other for other in left_out if _are_swapped(residual, other)), None)
        if other is not None:
            left_out.remove(other)
            findings.append(
                f"{residual.pair.event.capitalize()} and {other.pair.event} seem to be swapped: exchanged, both fit."
            )
            continue
        late = "late" if residual.residual_s > 0.0 else "early"
        findings.append(
            f"{residual.pair.event.capitalize()} is {1e3 * abs(residual.residual_s):.3g} ms too {late} "
            "for the other events, "
            f"which place it within {1e3 * GATE_STDS * residual.std_s:.2g} ms: it was left out."
        )
    return tuple(findings)


def _are_swapped(residual: Residual, other: Residual) -> bool:
    """Return whether each of two events lies where the other is expected."""
    apart = other.pair.logger_s - residual.pair.logger_s
    return abs(residual.residual_s + apart) <= GATE_STDS * max(residual.std_s, other.std_s) and abs(
        other.residual_s - apart
    ) <= GATE_STDS * max(residual.std_s, other.std_s)
