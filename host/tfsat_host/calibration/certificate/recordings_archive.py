"""The folder of a certificate: its recordings, every certificate that was ever written, and which a drop needs."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.certificate.certificate import (
    Calibration,
    quantities,
    with_landing,
)
from tfsat_host.calibration.certificate.file import format_calibration, read_calibration
from tfsat_host.whole_file import write_whole

_LOG = logging.getLogger(__name__)

_KEPT = "certificate-%Y%m%dT%H%M%S.%f.toml"


def recordings_folder(certificate: Path) -> Path:
    """Return the folder of a certificate's recordings and of every version of it that was written."""
    return certificate.with_name(f"{certificate.stem}-recordings")


def kept_copy(certificate: Path, calibration: Calibration) -> Path:
    """Return the path of the certificate's permanent copy."""
    return recordings_folder(certificate) / calibration.written.astimezone(UTC).strftime(_KEPT)


def write_certificate(certificate: Path, calibration: Calibration) -> None:
    """Writes a certificate, and a copy that stays: a drop is evaluated by the one that held when it fell.

    Raises:
        OSError: one of the two cannot be written; the certificate is as before.
    """
    text = format_calibration(calibration).encode()
    # The copy first: where it fails, the certificate has not changed yet.
    write_whole(kept_copy(certificate, calibration), text)
    write_whole(certificate, text)


def kept_before(certificate: Path, moment: datetime) -> list[Path]:
    """Return the permanent copies of a certificate written before `moment`, newest first."""
    written = (
        (_time_of_copy(path), path) for path in recordings_folder(certificate).glob("certificate-*.toml")
    )
    return [path for when, path in sorted(written, reverse=True) if when < moment]


def _time_of_copy(path: Path) -> datetime:
    """Parse a copy's time from its file name; return `datetime.max` for a file that a person named."""
    try:
        return datetime.strptime(path.name, _KEPT).replace(tzinfo=UTC)
    except ValueError:
        # Later than every moment, so that it is never taken for a kept one.
        return datetime.max.replace(tzinfo=UTC)


@dataclass(frozen=True, eq=False)
class CertificateOfDrop:
    """A certificate, and what it says.

    Attributes:
        path: Of the file that was read.
        calibration: What it says; all landings that are known today are in it.
        unreadable: Kept certificates that would have come first but cannot be read; a sentence each.
    """

    path: Path
    calibration: Calibration
    unreadable: tuple[str, ...] = ()


def certificate_for(path: Path, release_time: datetime, landing_time: datetime) -> CertificateOfDrop:
    """Read the certificate at `path`, or an earlier one if it holds values measured after the landing.

    Every certificate that was ever written lies in the folder of the recordings. The newest one there that was
    written before the release, of the same subject, is the drop's. If there is none, the one at `path` is
    returned, and `measured_after` names the quantities in it that are too new.

    Args:
        path: Present certificate.
        release_time: Time of the robot's release, with its time zone.
        landing_time: Time of its impact on the ground.

    Raises:
        CalibrationError: the present certificate cannot be read or understood.
    """
    present = read_calibration(path)
    if not measured_after(present, landing_time):
        # Nothing in it is newer than the landing: it is the one that held during the fall.
        _LOG.debug("certificate %s: nothing in it is newer than the landing", path)
        return CertificateOfDrop(path, present)
    unreadable: list[str] = []
    # Newest first; what cannot be read is reported, for it might have been the right one.
    for copy_path in kept_before(path, release_time):
        try:
            calibration = read_calibration(copy_path)
        except CalibrationError as error:
            unreadable.append(error.what)
            continue
        if calibration.subject == present.subject:
            _LOG.debug("certificate %s: the newest from before the release", copy_path)
            return CertificateOfDrop(copy_path, _with_landings_of(present, calibration), tuple(unreadable))
    return CertificateOfDrop(path, present, tuple(unreadable))


def measured_after(calibration: Calibration, landing_time: datetime) -> list[str]:
    """Return the names of the quantities that a landing may change and that were measured after it."""
    return [
        quantity.name
        for quantity in quantities(calibration)
        if quantity.ends_at_landing
        and quantity.measured_at is not None
        and quantity.measured_at > landing_time
    ]


def _with_landings_of(present: Calibration, calibration: Calibration) -> Calibration:
    """Add the present certificate's landings to a kept one, which does not know the later ones."""
    for landing in present.landings:
        calibration = with_landing(calibration, landing)
    return calibration
