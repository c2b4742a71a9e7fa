"""Whether the drop of a folder was flown: its preflight is then evidence, and no other one takes its place."""

from __future__ import annotations

import shlex
from pathlib import Path

from tfsat_host.campaign.folder import DROP
from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.protocol.limits import BLOCK_MAGIC
from tfsat_host.record.run_record import entries_of

_LOOK_BYTES = 4096
_RECORDING = ".bin"
_MAGIC = BLOCK_MAGIC.to_bytes(4, "little")


def require_not_flown(folder: Path) -> None:
    """Refuses the folder of a drop that is over.

    Raises:
        UsageError: it is a campaign's drop, holds a recording, or its record names one.
        OSError: something cannot be read.
    """
    why = _flown(folder)
    if why:
        raise UsageError(
            what=f"{folder} is the folder of a drop that was flown: {why}.",
            meaning="A preflight is what was known before the drop. One of today would take the place of that of then. "
            "Nothing was looked at, nothing was changed.",
            next_step="Make a folder for the next drop, copy maneuver.toml and the certificate into it, then: "
            f"tfsat-host preflight {shlex.quote(_next_to(folder))}",
        )


def _flown(folder: Path) -> str:
    """How that is known; empty: it was not."""
    if (folder / DROP).exists():
        return f"it holds {DROP}, so it is a campaign's"
    found = next((path for path in sorted(folder.iterdir()) if _is_recording(path)), None)
    if found is not None:
        return f"it holds the recording {found.name}"
    signed = next((name for name in _signed(folder) if name.lower().endswith(_RECORDING)), None)
    return "" if signed is None else f"its record vouches for the recording {signed}"


def _is_recording(path: Path) -> bool:
    if path.suffix.lower() != _RECORDING or not path.is_file():
        return False
    with path.open("rb") as file:
        return path.name == "SD.bin" or _MAGIC in file.read(_LOOK_BYTES)


def _signed(folder: Path) -> list[str]:
    """Names in the run's record; none where it is damaged: the preflight says so when it signs."""
    try:
        return [file.name for entry in entries_of(folder) for file in entry.files]
    except TfsatError:
        return []


def _next_to(folder: Path) -> str:
    return str(folder.parent / "NEXT") if folder.name else "NEXT"
