"""docs/faults.md: each fault, the checks that find it, and what the robot does; as rehearsed."""

from __future__ import annotations

from collections.abc import Callable

from tests.paths import DOCS
from tests.rehearsal import days
from tests.rehearsal.days import Day, Days
from tfsat_host.rehearsal.faults.fault import Fault, Moment, Outcome, words_of
from tfsat_host.rehearsal.faults.fault_catalog import FAULTS, GROUPS

PAGE = DOCS / "faults.md"
_MOMENTS = "\n".join(
    ["| moment | |", "| --- | --- |", *(f"| {moment.typed} | {moment.value} |" for moment in Moment)]
)
_HEAD = f"""# Faults

Written by `python -m tests.rehearsal.faults_page`; do not edit. Each row was rehearsed with the firmware's own code;
the tests repeat it. [How to type a fault](rehearsal.md#what-goes-wrong):

    tfsat-host rehearse 59 70 --fault gyro-dead
    tfsat-host rehearse 59 70 --fault gyro-dead@powered
    tfsat-host rehearse 59 70 --fault gyro-swapped --despite-preflight

- **What happens**, in parentheses the default size.
- **When**: the default moment; after it the others that can be given. In the day's order:

{_MOMENTS}

- **Preflight**: the [checks](preflight.md) that say NO-GO; "–": none detects it; "later": it occurs after it.
- **Outcome**, if dropped despite NO-GO. "Flies": all strokes of the maneuver. Recording: complete unless stated; "cut
  off": it has every sample that had reached the card.
- **Reported by**: a board's refusal, a board after the landing, the log (`decode`), the report (`evaluate`, `report`),
  or their refusal to give numbers; a mismatch counts as reported if its cause is named. "–": by none; the results
  stay valid.

| fault | what happens | when | preflight | outcome | reported by |
| --- | --- | --- | --- | --- | --- |
"""
MISMATCHES = (*GROUPS["model-mismatch"], *GROUPS["sensor-mismatch"])
_DIAGNOSES = """
## Evaluation of a mismatch

One drop each, seed 1, default size: the verdict, and the cause that the failed checks name.

| fault | verdict | cause |
| --- | --- | --- |
"""

Checks = Callable[[Fault], tuple[str, ...]]


def page(day_of: Days, no_go: Checks) -> str:
    """Render the page's text.

    Args:
        day_of: Gives the outcome of a fault's day.
        no_go: Gives the checks that forbid the drop if the fault is present before the preflight.
    """
    rows = "".join(row(fault, day_of(fault), no_go) for fault in FAULTS)
    return _HEAD + rows + _DIAGNOSES + "".join(diagnosis(fault, day_of(fault)) for fault in MISMATCHES)


def diagnosis(fault: Fault, day: Day) -> str:
    """Format a mismatch's row in the second table: the evaluation's diagnosis."""
    causes = dict.fromkeys(check["cause"] for check in day.checks.values() if check["cause"])
    level = day.verdict or "refused"
    return f"| `{fault.name}` | {level} | {'; '.join(causes) or '–'} |\n"


def row(fault: Fault, day: Day, no_go: Checks) -> str:
    """Format a fault's row of the table."""
    where = ", ".join(who for who, words in day.screens.items() if fault.noticed and fault.noticed in words)
    own, all_of_it = fault.moment.typed, words_of(fault.outcomes)
    recording_note = ", no recording" if day.log is None else "" if fault.complete else ", recording cut off"
    cells = (
        f"`{fault.name}`",
        fault.what if fault.size is None else f"{fault.what} ({fault.size})",
        own if own == all_of_it else f"{own}; {all_of_it}",
        "later" if fault.preflight is None else ", ".join(f"`{name}`" for name in no_go(fault)) or "–",
        _robot(fault, recording_note),
        where or "–",
    )
    return "| " + " | ".join(cells) + " |\n"


def _robot(fault: Fault, recording_note: str) -> str:
    others = [outcome for outcome in dict.fromkeys(fault.outcomes.values()) if outcome is not fault.outcome]
    when = {
        outcome: words_of([at for at, what in fault.outcomes.items() if what is outcome])
        for outcome in others
    }
    return "; ".join(
        [
            _short(fault.outcome) + recording_note,
            *(f"{_short(outcome)} if @{when[outcome]}" for outcome in others),
            *(
                [f"{_short(fault.three_moving[0])} if three joints move at once"]
                if fault.three_moving
                else []
            ),
        ]
    )


def _short(outcome: Outcome) -> str:
    return "flies" if outcome is Outcome.FLIES else outcome.value


def _no_go(fault: Fault) -> tuple[str, ...]:
    return days.judge_day(fault).no_go if fault.moment in days.BEFORE_PREFLIGHT else days.no_go(fault)


if __name__ == "__main__":
    PAGE.write_text(page(days.judge_day, _no_go), encoding="utf-8")
