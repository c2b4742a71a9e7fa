"""The certificate that a recording is evaluated by: found, checked against it, and objections to its use."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

from tfsat_host.calibration.certificate.certificate import (
    Calibration,
    Quantity,
    Subject,
    commands_of,
    exchanged_imus,
    list_names,
    measured_in_future,
    of_another_robot,
)
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.calibration.certificate.recordings_archive import (
    measured_after,
)
from tfsat_host.calibration.steps.evidence import Origin
from tfsat_host.errors import TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.notices import SILENT, Listener, Notices
from tfsat_host.protocol.messages import LogHeader
from tfsat_host.quantity import Column, Columns
from tfsat_host.run.files import command_options
from tfsat_host.run.recorded_landing import (
    certificate_of,
    note_landing_of,
    time_of_day,
    without_landing_of,
)
from tfsat_host.sdlog import DropLog


@dataclass(frozen=True, slots=True)
class CertificateState:
    """What a certificate is worth for a use.

    Attributes:
        path: Of the certificate.
        objections: To using it, a sentence or two each; empty if it can be used.
        shortcomings: The quantities that it lacks or that a landing may have changed.
        options: That make a `calibrate` command go on with it.
    """

    path: Path
    objections: tuple[str, ...]
    shortcomings: tuple[Quantity, ...] = ()
    options: tuple[str, ...] = ()

    @property
    def rows(self) -> list[tuple[Quantity, str]]:
        """Each shortcoming, and the command that measures it with these options."""
        return [(gap, str(gap.command.with_arguments(*self.options))) for gap in self.shortcomings]


_SHORTCOMING: Columns = (
    Column("quantity", of=lambda row: row[0].name),
    Column("reason", of=lambda row: row[0].state),
    Column("taken", of=lambda row: row[0].measured_at and row[0].measured_at.isoformat()),
    Column("command", of=lambda row: row[1]),
)
CERTIFICATE_STATE: Columns = (
    Column("file", of=lambda state: str(state.path)),
    Column("usable", of=lambda state: not state.objections),
    Column("shortcomings", of="rows", columns=_SHORTCOMING),
    Column("sentences", of="objections"),
)
"""Under `calibration` of `--json`."""


def check_certificate(
    calibration: Calibration,
    origin: Origin | None,
    file: Path,
    before: datetime | None = None,
    now: datetime | None = None,
    *,
    into: Path | None = None,
    servos: bool = True,
) -> CertificateState:
    """Check whether a calibration can be used.

    Args:
        calibration: As it was read.
        origin: The robot whose sensors it would be used for; None: not known.
        file: The certificate.
        before: When its samples were taken: later landings do not matter, but quantities measured after one may
            have been different before. None: now.
        now: The current time; None: by the computer's clock.
        into: The certificate that further steps are to go into; None: the same.
        servos: Whether the servos' shortcomings count; no sensor's reading rests on them.
    """
    target, emulated = into or file, calibration.subject.emulated
    options = command_options(target, emulated=emulated)
    shortcomings = calibration.shortcomings(before, servos=servos)
    # A drop may be older than a replaced part: held against what the robot was then.
    subject = calibration.subject_at(before)
    other = "" if origin is None else of_another_robot(subject, origin)
    if other:
        other = f"The calibration{other.removeprefix('It')} None of its numbers hold."
        return CertificateState(file, (other,), shortcomings, options)
    objections = [] if origin is None else _of_other_imus(subject, origin)
    later_parts = [] if before is None else calibration.specimens.since(before)
    if later_parts:
        objections.append(
            f"Replaced only after these samples: {list_names(later_parts)}. Its numbers are of the new part. "
            "A calibration from before says more."
        )
    # Tell missing from stale: what was never measured, and what a landing may have moved since.
    for reason, words in (
        ("missing", "The calibration lacks"),
        ("stale", "Measured before the last landing, which may have changed it:"),
    ):
        lacking = [gap for gap in shortcomings if gap.state == reason]
        if lacking:
            names = list_names([gap.name for gap in lacking])
            objections.append(f"{words} {names}. To measure: {_commands(lacking, options)}")
    # A value measured only after the impact may be of a sensor that the impact had moved.
    later = [] if before is None else _measured_after_a_landing(calibration, before)
    if later:
        objections.append(
            f"Measured only after the landing that followed, which may have changed it: {list_names(later)}. "
            "A calibration from before the drop says more."
        )
    objections += _of_the_future(calibration, target, now or datetime.now(UTC))
    return CertificateState(file, tuple(objections), shortcomings, options)


def report_certificate(
    read: Callable[[], CertificateState], file: Path, listener: Listener, use: str
) -> CertificateState:
    """Notify of a certificate's state, or of why it cannot be read; neither ends the command.

    `read` reads and checks it. `use` is that for which it was checked, such as `drop`; empty: it is not said
    that it holds.
    """
    try:
        state = read()
    except TfsatError as error:
        listener.warn(Advice(f"{error.what} {error.meaning} ", error.next_step))
        return CertificateState(file, (error.what,))
    for sentence in state.objections:
        listener.note(Advice(f"Calibration {state.path}: ", sentence))
    if use and not state.objections:
        listener.note(f"Calibration: {state.path} (valid for this {use})")
    return state


def _of_other_imus(subject: Subject, origin: Origin) -> list[str]:
    calibrated, who_am_i = subject.who_am_i, origin.who_am_i
    bodies = [str(body) for body in exchanged_imus(subject, who_am_i)]
    if not bodies:
        return []
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
    early = measured_in_future(calibration, now)
    if not early:
        return []
    last = max(quantity.measured_at for quantity in early if quantity.measured_at is not None)
    another = command_options(file.with_name(f"{file.stem}-anew.toml"), emulated=calibration.subject.emulated)
    return [
        f"{list_names([quantity.name for quantity in early])} {'was' if len(early) == 1 else 'were'} "
        "measured in the future "
        f"({last.astimezone(UTC):%Y-%m-%d %H:%M} UTC): the clock was wrong then or is now; landings cannot end it. "
        f"Set the clock if it is wrong now; else measure again into another certificate: "
        f"{_commands(early, another)}"
    ]


def _commands(gaps: Iterable[Quantity], options: tuple[str, ...]) -> str:
    return list_names([str(command.with_arguments(*options)) for command in commands_of(gaps)])


_NO_TIME = Advice(
    "The recording has no time of day: it is not known whether the calibration is older or newer than this fall, and a "
    "landing in between may have changed what it says. All landings but its own are taken to have come before it. Use "
    "the calibration only if you know that it was taken before this fall, and that the robot did not land in between. "
    "The next recording has a time of day if it is begun with ",
    NextStep("record start"),
    ".",
)


@dataclass(frozen=True, eq=False)
class CheckedCertificate:
    """A certificate, checked against a recording.

    Attributes:
        path: Of the certificate that held at the release.
        calibration: Its contents; where the time of the recording is unknown, without the landing that ended it.
        state: What it is worth for the recording.
    """

    path: Path
    calibration: Calibration
    state: CertificateState

    @property
    def objections(self) -> tuple[str, ...]:
        """Objections to using it for the recording, a sentence or two each."""
        return self.state.objections


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


def is_of_robot(calibration: Calibration, origin: Origin, at: datetime | None = None) -> bool:
    """Return whether a calibration is of the robot that had these sensors, even if one of them was exchanged.

    `at` is when it had them; None: now.
    """
    return not of_another_robot(calibration.subject_at(at), origin)


def hold_against(
    log: DropLog, file: Path, notified: Notices = SILENT, *, servos: bool = True
) -> CheckedCertificate:
    """Holds the certificate that lies there now against a recording, whose landing is written into it.

    `servos`: whether it matters that they were measured.

    Raises:
        TfsatError: the certificate cannot be read or understood.
    """
    origin, recorded = origin_of_log(log.header), time_of_day(log, log.origin_us)
    present = read_calibration(file)
    # The landing ends values of the present certificate for the next drop; for this one they still hold.
    if is_of_robot(present, origin, recorded):
        note_landing_of(log, file, present, notified)
    # If it was measured again since the fall, a kept version from before the release is this drop's.
    drop_certificate = certificate_of(log, file)
    for sentence in drop_certificate.unreadable:
        notified.warn(f"{sentence} It was passed over.")
    if drop_certificate.path != file:
        notified.note(
            f"{file} was measured again after this fall: {drop_certificate.path} is the certificate "
            "that was the newest at its "
            "release."
        )
    # Without a time of day only this recording's own landing is known to have come after it.
    calibration = (
        drop_certificate.calibration if recorded else without_landing_of(log, drop_certificate.calibration)
    )
    state = check_certificate(calibration, origin, drop_certificate.path, recorded, into=file, servos=servos)
    if recorded is None and is_of_robot(calibration, origin):
        state = replace(state, objections=(*state.objections, _NO_TIME))
    return CheckedCertificate(drop_certificate.path, calibration, state)
