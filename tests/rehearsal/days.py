"""Rehearsed days for tests and pages: with one fault, or of the robot exactly as its file says."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.evaluation.result.evaluation_tables import CHECKS
from tfsat_host.evaluation.verdict import verdict_of
from tfsat_host.maneuver import Schedule, four_stroke, schedule_maneuver
from tfsat_host.plan.facility import load_tower
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.protocol.messages import RecordStopReply, SequencerStatusReply
from tfsat_host.quantity import records
from tfsat_host.rehearsal.day import DROPPED, NoGo, Preflight
from tfsat_host.rehearsal.faults.fault import BEFORE_PREFLIGHT as BEFORE_PREFLIGHT
from tfsat_host.rehearsal.faults.fault import Fault, Moment, Outcome
from tfsat_host.rehearsal.judgement import JudgedDay, moved_deg, outcome_reached
from tfsat_host.rehearsal.rehearsed_drop import Drop, rehearse
from tfsat_host.rehearsal.series import decode_drop
from tfsat_host.rehearsal.truth import drawn_truth, truth_as_filed
from tfsat_host.robot import load_robot
from tfsat_host.sdlog import DropLog

SEED = 1
SCHEDULE = schedule_maneuver(four_stroke(59.0, 70.0))


@dataclass(frozen=True)
class Rehearsed:
    """What the command left, and what it printed."""

    folder: Path
    out: str
    err: str

    @property
    def result(self) -> Any:
        """As with --json."""
        return json.loads((self.folder / "summary.json").read_text())


class Rehearsing(Protocol):
    def __call__(self, *arguments: str, expect: int = 0) -> Rehearsed: ...


@dataclass(frozen=True, eq=False)
class Day:
    """What became of a day with one fault, on which the robot is dropped whatever the preflight says.

    Attributes:
        no_go: Checks of the preflight that stood against the drop.
        refused: A board kept the robot from being dropped.
        came: What the robot did, by the truth.
        moved_deg: How far the joint went that went farthest.
        turned_deg: (3,) joint angles at the end less those at the beginning.
        state: Of the sequencer after the landing.
        log: Of its recording; None: there is none.
        screens: What each command printed, by who prints it.
        checks: Of the evaluation, by name, as in JSON.
        reasons: Of its verdict.
        verdict: Its level; empty without one.
    """

    no_go: tuple[str, ...]
    refused: bool
    came: tuple[Outcome, ...]
    moved_deg: float
    turned_deg: NDArray[np.float64] | None
    state: SequencerState | None
    log: DropLog | None
    screens: dict[str, str]
    checks: dict[str, Any]
    reasons: tuple[str, ...]
    verdict: str


Days = Callable[[Fault], Day]


@cache
def preflight(*, despite: bool) -> Preflight:
    """Return the preflight of the day's maneuver."""
    return Preflight.of(SCHEDULE, load_robot(), load_tower(None), None, despite=despite)


def fly_day(fault: Fault, *, despite: bool) -> Drop:
    """Rehearse a day with that fault, including the preflight."""
    filed = load_robot()
    truth = drawn_truth(filed, SEED)
    return rehearse(SCHEDULE, filed, truth, preflight=preflight(despite=despite), faults=(fault,))


def no_go(fault: Fault) -> tuple[str, ...]:
    """Checks that block the drop when the fault is there before the preflight."""
    drop = fly_day(fault.at(Moment.POWERED), despite=False)
    assert drop.preflight is not None
    # Without `despite`, the preflight alone decides whether the robot is dropped.
    assert isinstance(drop.refused, NoGo) == (not drop.preflight.go)
    return tuple(check.name for check in drop.preflight.blocking)


def turned_deg(drop: Drop) -> NDArray[np.float64] | None:
    """(3,) of each joint; None: nothing was recorded."""
    return np.rad2deg(drop.truth[-1, 1:4] - drop.truth[0, 1:4]) if len(drop.truth) else None


def judge_day(fault: Fault) -> Day:
    """Rehearse, decode and evaluate a day with that fault."""
    drop = fly_day(fault, despite=True)
    assert drop.preflight is not None
    judged, checks = JudgedDay(drop), {}
    # A robot that was not dropped left nothing to decode.
    if drop.refused is None:
        log = decode_drop(drop)
        try:
            evaluation = evaluate(log, load_robot(), drop.calibration, SCHEDULE, recorded=DROPPED)
            judged = JudgedDay(drop, log, evaluation, verdict_of(evaluation))
            checks = {check["name"]: check for check in records(CHECKS, evaluation.checks)}
        except TfsatError as error:
            # Some faults leave a recording that cannot be evaluated: the refusal is what a person reads.
            judged = JudgedDay(drop, log, refusal=error)
    return Day(
        tuple(check.name for check in drop.preflight.blocking),
        drop.refused is not None,
        tuple(outcome for outcome in Outcome if outcome_reached(outcome, drop)),
        float(moved_deg(drop).max()),
        turned_deg(drop),
        None if drop.sequencer is None else drop.sequencer.state,
        judged.log,
        {who: " ".join(sentences) for who, sentences in judged.sentences.items()},
        checks,
        () if judged.verdict is None else judged.verdict.reasons,
        "" if judged.verdict is None else judged.verdict.level,
    )


@dataclass(frozen=True, eq=False)
class WholeDrop:
    """A `Drop` from which nothing is missing; see there."""

    card: bytes
    truth: NDArray[np.float64]
    released_s: float
    landed_s: float
    recording: RecordStopReply
    sequencer: SequencerStatusReply


def rehearse_drop(schedule: Schedule, *, seed: int, rate_rad_s: Sequence[float] | None = None) -> WholeDrop:
    """Rehearse a whole drop of the robot exactly as its file says.

    It is released as the paper's was, or at the given rate of body 3.
    """
    filed = load_robot()
    # No drawn imperfections: the robot that the numbers of the paper are of.
    truth = truth_as_filed(filed, seed)
    if rate_rad_s is not None:
        truth = replace(truth, rate_rad_s=np.array(rate_rad_s))
    drop = rehearse(schedule, filed, truth)
    assert drop.released_s is not None and drop.landed_s is not None
    assert drop.recording is not None and drop.sequencer is not None
    return WholeDrop(drop.card, drop.truth, drop.released_s, drop.landed_s, drop.recording, drop.sequencer)
