"""One integrity check: what was looked at, what it may be at most, what it means, and which results rest on it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

from scipy.special import chdtri, ndtri

from tfsat_host.next_step import Advice, NextStep

Outcome = Literal["passed", "failed", "not possible"]

FALSE_ALARM = 1e-4
"""Probability that a check fails although its sensors are as stated: with two dozen checks, one healthy drop in 400."""
UNKNOWN = "unknown"
NATS = "nats"
"""Unit of logarithms of evidence."""


class SensorColumn(NamedTuple):
    """One gyro or angle sensor, as a column of the log.

    Attributes:
        name: For people.
        kind: Of sensor.
        column: From 0: a gyro's body in `DropLog.imu_valid`, an angle sensor's place in `DropLog.angle_valid`.
    """

    name: str
    kind: Literal["gyro", "angle sensor"]
    column: int


def gyro_column(body: int) -> SensorColumn:
    """Return the column of a body's gyro; bodies are counted from 0."""
    return SensorColumn(f"gyro of body {body + 1}", "gyro", body)


@dataclass(frozen=True, slots=True)
class Cause:
    """One kind of cause, and how likely it is.

    Attributes:
        kind: Such as `bias step`; `as filed and certified` if nothing is wrong, or `unknown`.
        cause: In words, of its likeliest member.
        probability: Given that one of those that were tried is true.
        next_step: What to do about it.
        sensor: That its likeliest member accuses; None: none or several.
        sensor_share: Share of `probability` whose members accuse this sensor.
    """

    kind: str
    cause: str
    probability: float
    next_step: str
    sensor: SensorColumn | None = None
    sensor_share: float = 1.0


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
        causes: The kinds of cause that were compared for it, the likeliest first; see `cause_evidence.py`.
        protects: The results that are wrong by more than they state where it fails, of `rates`, `attitudes`, `strokes`,
            `offsets` (the correction) and `micro-gravity`; empty where what it finds is in their uncertainty.
    """

    name: str
    verdict: Outcome
    value: float
    threshold: float
    unit: str
    sentence: str
    cause: str | None = None
    next_step: str | None = None
    protects: tuple[str, ...] = ()
    causes: tuple[Cause, ...] = ()

    @property
    def failed(self) -> bool:
        """The data contradict themselves."""
        return self.verdict == "failed"

    @property
    def excess(self) -> float:
        """By what factor errors are greater than stated, roughly."""
        ratio = self.value / self.threshold
        # Evidence goes by the square of the errors.
        return float(ratio**0.5) if self.unit == NATS else ratio

    def caused_by(self, cause: str, next_step: str) -> Check:
        """Return the check with a cause and a next step if it failed, else unchanged."""
        return replace(self, cause=cause, next_step=next_step) if self.failed else self

    def attach_causes(self, causes: tuple[Cause, ...], cause: str, next_step: str) -> Check:
        """Return the check with the causes compared, the likely cause and the next step if it failed."""
        return replace(self.caused_by(cause, next_step), causes=causes) if self.failed else self


class Kind(NamedTuple):
    """What is the same of a check in every drop; see `Check`."""

    name: str
    unit: str
    protects: tuple[str, ...]

    def judge(self, value: float, threshold: float, sentence: str) -> Check:
        """Failed if the value is above the threshold, or no number; its cause is then unknown as yet."""
        # NaN compares false and fails: a check that could not be computed must not pass.
        if value <= threshold:
            return Check(self.name, "passed", value, threshold, self.unit, sentence, protects=self.protects)
        look = Advice("Look at the samples: ", NextStep("decode"))
        return Check(self.name, "failed", value, threshold, self.unit, sentence, UNKNOWN, look, self.protects)

    def not_possible(self, why: str) -> Check:
        """Build the check's result for data that do not allow it."""
        nan = float("nan")
        return Check(self.name, "not possible", nan, nan, self.unit, why, protects=self.protects)


def z_limit(numbers: int) -> float:
    """Compute the limit that the largest of `numbers` normal deviates rarely exceeds.

    The probability of exceeding it is `FALSE_ALARM` at most.
    """
    # Bonferroni: two-sided deviates share the false alarms evenly.
    return float(-ndtri(FALSE_ALARM / (2 * max(numbers, 1))))


def rms_limit(numbers: float) -> float:
    """Compute the limit that the RMS of `numbers` normal deviates exceeds with probability `FALSE_ALARM`."""
    return float((chdtri(numbers, FALSE_ALARM) / numbers) ** 0.5)


def withheld_by(checks: Iterable[Check]) -> dict[str, str]:
    """Return the quantities protected by failed checks, each with the check farthest above its limit."""
    # Ascending, so that the check that is farthest above its limit overwrites the others.
    failed = sorted(
        (check for check in checks if check.failed and check.protects), key=lambda check: check.excess
    )
    return {name: check.name for check in failed for name in check.protects}
