"""Who noticed a fault of a rehearsed day: preflight, a refusal, a board, the log, the evaluation, or nobody."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.verdict import Verdict
from tfsat_host.rehearsal.checked import NoGo
from tfsat_host.rehearsal.drop import Drop
from tfsat_host.rehearsal.faults.fault import Fault
from tfsat_host.rehearsal.moment import Moment
from tfsat_host.sdlog import DropLog
from tfsat_host.sdlog.summary import warnings

PREFLIGHT, REFUSAL, BOARD, LOG = "preflight", "refusal", "board", "log"
REPORT, REPORT_REFUSES = "report", "report refuses"
BEFORE_PREFLIGHT = (Moment.POWERED, Moment.UPLOADED)
"""What strikes then is there when the preflight looks."""

Said = Mapping[str, Sequence[str]]
"""Sentences by who said them: `REFUSAL` by a board before the drop, `BOARD` after the landing, `LOG` as `decode` says
it, `REPORT` as `evaluate` and `report` do, `REPORT_REFUSES` when they give no numbers."""


@dataclass(frozen=True, slots=True)
class Notice:
    """One that noticed.

    Attributes:
        who: `PREFLIGHT`, or a key of `Said`.
        what: Names of the checks that say NO-GO, or the sentence that was said.
        certain: The fault's own words were found; else it is taken for noticed because nothing else had been thrown in.
    """

    who: str
    what: str
    certain: bool


def said_of(
    drop: Drop,
    log: DropLog | None,
    evaluated: tuple[Evaluation, Verdict] | None,
    refusal: TfsatError | None,
) -> Said:
    """Everything that was said on a day.

    Args:
        drop: The day.
        log: Of its recording; None: there is none.
        evaluated: None: it was not.
        refusal: Why it could not be; None: it could, or nobody tried.
    """
    said: dict[str, Sequence[str]] = {}
    if drop.refused is not None and not isinstance(drop.refused, NoGo):
        said[REFUSAL] = (str(drop.refused.what),)
    said[BOARD] = (*drop.setbacks, *_false_releases(drop))
    said[LOG] = () if log is None else tuple(warnings(log))
    if evaluated is not None:
        found, verdict = evaluated
        causes = (check.cause or "" for check in found.failed_checks)
        said[REPORT] = (verdict.sentence, *verdict.reasons, *found.notes, *causes)
    if refusal is not None:
        said[REPORT_REFUSES] = (f"{refusal.what} {refusal.meaning}",)
    return said


def _false_releases(drop: Drop) -> list[str]:
    count = 0 if drop.sequencer is None else drop.sequencer.false_releases
    if not count:
        return []
    return [f"The sequencer counted {count} false release{'s' if count > 1 else ''}: tfsat-host status"]


def notices_of(fault: Fault, drop: Drop, said: Said, *, alone: bool, good: bool) -> tuple[Notice, ...]:
    """Who noticed one fault.

    Args:
        fault: That has struck.
        drop: The day.
        said: See `said_of`.
        alone: No other fault was thrown in: then all that is wrong with the day comes of this one.
        good: The evaluation found nothing to say against the drop.
    """
    found = [*_by_preflight(fault, drop, alone=alone)]
    for who, sentences in said.items():
        # A verdict in short says the same as its reasons, in fewer words: the longest is the most telling.
        own = [one for one in sentences if fault.noticed and fault.noticed in one]
        if own:
            found.append(Notice(who, max(own, key=len), True))
    if not found and alone and not good:
        found += [Notice(who, sentences[0], False) for who, sentences in said.items() if sentences]
    return tuple(found)


def _by_preflight(fault: Fault, drop: Drop, *, alone: bool) -> list[Notice]:
    if drop.checked is None or fault.moment not in BEFORE_PREFLIGHT:
        return []
    wrong = [check.name for check in drop.checked.wrong]
    own = [name for name in wrong if name in (fault.morning or ())]
    if own:
        return [Notice(PREFLIGHT, ", ".join(own), True)]
    return [Notice(PREFLIGHT, ", ".join(wrong), False)] if wrong and alone else []
