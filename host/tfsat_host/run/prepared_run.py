"""A run before its drop: what a preflight checks the robot against, and where its result goes."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

from tfsat_host import __version__
from tfsat_host.acceptance.record import EMULATED_FILE, FILE, read_acceptance
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.file_hash import sha256_of
from tfsat_host.flashing.image import default_hex, load_image
from tfsat_host.json_values import format_json
from tfsat_host.maneuver import ManeuverError, Schedule, read_maneuver, schedule_maneuver
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.output_files import check_may_write
from tfsat_host.plan.facility import DropTower, load_tower
from tfsat_host.plan.reach_envelope import envelope_of
from tfsat_host.plan.tower_checks import Check as FacilityCheck
from tfsat_host.plan.tower_checks import check_maneuver
from tfsat_host.preflight.preflight_evidence import AcceptedRobot, Failed, Missing, Reference
from tfsat_host.preflight.preflight_result import RESULT, PreflightResult
from tfsat_host.protocol.limits import BLOCK_MAGIC
from tfsat_host.quantity import record
from tfsat_host.robot import RobotModel
from tfsat_host.robot.absent_parts import load_robot_of_boards
from tfsat_host.run.campaign.campaign_folder import DROP
from tfsat_host.run.files import MANEUVER, PREFLIGHT, RECORDING, find_certificate, robot_beside
from tfsat_host.run.signed_record import entries_of, sign
from tfsat_host.whole_file import write_whole

_MADE_BY = "tfsat-host preflight"
_NAME_IMAGE = Advice(
    "make firmware, or name the image with --sequencer-image: its HEX, or the image_crc that ",
    NextStep("status", ("--json",)),
    " showed right after it was flashed.",
)
# Eight blocks, each of which begins with the magic number: one that is damaged does not hide a recording.
_LOOK_BYTES = 4096
_MAGIC = BLOCK_MAGIC.to_bytes(4, "little")


@dataclass(frozen=True, eq=False)
class PreparedRun:
    """What lies in a run's folder, read.

    Attributes:
        folder: Of the run.
        maneuver: The file, whether it is there or not.
        schedule: What it commands.
        robot: By design.
        tower: The facility.
        certificate: As it was named; None: by its usual name.
        sequencer_image: As it was named; None: that of make firmware.
        logger_image: Its CRC, as typed.
    """

    folder: Path
    maneuver: Path
    schedule: Schedule | Missing
    robot: RobotModel
    tower: DropTower
    certificate: Path | None
    sequencer_image: Path | None
    logger_image: str | None

    @classmethod
    def open(
        cls,
        folder: Path,
        *,
        maneuver: Path | None = None,
        certificate: Path | None = None,
        robot: Path | str | None = None,
        facility: Path | None = None,
        sequencer_image: Path | None = None,
        logger_image: str | None = None,
    ) -> PreparedRun:
        """Reads what lies in a run's folder, or what is named instead.

        Raises:
            UsageError: there is no such folder, or it is that of a drop that was flown.
            TfsatError: the robot or facility file cannot be understood, or the result could not be written there.
        """
        if not folder.is_dir():
            raise UsageError(
                what=f"There is no folder {folder}.",
                meaning="A preflight belongs to a run: its folder holds what is to be flown. Nothing was looked at.",
                next_step=f"mkdir {shlex.quote(str(folder))}, and copy maneuver.toml and calibration.toml into it",
            )
        require_not_flown(folder)
        check_may_write(
            folder / PREFLIGHT,
            marker=_MADE_BY.encode(),
            force=False,
            elsewhere="Make the folder writable, or copy maneuver.toml and the certificate into one that is.",
        )
        maneuver = maneuver or folder / MANEUVER
        robot_file = load_robot_of_boards(robot or robot_beside(folder))
        tower = load_tower(facility)
        # A maneuver that is missing or wrong is a finding of the checks and does not end the command.
        schedule = _schedule(maneuver)
        return cls(folder, maneuver, schedule, robot_file, tower, certificate, sequencer_image, logger_image)

    def calibration(self, emulated: bool) -> tuple[Calibration | Missing, str]:
        """Read the certificate; return its calibration and its file's name."""
        file = find_certificate(self.certificate, self.folder, Path(), emulated=emulated)
        if file is None:
            # Real and emulated robots' certificates differ in name: point to the other, do not use it.
            other = find_certificate(None, self.folder, Path(), emulated=not emulated)
            kind = "a real" if emulated else "an emulated"
            of_other = "" if other is None else f" {other} is that of {kind} robot."
            return (
                Missing(
                    f"There is no calibration in {self.folder} or here.{of_other}",
                    Advice(
                        NextStep("calibrate bias"), ", and what ", NextStep("calibrate show"), " then names"
                    ),
                ),
                "",
            )
        try:
            return read_calibration(file).of_robot(self.robot), str(file)
        except TfsatError as error:
            return Missing(f"{error.what} {error.meaning}", error.next_step), str(file)

    def acceptance(self, *, emulated: bool) -> AcceptedRobot | Missing:
        """Read the record of the robot's acceptance that lies in the run's folder or here."""
        name = EMULATED_FILE if emulated else FILE
        file = next((path for path in (self.folder / name, Path(name)) if path.is_file()), None)
        again = Advice(NextStep("acceptance"))
        if file is None:
            return Missing(
                f"There is no {name} in {self.folder} or here: the wiring was not accepted.", again
            )
        try:
            accepted = read_acceptance(file)
        except TfsatError as error:
            return Failed(error.what, error.next_step)
        if not accepted.steps:
            return Missing(f"{file} holds no step yet.", again)
        serials = accepted.sequencer.serial, accepted.logger.serial
        return AcceptedRobot(
            str(file), accepted.steps[-1].at, *serials, accepted.parts_sha256, accepted.remaining
        )

    def facility(self) -> tuple[FacilityCheck, ...] | Missing:
        """Check the maneuver against the facility's limits."""
        if isinstance(self.schedule, Missing):
            return self.schedule
        try:
            # Reach and travel of the design model from release to landing, for the tower's limits.
            envelope = envelope_of(self.robot, self.schedule, until_s=self.tower.fall_s)
        except TfsatError as error:
            return Missing(f"{error.what} {error.meaning}", error.next_step)
        return check_maneuver(self.schedule, self.robot, self.tower, envelope)

    def images(self) -> tuple[Reference | Missing, Reference | Missing]:
        """Return the reference images that the sequencer and the logger should run."""
        logger: Reference | Missing = Missing(
            "none was named, and no calibration of this logger says which one it ran then.",
            Advice(
                "Name it with --logger-image: image_crc of ",
                NextStep("status", ("--json",)),
                " right after it was flashed. The next calibration step keeps it in the certificate.",
            ),
        )
        # `make firmware` makes no image of the logger: it is named, or taken from its calibration later.
        if self.logger_image is not None:
            logger = Reference(self.logger_image, "--logger-image")
        return _sequencer_image(self.sequencer_image), logger

    def newest(self) -> tuple[datetime, str] | None:
        """Return the modification time and name of the newer of the maneuver and the certificate."""
        # Dates of files bound the computer's clock from below.
        paths = [path for path in (self.maneuver, self.certificate) if path is not None and path.is_file()]
        times = ((datetime.fromtimestamp(path.stat().st_mtime, UTC), path.name) for path in paths)
        return max(times, default=None)

    def hashes(self, certificate: str) -> dict[str, HashedFile]:
        """Hash each file that was looked at."""
        return hashes_of(
            {
                "maneuver": self.maneuver,
                "calibration": Path(certificate) if certificate else None,
                "robot": self.robot.path,
                "facility": self.tower.path,
            }
        )


@dataclass(frozen=True, slots=True)
class HashedFile:
    """A file's path, and the SHA-256 of its bytes."""

    path: str
    sha256: str


def hashes_of(files: Mapping[str, Path | None]) -> dict[str, HashedFile]:
    """Hash each of the files that is there."""
    return {
        name: HashedFile(str(path), sha256_of(path))
        for name, path in files.items()
        if path is not None and path.is_file()
    }


def require_not_flown(folder: Path) -> None:
    """Refuses the folder of a drop that is over.

    Raises:
        UsageError: it is a campaign's drop, holds a recording, or its record names one.
        OSError: something cannot be read.
    """
    why = _flown_evidence(folder)
    if why:
        raise UsageError(
            what=f"{folder} is the folder of a drop that was flown: {why}.",
            meaning="A preflight is what was known before the drop. One of today would take the place of that of then. "
            "Nothing was looked at, nothing was changed.",
            next_step=Advice(
                "Make a folder for the next drop, copy maneuver.toml and the certificate into it, then: ",
                NextStep("preflight", (str(folder.parent / "NEXT") if folder.name else "NEXT",)),
            ),
        )


def _flown_evidence(folder: Path) -> str:
    """Describe how it is known that the run was flown; empty if it was not."""
    if (folder / DROP).exists():
        return f"it holds {DROP}, so it is a campaign's"
    recording_path = next((path for path in sorted(folder.iterdir()) if _is_recording(path)), None)
    if recording_path is not None:
        return f"it holds the recording {recording_path.name}"
    # The record remembers a recording that was moved away since.
    signed = next((name for name in _signed_names(folder) if name.lower().endswith(".bin")), None)
    return "" if signed is None else f"its record has signed the recording {signed}"


def _is_recording(path: Path) -> bool:
    if path.suffix.lower() != ".bin" or not path.is_file():
        return False
    # The log's magic number shows a recording under any name; SD.bin is taken for one even if damaged.
    with path.open("rb") as file:
        return path.name == RECORDING or _MAGIC in file.read(_LOOK_BYTES)


def _signed_names(folder: Path) -> list[str]:
    """Names in the run's record; none where it is damaged: the preflight says so when it signs."""
    try:
        return [file.name for entry in entries_of(folder) for file in entry.files]
    except TfsatError:
        return []


def _schedule(file: Path) -> Schedule | Missing:
    if not file.is_file():
        return Missing(
            f"No maneuver: file {file} does not exist.",
            f"Copy the maneuver to {file}, or name it with --maneuver.",
        )
    try:
        return schedule_maneuver(read_maneuver(file))
    except ManeuverError as error:
        return Missing(f"{file}: {error.what}", error.next_step)


def _sequencer_image(named: Path | None) -> Reference | Missing:
    text = "" if named is None else str(named)
    # Eight hexadecimal digits that are no file's name are the CRC itself.
    if (
        named is not None
        and not named.exists()
        and len(text) == 8
        and set(text) <= set("0123456789abcdefABCDEF")
    ):
        return Reference(text.lower(), "--sequencer-image")
    try:
        file = named or default_hex()
        return Reference(load_image(file).crc, str(file))
    except TfsatError as error:
        return Missing(error.what, _NAME_IMAGE)


def write_result(folder: Path, result: PreflightResult) -> tuple[PreflightResult, TfsatError | None]:
    """Write `preflight.json` and sign it into the run's record; an older one is replaced.

    Returns the result with its file and signature, and why it could not be signed, if so.

    Raises:
        OSError: it cannot be written.
    """
    file = folder / PREFLIGHT
    write_whole(file, format_json({"made_by": _MADE_BY, "format": 1, **record(RESULT, result)}).encode())
    by = f"{_MADE_BY} {__version__}: {result.verdict.upper()}"
    # A damaged record does not cost the result: it stands, unsigned, and that is said.
    try:
        entry = sign(folder, [file], by, result.evidence.now)
    except TfsatError as error:
        meaning = f"The result stands in {file} but not in the run's record. {error.meaning}"
        return replace(result, file=file), error.with_words(meaning=meaning)
    return replace(result, file=file, sha256=entry.files[0].sha256), None
