"""A study on this computer: its chunks on a few processes.

Processes and not threads, for most of the time goes into numpy calls too small to let another thread in.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool

from tfsat_host.errors import TfsatError
from tfsat_host.sensitivity.study import Outcomes, Study, run_chunk

_WORTH_A_PROCESS = 8  # chunks; starting one takes as long as computing fewer


def usable_cores() -> int:
    """The processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def run_locally(
    study: Study, *, workers: int | None = None, progress: Callable[[float], None] | None = None
) -> Outcomes:
    """All chunks, on `workers` processes.

    Args:
        study: What to compute.
        workers: Processes at most; one for each usable core if None, and no more than are worth their start.
        progress: Called with the number of samples that were done since its last call.

    Raises:
        TfsatError: a process was ended by somebody else.
    """
    wanted = usable_cores() if workers is None else workers
    count = min(wanted, -(-study.chunks // _WORTH_A_PROCESS))
    done = progress or (lambda _samples: None)
    if count > 1:
        return _by_processes(study, count, done)
    parts = []
    for chunk in range(study.chunks):
        parts.append(run_chunk(study, chunk))
        done(len(parts[-1]))
    return Outcomes.joined(parts)


def _by_processes(study: Study, count: int, done: Callable[[float], None]) -> Outcomes:
    parts: dict[int, Outcomes] = {}
    # Spawned: a fork would copy the locks of whatever threads this process has.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(count, mp_context=context, initializer=_end_at_interrupt) as pool:
        chunk_of = {pool.submit(run_chunk, study, chunk): chunk for chunk in range(study.chunks)}
        try:
            for future in as_completed(chunk_of):
                parts[chunk_of[future]] = future.result()
                done(len(future.result()))
        except BrokenProcessPool as error:
            raise TfsatError(
                what="A process that computed a part of the study was ended, perhaps for want of memory.",
                meaning="Without all parts there is no result.",
                next_step="Run the same command with --workers 1.",
            ) from error
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
    return Outcomes.joined([parts[chunk] for chunk in range(study.chunks)])


def _end_at_interrupt() -> None:
    """Ctrl-C reaches this process too: it ends at once and leaves the words to the one that a person started."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
