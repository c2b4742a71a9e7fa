"""One integrity check: what was looked at, what it may be at most, and what it means."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from scipy.special import chdtri, ndtri

Verdict = Literal["passed", "failed", "not possible"]

FALSE_ALARM = 1e-4
"""Probability that a check fails although its sensors are as stated: with two dozen checks, one healthy drop in 400."""
UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class Check:
    """One check of one drop.

    Attributes:
        name: For people, and the same in every drop.
        verdict: `passed`, `failed` or `not possible`.
        value: What was found, in `unit`; NaN if it was not possible.
        threshold: What `value` may be at most.
        unit: Of both.
        sentence: What was found, for people.
        cause: The likely cause of a failure; begins with `unknown` where no hypothesis explains the data; None unless
            it failed.
        next_step: What to do about a failure; None unless it failed.
    """

    name: str
    verdict: Verdict
    value: float
    threshold: float
    unit: str
    sentence: str
    cause: str | None = None
    next_step: str | None = None

    @property
    def failed(self) -> bool:
        """The data contradict themselves."""
        return self.verdict == "failed"

    def caused_by(self, cause: str, next_step: str) -> Check:
        """The same with a cause, if it failed."""
        return replace(self, cause=cause, next_step=next_step) if self.failed else self


def judged(name: str, value: float, threshold: float, unit: str, sentence: str) -> Check:
    """Failed if the value is above the threshold, or no number; its cause is then unknown as yet."""
    if value <= threshold:
        return Check(name, "passed", value, threshold, unit, sentence)
    return Check(
        name, "failed", value, threshold, unit, sentence, UNKNOWN, "Look at the samples: tfsat-host decode"
    )


def not_possible(name: str, unit: str, why: str) -> Check:
    """The data do not allow the check."""
    return Check(name, "not possible", float("nan"), float("nan"), unit, why)


def z_limit(numbers: int) -> float:
    """The greatest of so many normal deviates is above it in `FALSE_ALARM` of all cases at most."""
    return float(-ndtri(FALSE_ALARM / (2 * max(numbers, 1))))


def rms_limit(numbers: float) -> float:
    """The root mean square of so many normal deviates is above it in `FALSE_ALARM` of all cases."""
    return float((chdtri(numbers, FALSE_ALARM) / numbers) ** 0.5)
