"""A study on a Dask cluster: the same chunks, so the same numbers.

Needs the extra `dask` here, and the same tfsat on the scheduler and on every worker.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError
from functools import partial
from importlib.util import find_spec
from typing import TYPE_CHECKING, NamedTuple

from tfsat_host import __version__
from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.next_step import install_extra
from tfsat_host.notices import SILENT, Notices
from tfsat_host.plan.study import Outcomes, Study, run_chunk, run_locally

if TYPE_CHECKING:
    from distributed import Client, Future

ANSWER_S = 5.0
"""How long the scheduler may take to answer, and to have a worker."""
CHUNK_TIMEOUT_S = 600.0
"""How long the cluster may take for the next chunk, though it may be busy with others' work."""
MAX_RESUBMITTED = 3
"""Times the number of chunks: a cluster that is restarted over and over is not waited for."""
_CANCELLED = ("cancelled", "lost")
_WORTH_PROGRESS = 2_000  # samples; about a second
_NOTHING = "No sample was computed on the cluster."
_LOCALLY = "leave out --dask to run the study on this computer"


class ClusterError(TfsatError):
    """The cluster cannot be reached, or cannot do the work (exit code 1)."""


class _Answer(NamedTuple):
    version: str
    outcomes: Outcomes


def run_study(study: Study, notices: Notices, *, workers: int | None, address: str | None) -> Outcomes:
    """Run a study on `workers` local processes (one per core if None), or on the cluster at `address`.

    Raises:
        TfsatError: as `run_locally` and `run_on_cluster`.
    """
    where = "on this computer" if address is None else f"on {address}"
    quick = study.samples < _WORTH_PROGRESS
    watched = SILENT if quick else notices
    with watched.progress(f"Flying {study.samples} robots {where}", study.samples) as advance:
        if address is None:
            return run_locally(study, workers=workers, progress=advance)
        return run_on_cluster(study, address, progress=advance)


def run_on_cluster(
    study: Study, address: str, *, progress: Callable[[float], None] | None = None
) -> Outcomes:
    """Run all chunks of `study` on the workers of the Dask scheduler at `address`, such as `tcp://127.0.0.1:8786`.

    `progress` is called with the number of samples completed since its last call.

    Raises:
        ClusterError: the extra `dask` is missing, the scheduler does not answer or has no workers, no chunk
            arrives within the timeout, or the workers fail or run another version of tfsat.
        UsageError: `address` is not a valid address.
    """
    if find_spec("distributed") is None:
        raise ClusterError(
            what="--dask needs the library distributed, which is not installed.",
            meaning=_NOTHING,
            next_step=f"{install_extra('dask')}; or {_LOCALLY}.",
        )
    _check_address(address)
    with _connect(address) as client, client.as_current():
        _wait_for_workers(client, address)
        return _collect_outcomes(client, address, study, progress or (lambda _samples: None))


def _answer(study: Study, chunk: int) -> _Answer:
    """Compute one chunk on a worker and return its outcomes with the worker's tfsat version."""
    return _Answer(__version__, run_chunk(study, chunk))


def _check_address(address: str) -> None:
    """Refuses what is no address: a client of Dask would ask for it until its time is over."""
    from distributed.comm.addressing import get_address_host_port

    try:
        get_address_host_port(address, strict=False)
    except ValueError as error:
        raise UsageError(
            what=f"{address!r} is no address of a Dask scheduler ({error}).",
            meaning=_NOTHING,
            next_step=f"Write it as the scheduler prints it, such as tcp://127.0.0.1:8786; or {_LOCALLY}.",
        ) from error


def _connect(address: str) -> Client:
    from distributed import Client

    try:
        return Client(address, timeout=ANSWER_S, set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, TimeoutError) as error:
        raise ClusterError(
            what=f"No Dask scheduler answered at {address} within {ANSWER_S:g} s ({_reason(error)}).",
            meaning=_NOTHING,
            next_step="Start one with `dask scheduler`, which prints its address, and `dask worker ADDRESS` on each "
            f"computer; or {_LOCALLY}.",
        ) from error


def _wait_for_workers(client: Client, address: str) -> None:
    try:
        client.wait_for_workers(1, timeout=ANSWER_S)
    except TimeoutError as error:
        raise ClusterError(
            what=f"The Dask scheduler at {address} has had no worker for {ANSWER_S:g} s.",
            meaning=_NOTHING,
            next_step=f"Start workers: dask worker {address}; or {_LOCALLY}.",
        ) from error


def _collect_outcomes(
    client: Client, address: str, study: Study, progress: Callable[[float], None]
) -> Outcomes:
    from distributed import wait

    def submit(chunks: Sequence[int]) -> list[Future[_Answer]]:
        # Not pure: otherwise Dask would take the result of an equal call for this one.
        return list(client.map(partial(_answer, study), chunks, pure=False))

    chunk_of: dict[Future[_Answer], int] = {
        future: chunk for chunk, future in enumerate(submit(range(study.chunks)))
    }
    parts: dict[int, Outcomes] = {}
    resubmitted = 0
    # The patience is for the next chunk, not for the whole: the cluster may be busy.
    while chunk_of:
        try:
            finished = wait(  # type: ignore[no-untyped-call]
                list(chunk_of), timeout=CHUNK_TIMEOUT_S, return_when="FIRST_COMPLETED"
            ).done
        except CancelledError:
            finished = {future for future in chunk_of if future.status in _CANCELLED}
        except TimeoutError as error:
            # Take the rest off the cluster, which others use, before giving up.
            client.cancel(list(chunk_of))  # type: ignore[no-untyped-call]
            raise ClusterError(
                what=f"{len(chunk_of)} of {study.chunks} parts of the study are missing, and none has come from the "
                f"cluster at {address} for {CHUNK_TIMEOUT_S:g} s.",
                meaning="The study was given up, and cancelled on the cluster.",
                next_step=f"Look at its workers, then run the same command again; or {_LOCALLY}.",
            ) from error
        for future in finished:
            # Its worker went since `wait` saw it done: Dask computes it again.
            if future.status == "pending":
                continue
            # Somebody restarted the workers, which takes what they had to do from them: ask once more.
            if future.status in _CANCELLED and resubmitted < MAX_RESUBMITTED * study.chunks:
                chunk = chunk_of.pop(future)
                chunk_of[submit([chunk])[0]] = chunk
                resubmitted += 1
                continue
            outcomes = _outcomes(future, address)
            parts[chunk_of.pop(future)] = outcomes
            progress(len(outcomes))
    # In the order of the chunks, not of their arrival: the same numbers as on one computer.
    return Outcomes.join([parts[chunk] for chunk in range(study.chunks)])


def _outcomes(future: Future[_Answer], address: str) -> Outcomes:
    """Return the outcomes of a finished chunk.

    Refuses a chunk that failed or that another version of tfsat computed.
    """
    if future.status != "finished":
        # Only a task that raised has an error to show; a cancelled or lost one has not.
        failed = future.status == "error"
        error = future.exception() if failed else None  # type: ignore[no-untyped-call]
        raise ClusterError(
            what=f"The Dask cluster at {address} could not compute a part of the study "
            f"({future.status if error is None else _reason(error)}).",
            meaning="Without all parts there is no result.",
            next_step=f"Install tfsat-host {__version__} where the scheduler and the workers run, look at their "
            f"messages, then run the same command again; or {_LOCALLY}.",
        ) from error
    answer: _Answer = future.result()
    if answer.version != __version__:
        raise ClusterError(
            what=f"A worker of {address} has tfsat-host {answer.version}, this computer {__version__}.",
            meaning="The numbers of different versions are not to be mixed: there is no result.",
            next_step=f"Install tfsat-host {__version__} on every worker; or {_LOCALLY}.",
        )
    return answer.outcomes


def _reason(error: BaseException) -> str:
    """Kind and first line of an error."""
    first = (str(error).splitlines() or [""])[0]
    return f"{type(error).__name__}: {first}" if first else type(error).__name__
