"""Which maneuver the sequencer held when a drop was recorded: kept, noted by session, compared stroke by stroke.

`upload-sequence` keeps what it uploaded in the user's state folder, by the board's serial number and the maneuver's
CRC. `record start`, `arm` and `log fetch` read the board back and note its maneuver there for the session that the
logger records; `log fetch` copies the note beside the recording, as `maneuver-SESSION.toml`. The log's header has the
CRC as well, so that a card alone tells. `evaluate` takes a `maneuver.toml` for what was commanded only where it agrees
with that note, or where there is none with the header.
"""

from __future__ import annotations

import os
import shlex
import shutil
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.devices.last_run import holds_what_flew
from tfsat_host.devices.sequencer import SequencerClient, StoredManeuver, maneuver_crc, maneuver_from_board
from tfsat_host.devices.serial_ports import PortError, PortProblem, find_port, port_variable
from tfsat_host.devices.transport import SerialTransport
from tfsat_host.errors import TfsatError
from tfsat_host.maneuver import Maneuver, Schedule, format_maneuver
from tfsat_host.run.files import MANEUVER, RunFiles, schedule_in
from tfsat_host.user_folders import NoUserFolder, state_folder
from tfsat_host.whole_file import write_whole

if TYPE_CHECKING:
    from tfsat_host.sdlog import DropLog

Note = Callable[[str], None]
"""Hears something that a person should know, and that is no result."""


@dataclass(frozen=True, slots=True)
class HeldManeuver:
    """What a sequencer holds.

    Attributes:
        stored: As it was read back.
        serial: Of the board, hexadecimal; empty: it gave none.
        has_flown: The board still reports the fall in which it flew it.
    """

    stored: StoredManeuver
    serial: str
    has_flown: bool


@dataclass(frozen=True, slots=True)
class CommandedManeuver:
    """What a drop is compared with.

    Attributes:
        file: Of the maneuver; None: unknown.
        schedule: Its strokes.
        objection: Why `maneuver.toml` is not what was commanded; empty: it is, or there is none.
        remark: That a named file is not what the sequencer held; empty otherwise.
    """

    file: Path | None
    schedule: Schedule | None
    objection: str = ""
    remark: str = ""


def ask_sequencer(note: Note, *, logger_named: bool) -> HeldManeuver | None:
    """Read back what the sequencer beside a logger holds; None: there is none, or it did not say, which is noted.

    `logger_named`: the logger's port was named, so that no others are searched, and only the environment
    names a sequencer.
    """
    if logger_named and not os.environ.get(port_variable("sequencer")):
        return None
    try:
        with closing(SerialTransport(find_port("sequencer"))) as transport:
            sequencer = SequencerClient.connect(transport)
            # An upload is taken only when SAFE: the state tells whether what is read back is what flew.
            has_flown = holds_what_flew(sequencer.status())
            return HeldManeuver(sequencer.read_back(), sequencer.identity.serial, has_flown)
    except TfsatError as error:
        # That none was found needs no note; that one did not answer does.
        if not (isinstance(error, PortError) and error.code == PortProblem.NONE_FOUND):
            note(f"The sequencer was not asked which maneuver it holds. {error.what}")
        return None


def keep_upload(maneuver: Maneuver, serial: str, crc: int, note: Note) -> None:
    """Keep an uploaded maneuver by its board and CRC; a folder that cannot be written to is named in a note."""
    # Filed by board and CRC: from a read-back alone the upload's name can be found again.
    try:
        write_whole(_upload_file(serial, crc), format_maneuver(maneuver).encode())
    except (OSError, NoUserFolder) as error:
        note(f"The upload is on the board, and this computer keeps no copy of it: {_reason(error)}")


def note_held(held_maneuver: HeldManeuver, session: int, command: str, note: Note) -> bool:
    """Note what the sequencer holds for the session that is being recorded; whether it was noted.

    `command` is the one that read it back; `note` hears of a folder that cannot be written to.
    """
    crc = f"{held_maneuver.stored.crc:04x}"
    text = note_text(held_maneuver, session, command, _kept_name(held_maneuver))
    try:
        write_whole(_note_file(session), text.encode())
    except (OSError, NoUserFolder) as error:
        note(f"Maneuver {crc} of the sequencer was not noted for session {session:08x}: {_reason(error)}")
        return False
    return True


def copy_note(recording: Path, session: int, note: Note) -> Path | None:
    """Copy the note of a session beside its recording; None: there is none."""
    target = recording.with_name(note_name(session))
    try:
        source = _note_file(session)
        if source.is_file():
            shutil.copyfile(source, target)
    except (OSError, NoUserFolder) as error:
        note(f"The maneuver of session {session:08x} was not copied to {target}: {_reason(error)}")
    # A note that lies beside the recording already serves as well.
    return target if target.is_file() else None


def find_note(recording: Path, session: int) -> Path | None:
    """Find the note of a session: beside its recording, else on this computer, else None."""
    # The note that travels with the recording goes before this computer's own.
    beside = recording.with_name(note_name(session))
    if beside.is_file():
        return beside
    try:
        note_path = _note_file(session)
    except NoUserFolder:
        return None
    return note_path if note_path.is_file() else None


def note_name(session: int) -> str:
    """Return the name of a note beside the recording of a session."""
    return f"maneuver-{session:08x}.toml"


def note_text(held_maneuver: HeldManeuver, session: int, command: str, name: str = "") -> str:
    """Return a maneuver file of what a sequencer holds; the board stores no name."""
    stored, crc = held_maneuver.stored, f"{held_maneuver.stored.crc:04x}"
    board = f"sequencer {held_maneuver.serial}" if held_maneuver.serial else "the sequencer"
    header = f"# What {board} held in session {session:08x}: CRC {crc}, upload {stored.generation}, by {command}.\n"
    return header + format_maneuver(maneuver_from_board(stored, name=name))


def find_commanded(files: RunFiles, named: Path | None, log: DropLog) -> CommandedManeuver:
    """Decide what was commanded: the named file, else what the sequencer held, else `maneuver.toml`.

    Raises:
        ManeuverError: a file cannot be read or understood.
    """
    schedule = None if files.maneuver is None else schedule_in(files.maneuver)
    note = find_note(files.recording, log.session) or _find_upload(log.maneuver_crc)
    held_schedule = None if note is None else schedule_in(note)
    if schedule is None:
        return CommandedManeuver(note, held_schedule)
    # The same strokes to the last stored digit: what else differs in the files does not matter.
    if held_schedule is not None:
        agree = schedule.is_same_motion(held_schedule)
    else:
        agree = log.maneuver_crc in (None, maneuver_crc(schedule))
    if agree:
        return CommandedManeuver(files.maneuver, schedule)
    # They contradict each other: the board's read-back is evidence of what flew, the file is not.
    held = note or f"CRC {log.maneuver_crc:04x} in the log's header"
    words = f"{files.maneuver} is not the maneuver that the sequencer held in this drop ({held})"
    # A person's explicit choice goes before the evidence; a leftover maneuver.toml becomes an objection.
    if named is not None:
        return CommandedManeuver(
            files.maneuver, schedule, remark=f"{words}; it was named with --maneuver and is compared."
        )
    if note is None:
        objection = f"{words}; the drop is compared with the file. To name the right one: --maneuver FILE"
        return CommandedManeuver(files.maneuver, schedule, objection=objection)
    objection = (
        f"{words}; the drop is compared with what the sequencer held. If {MANEUVER} is left over from another drop, "
        f"replace it: cp {shlex.quote(str(note))} {shlex.quote(str(files.maneuver))}. To compare with it all the "
        f"same: --maneuver {shlex.quote(str(files.maneuver))}"
    )
    return CommandedManeuver(note, held_schedule, objection=objection)


def _find_upload(crc: int | None) -> Path | None:
    """Find a maneuver of this CRC that this computer uploaded, to whichever board: its strokes are the same."""
    try:
        return None if crc is None else next(iter(sorted(_folder().glob(f"*-{crc:04x}.toml"))), None)
    except NoUserFolder:
        return None


def _kept_name(held_maneuver: HeldManeuver) -> str:
    """Look up the name of the uploaded maneuver; the board does not store names.

    Returns an empty string if this computer did not make the upload.
    """
    from tfsat_host.maneuver import ManeuverError, read_maneuver

    try:
        return read_maneuver(_upload_file(held_maneuver.serial, held_maneuver.stored.crc)).name
    except (ManeuverError, NoUserFolder):
        return ""


def _folder() -> Path:
    return state_folder() / "maneuvers"


def _upload_file(serial: str, crc: int) -> Path:
    return _folder() / f"{serial or 'no-serial'}-{crc:04x}.toml"


def _note_file(session: int) -> Path:
    return _folder() / note_name(session)


def _reason(error: OSError | NoUserFolder) -> str:
    if isinstance(error, NoUserFolder):
        return f"{error.what} {error.next_step}"
    return f"{error.filename}: {error.strerror or error}."
