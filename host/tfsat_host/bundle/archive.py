"""The archive: a ZIP whose bytes depend on nothing but its files' names and contents.

ZIP is what every system has opened since 1989. Files are stored, not compressed: so the bytes do not hang on the
version of a compressor, a flipped bit spoils one file only, and what is large (calibration recordings) is compressed
already.
"""

from __future__ import annotations

import shutil
import stat
import zipfile
from collections.abc import Mapping
from pathlib import Path

MARKER = b"tfsat bundle, format 1"
"""The archive's comment: by it the command knows its own file."""
_TIME = (1980, 1, 1, 0, 0, 0)
_MODE = stat.S_IFREG | 0o644
_UNIX = 3
_CHUNK_BYTES = 1 << 20


def write_archive(path: Path, files: Mapping[str, Path]) -> None:
    """Writes the files by their names, sorted, all with one time and one mode. Raises OSError."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
        archive.comment = MARKER
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, _TIME)
            entry.create_system, entry.external_attr = _UNIX, _MODE << 16
            entry.file_size = files[name].stat().st_size
            with files[name].open("rb") as source, archive.open(entry, "w") as target:
                shutil.copyfileobj(source, target, _CHUNK_BYTES)
