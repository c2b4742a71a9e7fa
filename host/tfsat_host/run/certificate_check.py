"""The certificate that a recording is evaluated by: found, held against it, taught of its landing; its notices."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from tfsat_host.calibration.certificate.calibration_campaign import note_landing
from tfsat_host.calibration.certificate.certificate import (
    Calibration,
    Landing,
    Quantity,
    of_another_robot,
    quantities,
    with_landing,
)
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.calibration.certificate.recordings_archive import (
    CertificateOfDrop,
    certificate_for,
    measured_after,
)
from tfsat_host.calibration.steps.evidence import Origin
from tfsat_host.errors import TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.notices import SILENT, Notices
from tfsat_host.protocol.limits import FALL_US, IMU_COUNT
from tfsat_host.protocol.messages import LogHeader
from tfsat_host.run.files import CERTIFICATE, EMULATED_CERTIFICATE
from tfsat_host.sdlog import DropLog

_NAMED = 3
# Two computers' clocks may differ by so much; what was measured later than this is of the future.
_CLOCKS_APART = timedelta(minutes=1)


def command_options(file: Path, *, emulated: bool) -> tuple[str, ...]:
    """Return the options that make a `calibrate` command use that certificate; none where none is needed."""
    default = Path(EMULATED_CERTIFICATE if emulated else CERTIFICATE)
    out = () if file.resolve() == default.resolve() else ("--out", str(file))
    return (*out, *(("--emulated",) if emulated else ()))


def notices(
    calibration: Calibration,
    origin: Origin | None,
    file: Path,
    before: datetime | None = None,
    now: datetime | None = None,
    *,
    servos: bool = True,
) -> list[str]:
    """List the objections to using a calibration, a sentence or two each; empty if it can be used.

    Args:
        calibration: As it was read.
        origin: The robot whose sensors it would be used for; None: not known.
        file: The certificate that further steps are to go into.
        before: When its samples were taken: later landings do not matter, but quantities measured after one may
            have been different before. None: now.
        now: The current time; None: by the computer's clock.
        servos: Whether the servos' shortcomings count; no sensor's reading rests on them.
    """
    if origin is not None and (other := _of_another_robot(calibration, origin)):
        return [other]
    objections = [] if origin is None else _of_other_imus(calibration, origin)
    options = command_options(file, emulated=calibration.subject.emulated)
    shortcomings = _shortcomings(calibration, before, servos=servos)
    # Tell missing from stale: what was never measured, and what a landing may have moved since.
    for reason, words in (
        ("missing", "The calibration lacks"),
        ("stale", "Measured before the last landing, which may have changed it:"),
    ):
        lacking = [shortfall for shortfall in shortcomings if shortfall.state == reason]
        if lacking:
            commands = _commands((shortfall.command for shortfall in lacking), options)
            objections.append(
                f"{words} {_list_names([shortfall.name for shortfall in lacking])}. To measure: {commands}"
            )
    # A value measured only after the impact may be of a sensor that the impact had moved.
    later = [] if before is None else _measured_after_a_landing(calibration, before)
    if later:
        objections.append(
            f"Measured only after the landing that followed, which may have changed it: {_list_names(later)}. "
            "A calibration from before the drop says more."
        )
    return objections + _of_the_future(calibration, file, now or datetime.now(UTC))


def as_json(
    calibration: Calibration,
    file: Path,
    objections: list[str],
    before: datetime | None = None,
    into: Path | None = None,
    *,
    servos: bool = True,
) -> dict[str, Any]:
    """Return the calibration's state for `--json`, under `calibration`.

    `into` is the certificate that further steps go into, if not `file`.
    """
    options = command_options(into or file, emulated=calibration.subject.emulated)
    return {
        "file": str(file),
        "usable": not objections,
        "shortcomings": [
            _shortcoming_as_json(shortfall, options)
            for shortfall in _shortcomings(calibration, before, servos=servos)
        ],
        "sentences": objections,
    }


def unreadable_as_json(file: Path, sentence: str) -> dict[str, Any]:
    """Return the entry of `as_json` for a certificate that could not be read."""
    return {"file": str(file), "usable": False, "shortcomings": [], "sentences": [sentence]}


def _shortcomings(calibration: Calibration, before: datetime | None, *, servos: bool) -> list[Quantity]:
    return [
        shortfall
        for shortfall in calibration.shortcomings(before)
        if servos or not shortfall.name.startswith("servo ")
    ]


def _shortcoming_as_json(shortcoming: Quantity, options: tuple[str, ...]) -> dict[str, Any]:
    return {
        "quantity": shortcoming.name,
        "reason": shortcoming.state,
        "taken": None if shortcoming.measured_at is None else shortcoming.measured_at.isoformat(),
        "command": str(shortcoming.command.with_arguments(*options)),
    }


def _of_another_robot(calibration: Calibration, origin: Origin) -> str:
    """Empty if it is of the same."""
    other = of_another_robot(calibration.subject, origin)
    return other and f"The calibration{other.removeprefix('It')} None of its numbers hold."


def _of_other_imus(calibration: Calibration, origin: Origin) -> list[str]:
    calibrated, who_am_i = calibration.subject.who_am_i, origin.who_am_i
    if calibrated == who_am_i:
        return []
    bodies = [
        str(body)
        for body in range(1, IMU_COUNT + 1)
        if calibrated[2 * body - 2 : 2 * body] != who_am_i[2 * body - 2 : 2 * body]
    ]
    return [
        f"The IMU of body {' and '.join(bodies)} is another than the one that was calibrated, or does not answer "
        f"(WHO_AM_I {who_am_i}, calibrated {calibrated}): its numbers do not hold."
    ]


def _measured_after_a_landing(calibration: Calibration, moment: datetime) -> list[str]:
    """List the quantities measured only after a landing that followed `moment` and may have changed them."""
    # Landings are in order of time: this is the first one after the recording.
    landing = next((landing.at for landing in calibration.landings if landing.at >= moment), None)
    return [] if landing is None else measured_after(calibration, landing)


def _of_the_future(calibration: Calibration, file: Path, now: datetime) -> list[str]:
    """List the objections to quantities measured in the future; empty if there are none.

    A certificate takes no step older than the one it has: one of the future needs another file.
    """
    early = [
        quantity
        for quantity in quantities(calibration)
        if quantity.measured_at is not None and quantity.measured_at > now + _CLOCKS_APART
    ]
    if not early:
        return []
    last = max(quantity.measured_at for quantity in early if quantity.measured_at is not None)
    another = command_options(file.with_name(f"{file.stem}-anew.toml"), emulated=calibration.subject.emulated)
    return [
        f"{_list_names([quantity.name for quantity in early])} {'was' if len(early) == 1 else 'were'} "
        "measured in the future "
        f"({last.astimezone(UTC):%Y-%m-%d %H:%M} UTC): the clock was wrong then or is now; landings cannot end it. "
        f"Set the clock if it is wrong now; else measure again into another certificate: "
        f"{_commands((quantity.command for quantity in early), another)}"
    ]


def _commands(commands: Iterable[NextStep], options: tuple[str, ...]) -> str:
    return _list_names(list(dict.fromkeys(str(command.with_arguments(*options)) for command in commands)))


def _list_names(names: list[str]) -> str:
    omitted_count = len(names) - _NAMED
    return ", ".join(names[:_NAMED]) + (f" and {omitted_count} more" if omitted_count > 0 else "")


_NO_TIME = Advice(
    "The recording has no time of day: it is not known whether the calibration is older or newer than this fall, and a "
    "landing in between may have changed what it says. All landings but its own are taken to have come before it. Use "
    "the calibration only if you know that it was taken before this fall, and that the robot did not land in between. "
    "The next recording has a time of day if it is begun with ",
    NextStep("record start"),
    ".",
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
        # All zeros: the board gave no serial number.
        logger_serial=header.board_serial.hex() if any(header.board_serial) else "",
        who_am_i=header.who_am_i.hex(),
        # Sources that run natively, as the emulator's do, have no image in flash to compute a CRC of.
        emulated=header.image_crc == 0,
        firmware=".".join(map(str, header.firmware_version)),
        image_crc=f"{header.image_crc:08x}",
    )


def is_of_robot(calibration: Calibration, origin: Origin) -> bool:
    """Return whether a calibration is of the robot with these sensors, even if one of them was exchanged."""
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
    # The landing ends values of the present certificate for the next drop; for this one they still hold.
    if is_of_robot(present, origin):
        note_landing_of(log, file, present, notified)
    # If it was measured again since the fall, a kept version from before the release is this drop's.
    drop_certificate = _certificate_of(log, file)
    for sentence in drop_certificate.unreadable:
        notified.warn(f"{sentence} It was passed over.")
    if drop_certificate.path != file:
        notified.note(
            f"{file} was measured again after this fall: {drop_certificate.path} is the certificate "
            "that was the newest at its "
            "release."
        )
    recorded = time_of_day(log, log.origin_us)
    # Without a time of day only this recording's own landing is known to have come after it.
    calibration = (
        drop_certificate.calibration if recorded else _without_landing_of(log, drop_certificate.calibration)
    )
    objections = notices(calibration, origin, file, recorded, servos=servos)
    if recorded is None and is_of_robot(calibration, origin):
        objections.append(_NO_TIME)
    facts = as_json(calibration, drop_certificate.path, objections, recorded, into=file, servos=servos)
    return CheckedCertificate(drop_certificate.path, calibration, objections, facts)


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


def _certificate_of(log: DropLog, file: Path) -> CertificateOfDrop:
    """Read the certificate in force at the release.

    Raises CalibrationError: the present one cannot be read.
    """
    released, landed = time_of_day(log, log.release_us), _landing_of(log)
    if released is None or landed is None:
        return CertificateOfDrop(file, read_calibration(file))
    return certificate_for(file, released, landed)


def _without_landing_of(log: DropLog, calibration: Calibration) -> Calibration:
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
    # A date before 2020 or in the future is of a clock that was not set: now is the bound that is left.
    return (written, "its file") if _NO_CLOCK < written < now else (now, "the clock")


def _is_of(landing: Landing, log: DropLog) -> bool:
    """Return whether the landing is known from this recording."""
    return _name(log) in landing.told_by


def _name(log: DropLog) -> str:
    return f"recording {log.session:08x}"
