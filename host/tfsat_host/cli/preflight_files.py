"""A run's files for a preflight: what the drop is checked against, and where the result goes."""

from __future__ import annotations

import argparse
import json
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.calibration_notice import find_certificate
from tfsat_host.cli.flown import require_not_flown
from tfsat_host.cli.output import jsonable
from tfsat_host.cli.outputs import check_may_write
from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.file_hash import sha256_of
from tfsat_host.whole_file import write_whole

if TYPE_CHECKING:
    from tfsat_host.calibration.certificate.certificate import Calibration
    from tfsat_host.facility import Check as FacilityCheck
    from tfsat_host.facility import DropTower
    from tfsat_host.maneuver import Schedule
    from tfsat_host.preflight import Check
    from tfsat_host.preflight.evidence import Evidence, Missing, Reference
    from tfsat_host.robot import RobotModel

RESULT = "preflight.json"
MANEUVER = "maneuver.toml"
_MADE_BY = "tfsat-host preflight"
_NAME_IMAGE = (
    "make firmware, or name the image with --sequencer-image: its HEX, or the image_crc that tfsat-host status --json "
    "showed right after it was flashed."
)


@dataclass(frozen=True, eq=False)
class RunFiles:
    """What lies in a run's folder, read.

    Attributes:
        folder: Of the run.
        maneuver: The file, whether it is there or not.
        schedule: What it commands.
        robot: By design.
        tower: The facility.
        certificate: As it was named; None: by its usual name.
        sequencer_image: As it was named; None: that of make firmware.
        logger_image: Its CRC as it was named.
    """

    folder: Path
    maneuver: Path
    schedule: Schedule | Missing
    robot: RobotModel
    tower: DropTower
    certificate: Path | None
    sequencer_image: Path | None
    logger_image: str | None

    def calibration(self, emulated: bool) -> tuple[Calibration | Missing, str]:
        """The certificate, and its name."""
        from tfsat_host.calibration.certificate.file import read_calibration
        from tfsat_host.preflight.evidence import Missing

        file = find_certificate(self.certificate, self.folder, Path(), emulated=emulated)
        if file is None:
            other = find_certificate(None, self.folder, Path(), emulated=not emulated)
            kind = "a real" if emulated else "an emulated"
            beside = "" if other is None else f" {other} is that of {kind} robot."
            return (
                Missing(
                    f"There is no calibration in {self.folder} or here.{beside}",
                    "tfsat-host calibrate bias, and what tfsat-host calibrate show then names",
                ),
                "",
            )
        try:
            return read_calibration(file), str(file)
        except TfsatError as error:
            return Missing(f"{error.what} {error.meaning}", error.next_step), str(file)

    def facility(self) -> tuple[FacilityCheck, ...] | Missing:
        """What the facility says of the maneuver."""
        from tfsat_host.facility import check_maneuver, envelope_of
        from tfsat_host.preflight.evidence import Missing

        if isinstance(self.schedule, Missing):
            return self.schedule
        try:
            envelope = envelope_of(self.robot, self.schedule, until_s=self.tower.fall_s)
        except TfsatError as error:
            return Missing(f"{error.what} {error.meaning}", error.next_step)
        return check_maneuver(self.schedule, self.robot, self.tower, envelope)

    def images(self) -> tuple[Reference | Missing, Reference | Missing]:
        """What the sequencer and the logger should run."""
        from tfsat_host.preflight.evidence import Missing, Reference

        logger: Reference | Missing = Missing(
            "none was named, and no calibration of this logger says which one it ran then.",
            "Name it with --logger-image: image_crc of tfsat-host status --json right after it was flashed. The "
            "next calibration step keeps it in the certificate.",
        )
        if self.logger_image is not None:
            logger = Reference(self.logger_image, "--logger-image")
        return _sequencer_image(self.sequencer_image), logger

    def newest(self) -> tuple[datetime, str] | None:
        """The youngest of the files that people made, and its name."""
        paths = [path for path in (self.maneuver, self.certificate) if path is not None and path.is_file()]
        times = ((datetime.fromtimestamp(path.stat().st_mtime, UTC), path.name) for path in paths)
        return max(times, default=None)

    def hashes(self, certificate: str) -> dict[str, Any]:
        """Path and SHA-256 of each file that was looked at."""
        return hashes_of(
            {
                "maneuver": self.maneuver,
                "calibration": Path(certificate) if certificate else None,
                "robot": self.robot.path,
                "facility": self.tower.path,
            }
        )


def hashes_of(files: Mapping[str, Path | None]) -> dict[str, Any]:
    """Path and SHA-256 of each of them that is there."""
    return {
        name: {"path": str(path), "sha256": sha256_of(path)}
        for name, path in files.items()
        if path is not None and path.is_file()
    }


def run_files(args: argparse.Namespace) -> RunFiles:
    """Reads what the options name.

    Raises:
        UsageError: RUN is no folder, or that of a drop that was flown.
        TfsatError: the robot or facility file cannot be understood, or the result could not be written there.
    """
    from tfsat_host.cli.evaluate.run_files import robot_beside
    from tfsat_host.facility import load_tower
    from tfsat_host.robot import load_robot

    folder: Path = args.run
    if not folder.is_dir():
        raise UsageError(
            what=f"There is no folder {folder}.",
            meaning="A preflight belongs to a run: its folder holds what is to be flown. Nothing was looked at.",
            next_step=f"mkdir {shlex.quote(str(folder))}, and copy maneuver.toml and calibration.toml into it",
        )
    require_not_flown(folder)
    check_may_write(
        folder / RESULT,
        marker=_MADE_BY.encode(),
        force=False,
        elsewhere="Make the folder writable, or copy maneuver.toml and the certificate into one that is.",
    )
    maneuver = args.maneuver or folder / MANEUVER
    return RunFiles(
        folder,
        maneuver,
        _schedule(maneuver),
        load_robot(args.robot or robot_beside(folder)),
        load_tower(args.facility),
        args.calibration,
        args.sequencer_image,
        args.logger_image,
    )


def _schedule(file: Path) -> Schedule | Missing:
    from tfsat_host.maneuver import ManeuverError, read_maneuver, schedule_maneuver
    from tfsat_host.preflight.evidence import Missing

    if not file.is_file():
        return Missing(
            f"There is no {file}: what is to be flown is not known.",
            f"Copy the maneuver to {file}, or name it with --maneuver.",
        )
    try:
        return schedule_maneuver(read_maneuver(file))
    except ManeuverError as error:
        return Missing(f"{file}: {error.what}", error.next_step)


def _sequencer_image(named: Path | None) -> Reference | Missing:
    from tfsat_host.flashing.image import default_hex, load_image
    from tfsat_host.preflight.evidence import Missing, Reference

    text = "" if named is None else str(named)
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


def result_of(
    evidence: Evidence, checks: Sequence[Check], files: Mapping[str, Any], left: str = ""
) -> dict[str, Any]:
    """What `preflight --json` prints, and `preflight.json` holds.

    Args:
        evidence: Of the boards and the files.
        checks: Made of it.
        files: Their hashes.
        left: What is left of the preflight on the logger.
    """
    from tfsat_host import __version__
    from tfsat_host.cli.preflight_words import as_json
    from tfsat_host.preflight import may_drop

    return {
        "verdict": "go" if may_drop(checks) else "no-go",
        "at": evidence.now.astimezone(UTC).isoformat(),
        "tfsat_version": __version__,
        "emulated": runs_natively(evidence),
        "reasons": [check.name for check in checks if check.blocks],
        "checks": [as_json(check) for check in checks],
        "boards": _boards(evidence),
        "files": dict(files),
        "left_on_the_boards": left,
    }


def runs_natively(evidence: Evidence) -> bool:
    """Some board is no board: the robot is an emulated one."""
    return any(board is not None and board["image_crc"] is None for board in _boards(evidence).values())


def _boards(evidence: Evidence) -> dict[str, Any]:
    from tfsat_host.preflight.evidence import Missing

    return {
        board.name: None if isinstance(board.identity, Missing) else board.identity.as_dict()
        for board in (evidence.sequencer_board, evidence.logger_board)
    }


@dataclass(frozen=True, slots=True)
class Written:
    """Where the result is.

    Attributes:
        file: In the run's folder.
        sha256: As the run's record has it; None: it could not be signed.
        error: Why not.
    """

    file: Path
    sha256: str | None
    error: TfsatError | None = None


def write_result(folder: Path, result: Mapping[str, Any], at: datetime) -> Written:
    """Writes `preflight.json` and signs it into the run's record; an older one is replaced.

    Raises:
        OSError: it cannot be written.
    """
    from tfsat_host.record.run_record import sign

    file = folder / RESULT
    text = json.dumps({"made_by": _MADE_BY, "format": 1, **jsonable(result)}, indent=1, allow_nan=False)
    write_whole(file, (text + "\n").encode())
    by = f"{_MADE_BY} {result['tfsat_version']}: {str(result['verdict']).upper()}"
    try:
        entry = sign(folder, [file], by, at)
    except TfsatError as error:
        error.meaning = f"The result stands in {file} but not in the run's record. {error.meaning}"
        return Written(file, None, error)
    return Written(file, entry.files[0].sha256)
