"""The files of one drop: a recording, the files with it, and what else can be given for its evaluation."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.file_hash import sha256_of
from tfsat_host.maneuver import Defect, ManeuverError, Schedule, read_maneuver, schedule_maneuver
from tfsat_host.next_step import Advice, NextStep

RECORDING = "SD.bin"
MANEUVER = "maneuver.toml"
ROBOT = "robot.toml"
ROBOTS = REAL, EMULATED, UNKNOWN = ("real", "emulated", "unknown")
"""Whether a robot fell, or an emulated one did, as in a rehearsal: by the logger's own words in the recording."""
PREFLIGHT = "preflight.json"
CERTIFICATE, EMULATED_CERTIFICATE = "calibration.toml", "calibration-emulated.toml"
EVALUATION_MARKER = b'"made_by": "tfsat-host evaluate'
"""By which an evaluation that was written to a file is known."""
CORRECTED_MARKER = b"# Corrected robot, by tfsat-host evaluate"
"""By which a corrected robot file is known."""
REHEARSED = ".tfsat-rehearsal"
"""A folder with this file was made by a rehearsal and may be made again by another; the file names what lies there."""
_HASHED = re.compile(r"(?P<sha256>[0-9a-f]{64})  (?P<name>.+)")
_LISTED = 8
_NOTHING_DONE = "Nothing was evaluated."
_EVALUATE = NextStep("evaluate")
_FILES = ("maneuver", "calibration", "robot", "video", "laser", "facility")
_FLAGS = ("swarm",)
_OF_ONE_DROP = ("session", "video", "video_rate", "laser")


@dataclass(frozen=True, slots=True)
class EvaluationOptions:
    """What is known of a drop besides its recording.

    Attributes:
        maneuver: What was flown; None: `maneuver.toml` next to the recording, if it is there.
        calibration: The certificate; None: the one next to the recording or in the current folder, if there is one.
        robot: A robot file, or the name of a shipped one; None: `robot.toml` next to the recording, else `drop_tower`.
        video: Events of the drop in a video, CSV.
        video_rate: Seconds of the video's times in a real one: 1 in real time; None: as its events tell.
        laser: Places of the two laser spots over time, CSV.
        facility: For the release velocity that `laser` gives; None: COSMOTORRE's.
        session: Id of the recording in its file; None: as `sdlog.load` chooses.
        swarm: Whether the paper's particle swarm looks for the centers of mass as well.
    """

    maneuver: Path | None = None
    calibration: Path | None = None
    robot: Path | str | None = None
    video: Path | None = None
    video_rate: float | None = None
    laser: Path | None = None
    facility: Path | None = None
    session: int | None = None
    swarm: bool = False

    def as_arguments(self) -> tuple[str, ...]:
        """Format the options as they are typed for `evaluate`, for the provenance of results."""
        arguments = [f"--{name} {getattr(self, name)}" for name in _FILES if getattr(self, name) is not None]
        arguments += [f"--video-rate {self.video_rate:g}"] if self.video_rate is not None else []
        arguments += [f"--session {self.session:08x}"] if self.session is not None else []
        return (*arguments, *(f"--{name}" for name in _FLAGS if getattr(self, name)))

    def check(self, places: Sequence[Path]) -> None:
        """Check the options against each other and against the number of drops.

        Raises:
            UsageError: an option of one drop was given for several, a drop was named twice, a facility was given
                without a laser, or a video rate without a video or out of range.
        """
        if self.facility is not None and self.laser is None:
            raise _wrong("--facility permits a release velocity, and only --laser tells that velocity.")
        if self.video_rate is not None and not 1e-3 < self.video_rate < 1e3:
            raise _wrong(f"--video-rate {self.video_rate:g} is no rate of a video: 1 in real time.")
        if self.video_rate is not None and self.video is None:
            raise _wrong("--video-rate is of the times in --video, and that was not given.")
        if len(places) == 1:
            return
        for name in _OF_ONE_DROP:
            if getattr(self, name) is not None:
                raise _wrong(f"--{name.replace('_', '-')} belongs to one drop, and {len(places)} were named.")
        # Resolved, one folder named in two ways is one drop.
        real = [place.resolve() for place in places]
        twice = next((place for i, place in enumerate(places) if real[i] in real[:i]), None)
        if twice is not None:
            raise _wrong(f"{twice} was named twice: one drop says nothing about itself.")


AS_FOUND = EvaluationOptions()
"""With what lies next to the recording."""


def _wrong(what: str) -> UsageError:
    return UsageError(what=what, meaning=_NOTHING_DONE, next_step=Advice(NextStep("evaluate", ("--help",))))


_MADE_BY_DECODE = (".csv", ".npz", ".mat", ".parquet", ".mcap")


@dataclass(frozen=True, slots=True)
class RunFiles:
    """Where the parts of one drop are.

    Attributes:
        recording: The file off the card.
        maneuver: What was commanded; None: not known.
    """

    recording: Path
    maneuver: Path | None


def run_files(
    place: Path,
    maneuver: Path | None,
    *,
    command: NextStep = _EVALUATE,
    nothing: str = _NOTHING_DONE,
) -> RunFiles:
    """Resolve a RUN, a recording or a folder with one, to its files.

    Args:
        place: As it was typed.
        maneuver: As it was typed; None: the one next to the recording.
        command: The command that asks, up to the recording's name, for errors.
        nothing: The sentence for errors that states what was not done.

    Raises:
        TfsatError: there is nothing of that name, or the folder holds no recording, or several.
    """
    recording = _recording_in(place, command, nothing) if place.is_dir() else place
    if not place.exists():
        raise TfsatError(
            what=f"There is no file or folder {place}.",
            meaning=nothing,
            next_step=Advice(
                "Name the recording off the card, or the folder with it: ", command.with_arguments(RECORDING)
            ),
        )
    # Evidence is the raw log alone, with its blocks and their CRCs.
    if recording.suffix.lower() in _MADE_BY_DECODE:
        raw = recording.with_suffix(".bin")
        raise TfsatError(
            what=f"{recording} is what decode made of a recording, not the recording itself.",
            meaning=nothing,
            next_step=Advice(command.with_arguments(str(raw)))
            if raw.is_file()
            else Advice(command, " SD.bin, the file off the card"),
        )
    default = recording.parent / MANEUVER
    return RunFiles(recording, maneuver or (default if default.is_file() else None))


def robot_beside(place: Path) -> Path | None:
    """`robot.toml` of a run: the robot that was dropped, as its file had it then; None: none lies there.

    Args:
        place: The run's folder, or the recording in it.
    """
    file = (place if place.is_dir() else place.parent) / ROBOT
    return file if file.is_file() else None


def names_of(recordings: Sequence[Path]) -> list[str]:
    """Return a unique name for people of each drop.

    It is the folder's name, or the file's where that differs from the default.
    """
    names: list[str] = []
    for recording in recordings:
        folder = recording.resolve().parent.name or "drop"
        name = folder if recording.name == RECORDING else recording.stem
        # Count the numbered ones as well: the third of a name becomes `name (3)`.
        same = sum(other == name or other.startswith(f"{name} (") for other in names)
        names.append(f"{name} ({same + 1})" if same else name)
    return names


def find_certificate(named: Path | None, *folders: Path, emulated: bool) -> Path | None:
    """Find the certificate: the named one, else the first of its usual name in `folders`, else None."""
    if named is not None:
        return named
    name = EMULATED_CERTIFICATE if emulated else CERTIFICATE
    return next((folder / name for folder in folders if (folder / name).is_file()), None)


def command_options(file: Path, robot: Path | None = None, *, emulated: bool) -> tuple[str, ...]:
    """Return the options that make a `calibrate` command use that certificate; none where none is needed.

    `robot` is its robot's file; None: the one beside the certificate, if any.
    """
    default = Path(EMULATED_CERTIFICATE if emulated else CERTIFICATE)
    out = () if file.resolve() == default.resolve() else ("--out", str(file))
    return (*out, *robot_options(robot or robot_beside(file.parent)), *(("--emulated",) if emulated else ()))


def robot_options(robot: Path | None) -> tuple[str, ...]:
    """Return the options by which a command takes a robot file; none for the shipped one, which it takes by default."""
    from tfsat_host.robot import default_robot_path

    shipped = robot is None or sha256_of(robot) == sha256_of(default_robot_path())
    return () if shipped else ("--robot", str(robot))


def rehearsed_files(folder: Path) -> dict[str, str]:
    """SHA-256 of each file that a rehearsal left there by its mark, empty where that does not say; none without one."""
    mark = folder / REHEARSED
    # After the mark's first line each line is a file, in the format of sha256sum where its hash was noted.
    lines = mark.read_text(encoding="utf-8", errors="replace").splitlines()[1:] if mark.is_file() else []
    hashed = [(_HASHED.fullmatch(line), line) for line in lines]
    named = [(match["name"], match["sha256"]) if match else (line, "") for match, line in hashed]
    # A mark is text that may have been edited: names that lead out of the folder are dropped.
    return {name: sha256 for name, sha256 in named if is_inside(name)}


def is_inside(name: str) -> bool:
    """Return whether a relative name from an untrusted source stays below its folder."""
    parts = PurePosixPath(name).parts
    return bool(parts) and not PurePosixPath(name).is_absolute() and ".." not in parts and "\0" not in name


def schedule_in(file: Path) -> Schedule:
    """Read the schedule that a maneuver file commands.

    Raises:
        ManeuverError: it cannot be read, understood or flown; names the file.
    """
    try:
        maneuver = read_maneuver(file)
        try:
            return schedule_maneuver(maneuver)
        except ManeuverError as error:
            raise error.in_file(file) from error
    except ManeuverError as error:
        unreadable = error.code == Defect.FILE_UNREADABLE
        raise error.with_words(
            meaning=f"{error.meaning} {_NOTHING_DONE}".strip(),
            next_step="Give the path of the maneuver that was flown with --maneuver, or leave that out."
            if unreadable
            else None,
        ) from None


def _recording_in(folder: Path, command: NextStep, nothing: str) -> Path:
    """`SD.bin`, or else the only recording there."""
    recordings = sorted(path for path in folder.glob("*.[bB][iI][nN]") if path.is_file())
    usual = [path for path in recordings if path.name == RECORDING]
    # SD.bin goes before what else lies there; among several others none is guessed.
    if usual or len(recordings) == 1:
        return (usual or recordings)[0]
    if not recordings:
        raise TfsatError(
            what=f"{folder} holds no recording: no {RECORDING}, no other file that ends in .bin.",
            meaning=nothing,
            next_step=Advice(
                "Copy the recording off the card into it (DROP0001.BIN and up), or fetch it: ",
                NextStep("log fetch", ("1",)),
            ),
        )
    names = ", ".join(path.name for path in recordings[:_LISTED]) + (
        ", …" if len(recordings) > _LISTED else ""
    )
    raise TfsatError(
        what=f"{folder} holds several recordings: {names}.",
        meaning=f"Which of them is meant is not known. {nothing}",
        next_step=Advice("Name one: ", command.with_arguments(str(recordings[0]))),
    )
