"""Processes that share the work of one command: started the same way everywhere, or none where none can be."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Any

from tfsat_host.errors import TfsatError

_SAFE_PATH = {"PYTHONSAFEPATH": "1"}
"""A worker does not import a `signal.py` that lies in the current folder."""


class SerialExecutor(Executor):
    """An executor that computes in this process, as each task is submitted."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Compute at once; the future is done. Raises what the task raises."""
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


@contextmanager
def worker_pool(
    count: int, initializer: Callable[[], None], environment: Mapping[str, str] | None = None
) -> Iterator[Executor]:
    """Give an executor of `count` processes; of this one where the system has no shared memory for a pool.

    `initializer` is called in each of them; `environment` has variables besides those of this process.

    Raises:
        TfsatError: a process was ended from outside.
    """
    # A spawned process reads its environment as it starts, which a pool may do at any task.
    with _environment({**_SAFE_PATH, **(environment or {})}):
        try:
            # Spawned: a fork would copy the locks of whatever threads this process has.
            pool: Executor = ProcessPoolExecutor(
                count, mp_context=multiprocessing.get_context("spawn"), initializer=initializer
            )
        except (OSError, ImportError):  # no /dev/shm, or no semaphores
            pool = SerialExecutor()
        with pool:
            try:
                yield pool
            except BrokenProcessPool as error:
                raise TfsatError(
                    what="A process that computed a part of the result was ended from outside.",
                    meaning="Without all parts there is no result. The system may have run out of memory.",
                    next_step="Close other programs, then run the same command again, with --workers 1 if it has that.",
                ) from error
            finally:
                # Whatever ended the block, nobody takes the results of tasks that are still waiting.
                pool.shutdown(wait=False, cancel_futures=True)


@contextmanager
def _environment(variables: Mapping[str, str]) -> Iterator[None]:
    """Set environment variables for processes started in the block."""
    before = {name: os.environ.get(name) for name in variables}
    os.environ.update(variables)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
