"""The likely cause of a contradiction: the one hypothesis that ends it, if there is one and only one.

Hypotheses with more unknown numbers fit better by that alone; Schwarz's criterion (Ann. Statist. 6, 1978) charges each
of them the logarithm of the number of data.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.checks.consistency import Consistency
from tfsat_host.evaluation.checks.hypotheses import (
    Hypothesis,
    changed_gyros,
    exchanged_axes,
    exchanged_sensors,
    late_sensors,
    moved_zeros,
    one_left_out,
    other_low_passes,
    reversed_sensors,
    turned_mountings,
    wrong_orders,
)
from tfsat_host.evaluation.checks.stated_errors import StatedErrors

FloatArray = NDArray[np.float64]

ENDS_IT = 2.0
"""Chi-square a number that a true hypothesis may leave: with the floors of `stated_errors`, healthy drops leave 0.5."""
CLEARLY = 10.0
"""Ahead of every other by so much of Schwarz's criterion: "very strong" (Kass and Raftery, JASA 90, 1995)."""

_RIDGE = 1e-10
"""Of columns of length one: two that are the same are then no error."""


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What is likely wrong.

    Attributes:
        cause: In words; begins with `unknown` where no hypothesis ends the contradiction alone.
        next_step: What to do.
        before: Chi-square a number of the data as they are; about 1 or less if all is as stated.
        after: The same by the best hypothesis.
    """

    cause: str
    next_step: str
    before: float
    after: float


@dataclass(frozen=True, eq=False)
class _Tried:
    hypothesis: Hypothesis
    numbers: FloatArray
    chi_square: float
    degrees: int
    criterion: float


def diagnose(of: Consistency, stated: StatedErrors) -> Diagnosis:
    """Tries every hypothesis on the data of one drop."""
    as_they_are = stated.whitened(of.own_vector)
    before = float((as_they_are**2).mean())
    tried = sorted((_tried(one, stated) for one in _hypotheses(of, stated)), key=lambda one: one.criterion)
    best = tried[0]
    rival = next(one for one in tried if one.hypothesis.family != best.hypothesis.family)
    after = best.chi_square / best.degrees
    numbers = f"the data contradict each other {before:.3g} times as much as their errors allow"
    if best.criterion > float(as_they_are @ as_they_are) - CLEARLY:
        cause = f"unknown; gyros and angle sensors agree to {before:.3g} times what their errors allow"
        return Diagnosis(cause, "Look at the samples: tfsat-host decode", before, before)
    if after > ENDS_IT:
        return Diagnosis(
            f"unknown; {numbers}, with the best explanation ({_said(best)}) still {after:.3g} times",
            "Look at the samples: tfsat-host decode",
            before,
            after,
        )
    if rival.criterion - best.criterion < CLEARLY and rival.chi_square / rival.degrees <= ENDS_IT:
        return Diagnosis(
            f"unknown; {numbers}, and two explanations fit: {_said(best)}; or {_said(rival)}",
            best.hypothesis.next_step,
            before,
            after,
        )
    return Diagnosis(_said(best), best.hypothesis.next_step, before, after)


def _hypotheses(of: Consistency, stated: StatedErrors) -> Iterator[Hypothesis]:
    yield from exchanged_axes(of)
    yield from turned_mountings(of)
    yield from wrong_orders(of)
    yield from changed_gyros(of, stated)
    yield from reversed_sensors(of)
    yield from moved_zeros(of)
    yield from exchanged_sensors(of)
    yield from late_sensors(of, stated)
    yield from other_low_passes(of)
    yield from one_left_out(of)


def _tried(one: Hypothesis, stated: StatedErrors) -> _Tried:
    left = stated.whitened(one.left)
    free = one.free[stated.known]
    # Columns of zeros are of data that are missing: no number is unknown for them.
    present = np.abs(free).max(axis=0, initial=0.0) > 0.0
    columns = stated.whitening @ free[:, present]
    numbers = np.zeros(free.shape[1])
    if columns.shape[1]:
        length = np.sqrt((columns**2).sum(axis=0))
        columns = columns / length
        found = np.linalg.solve(columns.T @ columns + _RIDGE * np.eye(columns.shape[1]), -columns.T @ left)
        left = left + columns @ found
        numbers[present] = found / length
    chi_square = float(left @ left)
    size, spent = len(left), columns.shape[1]
    degrees = max(size - spent, 1)
    return _Tried(one, numbers, chi_square, degrees, chi_square + spent * float(np.log(max(size, 2))))


def _said(one: _Tried) -> str:
    return one.hypothesis.said(one.numbers)
