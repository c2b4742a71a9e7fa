"""A Monte Carlo study over the errors of a robot's parameters: what is drawn, and what the robots drawn do.

A study is cut into chunks that can be computed anywhere and in any order. Chunk i draws from the i-th child of the
seed, and its size is fixed: a sample has the same numbers whatever the number of workers, and the first samples of a
longer study are those of a shorter one. A source draws its deviates even if its standard deviation is 0: without one
kind of error, all others stay as they were.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from concurrent.futures import as_completed
from dataclasses import dataclass

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import quaternion
from tfsat_host.dynamics.history import ServoMotion
from tfsat_host.dynamics.propagate_within import final_attitudes
from tfsat_host.plan.error_sources import ErrorSources
from tfsat_host.plan.parameters import Parameters
from tfsat_host.worker_processes import worker_pool

CHUNK = 500
"""Samples a chunk: small enough for a processor's cache, large enough for numpy."""
MAX_DEVIATE = 4.5
"""Deviates beyond it, seven of a million, are drawn to it: a share of up to 20 % leaves something of every mass."""


@dataclass(frozen=True, eq=False)
class Study:
    """What is drawn, how often, and from which seed.

    Attributes:
        parameters: Of the robot and its plan.
        sources: What may be wrong with them.
        samples: How many, at least one.
        seed: From 0.
    """

    parameters: Parameters
    sources: ErrorSources
    samples: int
    seed: int

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return -(-self.samples // CHUNK)

    def deviates(self, chunk: int) -> FloatArray:
        """(s, d) standard normal deviates of a chunk; s is less than `CHUNK` in the last one only."""
        return self.draw_chunk(chunk)[: self.samples - chunk * CHUNK]

    def draw_chunk(self, chunk: int) -> FloatArray:
        """(CHUNK, d) those of the whole chunk, whatever the number of samples."""
        # A child of the seed by its key: no chunk depends on what others have drawn.
        seeds = np.random.SeedSequence(self.seed, spawn_key=(chunk,))
        random, first = np.random.Generator(np.random.PCG64(seeds)), self.sources.drawn_first
        counts = (first, len(self.sources.names) - first)
        deviates = np.hstack([random.standard_normal((CHUNK, count)) for count in counts])
        return np.clip(deviates, -MAX_DEVIATE, MAX_DEVIATE)

    def vectors(self, deviates: FloatArray) -> FloatArray:
        """(s, p) parameters of the samples."""
        return np.asarray(self.parameters.nominal + self.sources.shifts(deviates))


@dataclass(frozen=True, eq=False)
class Outcomes:
    """What s samples did.

    Attributes:
        quaternion_xyzw: (s, 4) final attitude of the base: from base axes to inertial axes.
        moving_time_s: (s,) time in which at least one joint moves.
        end_s: (s,) when the last joint has arrived, after release.
        error_rad: How wrong the worst of the attitudes may be by the error of the integration.
    """

    quaternion_xyzw: FloatArray
    moving_time_s: FloatArray
    end_s: FloatArray
    error_rad: float

    def __len__(self) -> int:
        return len(self.end_s)

    @classmethod
    def join(cls, parts: list[Outcomes]) -> Outcomes:
        """Join the outcomes of chunks, in their order."""
        return cls(
            np.concatenate([part.quaternion_xyzw for part in parts]),
            np.concatenate([part.moving_time_s for part in parts]),
            np.concatenate([part.end_s for part in parts]),
            max(part.error_rad for part in parts),
        )

    @property
    def rotation_vector_deg(self) -> FloatArray:
        """(s, 3)."""
        return np.degrees(quaternion.logarithm(self.quaternion_xyzw.T)).T

    @property
    def reorientation_deg(self) -> FloatArray:
        """(s,) rotation angles."""
        return np.degrees(quaternion.angle(self.quaternion_xyzw.T))

    def attitude_error_deg(self, nominal_xyzw: FloatArray) -> FloatArray:
        """(s,) angles between the final attitudes and the nominal one (4,)."""
        back = quaternion.inverse(nominal_xyzw)[:, None]
        return np.degrees(quaternion.angle(quaternion.product(back, self.quaternion_xyzw.T)))


def run_chunk(study: Study, chunk: int) -> Outcomes:
    """Compute the outcomes of one chunk; the same wherever it runs.

    The whole chunk is flown even if the study ends within it: its robots share their steps, so a sample's
    bits do not depend on how many follow.
    """
    parameters, vectors = study.parameters, study.vectors(study.draw_chunk(chunk))
    motion = parameters.motion(vectors)
    attitude, error_rad = final_attitudes(
        parameters.robots(vectors),
        parameters.history(vectors, motion),
        initial_rate_rad_s=parameters.initial_rate_rad_s,
    )
    count = len(study.deviates(chunk))
    return Outcomes(
        np.ascontiguousarray(attitude.T[:count]),
        _moving_time_s(motion)[:count],
        motion.end_s.max(axis=0)[:count],
        error_rad,
    )


def _moving_time_s(motion: ServoMotion) -> FloatArray:
    """(s,) time in which at least one joint moves."""
    order = motion.start_s.argsort(axis=0, kind="stable")
    start_s, end_s = (np.take_along_axis(times, order, axis=0) for times in (motion.start_s, motion.end_s))
    # What a stroke adds begins where all before it have ended.
    until_s = np.vstack([start_s[:1], np.maximum.accumulate(end_s, axis=0)[:-1]])
    return np.asarray(np.maximum(0.0, end_s - np.maximum(start_s, until_s)).sum(axis=0))


_WORTH_A_PROCESS = 8  # chunks; starting one takes as long as computing fewer


def usable_cores() -> int:
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def run_locally(
    study: Study, *, workers: int | None = None, progress: Callable[[float], None] | None = None
) -> Outcomes:
    """Run all chunks of `study` on `workers` local processes at most.

    None: one for each usable core, and no more than are worth their start. `progress` is called with the
    number of samples completed since its last call.

    Raises:
        TfsatError: a process was ended from outside.
    """
    max_workers = usable_cores() if workers is None else workers
    # No more processes than have chunks enough to be worth their start.
    count = min(max_workers, -(-study.chunks // _WORTH_A_PROCESS))
    report_progress = progress or (lambda _samples: None)
    if count > 1:
        return _by_processes(study, count, report_progress)
    parts = []
    for chunk in range(study.chunks):
        parts.append(run_chunk(study, chunk))
        report_progress(len(parts[-1]))
    return Outcomes.join(parts)


def _by_processes(study: Study, count: int, progress: Callable[[float], None]) -> Outcomes:
    parts: dict[int, Outcomes] = {}
    with worker_pool(count, end_at_interrupt) as pool:
        chunk_of = {pool.submit(run_chunk, study, chunk): chunk for chunk in range(study.chunks)}
        for future in as_completed(chunk_of):
            parts[chunk_of[future]] = future.result()
            progress(len(future.result()))
    # Chunks finish in any order: join them by number, so that samples keep their places.
    return Outcomes.join([parts[chunk] for chunk in range(study.chunks)])


def end_at_interrupt() -> None:
    """End at Ctrl-C, which reaches this process too, and leave the words to the one that a person started."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
