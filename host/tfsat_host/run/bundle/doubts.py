"""What stands against a drop that is bundled: samples lost, another robot, files changed since they were checked."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.errors import TfsatError
from tfsat_host.file_hash import sha256_of
from tfsat_host.run.bundle.collecting import Collected
from tfsat_host.run.bundle.manifest import Evaluated
from tfsat_host.run.certificate import origin_of_log
from tfsat_host.run.files import rehearsed_files

_MADE_AGAIN = (".csv", ".html")
"""Of a rehearsal's files: `decode` and `report` write them again."""
_TRUTH = "truth.csv"
_CHECKED = ("maneuver", "calibration", "robot", "facility")


def doubts_of(found: Collected, used: Evaluated, preflight: Any) -> tuple[str, ...]:
    """Sentences; none: nothing stands against it. `preflight` is what `preflight.json` holds."""
    doubts = []
    if found.log is not None:
        if found.log.verdict != "complete" or found.log.samples_lost:
            doubts.append(
                f"{found.recording.name} is {found.log.verdict}, {found.log.samples_lost} samples are lost. What is "
                "missing: tfsat-host decode"
            )
        doubts += _of_other_robots(origin_of_log(found.log.header).logger_serial, found, used, preflight)
    return (*doubts, *_not_as_rehearsed(found.folder))


def not_as_checked(preflight: Any, at_hand: Mapping[str, str], used: Evaluated) -> list[str]:
    """What the preflight checked and is gone, or is another one now; a sentence each.

    A certificate is written again when the robot has landed: the one that was checked lies among those that were kept.

    Args:
        preflight: What `preflight.json` holds; whatever is no preflight's names no files.
        at_hand: SHA-256 of every file, by its name in the bundle.
        used: Which of them the drop is evaluated with.
    """
    files = preflight.get("files") if isinstance(preflight, dict) else None
    if not isinstance(files, dict):
        return []
    found = (_changed(kind, files[kind], at_hand, getattr(used, kind)) for kind in _CHECKED if kind in files)
    return [sentence for sentence in found if sentence]


def _changed(kind: str, checked: Any, at_hand: Mapping[str, str], name: str | None) -> str:
    """Empty: it is there."""
    sha256 = checked.get("sha256") if isinstance(checked, dict) else None
    if not isinstance(sha256, str):
        return f"preflight.json does not say which {kind} was checked."
    kept = kind == "calibration" and sha256 in at_hand.values()
    if kept or (name is not None and at_hand.get(name) == sha256):
        return ""
    then = f"{checked.get('path')}, SHA-256 {sha256[:12]}…"
    if name is None:
        return f"The {kind} that the preflight checked ({then}) is gone."
    beside = ", and none of the certificates that were kept is" if kind == "calibration" else ""
    return f"{name} is not the {kind} that the preflight checked ({then}){beside}."


def _of_other_robots(serial: str, found: Collected, used: Evaluated, preflight: Any) -> list[str]:
    """What names another logger than the recording does; a sentence each."""
    loggers = {"preflight.json": _logger_in(preflight), "the certificate": _logger_calibrated(found, used)}
    return [
        f"The recording is of logger {serial or 'without a serial number'}, {what} of logger "
        f"{other or 'without a serial number'}: they are of different robots."
        for what, other in loggers.items()
        if other is not None and other.lower() != serial.lower()
    ]


def _logger_in(preflight: Any) -> str | None:
    """Of the logger that was asked; whatever is no preflight's names none."""
    for key in ("boards", "logger", "serial"):
        preflight = preflight.get(key) if isinstance(preflight, dict) else None
    return preflight if isinstance(preflight, str) else None


def _logger_calibrated(found: Collected, used: Evaluated) -> str | None:
    if used.calibration is None:
        return None
    try:
        return read_calibration(found.files[used.calibration]).subject.logger_serial
    except TfsatError:
        return None  # stands with what is missing


def _not_as_rehearsed(folder: Path) -> list[str]:
    """What is not as a rehearsal left it, by the hashes in its mark; none where none was here."""
    return [
        f"{name} {'was changed since' if (folder / name).is_file() else 'is gone:'} the rehearsal left it."
        for name, sha256 in rehearsed_files(folder).items()
        if sha256
        and (name == _TRUTH or not name.endswith(_MADE_AGAIN))
        and not ((folder / name).is_file() and sha256_of(folder / name) == sha256)
    ]
