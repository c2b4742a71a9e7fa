"""The result of many drops: distribution of each number that has a truth, table of all drops, files."""

from __future__ import annotations

import csv
import io
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from tfsat_host.exit_code import ExitCode
from tfsat_host.maneuver import Maneuver, format_maneuver
from tfsat_host.next_step import Advice
from tfsat_host.quantity import Column, Columns, fields, record
from tfsat_host.rehearsal.folder import ResultFolder
from tfsat_host.rehearsal.series import RehearsedDrop, Series
from tfsat_host.rehearsal.truth_comparison import EstimateAndTruth
from tfsat_host.run.files import MANEUVER, ROBOT

TABLE, SUMMARY = "runs.csv", "runs.json"
_MIN_RUNS_FOR_SHARE = 20
"""Below, the intervals that hold the truth are counted: a share of few drops says less than their number."""


@dataclass(frozen=True, slots=True)
class Distribution:
    """Of one number over all drops.

    Attributes:
        name: Of it.
        unit: Of all but `coverage`.
        mean_true: What it truly was, on average.
        spread_true: Its standard deviation over the robots.
        rms_error: Of the estimates.
        largest_error: In magnitude.
        stated_std: Median.
        coverage: Share of the 95 % intervals that hold the truth.
        count: Drops in which it was estimated.
    """

    name: str
    unit: str
    mean_true: float
    spread_true: float
    rms_error: float
    largest_error: float
    stated_std: float
    coverage: float
    count: int

    @property
    def coverage_text(self) -> str:
        """The coverage for people."""
        if self.count < _MIN_RUNS_FOR_SHARE:
            return f"{round(self.coverage * self.count)}/{self.count}"
        return f"{100.0 * self.coverage:.0f} %"


DISTRIBUTION: Columns = (
    Column("name", "number"),
    Column("unit", "unit"),
    Column("mean_true", "true, mean"),
    Column("spread_true", "spread"),
    Column("rms_error", "error, rms", form=".4f"),
    Column("largest_error", "largest", form=".4f"),
    Column("stated_std", "stated ±", form=".4f"),
    Column("held", "in 95 %", of="coverage", words=lambda distribution: distribution.coverage_text),
    Column("count"),
)


def distributions(outcomes: Sequence[RehearsedDrop]) -> tuple[Distribution, ...]:
    """Compute the distribution of every compared number, in the order of first appearance."""
    by_name: dict[str, list[EstimateAndTruth]] = {}
    for outcome in outcomes:
        for comparison in outcome.compared:
            by_name.setdefault(comparison.name, []).append(comparison)
    return tuple(_distribution(name, comparisons) for name, comparisons in by_name.items())


def _distribution(name: str, comparisons: Sequence[EstimateAndTruth]) -> Distribution:
    # (m, 3) rows to three columns.
    estimate, std, true = np.array(
        [(comparison.estimate, comparison.std, comparison.true) for comparison in comparisons]
    ).T
    error = estimate - true
    return Distribution(
        name,
        comparisons[0].unit,
        float(true.mean()),
        float(true.std()),
        float(np.sqrt((error**2).mean())),
        float(np.abs(error).max()),
        float(np.median(std)),
        # Coverage of the 95 % intervals: whether the standard deviations that are stated are honest.
        float((np.abs(error) <= 1.96 * std).mean()),
        len(comparisons),
    )


@dataclass(frozen=True, slots=True)
class StrokeTiming:
    """Magnitude of the strokes' time less schedule, of all drops; None without a logged stroke.

    Attributes:
        rms: In microseconds.
        largest: In microseconds.
    """

    rms: float | None
    largest: float | None


@dataclass(frozen=True, slots=True)
class DetectionCount:
    """In how many drops a fault was injected and detected.

    Attributes:
        name: Of the fault.
        injected: Drops.
        detected: Of these.
        detected_by: The same by who detected it.
    """

    name: str
    injected: int
    detected: int
    detected_by: Mapping[str, int]


@dataclass(frozen=True, eq=False)
class SeriesResult:
    """What came of a series.

    Attributes:
        series: What was the same for all drops.
        asked: How many drops were wanted; fewer may have been flown.
        outcomes: Of each drop.
        table: The file with a row for each drop.
        command_of_one: What to type to fly one of them again.
    """

    series: Series
    asked: int
    outcomes: tuple[RehearsedDrop, ...]
    table: Path
    command_of_one: Advice

    @property
    def runs(self) -> int:
        """How many drops were flown."""
        return len(self.outcomes)

    @cached_property
    def verdicts(self) -> Counter[str]:
        """How many drops were `good`, `doubtful`, `failed`, or had no evaluation: `none`."""
        return Counter(outcome.verdict for outcome in self.outcomes)

    @property
    def refused(self) -> tuple[RehearsedDrop, ...]:
        """Drops in which nothing fell, or nothing was recorded."""
        return tuple(outcome for outcome in self.outcomes if outcome.refused)

    @property
    def missed_outcomes(self) -> list[int]:
        """Numbers of the drops in which the robot did not do what it must with the injected faults."""
        return [outcome.number for outcome in self.outcomes if outcome.outcome_missed]

    @property
    def no_go(self) -> Counter[str]:
        """How many times each check of the preflight blocked a drop."""
        return Counter(name for outcome in self.outcomes for name in outcome.no_go)

    @property
    def samples_lost(self) -> int:
        """In all recordings."""
        # Drops without a recording have -1, which must not make up for another's loss.
        return sum(max(0, outcome.samples_lost) for outcome in self.outcomes)

    @property
    def stroke_timing(self) -> StrokeTiming:
        """By the logger's clock."""
        # A stroke that the log lacks is NaN, the only number that differs from itself.
        timing = [abs(off) for outcome in self.outcomes for off in outcome.strokes_off_us if off == off]
        rms = (sum(off**2 for off in timing) / len(timing)) ** 0.5 if timing else None
        return StrokeTiming(rms, max(timing, default=None))

    @cached_property
    def distributions(self) -> tuple[Distribution, ...]:
        """Of each number that was compared with the truth."""
        return distributions(self.outcomes)

    @property
    def detections(self) -> tuple[DetectionCount, ...]:
        """Of each fault of the series."""
        return tuple(self._count_detections(name) for name in self.series.faults)

    def _count_detections(self, name: str) -> DetectionCount:
        by = [outcome.detected_by[name] for outcome in self.outcomes if name in outcome.detected_by]
        return DetectionCount(name, len(by), sum(map(bool, by)), Counter(who for each in by for who in each))

    @property
    def exit_code(self) -> int:
        """0 if every drop was flown, recorded whole and evaluated; 4: the preflight let none go; else 3."""
        if self.no_go and len(self.refused) == self.runs:
            return ExitCode.REFUSED
        as_planned = self.verdicts["good"] == self.runs and not self.missed_outcomes
        return 0 if as_planned else ExitCode.DATA_LOSS


def _of_verdict(level: str) -> Column:
    return Column(level, of=lambda result: result.verdicts[level])


SERIES: Columns = (
    *fields("runs asked seed=series.seed"),
    Column(
        "robot",
        of="series.filed",
        columns=(Column("name"), Column("file", of=lambda robot: str(robot.path))),
    ),
    *fields("as_filed=series.as_filed"),
    Column("imu", of=lambda result: result.outcomes[0].imu or None),
    *fields("faults=series.faults"),
    Column(
        "faults_noticed",
        of="detections",
        columns=fields("name struck=injected noticed=detected noticed_by=detected_by"),
    ),
    *fields("broke_design=missed_outcomes"),
    Column("dropped", of=lambda result: result.runs - len(result.refused)),
    *fields("no_go"),
    *(_of_verdict(level) for level in ("good", "doubtful", "failed", "none")),
    *fields("samples_lost"),
    Column("stroke_timing_us", of="stroke_timing", columns=fields("rms largest")),
    Column("distributions", columns=DISTRIBUTION),
    Column("refused", columns=fields("number seed why=refused")),
)
"""The object of `rehearse --runs --json`, which `runs.json` keeps, of a `SeriesResult`."""


def write_series(folder: ResultFolder, maneuver: Maneuver, result: SeriesResult) -> None:
    """Maneuver, robot, a table with a row for each drop, and the result; all or none. Raises UsageError, OSError."""
    robot = result.series.filed.path.read_bytes()  # which may lie in this very folder
    with folder.replace_files():
        folder.file(MANEUVER).write_text(format_maneuver(maneuver), encoding="utf-8")
        folder.file(ROBOT).write_bytes(robot)
        folder.file(TABLE).write_text(_table(result.outcomes), encoding="utf-8")
        folder.file(SUMMARY).write_text(json.dumps(record(SERIES, result), indent=1) + "\n", encoding="utf-8")
        folder.seal()


_ROW: Columns = (
    *fields("number seed"),
    Column("no_go", of=lambda outcome: " ".join(outcome.no_go)),
    *fields("refused verdict samples_lost"),
)


def _table(outcomes: Sequence[RehearsedDrop]) -> str:
    """CSV: a row for each drop, with the seed that flies it again alone."""
    # Columns of all that any drop gave: one that lacks a number has NaN there.
    names = list(dict.fromkeys(comparison.name for outcome in outcomes for comparison in outcome.compared))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    columns = [f"{name} {what}" for name in names for what in ("found", "std", "true")]
    writer.writerow([*(column.key for column in _ROW), *columns])
    for outcome in outcomes:
        by_name = {
            comparison.name: (comparison.estimate, comparison.std, comparison.true)
            for comparison in outcome.compared
        }
        values = [f"{value:.9g}" for name in names for value in by_name.get(name, (float("nan"),) * 3)]
        writer.writerow([*record(_ROW, outcome).values(), *values])
    return text.getvalue()
