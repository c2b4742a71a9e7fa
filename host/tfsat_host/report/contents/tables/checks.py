"""The integrity checks."""

from __future__ import annotations

from tfsat_host.evaluation.checks.check import Check
from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.report.contents.tables.cells import NOTHING, significant
from tfsat_host.report.document import Fold, Table

_ORDER = ("failed", "not possible", "passed")


def check_table(found: Evaluation) -> Table:
    """What failed stands first; what passed is folded."""
    checks = sorted(found.checks, key=lambda check: _ORDER.index(check.verdict))
    passed = sum(check.verdict == "passed" for check in checks)
    table = Table(
        title="Integrity checks",
        columns=["check", "verdict", "found", "at most", "what it says"],
        rows=[
            [
                check.name,
                check.verdict,
                _with_unit(check.value, check.unit),
                _with_unit(check.threshold, check.unit),
                " ".join(part for part in (check.sentence, _advice(check)) if part),
            ]
            for check in checks
        ],
        caption="They need no truth: sensors that contradict each other, or free fall, cannot all be right.",
    )
    if passed:
        words = f"{passed} of {len(checks)} checks passed"
        table["fold"] = Fold(first=len(checks) - passed, words=words)
    return table


def _with_unit(value: float, unit: str) -> str:
    shown = significant(value)
    return shown if shown == NOTHING else f"{shown} {unit}".rstrip()


def _advice(check: Check) -> str:
    """Likely cause and what to do, of a failure."""
    cause = f"Likely cause: {check.cause.rstrip('.')}." if check.cause else ""
    return " ".join(part for part in (cause, check.next_step) if part)
