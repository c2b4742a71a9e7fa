"""Many drops, each of another robot, flown on all cores."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

from tfsat_host.blas_threads import VARIABLES
from tfsat_host.emulated.imu_part import ImuPart
from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.evaluation.verdict import verdict_of
from tfsat_host.maneuver import Schedule
from tfsat_host.rehearsal import rehearsed_drop as drops
from tfsat_host.rehearsal.day import DROPPED, Preflight
from tfsat_host.rehearsal.faults.fault_catalog import fault_named
from tfsat_host.rehearsal.judgement import JudgedDay, outcome_missed
from tfsat_host.rehearsal.rehearsed_drop import Drop
from tfsat_host.rehearsal.truth import Truth, drawn_truth, hash_of, truth_as_filed
from tfsat_host.rehearsal.truth_comparison import EstimateAndTruth, compare_with_truth
from tfsat_host.robot import RobotModel
from tfsat_host.sdlog import DropLog, load
from tfsat_host.worker_processes import worker_pool

_STOP_POLL_S = 0.2


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
        no_go: Checks of the preflight that block a drop.
        verdict: Of the evaluation; `none` without one.
        samples_lost: In the recording; -1 without one.
        strokes_off_us: When each stroke came, less when it was scheduled.
        compared: Estimates and truth.
        detected_by: Of each injected fault, by its name, who detected it (`judgement.Detection`); may be empty.
        outcome_missed: By the truth the robot did not do what it must with the injected faults.
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
    detected_by: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    outcome_missed: bool = False


def fly_many(
    series: Series,
    runs: int,
    workers: int | None = None,
    progress: Callable[[], None] = lambda: None,
    stop: Callable[[], bool] = lambda: False,
) -> tuple[RehearsedDrop, ...]:
    """Fly every drop and return them in order, the same to the bit whatever the number of workers.

    There are as many `workers` as cores if None; `progress` is called after each drop. `stop` is polled
    often: whether to begin no more drops. Those in the air are flown to their end; fewer than `runs` come
    back.
    """
    outcomes: list[RehearsedDrop] = []
    workers = workers or os.cpu_count() or 1
    # A process on each core leaves none for a second thread of its linear algebra; and sums of threads differ.
    with worker_pool(workers, _ignore_interrupts, dict.fromkeys(VARIABLES, "1")) as pool:
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
            landed, flying = wait(flying, timeout=_STOP_POLL_S, return_when=FIRST_COMPLETED)
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
    evaluation = judged.evaluation
    return RehearsedDrop(
        number,
        truth.seed,
        truth.imu,
        drop.refused.what if drop.refused is not None else "" if drop.card else "no recording",
        tuple(check.name for check in drop.blocking),
        "none" if judged.verdict is None else judged.verdict.level,
        -1 if judged.log is None else judged.log.samples_lost,
        ()
        if evaluation is None
        else tuple(1e6 * (stroke.logged_s - stroke.scheduled_s) for stroke in evaluation.strokes),
        () if evaluation is None else compare_with_truth(evaluation, drop),
        # Each who detected it once, in the order of the day; a dict keeps that, a set would not.
        {
            fault.fault.name: tuple(dict.fromkeys(detection.who for detection in fault.detections))
            for fault in judged.faults
            if fault.injected_s is not None
        },
        outcome_missed(drop),
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
