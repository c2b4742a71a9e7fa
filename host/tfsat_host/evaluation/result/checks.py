"""The integrity checks."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite

from tfsat_host.evaluation.checks.check import Check
from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.quantity import UNKNOWN, Column, Columns, Table, fields, number

_ORDER = ("failed", "not possible", "passed")


def _with_unit(attribute: str) -> Callable[[Check], str]:
    def text(check: Check) -> str:
        value = getattr(check, attribute)
        return f"{number(value, '.3g')} {check.unit}".rstrip() if isfinite(value) else UNKNOWN

    return text


def _advised(check: Check) -> str:
    """The sentence; of a failure also the likely cause, and what to do."""
    cause = f"Likely cause: {check.cause.rstrip('.')}." if check.cause else ""
    return " ".join(part for part in (check.sentence, cause, check.next_step) if part)


CHECKS: Columns = (
    Column("name", "check"),
    Column("verdict", "verdict"),
    Column("value", "found", words=_with_unit("value")),
    Column("threshold", "at most", words=_with_unit("threshold")),
    Column("sentence", "what it says", words=_advised),
    *fields("unit cause next_step"),
)


def check_table(found: Evaluation) -> Table:
    """What failed stands first; what passed is folded."""
    checks = sorted(found.checks, key=lambda check: _ORDER.index(check.verdict))
    passed = sum(check.verdict == "passed" for check in checks)
    return Table(
        "Integrity checks",
        CHECKS,
        checks,
        "They need no truth: sensors that contradict each other, or free fall, cannot all be right.",
        folded=passed,
        fold=f"{passed} of {len(checks)} checks passed",
    )
