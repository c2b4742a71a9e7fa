"""Whether a file is still the one that it was."""

from __future__ import annotations

import hashlib
import logging
from pathlib import Path
from typing import Literal

_LOG = logging.getLogger(__name__)


def sha256_of(path: Path) -> str:
    """SHA-256 of a file, hexadecimal; a card's image is read piece by piece. Raises OSError."""
    _LOG.debug("hashing %s", path)
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def change_of(path: Path, sha256: str) -> Literal["", "missing", "changed"]:
    """Return what happened to a file that had this SHA-256; empty: nothing. Raises OSError."""
    if not path.is_file():
        return "missing"
    return "" if sha256_of(path) == sha256 else "changed"
