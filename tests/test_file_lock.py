"""Two programs never do at once what one of them must do alone, and none waits for a dead one."""

from __future__ import annotations

import fcntl
import multiprocessing
import os
import signal
from contextlib import ExitStack
from multiprocessing.connection import Connection
from pathlib import Path
from typing import IO

import pytest

from tfsat_host.file_lock import BusyError, one_at_a_time


@pytest.fixture
def lock(tmp_path: Path) -> Path:
    return tmp_path / ".record.lock"


def test_who_waits_too_long_is_told(lock: Path) -> None:
    with (
        one_at_a_time(lock, "the record"),
        pytest.raises(BusyError, match="has been writing the record for 0 s"),
        one_at_a_time(lock, "the record", patience_s=0.0),
    ):
        raise AssertionError("two at once")
    with one_at_a_time(lock, "the record", patience_s=0.0):
        pass


def test_nothing_stays_behind_whatever_happened_meanwhile(lock: Path) -> None:
    for what in (KeyboardInterrupt, ValueError, None):
        with ExitStack() as stack:
            if what is not None:
                stack.enter_context(pytest.raises(what))
            stack.enter_context(one_at_a_time(lock, "the record", patience_s=0.0))
            assert lock.exists()
            if what is not None:
                raise what
        assert list(lock.parent.iterdir()) == []


def test_a_lock_that_somebody_removed_meanwhile_is_no_failure(lock: Path) -> None:
    with one_at_a_time(lock, "the record"):
        lock.unlink()


def test_who_opened_the_file_that_the_last_one_removed_does_not_hold_the_lock(
    lock: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Reject a lock on a file that its previous holder has removed.

    The first holder lets go after the second has opened the file and before the second has locked it.
    """
    before = ExitStack()
    before.enter_context(one_at_a_time(lock, "the record"))
    flock, calls = fcntl.flock, []

    def late(file: IO[bytes], operation: int) -> None:
        calls.append(operation)
        if len(calls) == 1:
            before.close()
        flock(file, operation)

    monkeypatch.setattr(fcntl, "flock", late)
    with one_at_a_time(lock, "the record"):
        assert lock.exists()
        with pytest.raises(BusyError), one_at_a_time(lock, "the record", patience_s=0.0):
            raise AssertionError("two at once")


def _hold(lock: Path, connection: Connection) -> None:
    with one_at_a_time(lock, "the record"):
        connection.send("held")
        signal.pause()


def test_a_program_that_was_killed_stops_nobody(lock: Path) -> None:
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    program = context.Process(target=_hold, args=(lock, there))
    program.start()
    assert here.recv() == "held"
    with pytest.raises(BusyError), one_at_a_time(lock, "the record", patience_s=0.0):
        raise AssertionError("two at once")
    assert program.pid is not None
    os.kill(program.pid, signal.SIGKILL)
    program.join()
    assert lock.exists()
    with one_at_a_time(lock, "the record", patience_s=0.0):
        pass
    assert not lock.exists()
