"""Which certificate a drop is evaluated by: the one that held when the robot fell."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from tfsat_host.calibration.certificate.archive import kept_before
from tfsat_host.calibration.certificate.certificate import Calibration, quantities, with_landing
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.calibration.errors import CalibrationError


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
    """The certificate at `path`, or one before it if anything in that was measured after the landing.

    Every certificate that was ever written lies in the folder of the recordings. The newest one there that was
    written before the release, of the same subject, is the drop's; where there is none, the one at `path` is all
    there is, and `measured_after` says what in it is too young.

    Args:
        path: Of the present certificate.
        release_time: When the robot was released, with its time zone.
        landing_time: When it hit the ground.

    Raises:
        CalibrationError: the present certificate cannot be read or understood.
    """
    present = read_calibration(path)
    if not measured_after(present, landing_time):
        return CertificateOfDrop(path, present)
    unreadable: list[str] = []
    for kept in kept_before(path, release_time):
        try:
            found = read_calibration(kept)
        except CalibrationError as error:
            unreadable.append(error.what)
            continue
        if found.subject == present.subject:
            return CertificateOfDrop(kept, _with_landings_of(present, found), tuple(unreadable))
    return CertificateOfDrop(path, present, tuple(unreadable))


def measured_after(calibration: Calibration, landing_time: datetime) -> list[str]:
    """The quantities that a landing may have changed before they were measured."""
    return [
        one.name
        for one in quantities(calibration)
        if one.ends_at_landing and one.taken is not None and one.taken > landing_time
    ]


def _with_landings_of(present: Calibration, kept: Calibration) -> Calibration:
    """A landing is noted in the present certificate; one that was kept before does not know of it."""
    for landing in present.landings:
        kept = with_landing(kept, landing)
    return kept
