"""A calibration computed anew from the recordings that it rests on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

from tfsat_host.calibration.certificate.archive import recordings_folder
from tfsat_host.calibration.certificate.certificate import DRAWABLE, Calibration
from tfsat_host.calibration.certificate.drawn import in_words, measured_by, with_measured
from tfsat_host.calibration.certificate.file import certificate_values, read_calibration
from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.calibration.servos.reached import servo_map_of
from tfsat_host.calibration.solution import solve
from tfsat_host.calibration.steps.evidence import Evidence, from_bytes, sha256
from tfsat_host.robot import RobotModel
from tfsat_host.run.bundle.comparing import CERTIFICATE_TOLERANCE, Compared, Difference, differences


def recalibrate(certificate: Path, recordings: Path, model: RobotModel, name: str) -> Compared:
    """Computes a certificate from its recordings and compares.

    Args:
        certificate: Its file.
        recordings: The folder of its recordings; see `recordings_of`.
        model: The robot.
        name: Of the certificate, for the sentence.

    Raises:
        CalibrationError: the certificate cannot be read.
    """
    found = read_calibration(certificate)
    if not found.papers:
        why = "The certificate names no recordings: its values cannot be computed anew."
        return Compared("calibration", None, f"{name}: {why}{_drawn(found)}")
    try:
        evidence = [_read(recordings / paper.file, paper.sha256) for paper in found.papers]
        tried = [_differences(found, evidence, model, landing) for landing in _landings(found)]
    except CalibrationError as error:
        why = f"The calibration cannot be computed anew: {error.what}"
        return Compared("calibration", None, f"{name}: {why}", lacking=True)
    sentence, lacking = _sentence(found, evidence)
    return Compared("calibration", min(tried, key=len), f"{name}: {sentence}", lacking)


def recordings_of(certificate: Path) -> Path:
    """Where a certificate's recordings lie: it is the present one, or one that was kept among them."""
    beside = recordings_folder(certificate)
    return beside if beside.is_dir() else certificate.parent


def _landings(found: Calibration) -> list[datetime | None]:
    """Which landing may have been the last that was known when the certificate was computed.

    One that is noted later stands in the certificate, too, and did not change its values.
    """
    newest = max(paper.taken for paper in found.papers)
    known = [landing.at for landing in found.landings]
    before = [at for at in known if at <= newest]
    return list(dict.fromkeys([*reversed(before), None, *(at for at in known if at > newest)]))


def _differences(
    found: Calibration, evidence: Sequence[Evidence], model: RobotModel, landing: datetime | None
) -> list[Difference]:
    if found.drawn:
        again = with_measured(found, evidence, model)
        return list(differences(_values(found), _values(again), CERTIFICATE_TOLERANCE))
    solution = solve(evidence, model, landing)
    servos = sorted(solution.servos, key=lambda servo: servo[0].step.joint or 0)
    again = replace(
        found,
        gyros=solution.gyros,
        joints=solution.joints,
        servo_maps=tuple(servo_map_of(one, joints, model) for one, joints in servos),
        servo_taken=tuple(one.taken for one, _ in servos),
    )
    return list(differences(_values(found), _values(again), CERTIFICATE_TOLERANCE))


def _sentence(found: Calibration, evidence: Sequence[Evidence]) -> tuple[str, bool]:
    """What was computed from what, and whether something that should have been was not."""
    of = f"{len(evidence)} recording{'' if len(evidence) == 1 else 's'}"
    if not found.drawn:
        return f"The calibration was computed anew from {of}.", False
    measured = measured_by(evidence)
    untold = [name for name in DRAWABLE if name not in (*found.drawn, *measured)]
    sentence = f"Computed anew from {of}: {in_words(measured)}.{_drawn(found)}"
    if untold:
        sentence += f" Neither recorded nor drawn: {in_words(untold)}."
    return sentence, bool(untold)


def _drawn(found: Calibration) -> str:
    """What no recording can tell: a rehearsal made it up."""
    return f" Not recorded in a rehearsal, but drawn: {in_words(found.drawn)}." if found.drawn else ""


def _values(calibration: Calibration) -> dict[str, Any]:
    """As the certificate's file has them, times as text."""
    values: dict[str, Any] = _plain(certificate_values(calibration))
    return values


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_plain(item) for item in value]
    return value.isoformat() if isinstance(value, datetime) else value


def _read(path: Path, expected_sha256: str) -> Evidence:
    try:
        data = path.read_bytes()
    except FileNotFoundError as error:
        raise _gone(path, "is not there") from error
    if sha256(data) != expected_sha256:
        raise _gone(path, "is not the one on which it rests: its SHA-256 differs")
    return from_bytes(data, source=path.name)


def _gone(path: Path, what: str) -> CalibrationError:
    return CalibrationError(
        what=f"the recording {path.name} {what}.",
        meaning="Its step cannot be computed again.",
        next_step="Copy it beside the certificate and bundle the run again.",
    )
