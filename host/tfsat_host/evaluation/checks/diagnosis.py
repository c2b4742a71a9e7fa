"""The likely cause of a contradiction: the hypothesis that ends it, if exactly one does.

Hypotheses with more unknown numbers fit better by that alone; Schwarz's criterion (Ann. Statist. 6, 1978) charges each
of them the logarithm of the number of data.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.checks.consistency import Consistency
from tfsat_host.evaluation.checks.hypotheses import Hypothesis, hypotheses
from tfsat_host.evaluation.checks.stated_errors import StatedErrors

ENDS_IT = 2.0
"""Chi-square a number that a true hypothesis may leave: with the floors of `stated_errors`, healthy drops leave 0.5."""
CLEARLY = 10.0
"""Ahead of every other by so much of Schwarz's criterion: "very strong" (Kass and Raftery, JASA 90, 1995)."""
_LOOK = "Look at the samples: tfsat-host decode"
_RIDGE = 1e-10
"""Of columns of length one, so that two equal ones are no error."""


class _Tried(NamedTuple):
    """A hypothesis at its best fit; `left` is its chi-square per degree of freedom."""

    hypothesis: Hypothesis
    numbers: FloatArray
    left: float
    criterion: float

    @property
    def cause(self) -> str:
        return self.hypothesis.cause(self.numbers)


def diagnose(data: Consistency, stated: StatedErrors) -> tuple[str, str]:
    """The cause in words, beginning with `unknown` where no hypothesis ends the contradiction alone; what to do."""
    as_they_are = stated.whitened(data.residual)
    before = float((as_they_are**2).mean())
    tried = sorted((_tried(one, stated) for one in hypotheses(data, stated)), key=lambda one: one.criterion)
    best = tried[0]
    rival = next(one for one in tried if one.hypothesis.family != best.hypothesis.family)
    if best.criterion > float(as_they_are @ as_they_are) - CLEARLY:
        return f"unknown; gyros and angle sensors agree to {before:.3g} times what their errors allow", _LOOK
    unknown = f"unknown; the data contradict each other {before:.3g} times as much as their errors allow"
    if best.left > ENDS_IT:
        return f"{unknown}, with the best explanation ({best.cause}) still {best.left:.3g} times", _LOOK
    if rival.criterion - best.criterion < CLEARLY and rival.left <= ENDS_IT:
        cause = f"{unknown}, and two explanations fit: {best.cause}; or {rival.cause}"
        return cause, best.hypothesis.next_step
    return best.cause, best.hypothesis.next_step


def _tried(one: Hypothesis, stated: StatedErrors) -> _Tried:
    left = stated.whitened(one.residual)
    free = one.jacobian[stated.known]
    # Columns of zeros belong to missing data: they cost no degree of freedom.
    present = np.abs(free).max(axis=0, initial=0.0) > 0.0
    columns = stated.whitening @ free[:, present]
    numbers = np.zeros(free.shape[1])
    size, spent = columns.shape
    if spent:
        length = np.sqrt((columns**2).sum(axis=0))
        columns = columns / length
        found = np.linalg.solve(columns.T @ columns + _RIDGE * np.eye(spent), -columns.T @ left)
        left = left + columns @ found
        numbers[present] = found / length
    chi_square = float(left @ left)
    criterion = chi_square + spent * float(np.log(max(size, 2)))
    return _Tried(one, numbers, chi_square / max(size - spent, 1), criterion)
