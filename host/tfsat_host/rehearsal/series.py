"""Many drops, each of another robot: flown on all cores; their distribution, table and result."""

from __future__ import annotations

import csv
import io
import json
import os
import signal
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from tfsat_host.emulated.imu_part import ImuPart
from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.evaluation.verdict import verdict_of
from tfsat_host.maneuver import Maneuver, Schedule, format_maneuver
from tfsat_host.quantity import fields, record, records
from tfsat_host.rehearsal import rehearsed_drop as drops
from tfsat_host.rehearsal.day import DROPPED, Preflight
from tfsat_host.rehearsal.faults.fault_catalog import fault_named
from tfsat_host.rehearsal.folder import ResultFolder
from tfsat_host.rehearsal.judgement import JudgedDay, broke_design
from tfsat_host.rehearsal.rehearsed_drop import Drop
from tfsat_host.rehearsal.truth import Truth, drawn_truth, hash_of, truth_as_filed
from tfsat_host.rehearsal.truth_comparison import EstimateAndTruth, compare_with_truth
from tfsat_host.robot import RobotModel
from tfsat_host.run.files import MANEUVER, ROBOT
from tfsat_host.sdlog import DropLog, load
from tfsat_host.worker_processes import worker_pool

TABLE, SUMMARY = "runs.csv", "runs.json"
# Each of the libraries of linear algebra that numpy may be built with has a variable of its own.
_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
_ASKED_EVERY_S = 0.2


@dataclass(frozen=True, eq=False)
class Series:
    """What is the same for all of them.

    Attributes:
        schedule: What flies.
        filed: The robot as its file has it.
        seed: All robots are drawn from this one.
        as_filed: None of them is: each is what the file says.
        hex_path: The sequencer's image; None: its core natively.
        faults: By name.
        part: IMU on every body; None: the robot's own.
        preflight: What is checked before each drop; None: nothing is.
    """

    schedule: Schedule
    filed: RobotModel
    seed: int
    as_filed: bool = False
    hex_path: Path | None = None
    faults: tuple[str, ...] = ()
    part: ImuPart | None = None
    preflight: Preflight | None = None

    def seed_of(self, number: int) -> int:
        """Return the seed of drop `number`, counted from 1, the same in every process.

        The first is the seed of a single `rehearse`.
        """
        return self.seed if number == 1 else hash_of(self.seed, number)

    def truth(self, number: int) -> Truth:
        """Draw the robot of drop `number`."""
        seed = self.seed_of(number)
        return truth_as_filed(self.filed, seed) if self.as_filed else drawn_truth(self.filed, seed, self.part)

    def rehearse(self, truth: Truth, progress: Callable[[str], None] = lambda _: None) -> Drop:
        """Rehearse a drop of that robot. Raises TfsatError."""
        return drops.rehearse(
            self.schedule,
            self.filed,
            truth,
            hex_path=self.hex_path,
            preflight=self.preflight,
            faults=tuple(map(fault_named, self.faults)),
            progress=progress,
        )


@dataclass(frozen=True, eq=False)
class RehearsedDrop:
    """One drop.

    Attributes:
        number: From 1.
        seed: That flies it again.
        imu: Part on every body; empty: the robot is as filed.
        refused: Why nothing was dropped; empty: something was.
        no_go: Checks of the preflight that stand against a drop.
        verdict: Of the evaluation; `none` without one.
        samples_lost: In the recording; -1 without one.
        strokes_off_us: When each stroke came, less when it was scheduled.
        compared: Found and true.
        noticed: Of each fault that struck, by its name, who noticed it (see `judgement.Notice`); may be empty.
        broke_design: By the truth the robot did not do what it must with the faults that struck.
    """

    number: int
    seed: int
    imu: str
    refused: str
    no_go: tuple[str, ...]
    verdict: str = "none"
    samples_lost: int = -1
    strokes_off_us: tuple[float, ...] = ()
    compared: tuple[EstimateAndTruth, ...] = ()
    noticed: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    broke_design: bool = False


def fly_many(
    series: Series,
    runs: int,
    workers: int | None = None,
    progress: Callable[[], None] = lambda: None,
    stop: Callable[[], bool] = lambda: False,
) -> tuple[RehearsedDrop, ...]:
    """Fly every drop and return them in order, the same to the bit whatever the number of workers.

    Args:
        series: The series to fly.
        runs: The number of drops.
        workers: The number of processes; None: one for each core.
        progress: Called after each drop.
        stop: Polled often: whether to begin no more drops. Those in the air are flown to their end; fewer than
            `runs` come back.
    """
    outcomes: list[RehearsedDrop] = []
    workers = workers or os.cpu_count() or 1
    # A process on each core leaves none for a second thread of its linear algebra; and sums of threads differ.
    with worker_pool(workers, _ignore_interrupts, dict.fromkeys(_THREADS, "1")) as pool:
        numbers = iter(range(1, runs + 1))
        flying: set[Future[RehearsedDrop]] = set()
        while True:
            # Hand out no more than can fly at once: a stop then leaves nothing in a queue.
            while len(flying) < workers and not stop() and (number := next(numbers, None)) is not None:
                # Submitting may start a process, which inherits the signal mask.
                with _interrupts_blocked():
                    flying.add(pool.submit(fly, series, number))
            if stop():
                # Drops that have not begun are given up; those in the air land first.
                flying = {future for future in flying if not future.cancel()}
            if not flying:
                break
            # Time out now and then, to ask `stop` again.
            landed, flying = wait(flying, timeout=_ASKED_EVERY_S, return_when=FIRST_COMPLETED)
            for future in landed:
                outcomes.append(future.result())
                progress()
    # Drops land in any order, which depends on the load: sort, so that results repeat.
    return tuple(sorted(outcomes, key=lambda outcome: outcome.number))


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Block Ctrl-C for processes that start in the block, so that they finish their drops.

    Ctrl-C reaches all processes of a terminal.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT,))
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _ignore_interrupts() -> None:
    """Ignore Ctrl-C in this worker process, so that it finishes its drop."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def fly(series: Series, number: int) -> RehearsedDrop:
    """Fly, evaluate and compare one drop of the series with the truth."""
    truth = series.truth(number)
    drop = series.rehearse(truth)
    judged = _judge_drop(drop, series)
    numbers: dict[str, Any] = {}
    if judged.log is not None:
        numbers["samples_lost"] = judged.log.samples_lost
    if judged.found is not None and judged.verdict is not None:
        numbers |= {
            "verdict": judged.verdict.level,
            "strokes_off_us": tuple(
                1e6 * (stroke.logged_s - stroke.scheduled_s) for stroke in judged.found.strokes
            ),
            "compared": compare_with_truth(judged.found, drop, drop.robot, series.filed),
        }
    struck = [fault for fault in drop.faults if fault.name in drop.struck_s]
    return RehearsedDrop(
        number,
        truth.seed,
        truth.imu,
        drop.refused.what if drop.refused is not None else "" if drop.card else "no recording",
        () if drop.checked is None else tuple(check.name for check in drop.checked.wrong),
        **numbers,
        # Each who noticed once, in the order of the day; a dict keeps that, a set would not.
        noticed={
            fault.name: tuple(dict.fromkeys(by.who for by in judged.notices(fault))) for fault in struck
        },
        broke_design=broke_design(drop),
    )


def _judge_drop(drop: Drop, series: Series) -> JudgedDay:
    if drop.refused is not None or not drop.card:
        return JudgedDay(drop)
    log = decode_drop(drop)
    try:
        evaluation = evaluate(log, series.filed, drop.calibration, series.schedule, recorded=DROPPED)
    except TfsatError as error:
        # That the evaluation refuses is a result, too: it may be how a fault is noticed.
        return JudgedDay(drop, log, refusal=error)
    return JudgedDay(drop, log, evaluation, verdict_of(evaluation))


def decode_drop(drop: Drop) -> DropLog:
    """Decode the recording of a drop that has one."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "SD.bin"
        # The decoder reads files: take the same way as a team's card.
        path.write_bytes(drop.card)
        return load(path)


@dataclass(frozen=True, slots=True)
class Distribution:
    """Of one number over all drops.

    Attributes:
        name: Of it.
        unit: Of all but `held`.
        mean_true: What it truly was, on average.
        spread_true: Its standard deviation over the robots.
        rms_error: Of what was found.
        largest_error: In magnitude.
        stated_std: Median.
        held: Share of the 95 % intervals that hold the truth.
        count: Drops in which it was found.
    """

    name: str
    unit: str
    mean_true: float
    spread_true: float
    rms_error: float
    largest_error: float
    stated_std: float
    held: float
    count: int


def distributions(outcomes: Sequence[RehearsedDrop]) -> tuple[Distribution, ...]:
    """Compute the distribution of every compared number, in the order of first appearance."""
    by_name: dict[str, list[EstimateAndTruth]] = {}
    for outcome in outcomes:
        for comparison in outcome.compared:
            by_name.setdefault(comparison.name, []).append(comparison)
    return tuple(_distribution(name, ones) for name, ones in by_name.items())


def _distribution(name: str, ones: Sequence[EstimateAndTruth]) -> Distribution:
    # (m, 3) rows to three columns.
    estimate, std, true = np.array(
        [(comparison.found, comparison.std, comparison.true) for comparison in ones]
    ).T
    error = estimate - true
    return Distribution(
        name,
        ones[0].unit,
        float(true.mean()),
        float(true.std()),
        float(np.sqrt((error**2).mean())),
        float(np.abs(error).max()),
        float(np.median(std)),
        # Coverage of the 95 % intervals: whether the standard deviations that are stated are honest.
        float((np.abs(error) <= 1.96 * std).mean()),
        len(ones),
    )


def series_result(
    series: Series, runs: int, outcomes: Sequence[RehearsedDrop], spread: Sequence[Distribution]
) -> dict[str, Any]:
    """Build the result of a series, for `--json` and for the folder."""
    verdicts = [outcome.verdict for outcome in outcomes]
    # A stroke that the log lacks is NaN, the only number that differs from itself.
    timing = [abs(off) for outcome in outcomes for off in outcome.strokes_off_us if off == off]
    return {
        "runs": len(outcomes),
        "asked": runs,
        "seed": series.seed,
        "robot": {"name": series.filed.name, "file": str(series.filed.path)},
        "as_filed": series.as_filed,
        "imu": outcomes[0].imu or None,
        "faults": list(series.faults),
        "faults_noticed": [_count_notices(name, outcomes) for name in series.faults],
        "broke_design": [outcome.number for outcome in outcomes if outcome.broke_design],
        "dropped": sum(not outcome.refused for outcome in outcomes),
        "no_go": dict(Counter(name for outcome in outcomes for name in outcome.no_go)),
        **{level: verdicts.count(level) for level in ("good", "doubtful", "failed", "none")},
        # Drops without a recording have -1, which must not make up for another's loss.
        "samples_lost": sum(max(0, outcome.samples_lost) for outcome in outcomes),
        "stroke_timing_us": {
            "rms": (sum(off**2 for off in timing) / len(timing)) ** 0.5 if timing else None,
            "largest": max(timing, default=None),
        },
        "distributions": [asdict(distribution) for distribution in spread],
        "refused": records(
            fields("number seed why=refused"), (outcome for outcome in outcomes if outcome.refused)
        ),
    }


def _count_notices(name: str, outcomes: Sequence[RehearsedDrop]) -> dict[str, Any]:
    """Count the drops in which a fault struck and was noticed, and by whom."""
    by = [outcome.noticed[name] for outcome in outcomes if name in outcome.noticed]
    return {
        "name": name,
        "struck": len(by),
        "noticed": sum(bool(who) for who in by),
        "noticed_by": dict(Counter(who for each in by for who in each)),
    }


def write_series(
    folder: ResultFolder,
    maneuver: Maneuver,
    filed: RobotModel,
    outcomes: Sequence[RehearsedDrop],
    result: Mapping[str, Any],
) -> None:
    """Maneuver, robot, a table with a row for each drop, and the result; all or none. Raises UsageError, OSError."""
    robot = filed.path.read_bytes()  # which may lie in this very folder
    with folder.replace_files():
        folder.file(MANEUVER).write_text(format_maneuver(maneuver), encoding="utf-8")
        folder.file(ROBOT).write_bytes(robot)
        folder.file(TABLE).write_text(_table(outcomes), encoding="utf-8")
        folder.file(SUMMARY).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
        folder.seal()


def _table(outcomes: Sequence[RehearsedDrop]) -> str:
    """CSV: a row for each drop, with the seed that flies it again alone."""
    # Columns of all that any drop gave: one that lacks a number has NaN there.
    names = list(dict.fromkeys(comparison.name for outcome in outcomes for comparison in outcome.compared))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    columns = [f"{name} {what}" for name in names for what in ("found", "std", "true")]
    writer.writerow(["number", "seed", "no_go", "refused", "verdict", "samples_lost", *columns])
    for outcome in outcomes:
        by_name = {
            comparison.name: (comparison.found, comparison.std, comparison.true)
            for comparison in outcome.compared
        }
        values = [f"{value:.9g}" for name in names for value in by_name.get(name, (float("nan"),) * 3)]
        first = record(fields("number seed no_go refused verdict samples_lost"), outcome)
        writer.writerow([*(first | {"no_go": " ".join(outcome.no_go)}).values(), *values])
    return text.getvalue()
