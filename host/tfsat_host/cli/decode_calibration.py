"""What `decode` says of calibration: which one would apply, what stands against it, and that the robot landed."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.calibration_notice import (
    as_json,
    find_certificate,
    is_of_robot,
    notices,
    origin_of_log,
    unreadable_as_json,
)
from tfsat_host.cli.output import Output
from tfsat_host.errors import TfsatError
from tfsat_host.protocol.limits import FALL_US

if TYPE_CHECKING:
    from tfsat_host.calibration.certificate.certificate import Calibration
    from tfsat_host.calibration.steps.counts import Counts
    from tfsat_host.sdlog import DropLog


def tell_calibration(log: DropLog, named: Path | None, out: Output) -> dict[str, Any]:
    """Says it in notes; gives `calibration` (None: there is none) and `quiet_s` for `--json`.

    The landing of the recording is written into a certificate of the same sensors. Neither the exit code nor the
    recording's own warnings depend on any of this: the recording is what it is.
    """
    return {"calibration": _tell_certificate(log, named, out), "quiet_s": _tell_quiet(log, out)}


def _tell_certificate(log: DropLog, named: Path | None, out: Output) -> dict[str, Any] | None:
    from tfsat_host.calibration.certificate.file import read_calibration

    origin = origin_of_log(log.header)
    file = find_certificate(named, log.path.parent, Path(), emulated=origin.emulated)
    if file is None:
        return None
    try:
        calibration = read_calibration(file)
    except TfsatError as error:
        out.warn(f"{error.what} {error.meaning} {error.next_step}")
        return unreadable_as_json(file, error.what)
    if is_of_robot(calibration, origin):
        calibration = _with_landing(log, file, calibration, out)
    recorded = _time_of_day(log, log.origin_us)
    said = notices(calibration, origin, recorded)
    if recorded is None and calibration.landings:
        said.append(
            "The recording does not tell its time of day: all landings are taken to have come before it."
        )
    if not said:
        out.note(f"Calibration: {file} holds for this recording.")
    for sentence in said:
        out.note(f"Calibration {file}: {sentence}")
    return as_json(calibration, file, said, recorded)


def _tell_quiet(log: DropLog, out: Output) -> float | None:
    """How long the gyros rested before the release, s."""
    from tfsat_host.calibration.steps.quiet_log import quiet_before_release

    quiet = quiet_before_release(log)
    if quiet is None:
        return None
    quiet_s = float(quiet.t_us[-1] - quiet.t_us[0]) * 1e-6
    until = "" if log.release_us is None else " before the release"
    out.note(
        f"The gyros rested for {quiet_s:.0f} s{until}: bias {_biases_words(quiet)}. "
        f"To calibrate with it: tfsat-host calibrate bias --log {log.path}"
    )
    return quiet_s


def _biases_words(quiet: Counts) -> str:
    import numpy as np

    from tfsat_host.calibration.steps.recording import Recording

    biases = np.rad2deg(Recording.from_counts(quiet).rate_rad_s.mean(axis=0))
    bodies = [
        f"body {body} {' '.join(f'{value:+.3f}' for value in bias)}" for body, bias in enumerate(biases, 1)
    ]
    return f"{', '.join(bodies)} deg/s"


def landing_of(log: DropLog) -> datetime | None:
    """When the robot hit the ground; None where the recording does not tell the time of day, or no release.

    The landing that the logger noted after the release, else the end of the fall as the tower has it.
    """
    if log.release_us is None:
        return None
    noted = (event.t_us for event in log.events if event.name == "landing" and event.t_us > log.release_us)
    return _time_of_day(log, next(noted, log.release_us + FALL_US))


def _time_of_day(log: DropLog, logger_us: int | None) -> datetime | None:
    if logger_us is None or log.unix_offset_us is None:
        return None
    try:
        return datetime(1970, 1, 1, tzinfo=UTC) + timedelta(microseconds=logger_us + log.unix_offset_us)
    except OverflowError:  # a header that tells a time beyond all calendars; `decode` shows it as that
        return None


def _with_landing(log: DropLog, file: Path, calibration: Calibration, out: Output) -> Calibration:
    """The calibration that knows of the recording's landing, as its file does from now on."""
    from tfsat_host.calibration.certificate.campaign import note_landing
    from tfsat_host.calibration.certificate.certificate import Landing, with_landing

    at = landing_of(log)
    if at is None:
        return calibration
    landing = Landing(at, f"recording {log.session:08x}")
    known = with_landing(calibration, landing)
    if known is calibration:
        return known
    when = f"{at:%Y-%m-%d %H:%M:%S} UTC"
    try:
        note_landing(file, landing)
    except OSError as error:
        out.warn(
            f"The landing at {when} could not be written into {file}: {error.strerror or error}. "
            "That calibration does not know that the robot landed since."
        )
        return known
    out.note(
        f"{file} knows of the landing at {when} now: what it may have changed is to be measured again before the "
        "next drop (tfsat-host calibrate show)."
    )
    return known
