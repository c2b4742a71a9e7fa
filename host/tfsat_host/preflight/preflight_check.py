"""One line of a preflight: what was looked at, and whether the robot may be dropped as far as that goes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from tfsat_host.next_step import Advice, NextStep
from tfsat_host.quantity import Columns, fields

SEE = "See "
"""Begins the next step of a check that waits for another one, whose name follows."""


class GoNoGo(StrEnum):
    """What a check comes to."""

    GO = "go"
    NO_GO = "no-go"
    """What was looked at is wrong."""
    NOT_MADE = "not-made"
    """It could not be looked at: as good as NO-GO, unless the check is optional."""


@dataclass(frozen=True, slots=True)
class PreflightCheck:
    """One check.

    Attributes:
        name: Stable; scripts rely on it. `judge` sets it.
        verdict: See `GoNoGo`.
        sentence: What was found, for a person.
        evidence: The numbers behind it, with units in their names; what JSON can hold.
        next_step: What to do about it, a command to type where there is one; empty if GO.
        optional: By design it does not block a drop when it cannot be made.
    """

    name: str
    verdict: GoNoGo
    sentence: str
    evidence: Mapping[str, Any] = field(default_factory=dict)
    next_step: str = ""
    optional: bool = False

    @property
    def blocks(self) -> bool:
        """Whether it blocks a drop."""
        return self.verdict == GoNoGo.NO_GO or (self.verdict == GoNoGo.NOT_MADE and not self.optional)

    @property
    def follows(self) -> bool:
        """It could not be made because of another check, which its next step names."""
        return self.verdict == GoNoGo.NOT_MADE and self.next_step.startswith(SEE)


CHECK: Columns = fields("name verdict=verdict.value optional blocks sentence evidence next_step")
"""Of a check, for JSON."""


def go(sentence: str, /, **evidence: Any) -> PreflightCheck:
    """Nothing against a drop."""
    return PreflightCheck("", GoNoGo.GO, sentence, evidence)


def no_go(sentence: str, next_step: str, /, **evidence: Any) -> PreflightCheck:
    """Something is wrong."""
    return PreflightCheck("", GoNoGo.NO_GO, sentence, evidence, next_step)


def not_made(reason: str, next_step: str, /, **evidence: Any) -> PreflightCheck:
    """It could not be looked at; `reason` is a sentence."""
    return PreflightCheck("", GoNoGo.NOT_MADE, reason, evidence, next_step)


def join_steps(separator: str, steps: Iterable[str | NextStep]) -> Advice:
    """Join next steps, each once; their commands stay commands."""
    parts = [part for step in dict.fromkeys(steps) for part in (separator, step)]
    return Advice(*parts[1:])


def judge(wrong: Sequence[str], no: str, next_step: str, yes: str, /, **evidence: Any) -> PreflightCheck:
    """NO-GO if something is wrong, named in the sentence `no` where it has {}; GO with the sentence `yes` else."""
    return no_go(no.replace("{}", "; ".join(wrong)), next_step, **evidence) if wrong else go(yes, **evidence)
