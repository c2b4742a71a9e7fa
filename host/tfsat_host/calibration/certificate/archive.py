"""The folder beside a certificate: the recordings that it rests on, and every certificate that was ever written."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.certificate.file import format_calibration
from tfsat_host.whole_file import write_whole

_KEPT = "certificate-%Y%m%dT%H%M%S.%f.toml"


def recordings_folder(certificate: Path) -> Path:
    """Where the recordings of a certificate lie, and what it was at each time that it was written."""
    return certificate.with_name(f"{certificate.stem}-recordings")


def kept_copy(certificate: Path, calibration: Calibration) -> Path:
    """The copy that stays of what a certificate said."""
    return recordings_folder(certificate) / calibration.written.astimezone(UTC).strftime(_KEPT)


def write_certificate(certificate: Path, calibration: Calibration) -> None:
    """Writes a certificate, and a copy that stays: a drop is evaluated by the one that held when it fell.

    Raises:
        OSError: one of the two cannot be written; the certificate is as before.
    """
    text = format_calibration(calibration).encode()
    write_whole(kept_copy(certificate, calibration), text)
    write_whole(certificate, text)


def kept_before(certificate: Path, moment: datetime) -> list[Path]:
    """The copies of a certificate that were written before that moment, the newest first."""
    written = ((_written(kept), kept) for kept in recordings_folder(certificate).glob("certificate-*.toml"))
    return [kept for when, kept in sorted(written, reverse=True) if when < moment]


def _written(kept: Path) -> datetime:
    """As the name tells; never, for files of a person's own making."""
    try:
        return datetime.strptime(kept.name, _KEPT).replace(tzinfo=UTC)
    except ValueError:
        return datetime.max.replace(tzinfo=UTC)
