"""A rehearsed day afterwards: whether the robot did what it must, by the truth alone, and who noticed its faults."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.verdict import Verdict
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.quantity import fields, record, records
from tfsat_host.rehearsal.day import NoGo
from tfsat_host.rehearsal.faults.fault import BEFORE_PREFLIGHT, FAULT, Fault, Outcome
from tfsat_host.rehearsal.rehearsed_drop import Drop
from tfsat_host.sdlog import DropLog
from tfsat_host.sdlog.log_summary import warnings

FLOWN_DEG = 15.0
"""A joint that went further has made a stroke."""
STILL_DEG = 1.0
"""Backlash and the flow of the servos let a joint that holds move by less."""
AT_REST_DEG = 0.1
LAST_S = 0.5
"""Of the fall, by which a robot that stopped at once is at rest."""
_STRONGEST_FIRST = (Outcome.NOT_DROPPED, Outcome.STANDS_STILL, Outcome.STOPS, Outcome.FLIES)
PREFLIGHT, REFUSAL, BOARD, LOG = "preflight", "refusal", "board", "log"
REPORT, REPORT_REFUSES = "report", "report refuses"


def moved_deg(drop: Drop) -> FloatArray:
    """(3,) how far each joint went from where it began; 0 if nothing was recorded."""
    angles = drop.truth[:, 1:4]
    if not len(angles):
        return np.zeros(3)
    return np.asarray(np.rad2deg(np.abs(angles - angles[0]).max(axis=0)), dtype=np.float64)


def moves_at_the_end(drop: Drop) -> bool:
    """Some joint still moved in the last half second of the fall; not where nothing fell."""
    if drop.landed_s is None:
        return False
    t = drop.truth[:, 0]
    # Peak to peak over the last half second: true angles without noise, so that any motion shows.
    angles = drop.truth[(t > drop.landed_s - LAST_S) & (t < drop.landed_s), 1:4]
    return bool(len(angles)) and bool(np.rad2deg(np.ptp(angles, axis=0).max()) > AT_REST_DEG)


def came_of(outcome: Outcome, drop: Drop) -> bool | None:
    """Return whether the robot did what `outcome` says; None: it was not dropped and cannot be judged."""
    if outcome is Outcome.NOT_DROPPED:
        return drop.refused is not None
    if drop.refused is not None:
        return None
    moved = float(moved_deg(drop).max())
    if outcome is Outcome.STANDS_STILL:
        return moved < STILL_DEG
    if outcome is Outcome.FLIES:
        return moved > FLOWN_DEG
    # It stops by a latched fault, after a stroke at least, and is at rest when it lands.
    stopped = drop.sequencer is not None and drop.sequencer.state is SequencerState.FAULT
    return stopped and moved > FLOWN_DEG and not moves_at_the_end(drop)


def designed_for(drop: Drop) -> Outcome:
    """Return the outcome designed for all faults that struck; with none, that the robot flies."""
    # Of several faults the one that lets the robot do least decides.
    outcomes = [fault.outcome for fault in drop.faults if fault.name in drop.struck_s]
    return next((outcome for outcome in _STRONGEST_FIRST if outcome in outcomes), Outcome.FLIES)


def broke_design(drop: Drop) -> bool:
    """Return whether, by the truth, the robot did not do what the faults that struck call for."""
    return bool(drop.struck_s) and came_of(designed_for(drop), drop) is False


@dataclass(frozen=True, slots=True)
class Notice:
    """One that noticed a fault.

    Attributes:
        who: `PREFLIGHT`, or a key of `JudgedDay.sentences`.
        what: Names of the checks that give NO-GO, or the sentence.
        certain: The fault's own words were found; else it is taken for noticed because it was the only fault.
    """

    who: str
    what: str
    certain: bool


@dataclass(frozen=True, eq=False)
class JudgedDay:
    """A day with what was made of its recording.

    Attributes:
        drop: The day.
        log: Its recording, decoded; None: there is none.
        found: The evaluation; None: there is none.
        verdict: Of that.
        refusal: Why it could not be evaluated; None: it could, or it was not tried.
    """

    drop: Drop
    log: DropLog | None = None
    found: Evaluation | None = None
    verdict: Verdict | None = None
    refusal: TfsatError | None = None

    @property
    def good(self) -> bool:
        """The evaluation has no doubt."""
        return self.verdict is not None and self.verdict.level == "good"

    @cached_property
    def sentences(self) -> dict[str, Sequence[str]]:
        """By who gave them.

        `REFUSAL`: a board before the drop; `BOARD`: after the landing; `LOG`: `decode`; `REPORT`: `evaluate` and
        `report`; `REPORT_REFUSES`: these, when they give no numbers.
        """
        drop, sentences = self.drop, dict[str, Sequence[str]]()
        if drop.refused is not None and not isinstance(drop.refused, NoGo):
            sentences[REFUSAL] = (str(drop.refused.what),)
        sentences[BOARD] = (*drop.setbacks, *_false_releases(drop))
        sentences[LOG] = () if self.log is None else tuple(warnings(self.log))
        if self.found is not None and self.verdict is not None:
            causes = (check.cause or "" for check in self.found.failed_checks)
            sentences[REPORT] = (self.verdict.sentence, *self.verdict.reasons, *self.found.notes, *causes)
        if self.refusal is not None:
            sentences[REPORT_REFUSES] = (f"{self.refusal.what} {self.refusal.meaning}",)
        return sentences

    def notices(self, fault: Fault) -> tuple[Notice, ...]:
        """List who noticed a fault that struck.

        For the day's only fault, anything that was found wrong counts.
        """
        if fault.name not in self.drop.struck_s:
            return ()
        alone = len(self.drop.faults) == 1
        noticed = [*self._by_preflight(fault, alone)]
        for who, sentences in self.sentences.items():
            # A verdict in short says the same as its reasons, in fewer words: the longest is the most telling.
            own = [sentence for sentence in sentences if fault.noticed and fault.noticed in sentence]
            if own:
                noticed.append(Notice(who, max(own, key=len), True))
        # With one fault alone, whatever is complained of is taken for its doing, though not by its name.
        if not noticed and alone and not self.good:
            noticed = [
                Notice(who, statements[0], False) for who, statements in self.sentences.items() if statements
            ]
        return tuple(noticed)

    def _by_preflight(self, fault: Fault, alone: bool) -> Iterator[Notice]:
        if self.drop.checked is None or fault.moment not in BEFORE_PREFLIGHT:
            return
        wrong = [check.name for check in self.drop.checked.wrong]
        own = [name for name in wrong if name in (fault.preflight or ())]
        if own or (wrong and alone):
            yield Notice(PREFLIGHT, ", ".join(own or wrong), bool(own))

    def faults(self) -> list[dict[str, Any]]:
        """List each fault for JSON: when it struck, its outcome and who noticed it.

        Times are as in truth.json.
        """
        drop = self.drop
        designed = designed_for(drop)
        return [
            {
                **record(FAULT, fault),
                "struck_s": drop.struck_s.get(fault.name),
                "came_of_it": came_of(fault.outcome, drop) if fault.name in drop.struck_s else None,
                "outcome_of_all": designed.value,
                "all_came_of_it": came_of(designed, drop),
                "joints_moved_true_deg": moved_deg(drop).tolist(),
                "to_be_noticed": bool(fault.noticed or fault.preflight),
                "noticed_by": records(fields("who what by_name=certain"), self.notices(fault)),
            }
            for fault in drop.faults
        ]


def _false_releases(drop: Drop) -> list[str]:
    count = 0 if drop.sequencer is None else drop.sequencer.false_releases
    if not count:
        return []
    counted = f"The sequencer counted {count} false release{'s' if count > 1 else ''}: "
    return [Advice(counted, NextStep("status"))]
