"""The reasons of a verdict as a reader can use them: each once, a failed check's with its cause and cure."""

from __future__ import annotations

from tfsat_host.evaluation.checks.check import Check
from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.verdict import Verdict

NEARLY_ALL = 0.5
"""Of the checks that were possible: no single sensor makes so many fail."""


def reasons_of(found: Evaluation, verdict: Verdict) -> tuple[str, ...]:
    """Sentences.

    Where nearly everything failed at once, the causes that single checks name would mend nothing: then all checks are
    one sentence.

    Args:
        found: One drop.
        verdict: Its verdict.
    """
    failed = {check.sentence: check for check in found.failed_checks}
    possible = sum(check.verdict != "not possible" for check in found.checks)
    if len(found.failed_checks) <= NEARLY_ALL * possible:
        return tuple(_explained(failed[text]) if text in failed else text for text in verdict.reasons)
    everything = (
        f"{len(found.failed_checks)} of {possible} checks failed at once, which no single sensor brings about: most "
        "likely the calibration, the robot file or the order of the bodies is not this robot's."
    )
    return (everything, *(text for text in verdict.reasons if text not in failed))


def _explained(check: Check) -> str:
    """What was found, why, and what to do."""
    parts = [f"{check.name}: {check.sentence}"]
    parts += [f"Likely cause: {check.cause}"] if check.cause else []
    parts += [check.next_step] if check.next_step else []
    return " ".join(part if part.endswith((".", "!", "?")) else f"{part}." for part in parts)
