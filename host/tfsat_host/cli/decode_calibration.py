"""What `decode` says of calibration: which one would apply, what stands against it, and that the robot landed."""

from __future__ import annotations

import shlex
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.calibration_notice import (
    as_json,
    command_options,
    find_certificate,
    is_of_robot,
    notices,
    origin_of_log,
    unreadable_as_json,
)
from tfsat_host.cli.decode_landing import is_told_by, landing_of, note_landing_of, time_of_day
from tfsat_host.cli.output import Output
from tfsat_host.errors import TfsatError

if TYPE_CHECKING:
    from tfsat_host.calibration.certificate.certificate import Calibration
    from tfsat_host.calibration.certificate.of_drop import CertificateOfDrop
    from tfsat_host.calibration.steps.counts import Counts
    from tfsat_host.sdlog import DropLog

_NO_TIME = (
    "The recording has no time of day: it is not known whether the calibration is older or newer than this fall, and a "
    "landing in between may have changed what it says. All landings but its own are taken to have come before it. Use "
    "the calibration only if you know that it was taken before this fall, and that the robot did not land in between. "
    "The next recording has a time of day if it is begun with tfsat-host record start."
)


def tell_calibration(log: DropLog, named: Path | None, out: Output) -> dict[str, Any]:
    """Says it in notes; gives `calibration` (None: there is none) and `quiet_s` for `--json`.

    The landing of the recording is written into a certificate of the same sensors. Neither the exit code nor the
    recording's own warnings depend on any of this: the recording is what it is.
    """
    origin = origin_of_log(log.header)
    file = find_certificate(named, log.path.parent, Path(), emulated=origin.emulated)
    return {"calibration": _tell_certificate(log, file, out), "quiet_s": _tell_quiet(log, file, out)}


@dataclass(frozen=True, eq=False)
class HeldAgainst:
    """A certificate beside a recording.

    Attributes:
        path: Of the certificate that held at the release.
        calibration: What it says; where nobody knows when the recording was, without the landing that ended it.
        said: What stands against using it for the recording, a sentence or two each.
        facts: For `--json`.
    """

    path: Path
    calibration: Calibration
    said: list[str]
    facts: dict[str, Any]


def hold_against(log: DropLog, file: Path, out: Output, *, servos: bool = True) -> HeldAgainst:
    """Holds a certificate against a recording; the recording's landing is written into it.

    Args:
        log: The recording.
        file: The certificate that lies there now.
        out: For what was done on the way.
        servos: Whether it matters that they were measured.

    Raises:
        TfsatError: the certificate cannot be read or understood.
    """
    from tfsat_host.calibration.certificate.file import read_calibration

    origin = origin_of_log(log.header)
    present = read_calibration(file)
    if is_of_robot(present, origin):
        note_landing_of(log, file, present, out)
    used = _certificate_of(log, file)
    for sentence in used.unreadable:
        out.warn(f"{sentence} It was passed over.")
    if used.path != file:
        out.note(
            f"{file} was measured anew after this fall: {used.path} is the certificate that was the newest at its "
            "release."
        )
    recorded = time_of_day(log, log.origin_us)
    calibration = used.calibration if recorded else _without_landing_of(log, used.calibration)
    said = notices(calibration, origin, file, recorded, servos=servos)
    if recorded is None and is_of_robot(calibration, origin):
        said.append(_NO_TIME)
    facts = as_json(calibration, used.path, said, recorded, into=file, servos=servos)
    return HeldAgainst(used.path, calibration, said, facts)


def _tell_certificate(log: DropLog, file: Path | None, out: Output) -> dict[str, Any] | None:
    if file is None:
        return None
    try:
        held = hold_against(log, file, out)
    except TfsatError as error:
        out.warn(f"{error.what} {error.meaning} {error.next_step}")
        return unreadable_as_json(file, error.what)
    if not held.said:
        out.note(f"Calibration: {held.path} holds for this recording.")
    for sentence in held.said:
        out.note(f"Calibration {held.path}: {sentence}")
    return held.facts


def _certificate_of(log: DropLog, file: Path) -> CertificateOfDrop:
    """The one that held at the release. Raises CalibrationError if the present one cannot be read."""
    from tfsat_host.calibration.certificate.file import read_calibration
    from tfsat_host.calibration.certificate.of_drop import CertificateOfDrop, certificate_for

    released, landed = time_of_day(log, log.release_us), landing_of(log)
    if released is None or landed is None:
        return CertificateOfDrop(file, read_calibration(file))
    return certificate_for(file, released, landed)


def _without_landing_of(log: DropLog, calibration: Calibration) -> Calibration:
    """Its own landing ended the recording; whatever else is known may have come before."""
    others = tuple(one for one in calibration.landings if not is_told_by(one, log))
    return replace(calibration, landings=others)


def _tell_quiet(log: DropLog, file: Path | None, out: Output) -> float | None:
    """How long the gyros rested before the release, s."""
    from tfsat_host.calibration.steps.quiet_log import quiet_before_release

    quiet = quiet_before_release(log)
    if quiet is None:
        return None
    quiet_s = float(quiet.t_us[-1] - quiet.t_us[0]) * 1e-6
    until = "" if log.release_us is None else " before the release"
    told = f"The gyros rested for {quiet_s:.0f} s{until}: bias {_biases_words(quiet)}. "
    if time_of_day(log, log.origin_us) is None:
        out.note(f"{told}Without a time of day no calibration takes it.")
        return quiet_s
    emulated = origin_of_log(log.header).emulated
    options = "" if file is None else command_options(file, emulated=emulated)
    log_file = shlex.quote(str(log.path))
    out.note(f"{told}To calibrate with it: tfsat-host calibrate bias --log {log_file}{options}")
    return quiet_s


def _biases_words(quiet: Counts) -> str:
    import numpy as np

    from tfsat_host.calibration.steps.recording import Recording

    biases = np.rad2deg(Recording.from_counts(quiet).rate_rad_s.mean(axis=0))
    bodies = [
        f"body {body} {' '.join(f'{value:+.3f}' for value in bias)}" for body, bias in enumerate(biases, 1)
    ]
    return f"{', '.join(bodies)} deg/s"
