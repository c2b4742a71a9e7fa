"""The files of one drop: a recording, and what lies beside it."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.errors import TfsatError

if TYPE_CHECKING:
    from tfsat_host.maneuver import Schedule

RECORDING = "SD.bin"
MANEUVER = "maneuver.toml"
ROBOT = "robot.toml"
_LISTED = 8
_NOTHING_DONE = "Nothing was evaluated."


@dataclass(frozen=True, slots=True)
class RunFiles:
    """Where the parts of one drop are.

    Attributes:
        recording: The file off the card.
        maneuver: What was commanded; None: no file tells.
    """

    recording: Path
    maneuver: Path | None


def run_files(
    place: Path, maneuver: Path | None, *, command: str = "evaluate", nothing: str = _NOTHING_DONE
) -> RunFiles:
    """What a RUN is: a recording, or a folder with one.

    Args:
        place: As it was typed.
        maneuver: As it was typed; None: the one beside the recording.
        command: Which asks; for errors.
        nothing: What it then did not do; a sentence.

    Raises:
        TfsatError: there is nothing of that name, or the folder holds no recording, or several.
    """
    recording = _recording_in(place, command, nothing) if place.is_dir() else place
    if not place.exists():
        raise TfsatError(
            what=f"There is no file or folder {place}.",
            meaning=nothing,
            next_step=f"Name the recording off the card, or the folder with it: tfsat-host {command} SD.bin",
        )
    beside = recording.parent / MANEUVER
    return RunFiles(recording, maneuver or (beside if beside.is_file() else None))


def robot_beside(place: Path) -> Path | None:
    """`robot.toml` of a run: the robot that was dropped, as its file had it then; None: none lies there.

    Args:
        place: The run's folder, or the recording in it.
    """
    file = (place if place.is_dir() else place.parent) / ROBOT
    return file if file.is_file() else None


def schedule_in(file: Path) -> Schedule:
    """What a maneuver file commands.

    Raises:
        ManeuverError: it cannot be read, understood or flown; names the file.
    """
    from tfsat_host.maneuver import Defect, ManeuverError, read_maneuver, schedule_maneuver

    try:
        maneuver = read_maneuver(file)
        try:
            return schedule_maneuver(maneuver)
        except ManeuverError as error:
            raise error.in_file(str(file)) from error
    except ManeuverError as error:
        error.meaning = f"{error.meaning} {_NOTHING_DONE}".strip()
        if error.code == Defect.FILE_UNREADABLE:
            error.next_step = (
                "Give the path of the maneuver that was flown with --maneuver, or leave that out."
            )
        raise


def _recording_in(folder: Path, command: str, nothing: str) -> Path:
    """`SD.bin`, or else the only recording there."""
    found = sorted(path for path in folder.glob("*.[bB][iI][nN]") if path.is_file())
    usual = [path for path in found if path.name == RECORDING]
    if usual or len(found) == 1:
        return (usual or found)[0]
    if not found:
        raise TfsatError(
            what=f"{folder} holds no recording: no {RECORDING}, no other file that ends in .bin.",
            meaning=nothing,
            next_step="Copy the recording off the card into it (DROP0001.BIN and up), or fetch it: "
            "tfsat-host log fetch 1",
        )
    names = ", ".join(path.name for path in found[:_LISTED]) + (", …" if len(found) > _LISTED else "")
    raise TfsatError(
        what=f"{folder} holds several recordings: {names}.",
        meaning=f"Which of them is meant is not known. {nothing}",
        next_step=f"Name one: tfsat-host {command} {shlex.quote(str(found[0]))}",
    )
