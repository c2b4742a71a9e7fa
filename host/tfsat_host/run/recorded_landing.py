"""The landing that ended a recording: when it was, noted in the certificate once; and the certificate that it ended."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

from tfsat_host.calibration.certificate.calibration_campaign import note_landing
from tfsat_host.calibration.certificate.certificate import Calibration, Landing, with_landing
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.calibration.certificate.recordings_archive import CertificateOfDrop, certificate_for
from tfsat_host.errors import TfsatError
from tfsat_host.next_step import NextStep
from tfsat_host.notices import SILENT, Notices
from tfsat_host.protocol.limits import FALL_US
from tfsat_host.run.files import command_options
from tfsat_host.sdlog import DropLog
from tfsat_host.sdlog.header import MIN_TIME_OF_DAY


def time_of_day(log: DropLog, logger_us: int | None) -> datetime | None:
    """Convert a time of the logger's clock to UTC.

    Returns None where the logger did not know the time of day.
    """
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
    # A recording is decoded many times, and its landing counts once.
    if log.release_us is None or any(_is_of(landing, log) for landing in calibration.landings):
        return
    landing, how = _find_landing(log, now or datetime.now(UTC))
    updated_calibration = with_landing(calibration, landing)
    # Some other source has told of a landing within two minutes of this one.
    if updated_calibration is calibration:
        return
    when = f"{landing.at:%Y-%m-%d %H:%M:%S} UTC{how}"
    try:
        note_landing(file, landing, now)
    except (OSError, TfsatError) as error:
        # Not fatal: this drop can be evaluated; the certificate merely does not know that it is stale.
        reason = error.what if isinstance(error, TfsatError) else f"{error.strerror or error}."
        notified.warn(
            f"The landing at {when} could not be written into {file}: {reason} "
            "That calibration does not know that the robot landed since; decode the recording again when it can be."
        )
        return
    again = ""
    if any(shortfall.state == "stale" for shortfall in updated_calibration.shortcomings()):
        options = command_options(file, emulated=calibration.subject.emulated)
        again = (
            ": what it may have changed is to be measured again before the next drop "
            f"({NextStep('calibrate show', options)})"
        )
    notified.note(f"{file} knows of the landing at {when} now{again}.")


def certificate_of(log: DropLog, file: Path) -> CertificateOfDrop:
    """Read the certificate in force at the release.

    Raises CalibrationError: the present one cannot be read.
    """
    released, landed = time_of_day(log, log.release_us), _landing_of(log)
    if released is None or landed is None:
        return CertificateOfDrop(file, read_calibration(file))
    return certificate_for(file, released, landed)


def without_landing_of(log: DropLog, calibration: Calibration) -> Calibration:
    """Remove the recording's own landing from a calibration.

    That landing ended the recording; all other landings known may have come before it.
    """
    return replace(
        calibration,
        landings=tuple(
            known_landing for known_landing in calibration.landings if not _is_of(known_landing, log)
        ),
    )


def _landing_of(log: DropLog) -> datetime | None:
    """Find the time of the landing; None where the recording has no time of day, or no release.

    It is the landing that the logger recorded after the release, else the end of the tower's fall time.
    """
    if log.release_us is None:
        return None
    after = (event.t_us for event in log.events if event.name == "landing" and event.t_us > log.release_us)
    return time_of_day(log, next(after, log.release_us + FALL_US))


def _find_landing(log: DropLog, now: datetime) -> tuple[Landing, str]:
    """Return the landing and how its time is known.

    Without a time of day it was no later than the file's date: quantities measured before that date count as
    measured before the landing.
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
    """Return the file's modification time, or `now` if it has no valid one, and the source of that time."""
    try:
        written = datetime.fromtimestamp(path.stat().st_mtime, UTC)
    except (OSError, OverflowError, ValueError):  # a date that no calendar has
        return now, "the clock"
    # A file that something without a clock wrote says 1980 or 2000: now is the bound that is left.
    return (written, "its file") if MIN_TIME_OF_DAY < written < now else (now, "the clock")


def _is_of(landing: Landing, log: DropLog) -> bool:
    """Return whether the landing is known from this recording."""
    return _name(log) in landing.told_by


def _name(log: DropLog) -> str:
    return f"recording {log.session:08x}"
