"""The folder where an emulated robot is served: who has it, what lies in it."""

from __future__ import annotations

import contextlib
import fcntl
import os
import stat
import time
from pathlib import Path

from tfsat_host.emulated.state import KeptState
from tfsat_host.errors import TfsatError

_CONTROL = "control"
_HOLDER = "emulate.pid"
_LOCK_ATTEMPTS = 3
_LOCK_RETRY_S = 0.01


class ServedFolder:
    """A folder that this process alone serves, until `release`.

    Attributes:
        sequencer, logger: Links to the ports.
        control: The control socket.
        kept: What lasts from one start to the next: the sequencer's EEPROM, the logger's settings, the card.
        card: Copy of the card's newest recording.

    Raises:
        TfsatError: another process serves it, or a file of the user's is in the way.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.sequencer = path / "sequencer"
        self.logger = path / "logger"
        self.control = path / _CONTROL
        self.kept = KeptState.in_folder(path)
        self.card = path / "SD.bin"
        self._made = not path.exists()
        path.mkdir(parents=True, exist_ok=True)
        self._holder = _claim(path / _HOLDER, path)
        try:
            self._remove_stale()
        except TfsatError:
            self.release()
            raise

    def release(self) -> None:
        """Lets the next process have the folder. One that was made for nothing goes."""
        (self.path / _HOLDER).unlink(missing_ok=True)
        os.close(self._holder)
        if self._made:
            with contextlib.suppress(OSError):  # not empty: it was for something
                self.path.rmdir()

    def _remove_stale(self) -> None:
        """Removes what a run that was killed has left; nothing else."""
        ours = {self.sequencer: stat.S_ISLNK, self.logger: stat.S_ISLNK, self.control: stat.S_ISSOCK}
        for path, is_ours in ours.items():
            try:
                mode = path.lstat().st_mode
            except FileNotFoundError:
                continue
            if not is_ours(mode):
                raise TfsatError(
                    what=f"{path} is in the way: it was not made by tfsat-host emulate.",
                    meaning="The emulated robot was not started; the file is as it was.",
                    next_step="Name another folder: tfsat-host emulate --dir DIR",
                )
            path.unlink()


def being_started(port: Path) -> bool:
    """Whether `port` is missing because the emulated robot that will serve it is still being built.

    Once it serves, there is its control socket; a port that is missing then has its cable pulled.
    """
    return not (port.parent / _CONTROL).exists() and _is_held(port.parent)


def served_by_dead_process(port: Path) -> bool:
    """Whether `port` is a link that an emulated robot has left behind: its process was killed.

    Such a link may lead nowhere, or to a pseudo-terminal that belongs to another program by now. False
    for anything else, a real board's port included.
    """
    try:
        ours = stat.S_ISLNK(port.lstat().st_mode) and (port.parent / _HOLDER).exists()
    except OSError:
        return False
    return ours and not _is_held(port.parent)


def _is_held(folder: Path) -> bool:
    """A live process serves the folder."""
    try:
        holder = os.open(folder / _HOLDER, os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        return False
    try:
        fcntl.flock(holder, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    finally:
        os.close(holder)
    return False


def _claim(holder: Path, folder: Path) -> int:
    """Locks the folder's holder file, which names this process. The lock ends with the process."""
    while True:
        descriptor = os.open(holder, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        if not _lock(descriptor):
            pid = os.read(descriptor, 32).decode(errors="replace").strip() or "unknown"
            os.close(descriptor)
            raise TfsatError(
                what=f"{folder} is served already, by process {pid}.",
                meaning="The emulated robot that runs there goes on; no second one was started.",
                next_step=f"Use it, end it (kill {pid}), or name another folder with --dir.",
            )
        if _is_still(descriptor, holder):
            os.truncate(descriptor, 0)
            os.write(descriptor, f"{os.getpid()}\n".encode())
            return descriptor
        os.close(descriptor)


def _lock(descriptor: int) -> bool:
    """Tries more than once: `served_by_dead_process` elsewhere may be looking at this instant."""
    for attempt in range(_LOCK_ATTEMPTS):
        if attempt:
            time.sleep(_LOCK_RETRY_S)
        with contextlib.suppress(BlockingIOError):
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
    return False


def _is_still(descriptor: int, path: Path) -> bool:
    """Whether `path` names the open file: its former holder may just have removed it."""
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except FileNotFoundError:
        return False
