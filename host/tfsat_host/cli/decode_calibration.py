"""What `decode` says of calibration: which one would apply, what stands against it, and how long the gyros rested."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

import numpy as np

from tfsat_host.calibration.quiet_log import quiet_before_release
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.recording import Recording
from tfsat_host.errors import TfsatError
from tfsat_host.present.output import Output
from tfsat_host.run.certificate import hold_against, origin_of_log, time_of_day
from tfsat_host.run.certificate_notices import command_options, unreadable_as_json
from tfsat_host.run.files import find_certificate
from tfsat_host.sdlog import DropLog


def tell_calibration(log: DropLog, named: Path | None, out: Output) -> dict[str, Any]:
    """Says it in notes; gives `calibration` (None: there is none) and `quiet_s` for `--json`.

    The landing of the recording is written into a certificate of the same sensors. Neither the exit code nor the
    recording's own warnings depend on any of this: the recording is what it is.
    """
    origin = origin_of_log(log.header)
    file = find_certificate(named, log.path.parent, Path(), emulated=origin.emulated)
    return {"calibration": _tell_certificate(log, file, out), "quiet_s": _tell_quiet(log, file, out)}


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


def _tell_quiet(log: DropLog, file: Path | None, out: Output) -> float | None:
    """How long the gyros rested before the release, s."""
    quiet = quiet_before_release(log)
    if quiet is None:
        return None
    quiet_s = float(quiet.t_us[-1] - quiet.t_us[0]) * 1e-6
    until = "" if log.release_us is None else " before the release"
    rested = f"The gyros rested for {quiet_s:.0f} s{until}: bias {_biases_words(quiet)}. "
    if time_of_day(log, log.origin_us) is None:
        out.note(f"{rested}Without a time of day no calibration takes it.")
        return quiet_s
    emulated = origin_of_log(log.header).emulated
    options = "" if file is None else command_options(file, emulated=emulated)
    log_file = shlex.quote(str(log.path))
    out.note(f"{rested}To calibrate with it: tfsat-host calibrate bias --log {log_file}{options}")
    return quiet_s


def _biases_words(quiet: Counts) -> str:
    biases = np.rad2deg(Recording.from_counts(quiet).rate_rad_s.mean(axis=0))
    bodies = [
        f"body {body} {' '.join(f'{value:+.3f}' for value in bias)}" for body, bias in enumerate(biases, 1)
    ]
    return f"{', '.join(bodies)} deg/s"
