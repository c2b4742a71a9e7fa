"""What stands against a drop that is bundled, beside its record: samples lost, another robot, a rehearsal edited."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.calibration_notice import origin_of_log
from tfsat_host.errors import TfsatError
from tfsat_host.file_hash import sha256_of
from tfsat_host.record.run_record import is_inside

if TYPE_CHECKING:
    from tfsat_host.bundle.manifest import Evaluated
    from tfsat_host.cli.bundle_files import Collected

_HASHED = re.compile(r"(?P<sha256>[0-9a-f]{64})  (?P<name>.+)")
_MADE_AGAIN = (".csv", ".html")
"""Of a rehearsal's files: `decode` and `report` write them anew."""
_TRUTH = "truth.csv"


def doubts_of(found: Collected, used: Evaluated, preflight: Any) -> tuple[str, ...]:
    """Sentences; none: nothing stands against it."""
    from tfsat_host.bundle.of_one_robot import not_of_this_robot

    doubts = []
    if found.log is not None:
        serial = origin_of_log(found.log.header).logger_serial
        doubts += _lost(found)
        doubts += not_of_this_robot(serial, preflight, _logger_of_certificate(found, used))
    return (*doubts, *_not_as_rehearsed(found.folder))


def verdict_words(found: Collected) -> str:
    """What of the recording is there, for people."""
    if found.log is None:
        return "cannot be decoded"
    return f"{found.log.verdict}: {len(found.log)} samples, {found.log.samples_lost} lost"


def _lost(found: Collected) -> list[str]:
    if found.log is None or (found.log.verdict == "complete" and not found.log.samples_lost):
        return []
    return [
        f"{found.recording.name} is {found.log.verdict}, {found.log.samples_lost} samples are lost. What is missing: "
        "tfsat-host decode"
    ]


def _logger_of_certificate(found: Collected, used: Evaluated) -> str | None:
    from tfsat_host.calibration.certificate.file import read_calibration

    if used.calibration is None:
        return None
    try:
        return read_calibration(found.files[used.calibration]).subject.logger_serial
    except TfsatError:
        return None  # told with what is missing


def _not_as_rehearsed(folder: Path) -> list[str]:
    """What is not as a rehearsal left it, by the hashes in its mark; none where none was here."""
    from tfsat_host.cli.rehearse.result_folder import MARK_FILE

    mark = folder / MARK_FILE
    lines = mark.read_text(encoding="utf-8", errors="replace").splitlines() if mark.is_file() else []
    hashed = {one["name"]: one["sha256"] for line in lines if (one := _HASHED.fullmatch(line))}
    return [
        f"{name} {'was changed since' if (folder / name).is_file() else 'is gone:'} the rehearsal left it."
        for name, sha256 in hashed.items()
        if is_inside(name)
        and (name == _TRUTH or not name.endswith(_MADE_AGAIN))
        and not ((folder / name).is_file() and sha256_of(folder / name) == sha256)
    ]
