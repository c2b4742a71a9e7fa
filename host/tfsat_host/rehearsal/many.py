"""Many drops, each of another robot, and how their results are distributed."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from tfsat_host.emulated.imu_part import ImuPart
from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.evaluation import Evaluation, evaluate
from tfsat_host.evaluation.verdict import Verdict, verdict_of
from tfsat_host.maneuver import Schedule
from tfsat_host.rehearsal.compared import Compared, compared
from tfsat_host.rehearsal.day import DROPPED
from tfsat_host.rehearsal.drop import Drop
from tfsat_host.rehearsal.faults.fault import Fault
from tfsat_host.rehearsal.faults.known import fault_named
from tfsat_host.rehearsal.noticed import notices_of, said_of
from tfsat_host.rehearsal.outcome import came_of, designed_for
from tfsat_host.rehearsal.preflight import Preflight
from tfsat_host.rehearsal.rehearse import rehearse
from tfsat_host.rehearsal.truth import drawn_truth, hash_of, truth_as_filed
from tfsat_host.robot import RobotModel
from tfsat_host.sdlog import DropLog, load

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
        """Of drop `number`, from 1, whoever flies it; the first is that of `rehearse` alone."""
        return self.seed if number == 1 else hash_of(self.seed, number)


@dataclass(frozen=True, eq=False)
class Flown:
    """Of one drop.

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
        noticed: Of each fault that struck, by its name, who noticed it (see `noticed.Notice`); nobody, if it is empty.
        broke_design: By the truth the robot did not do what it must with the faults that struck.
    """

    number: int
    seed: int
    imu: str
    refused: str
    no_go: tuple[str, ...]
    verdict: str
    samples_lost: int
    strokes_off_us: tuple[float, ...]
    compared: tuple[Compared, ...]
    noticed: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    broke_design: bool = False


def fly_many(
    series: Series,
    runs: int,
    workers: int | None = None,
    progress: Callable[[], None] = lambda: None,
    stop: Callable[[], bool] = lambda: False,
) -> tuple[Flown, ...]:
    """Every drop, in order; the same to the bit whatever the number of workers.

    Args:
        series: What to fly.
        runs: How often.
        workers: Processes; None: one for each core.
        progress: Told after each drop.
        stop: Asked often: whether to begin no more drops. Those that are in the air are flown to their end; fewer
            than `runs` come back.
    """
    found: list[Flown] = []
    workers = workers or os.cpu_count() or 1
    # A process on each core leaves none for a second thread of its linear algebra; and sums of threads differ.
    with (
        _environment(dict.fromkeys(_THREADS, "1")),
        ProcessPoolExecutor(workers, get_context("spawn"), initializer=_hear_nothing) as pool,
    ):
        numbers = iter(range(1, runs + 1))
        flying: set[Future[Flown]] = set()
        while True:
            while len(flying) < workers and not stop() and (number := next(numbers, None)) is not None:
                with _deaf():
                    flying.add(pool.submit(_flown, series, number))
            if stop():
                flying = {one for one in flying if not one.cancel()}
            if not flying:
                break
            landed, flying = wait(flying, timeout=_ASKED_EVERY_S, return_when=FIRST_COMPLETED)
            for one in landed:
                found.append(one.result())
                progress()
    return tuple(sorted(found, key=lambda outcome: outcome.number))


@contextmanager
def _deaf() -> Iterator[None]:
    """A process that begins meanwhile never hears Ctrl-C, which reaches all of a terminal: its drop is to be told."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT,))
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _hear_nothing() -> None:
    """The same for one that has begun."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def _environment(names: dict[str, str]) -> Iterator[None]:
    """For processes that are started meanwhile."""
    before = {name: os.environ.get(name) for name in names}
    os.environ.update(names)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _flown(series: Series, number: int) -> Flown:
    seed, filed = series.seed_of(number), series.filed
    truth = truth_as_filed(filed, seed) if series.as_filed else drawn_truth(filed, seed, series.part)
    struck: dict[str, float] = {}
    faults = tuple(
        fault.telling(partial(struck.__setitem__, fault.name)) for fault in map(fault_named, series.faults)
    )
    drop = rehearse(
        series.schedule, filed, truth, hex_path=series.hex_path, preflight=series.preflight, faults=faults
    )
    broke = bool(struck) and came_of(designed_for(faults, struck), drop) is False
    no_go = () if drop.checked is None else tuple(check.name for check in drop.checked.wrong)
    if drop.refused is not None or not drop.card:
        why = "no recording" if drop.refused is None else drop.refused.what
        noticed = _noticed(faults, struck, drop)
        return Flown(number, seed, truth.imu, why, no_go, "none", -1, (), (), noticed, broke)
    log = _decoded(drop)
    try:
        found = evaluate(log, filed, drop.calibration, series.schedule, recorded=DROPPED)
    except TfsatError as error:
        noticed = _noticed(faults, struck, drop, log, refusal=error)
        return Flown(number, seed, truth.imu, "", no_go, "none", log.samples_lost, (), (), noticed, broke)
    off = [1e6 * (stroke.logged_s - stroke.scheduled_s) for stroke in found.strokes]
    beside = compared(found, drop, truth, filed)
    verdict = verdict_of(found)
    noticed = _noticed(faults, struck, drop, log, (found, verdict))
    lost = log.samples_lost
    return Flown(number, seed, truth.imu, "", no_go, verdict.level, lost, tuple(off), beside, noticed, broke)


def _noticed(
    faults: Sequence[Fault],
    struck: Collection[str],
    drop: Drop,
    log: DropLog | None = None,
    told: tuple[Evaluation, Verdict] | None = None,
    refusal: TfsatError | None = None,
) -> dict[str, tuple[str, ...]]:
    said, alone = said_of(drop, log, told, refusal), len(faults) == 1
    good = told is not None and told[1].level == "good"
    return {
        fault.name: tuple(
            dict.fromkeys(one.who for one in notices_of(fault, drop, said, alone=alone, good=good))
        )
        for fault in faults
        if fault.name in struck
    }


def _decoded(drop: Drop) -> DropLog:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "SD.bin"
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
        count: Drops that told it.
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


def distributions(outcomes: Sequence[Flown]) -> tuple[Distribution, ...]:
    """Of every number that was compared, in the order of the first drop that told it."""
    by_name: dict[str, list[Compared]] = {}
    for outcome in outcomes:
        for one in outcome.compared:
            by_name.setdefault(one.name, []).append(one)
    return tuple(_distribution(name, ones) for name, ones in by_name.items())


def _distribution(name: str, ones: Sequence[Compared]) -> Distribution:
    true, error = np.array([one.true for one in ones]), np.array([one.found - one.true for one in ones])
    std = np.array([one.std for one in ones])
    return Distribution(
        name,
        ones[0].unit,
        float(true.mean()),
        float(true.std()),
        float(np.sqrt((error**2).mean())),
        float(np.abs(error).max()),
        float(np.median(std)),
        float((np.abs(error) <= 1.96 * std).mean()),
        len(ones),
    )
