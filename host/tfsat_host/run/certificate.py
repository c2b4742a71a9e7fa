"""The certificate that a recording is evaluated by: found, held against it, and taught of its landing."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from tfsat_host.calibration.certificate.archive import CertificateOfDrop, certificate_for
from tfsat_host.calibration.certificate.campaign import note_landing
from tfsat_host.calibration.certificate.certificate import (
    Calibration,
    Landing,
    of_another_robot,
    with_landing,
)
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.calibration.steps.evidence import Origin
from tfsat_host.errors import TfsatError
from tfsat_host.notices import SILENT, Notices
from tfsat_host.protocol.limits import FALL_US
from tfsat_host.protocol.messages import LogHeader
from tfsat_host.run.certificate_notices import as_json, command_options, notices
from tfsat_host.sdlog import DropLog

_NO_TIME = (
    "The recording has no time of day: it is not known whether the calibration is older or newer than this fall, and a "
    "landing in between may have changed what it says. All landings but its own are taken to have come before it. Use "
    "the calibration only if you know that it was taken before this fall, and that the robot did not land in between. "
    "The next recording has a time of day if it is begun with tfsat-host record start."
)
_NO_CLOCK = datetime(2020, 1, 1, tzinfo=UTC)
"""A file of an earlier date was written by something without a clock, as the logger is: cards then say 1980 or 2000."""


@dataclass(frozen=True, eq=False)
class CheckedCertificate:
    """A certificate, checked against a recording.

    Attributes:
        path: Of the certificate that held at the release.
        calibration: Its contents; where the time of the recording is unknown, without the landing that ended it.
        objections: What stands against using it for the recording, a sentence or two each.
        facts: For `--json`.
    """

    path: Path
    calibration: Calibration
    objections: list[str]
    facts: dict[str, Any]


def origin_of_log(header: LogHeader) -> Origin:
    """Whose sensors a recording is of."""
    return Origin(
        logger_serial=header.board_serial.hex() if any(header.board_serial) else "",
        who_am_i=header.who_am_i.hex(),
        emulated=header.image_crc == 0,
        firmware=".".join(map(str, header.firmware_version)),
        image_crc=f"{header.image_crc:08x}",
    )


def is_of_robot(calibration: Calibration, origin: Origin) -> bool:
    """Whether a calibration is of the robot with these sensors, even if one of them was exchanged."""
    return not of_another_robot(calibration.subject, origin)


def hold_against(
    log: DropLog, file: Path, notified: Notices = SILENT, *, servos: bool = True
) -> CheckedCertificate:
    """Holds a certificate against a recording; the recording's landing is written into it.

    Args:
        log: The recording.
        file: The certificate that lies there now.
        notified: Of what was done on the way.
        servos: Whether it matters that they were measured.

    Raises:
        TfsatError: the certificate cannot be read or understood.
    """
    origin = origin_of_log(log.header)
    present = read_calibration(file)
    if is_of_robot(present, origin):
        note_landing_of(log, file, present, notified)
    used = _certificate_of(log, file)
    for sentence in used.unreadable:
        notified.warn(f"{sentence} It was passed over.")
    if used.path != file:
        notified.note(
            f"{file} was measured again after this fall: {used.path} is the certificate that was the newest at its "
            "release."
        )
    recorded = time_of_day(log, log.origin_us)
    calibration = used.calibration if recorded else _without_landing_of(log, used.calibration)
    objections = notices(calibration, origin, file, recorded, servos=servos)
    if recorded is None and is_of_robot(calibration, origin):
        objections.append(_NO_TIME)
    facts = as_json(calibration, used.path, objections, recorded, into=file, servos=servos)
    return CheckedCertificate(used.path, calibration, objections, facts)


def time_of_day(log: DropLog, logger_us: int | None) -> datetime | None:
    """When the logger's clock stood there; None where the logger did not know the time of day."""
    if logger_us is None or log.unix_offset_us is None:
        return None
    try:
        return datetime(1970, 1, 1, tzinfo=UTC) + timedelta(microseconds=logger_us + log.unix_offset_us)
    except OverflowError:  # a header with a time beyond all calendars; `decode` shows it as that
        return None


def note_landing_of(
    log: DropLog,
    file: Path,
    calibration: Calibration,
    notified: Notices = SILENT,
    now: datetime | None = None,
) -> None:
    """Writes the landing of a recording into a certificate, once, and gives notice of it, or why not.

    `now` is when the certificate is written; None: as the computer's clock says.
    """
    if log.release_us is None or any(_is_of(landing, log) for landing in calibration.landings):
        return
    landing, how = _landing(log, now or datetime.now(UTC))
    known = with_landing(calibration, landing)
    if known is calibration:
        return
    when = f"{landing.at:%Y-%m-%d %H:%M:%S} UTC{how}"
    try:
        note_landing(file, landing, now)
    except (OSError, TfsatError) as error:
        reason = error.what if isinstance(error, TfsatError) else f"{error.strerror or error}."
        notified.warn(
            f"The landing at {when} could not be written into {file}: {reason} "
            "That calibration does not know that the robot landed since; decode the recording again when it can be."
        )
        return
    again = ""
    if any(one.reason == "stale" for one in known.shortcomings()):
        options = command_options(file, emulated=calibration.subject.emulated)
        again = (
            ": what it may have changed is to be measured again before the next drop "
            f"(tfsat-host calibrate show{options})"
        )
    notified.note(f"{file} knows of the landing at {when} now{again}.")


def _certificate_of(log: DropLog, file: Path) -> CertificateOfDrop:
    """The one that held at the release. Raises CalibrationError if the present one cannot be read."""
    released, landed = time_of_day(log, log.release_us), _landing_of(log)
    if released is None or landed is None:
        return CertificateOfDrop(file, read_calibration(file))
    return certificate_for(file, released, landed)


def _without_landing_of(log: DropLog, calibration: Calibration) -> Calibration:
    """Its own landing ended the recording; whatever else is known may have come before."""
    return replace(calibration, landings=tuple(one for one in calibration.landings if not _is_of(one, log)))


def _landing_of(log: DropLog) -> datetime | None:
    """When the robot hit the ground; None where the recording has no time of day, or no release.

    The landing that the logger recorded after the release, else the end of the fall as the tower has it.
    """
    if log.release_us is None:
        return None
    after = (event.t_us for event in log.events if event.name == "landing" and event.t_us > log.release_us)
    return time_of_day(log, next(after, log.release_us + FALL_US))


def _landing(log: DropLog, now: datetime) -> tuple[Landing, str]:
    """The landing, and how its time is known.

    Without a time of day it was not later than the file: whatever was measured before that counts as before it.
    """
    at = _landing_of(log)
    if at is not None:
        return Landing(at, _name(log)), ""
    latest, whose = _latest(log.path, now)
    return (
        Landing(latest, f"{_name(log)}, which has no time of day: by {whose}"),
        f" (by {whose}, at the latest, as the recording has no time of day)",
    )


def _latest(path: Path, now: datetime) -> tuple[datetime, str]:
    """When the file was written, or now if it has no date."""
    try:
        written = datetime.fromtimestamp(path.stat().st_mtime, UTC)
    except (OSError, OverflowError, ValueError):  # a date that no calendar has
        return now, "the clock"
    return (written, "its file") if _NO_CLOCK < written < now else (now, "the clock")


def _is_of(landing: Landing, log: DropLog) -> bool:
    """Whether it is known from this recording."""
    return _name(log) in landing.told_by


def _name(log: DropLog) -> str:
    return f"recording {log.session:08x}"
