"""Several drops of one robot: each evaluated or refused, then each judged by the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from tfsat_host.error_columns import error_columns
from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.evaluation.com_fit.cross_validation import (
    CombinedOffsets,
    FittedDrop,
    LeftOut,
    combine,
    cross_validate,
    find_trusted_drops,
    left_aside,
)
from tfsat_host.evaluation.result.comparison_result import comparison_tables
from tfsat_host.evaluation.verdict import VERDICT, Verdict, refusal_verdict
from tfsat_host.file_hash import sha256_of
from tfsat_host.notices import SILENT, Notices
from tfsat_host.quantity import Column, Columns, Table
from tfsat_host.robot import RobotModel
from tfsat_host.run import drop_evaluation
from tfsat_host.run.drop_evaluation import EVALUATED_RUN, EvaluatedRun
from tfsat_host.run.files import EvaluationOptions, run_files


@dataclass(frozen=True, eq=False)
class Refused:
    """A drop that cannot be evaluated."""

    place: Path
    error: TfsatError

    @property
    def verdict(self) -> Verdict:
        """What it is worth."""
        return refusal_verdict(self.error)


_REFUSED: Columns = (
    Column("drop", of=lambda refused: str(refused.place)),
    Column("verdict", columns=VERDICT),
    Column("error", columns=error_columns),
)
Tried = EvaluatedRun | Refused


def tried_columns(attempt: Tried) -> Columns:
    """Return the columns of an attempt for `--json`."""
    return _REFUSED if isinstance(attempt, Refused) else EVALUATED_RUN


@dataclass(frozen=True, eq=False)
class DropSummary:
    """A drop in the table of several: its name, and its evaluation, None where it was refused."""

    name: str
    run: EvaluatedRun | None


DROPS: Columns = (
    Column("drop", "drop", of="name"),
    Column("verdict", "verdict", of=lambda drop: "failed" if drop.run is None else drop.run.verdict.level),
    Column(
        "reorientation_deg",
        "reorientation",
        of="run.found.reorientation.angle_rad",
        std="run.found.reorientation.std_rad",
    ),
    Column("before_deg", "nominal error", of="run.found.explained.nominal.error.final_norm_rad"),
    Column("after_deg", "fitted error", of="run.found.explained.fitted.error.final_norm_rad"),
)
"""Of several drops, a line each."""


def evaluate_several(
    places: Sequence[Path], options: EvaluationOptions, notices: Notices = SILENT
) -> list[Tried]:
    """Evaluates drops of one robot; one that is refused does not keep the others from being evaluated.

    Raises:
        UsageError: one is a copy of another, they are of different robots, or the options are of one drop.
    """
    options.check(places)
    robot = drop_evaluation.robot_of(options.robot, places)
    # Identical files are refused before anything is evaluated; other copies show by their session, decoded.
    _refuse_copies(places)
    return _without_copies([try_evaluation(place, options, robot, notices) for place in places])


def try_evaluation(place: Path, options: EvaluationOptions, robot: RobotModel, notices: Notices) -> Tried:
    """Evaluate one drop; return the refusal if it fails."""
    try:
        return drop_evaluation.evaluate_run(place, options, robot, notices)
    except TfsatError as error:
        return Refused(place, error)


def _refuse_copies(places: Sequence[Path]) -> None:
    """Refuse a recording that is named twice, byte for byte, before anything is evaluated."""
    first: dict[str, Path] = {}
    for place in places:
        try:
            sha256 = sha256_of(run_files(place, None).recording)
        except (TfsatError, OSError):
            continue  # refused for that reason when its turn comes
        if sha256 in first:
            raise UsageError(
                what=f"{place} holds the same recording as {first[sha256]}, byte for byte.",
                meaning="One drop says nothing about itself. Nothing was evaluated.",
                next_step="Name each drop once.",
            )
        first[sha256] = place


def _without_copies(drops: list[Tried]) -> list[Tried]:
    """Replace further copies of a session by refusals.

    Two files of one session, such as one that was cut, are one drop, which would agree with itself.
    """
    first: dict[int, Path] = {}
    attempts: list[Tried] = []
    for attempt in drops:
        if isinstance(attempt, EvaluatedRun):
            session = attempt.found.log.session
            if session in first:
                error = TfsatError(
                    what=f"{attempt.place} holds the same recording as {first[session]} ({session:08x}).",
                    meaning="One drop says nothing about itself: it was left out.",
                    next_step="Name each drop once.",
                )
                attempts.append(Refused(attempt.place, error))
                continue
            first[session] = attempt.place
        attempts.append(attempt)
    return attempts


class Comparison:
    """Two or more evaluated drops.

    Attributes:
        runs: The drops.
        combined: The offsets of all of them together whose correction is not withheld; None: it is in every drop.
        left_out: For each drop that others can judge, how their offsets do in it.
        doubts: Why the combination is not to be trusted: the drops contradict each other; sentences.
        remarks: These, and which drops correct no other, and why; sentences.
    """

    def __init__(self, runs: Sequence[EvaluatedRun]) -> None:
        self.runs = tuple(runs)
        drops = [_fit_drop(run) for run in runs]
        # A drop with failed checks or a withheld correction must not correct the others.
        fits = [drop.fit for drop in find_trusted_drops(drops)]
        self.combined: CombinedOffsets | None = combine(fits) if fits else None
        # Leave one out: offsets that fit their own drop prove little, that improve another one they do.
        self.left_out: tuple[LeftOut, ...] = cross_validate(drops)
        # A chi-square about the common offsets tells whether the drops can be of one model at all.
        doubt = "" if self.combined is None else self.combined.contradiction()
        self.doubts: tuple[str, ...] = (doubt,) if doubt else ()
        self.remarks: tuple[str, ...] = (*self.doubts, *left_aside(drops))

    def tables(self, names: Sequence[str]) -> list[Table]:
        """Build the tables of the common correction and of each drop's fit under the others' correction.

        The list is empty if all corrections are withheld. `names` are the drops' for people, in their order.
        """
        if self.combined is None:
            return []
        evaluations = {name: run.found for name, run in zip(names, self.runs, strict=True)}
        by_place = {str(run.place): name for name, run in zip(names, self.runs, strict=True)}
        left_out = [replace(fold, name=by_place[fold.name]) for fold in self.left_out]
        return comparison_tables(evaluations, self.combined, left_out, self.remarks)

    @classmethod
    def of(cls, runs: Sequence[EvaluatedRun]) -> Comparison | None:
        """Compare the drops; return None for a single drop, which has nothing to be compared with."""
        return cls(runs) if len(runs) > 1 else None


def _fit_drop(run: EvaluatedRun) -> FittedDrop:
    explained = run.found.explained

    # Norm of the attitude error at the end, of the model with these offsets, driven by this drop's joints.
    def error_deg(values: Any) -> float:
        return float(np.rad2deg(explained.driven.with_offsets(values).error.final_norm_rad))

    failed = ", ".join(check.name for check in run.found.failed_checks)
    against = (*([f"Checks failed: {failed}."] if failed else []), *explained.withheld)
    return FittedDrop(str(run.place), explained.driven.flown, explained.fit, error_deg, against)
