"""What an emulated robot keeps between two runs, EEPROM, settings and card; and the folder of one that is served."""

from __future__ import annotations

import contextlib
import os
import re
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Self

from tfsat_host.devices.log_transfer import recording_name
from tfsat_host.errors import TfsatError
from tfsat_host.file_lock import BusyError, one_at_a_time
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.served_robots import HOLDER, is_served
from tfsat_host.user_folders import state_folder
from tfsat_host.whole_file import write_whole

if TYPE_CHECKING:
    from tfsat_host.emulated.emulated_robot import EmulatedRobot
    from tfsat_host.robot import RobotModel


_RECORDING = re.compile(r"DROP(\d{4})\.BIN", re.ASCII)
_MAX_MEMORY_BYTES = 256


@dataclass(frozen=True)
class Kept:
    """What was found when a robot was made.

    Attributes:
        eeprom: The sequencer's EEPROM; None before the first run.
        logger_memory: The logger's stored settings; likewise.
        card: The card's files by number.
    """

    eeprom: bytes | None
    logger_memory: bytes | None
    card: dict[int, bytes]

    def put_card(self, robot: EmulatedRobot) -> None:
        """Puts the files on the robot's card."""
        for number, data in self.card.items():
            robot.card_slot.put(number, data)


@dataclass(frozen=True)
class KeptState:
    """Where the lasting parts of one emulated robot lie.

    Attributes:
        eeprom: The sequencer's EEPROM.
        logger_memory: The logger's stored settings.
        card: Folder with the card's files, DROP0001.BIN and up.
    """

    eeprom: Path
    logger_memory: Path
    card: Path

    @classmethod
    def in_folder(cls, folder: Path) -> Self:
        """Build the state whose files lie in one folder."""
        return cls(folder / "sequencer.eeprom", folder / "logger.settings", folder / "card")

    @classmethod
    def of_user(cls) -> Self:
        """Build the state of `--emulated`, in the user's state directory."""
        return cls.in_folder(state_folder() / "emulated")

    def load(self) -> Kept:
        """Load the stored memories and recordings. Raises TfsatError if they are damaged."""
        return Kept(load_eeprom(self.eeprom), _load_logger_memory(self.logger_memory), load_card(self.card))

    def save(self, robot: EmulatedRobot, before: Kept) -> None:
        """Keeps what has changed since `before`."""
        if (eeprom := robot.eeprom()) != before.eeprom:
            write_whole(self.eeprom, eeprom)
        memory = robot.logger_memory()
        # Before the first run the memory counts as erased (all 0xFF), so that untouched settings leave no file.
        if memory != (before.logger_memory or b"\xff" * len(memory)):
            write_whole(self.logger_memory, memory)
        self._save_card(robot.card_slot.files(), before.card)

    def _save_card(self, files: dict[int, bytes], before: dict[int, bytes]) -> None:
        # What was deleted from the card during the run must not come back at the next start.
        for number in before.keys() - files.keys():
            (self.card / recording_name(number)).unlink(missing_ok=True)
        for number, data in files.items():
            # Recordings are megabytes: rewrite only those that changed.
            if before.get(number) != data:
                write_whole(self.card / recording_name(number), data)


def load_eeprom(path: Path) -> bytes | None:
    """Load the stored EEPROM image; None before the first command.

    Raises:
        TfsatError: the file is not an EEPROM image.
    """
    from tfsat_host.emulated.emulated_robot import EEPROM_BYTES

    image = _read(path)
    if image is not None and len(image) != EEPROM_BYTES:
        raise _damage_error(
            path, f"{len(image)} bytes; the sequencer's EEPROM has {EEPROM_BYTES}", "sequencer"
        )
    return image


def load_card(folder: Path) -> dict[int, bytes]:
    """Load the card's files by number, padding a file that ends within a block with zeros."""
    files = {}
    for path in sorted(folder.glob("DROP*.BIN")) if folder.is_dir() else []:
        named = _RECORDING.fullmatch(path.name)
        # Recordings are numbered from 1; whatever else lies in the folder is not the card's.
        if named and int(named[1]) > 0:
            data = path.read_bytes()
            # The emulated card holds whole blocks only, and a copied file may have been cut within one.
            files[int(named[1])] = data + bytes(-len(data) % BLOCK_BYTES)
    return files


def _load_logger_memory(path: Path) -> bytes | None:
    memory = _read(path)
    if memory is not None and len(memory) > _MAX_MEMORY_BYTES:
        raise _damage_error(path, f"{len(memory)} bytes; the logger's memory has fewer", "logger")
    return memory


def _read(path: Path) -> bytes | None:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        return None


def _damage_error(path: Path, damage: str, board: str) -> TfsatError:
    return TfsatError(
        what=f"{path} has {damage}.",
        meaning=f"The emulated {board}'s memory is damaged; no real board is concerned.",
        next_step=f"Delete {path} and run the command again.",
    )


@contextmanager
def kept_robot(
    progress: Callable[[str], None], *, model: RobotModel | None = None, as_built: bool = False
) -> Iterator[EmulatedRobot]:
    """Yield the robot of `--emulated`, keeping its boards' memories and card from one command to the next.

    `progress` gets a line when the robot is being built. It is the drop tower robot unless there is a
    `model`. `as_built`: not calibrated, so that its scale factors, angle sensors and servos are off, too.

    Raises:
        BuildError: it cannot be built.
        TfsatError: the kept state is damaged.
    """
    from tfsat_host.emulated.emulated_robot import DEFAULT_SEED, SETTLE_US, EmulatedRobot
    from tfsat_host.emulated.imperfections import draw, draw_as_built

    storage = KeptState.of_user()
    before = storage.load()
    with EmulatedRobot(
        model,
        imperfections=(draw_as_built if as_built else draw)(DEFAULT_SEED),
        eeprom=before.eeprom,
        logger_memory=before.logger_memory,
        progress=progress,
    ) as robot:
        # Fill the card before any time passes: the logger finds the files when it first looks at it.
        before.put_card(robot)
        robot.advance(SETTLE_US)
        yield robot
        # Not in a `finally`: a command that raised leaves the kept state unchanged.
        storage.save(robot, before)


_CONTROL = "control"
_LOCK_TIMEOUT_S = 0.03


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
        # Asked before the folder is made: on release only a folder made here may be removed.
        self._made = not path.exists()
        path.mkdir(parents=True, exist_ok=True)
        self._lock = contextlib.ExitStack()
        # Lock first: without the lock, links in the folder may be those of a process that still serves.
        self._claim()
        try:
            self._remove_stale()
        except TfsatError:
            self.release()
            raise

    def release(self) -> None:
        """Lets the next process have the folder. One that was made for nothing goes."""
        self._lock.close()
        if self._made:
            with contextlib.suppress(OSError):  # not empty: it was for something
                self.path.rmdir()

    def _claim(self) -> None:
        """Lock the folder's holder file, which names this process. The lock ends with the process."""
        holder = self.path / HOLDER
        try:
            # More than one try: `served_by_dead_process` elsewhere may be looking at this instant.
            lock = one_at_a_time(holder, f"the folder {self.path}", patience_s=_LOCK_TIMEOUT_S)
            file = self._lock.enter_context(lock)
        except BusyError as error:
            pid = (_read(holder) or b"").decode(errors="replace").strip() or "unknown"
            raise TfsatError(
                what=f"{self.path} is served already, by process {pid}.",
                meaning="The emulated robot that runs there goes on; no second one was started.",
                next_step=f"Use it, end it (kill {pid}), or name another folder with --dir.",
            ) from error
        # The pid is only for messages; the claim is the lock, which the system frees at death.
        file.truncate(0)
        file.write(f"{os.getpid()}\n".encode())
        file.flush()

    def _remove_stale(self) -> None:
        """Removes what a run that was killed has left; nothing else."""
        ours = {self.sequencer: stat.S_ISLNK, self.logger: stat.S_ISLNK, self.control: stat.S_ISSOCK}
        for path, is_ours in ours.items():
            try:
                mode = path.lstat().st_mode
            except FileNotFoundError:
                continue
            # The file's type tells: links and a socket are made here, so a regular file is the user's.
            if not is_ours(mode):
                raise TfsatError(
                    what=f"{path} is in the way: it was not made by {NextStep('emulate')}.",
                    meaning="The emulated robot was not started; the file is unchanged.",
                    next_step=Advice("Name another folder: ", NextStep("emulate", ("--dir", "DIR"))),
                )
            path.unlink()


def being_started(port: Path) -> bool:
    """Return whether `port` is missing because the emulated robot that will serve it is still being built.

    A robot that serves has a control socket; a port missing then has its cable pulled.
    """
    return not (port.parent / _CONTROL).exists() and is_served(port.parent)


def served_by_dead_process(port: Path) -> bool:
    """Return whether `port` is a link left behind by an emulated robot whose process was killed.

    Such a link may lead nowhere, or to a pseudo-terminal that belongs to another program by now. False
    for anything else, including a real board's port.
    """
    try:
        ours = stat.S_ISLNK(port.lstat().st_mode) and (port.parent / HOLDER).exists()
    except OSError:
        return False
    return ours and not is_served(port.parent)
