"""A rehearsed day afterwards: whether the robot did what it must, by the truth alone, and who detected its faults."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.verdict import Verdict
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.quantity import Column, Columns, fields
from tfsat_host.rehearsal.day import NoGo
from tfsat_host.rehearsal.faults.fault import BEFORE_PREFLIGHT, Fault, Outcome
from tfsat_host.rehearsal.rehearsed_drop import Drop
from tfsat_host.sdlog import DropLog
from tfsat_host.sdlog.log_summary import warnings

MIN_STROKE_DEG = 15.0
"""A joint that went further has made a stroke."""
STILL_DEG = 1.0
"""Backlash and the flow of the servos let a joint that holds move by less."""
AT_REST_DEG = 0.1
LAST_S = 0.5
"""Of the fall, by which a robot that stopped at once is at rest."""
_STRONGEST_FIRST = (Outcome.NOT_DROPPED, Outcome.STANDS_STILL, Outcome.STOPS, Outcome.FLIES)
PREFLIGHT, REFUSAL, BOARD, LOG = "preflight", "refusal", "board", "log"
REPORT, REPORT_REFUSES = "report", "report refuses"
DETECTORS = {
    PREFLIGHT: "preflight",
    REFUSAL: "board, which refused",
    BOARD: "board after the landing",
    LOG: "log",
    REPORT: "evaluation",
    REPORT_REFUSES: "evaluation, which refused",
}
"""For people, by `Detection.who`."""


def moved_deg(drop: Drop) -> FloatArray:
    """(3,) how far each joint went from where it began; 0 if nothing was recorded."""
    angles = drop.truth[:, 1:4]
    if not len(angles):
        return np.zeros(3)
    return np.asarray(np.rad2deg(np.abs(angles - angles[0]).max(axis=0)), dtype=np.float64)


def moves_at_the_end(drop: Drop) -> bool:
    """Return whether some joint moved in the last half second of the fall; False where nothing fell."""
    if drop.landed_s is None:
        return False
    t = drop.truth[:, 0]
    # Peak to peak over the last half second: true angles without noise, so that any motion shows.
    angles = drop.truth[(t > drop.landed_s - LAST_S) & (t < drop.landed_s), 1:4]
    return bool(len(angles)) and bool(np.rad2deg(np.ptp(angles, axis=0).max()) > AT_REST_DEG)


def outcome_reached(outcome: Outcome, drop: Drop) -> bool | None:
    """Return whether the robot did what `outcome` says; None: it was not dropped and cannot be judged."""
    # That nothing is dropped shows before the fall; all else only in it.
    if outcome is Outcome.NOT_DROPPED:
        return drop.refused is not None
    if drop.refused is not None:
        return None
    # Judge by the true angles: sensors and evaluation may be what is broken.
    moved = float(moved_deg(drop).max())
    if outcome is Outcome.STANDS_STILL:
        return moved < STILL_DEG
    if outcome is Outcome.FLIES:
        return moved > MIN_STROKE_DEG
    # It stops by a latched fault, after a stroke at least, and is at rest when it lands.
    stopped = drop.sequencer is not None and drop.sequencer.state is SequencerState.FAULT
    return stopped and moved > MIN_STROKE_DEG and not moves_at_the_end(drop)


def expected_outcome(drop: Drop) -> Outcome:
    """Return what the robot must do with all injected faults; with none, that it flies."""
    # Of several faults the one that lets the robot do least decides.
    outcomes = [fault.outcome for fault in drop.faults if fault.name in drop.injected_s]
    return next((outcome for outcome in _STRONGEST_FIRST if outcome in outcomes), Outcome.FLIES)


def outcome_missed(drop: Drop) -> bool:
    """Return whether, by the truth, the robot did not do what the injected faults call for."""
    return bool(drop.injected_s) and outcome_reached(expected_outcome(drop), drop) is False


@dataclass(frozen=True, slots=True)
class Detection:
    """One that detected a fault.

    Attributes:
        who: `PREFLIGHT`, or a key of `JudgedDay.sentences`.
        what: Names of the checks that give NO-GO, or the sentence.
        by_name: The fault's own words were found; else it counts because it was the only fault.
    """

    who: str
    what: str
    by_name: bool


@dataclass(frozen=True, eq=False)
class JudgedFault:
    """A fault of a day, and what came of it.

    Attributes:
        fault: The fault.
        injected_s: When, as in truth.json; None: the day ended before.
        reached: The robot did what it must with this fault alone; None: that cannot be judged.
        expected: What the robot must do with all faults of the day.
        expected_reached: It did; None as of `reached`.
        moved_deg: (3,) how far each joint truly moved.
        detections: Who detected it.
    """

    fault: Fault
    injected_s: float | None
    reached: bool | None
    expected: Outcome
    expected_reached: bool | None
    moved_deg: FloatArray
    detections: tuple[Detection, ...]

    @property
    def detectable(self) -> bool:
        """Whether anything names it, by design."""
        return bool(self.fault.noticed or self.fault.preflight)


JUDGED_FAULT: Columns = (
    *fields("name=fault.name what=fault.what moment=fault.moment.typed when=fault.moment.value"),
    *fields("outcome=fault.outcome.value struck_s=injected_s came_of_it=reached"),
    *fields("outcome_of_all=expected.value all_came_of_it=expected_reached"),
    *fields("joints_moved_true_deg=moved_deg to_be_noticed=detectable"),
    Column("noticed_by", of="detections", columns=fields("who what by_name")),
)


@dataclass(frozen=True, eq=False)
class JudgedDay:
    """A day with what was made of its recording.

    Attributes:
        drop: The day.
        log: Its recording, decoded; None: there is none.
        evaluation: Of that; None: there is none.
        verdict: Of the evaluation.
        refusal: Why it could not be evaluated; None: it could, or it was not tried.
    """

    drop: Drop
    log: DropLog | None = None
    evaluation: Evaluation | None = None
    verdict: Verdict | None = None
    refusal: TfsatError | None = None

    @property
    def good(self) -> bool:
        """Whether the evaluation has no doubt."""
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
        if self.evaluation is not None and self.verdict is not None:
            causes = (check.cause or "" for check in self.evaluation.failed_checks)
            sentences[REPORT] = (
                self.verdict.sentence,
                *self.verdict.reasons,
                *self.evaluation.notes,
                *causes,
            )
        if self.refusal is not None:
            sentences[REPORT_REFUSES] = (f"{self.refusal.what} {self.refusal.meaning}",)
        return sentences

    def detections(self, fault: Fault) -> tuple[Detection, ...]:
        """List who detected an injected fault.

        For the day's only fault, anything that was found wrong counts.
        """
        if fault.name not in self.drop.injected_s:
            return ()
        alone = len(self.drop.faults) == 1
        detections = [*self._by_preflight(fault, alone)]
        for who, sentences in self.sentences.items():
            # A verdict in short says the same as its reasons, in fewer words: the longest is the most telling.
            own = [sentence for sentence in sentences if fault.noticed and fault.noticed in sentence]
            if own:
                detections.append(Detection(who, max(own, key=len), True))
        # With one fault alone, whatever is complained of counts as its detection, though not by its name.
        if not detections and alone and not self.good:
            detections = [
                Detection(who, sentences[0], False) for who, sentences in self.sentences.items() if sentences
            ]
        return tuple(detections)

    def _by_preflight(self, fault: Fault, alone: bool) -> Iterator[Detection]:
        if fault.moment not in BEFORE_PREFLIGHT:
            return
        blocking = [check.name for check in self.drop.blocking]
        own = [name for name in blocking if name in (fault.preflight or ())]
        if own or (blocking and alone):
            yield Detection(PREFLIGHT, ", ".join(own or blocking), bool(own))

    @cached_property
    def faults(self) -> tuple[JudgedFault, ...]:
        """Each fault of the day: when it was injected, what the robot did, who detected it."""
        drop = self.drop
        expected = expected_outcome(drop)
        return tuple(
            JudgedFault(
                fault,
                drop.injected_s.get(fault.name),
                outcome_reached(fault.outcome, drop) if fault.name in drop.injected_s else None,
                expected,
                outcome_reached(expected, drop),
                moved_deg(drop),
                self.detections(fault),
            )
            for fault in drop.faults
        )


def _false_releases(drop: Drop) -> list[str]:
    count = 0 if drop.sequencer is None else drop.sequencer.false_releases
    if not count:
        return []
    counted = f"The sequencer counted {count} false release{'s' if count > 1 else ''}: "
    return [Advice(counted, NextStep("status"))]
