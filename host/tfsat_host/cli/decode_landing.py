"""The landing that ends a recording: when it was, and its note in the certificate of the same sensors."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING

from tfsat_host.cli.calibration_notice import command_options
from tfsat_host.cli.output import Output
from tfsat_host.errors import TfsatError
from tfsat_host.protocol.limits import FALL_US

if TYPE_CHECKING:
    from pathlib import Path

    from tfsat_host.calibration.certificate.certificate import Calibration, Landing
    from tfsat_host.sdlog import DropLog

_NO_CLOCK = datetime(2020, 1, 1, tzinfo=UTC)
"""A file of an earlier date was written by something without a clock, as the logger is: cards then say 1980 or 2000."""


def time_of_day(log: DropLog, logger_us: int | None) -> datetime | None:
    """When the logger's clock stood there; None where nobody had told it the time of day."""
    if logger_us is None or log.unix_offset_us is None:
        return None
    try:
        return datetime(1970, 1, 1, tzinfo=UTC) + timedelta(microseconds=logger_us + log.unix_offset_us)
    except OverflowError:  # a header that tells a time beyond all calendars; `decode` shows it as that
        return None


def landing_of(log: DropLog) -> datetime | None:
    """When the robot hit the ground; None where the recording does not tell the time of day, or no release.

    The landing that the logger noted after the release, else the end of the fall as the tower has it.
    """
    if log.release_us is None:
        return None
    noted = (event.t_us for event in log.events if event.name == "landing" and event.t_us > log.release_us)
    return time_of_day(log, next(noted, log.release_us + FALL_US))


def is_told_by(landing: Landing, log: DropLog) -> bool:
    """Whether it is known from this recording."""
    return _name(log) in landing.told_by


def note_landing_of(
    log: DropLog, file: Path, calibration: Calibration, out: Output, now: datetime | None = None
) -> None:
    """Writes the landing of a recording into a certificate, once, and says so; says also why not.

    `now` is when the certificate is written; None: as the computer's clock says.
    """
    from tfsat_host.calibration.certificate.campaign import note_landing
    from tfsat_host.calibration.certificate.certificate import with_landing

    if log.release_us is None or any(is_told_by(landing, log) for landing in calibration.landings):
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
        out.warn(
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
    out.note(f"{file} knows of the landing at {when} now{again}.")


def _landing(log: DropLog, now: datetime) -> tuple[Landing, str]:
    """The landing, and what is to be said of its time.

    Without a time of day it was not later than the file: whatever was measured before that counts as before it.
    """
    from tfsat_host.calibration.certificate.certificate import Landing

    at = landing_of(log)
    if at is not None:
        return Landing(at, _name(log)), ""
    latest, whose = _latest(log.path, now)
    return (
        Landing(latest, f"{_name(log)}, which has no time of day: by {whose}"),
        f" (by {whose}, at the latest, as the recording has no time of day)",
    )


def _latest(path: Path, now: datetime) -> tuple[datetime, str]:
    """When the file was written, or now if it does not tell."""
    try:
        written = datetime.fromtimestamp(path.stat().st_mtime, UTC)
    except (OSError, OverflowError, ValueError):  # a date that no calendar has
        return now, "the clock"
    return (written, "its file") if _NO_CLOCK < written < now else (now, "the clock")


def _name(log: DropLog) -> str:
    return f"recording {log.session:08x}"
