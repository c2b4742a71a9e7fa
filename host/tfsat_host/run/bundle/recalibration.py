"""A bundled certificate computed again from its recordings, and compared with what was bundled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path

from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.certificate.certificate import QUANTITY_NAMES, Calibration, in_words
from tfsat_host.calibration.certificate.file import certificate_values, read_calibration
from tfsat_host.calibration.certificate.recordings_archive import recordings_folder
from tfsat_host.calibration.certificate.simulated_quantities import measured_by, with_measured
from tfsat_host.calibration.solution import solve
from tfsat_host.calibration.steps.evidence import Evidence, from_bytes, sha256
from tfsat_host.errors import TfsatError
from tfsat_host.json_values import jsonable
from tfsat_host.robot import RobotModel
from tfsat_host.robot.absent_parts import load_robot_of_boards
from tfsat_host.run.bundle.json_comparison import (
    CERTIFICATE_TOLERANCE,
    ComparedPart,
    Difference,
    differences,
)
from tfsat_host.run.bundle.manifest import Manifest


def recalibrate(folder: Path, manifest: Manifest, at_release: str | None) -> list[ComparedPart]:
    """Recompute and compare the certificate of a bundle that was unpacked into `folder`.

    So is the certificate in force at the release, `at_release`, by its name in the bundle.
    """
    inputs = manifest.evaluated
    if inputs.calibration is None:
        return [ComparedPart("calibration", None, "The bundle has no certificate.")]
    parts = []
    for name in dict.fromkeys((inputs.calibration, at_release or inputs.calibration)):
        if name not in manifest.files:
            continue
        try:
            robot = load_robot_of_boards(None if inputs.robot is None else folder / inputs.robot)
            parts.append(_recalibrate(folder / name, robot, name))
        except TfsatError as error:
            parts.append(ComparedPart("calibration", None, error.what, lacking=True))
    return parts


def _recalibrate(certificate: Path, model: RobotModel, name: str) -> ComparedPart:
    """Recompute a certificate from its recordings and compare the two.

    The recordings lie in their folder next to it, or beside the certificate itself.

    Raises:
        CalibrationError: the certificate cannot be read.
    """
    calibration, archive_folder = read_calibration(certificate), recordings_folder(certificate)
    recordings = archive_folder if archive_folder.is_dir() else certificate.parent
    drawn_text = (
        f" Simulated: {in_words(calibration.simulated_quantities)}."
        if calibration.simulated_quantities
        else ""
    )
    if not calibration.recordings:
        why = "The certificate names no recordings: its values cannot be recomputed."
        return ComparedPart("calibration", None, f"{name}: {why}{drawn_text}")
    try:
        evidence = [
            _evidence(recordings / recording.file, recording.sha256) for recording in calibration.recordings
        ]
        # Which landing it knew when it was computed is not recorded: solve with each, keep the closest.
        tried = [
            _solved_differently(calibration, evidence, model, landing) for landing in _landings(calibration)
        ]
    except CalibrationError as error:
        why = f"The calibration cannot be recomputed: {error.what}"
        return ComparedPart("calibration", None, f"{name}: {why}", lacking=True)
    of = f"{len(evidence)} recording{'' if len(evidence) == 1 else 's'}"
    extent = f"from {of}"
    sentence, unmeasured_names = f"The calibration was recomputed from {of}.", []
    if calibration.simulated_quantities:
        measured = measured_by(evidence)
        # Neither simulated by the rehearsal nor recorded: these values rest on nothing that was bundled.
        unmeasured_names = [
            quantity
            for quantity in QUANTITY_NAMES
            if quantity not in (*calibration.simulated_quantities, *measured)
        ]
        sentence = f"Recomputed from {of}: {in_words(measured)}.{drawn_text}"
        sentence += (
            f" Neither recorded nor simulated: {in_words(unmeasured_names)}." if unmeasured_names else ""
        )
        extent += ", the rest simulated"
    return ComparedPart(
        "calibration",
        min(tried, key=len),
        f"{name}: {sentence}",
        extent,
        CERTIFICATE_TOLERANCE,
        lacking=bool(unmeasured_names),
    )


def _landings(calibration: Calibration) -> list[datetime | None]:
    """List the landings that may have been the last one known when the certificate was computed.

    A landing noted later is in the certificate, too, but did not change its values.
    """
    newest = max(recording.recorded_at for recording in calibration.recordings)
    landing_times = [landing.at for landing in calibration.landings]
    before = [at for at in landing_times if at <= newest]
    # The likeliest first: the last one before the newest recording, then back to none.
    return list(dict.fromkeys([*reversed(before), None, *(at for at in landing_times if at > newest)]))


def _solved_differently(
    calibration: Calibration, evidence: Sequence[Evidence], model: RobotModel, landing: datetime | None
) -> list[Difference]:
    if calibration.simulated_quantities:
        again = with_measured(calibration, evidence, model)
    else:
        solution = solve(evidence, model, landing, calibration.specimens)
        again = replace(
            calibration,
            gyros=solution.gyros,
            joints=solution.joints,
            servo_maps=solution.servo_maps(model),
        )
    # Compare the values that the certificate's file holds.
    then, now = (jsonable(certificate_values(version)) for version in (calibration, again))
    return differences(then, now, CERTIFICATE_TOLERANCE)


def _evidence(path: Path, expected_sha256: str) -> Evidence:
    data = path.read_bytes() if path.is_file() else None
    if data is not None and sha256(data) == expected_sha256:
        return from_bytes(data, source=path.name)
    why = "is not there" if data is None else "is not the one on which it rests: its SHA-256 differs"
    raise CalibrationError(
        what=f"the recording {path.name} {why}.",
        meaning="Its step cannot be computed again.",
        next_step="Copy it next to the certificate and bundle the run again.",
    )
