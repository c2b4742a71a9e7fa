"""A bug of tfsat: its traceback and the end of the debug log go into a file, which the error names."""

from __future__ import annotations

import platform
import sys
import tempfile
import traceback
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from tfsat_host import __version__
from tfsat_host.debug_log import MAX_RECENT_LINES, recent_lines
from tfsat_host.errors import TfsatError
from tfsat_host.user_folders import NoUserFolder, state_folder


def bug_error(error: Exception, argv: Sequence[str]) -> TfsatError:
    """Build the error for an unforeseen exception; its traceback is written to a file."""
    text = "".join(
        [
            f"tfsat-host {__version__}, Python {platform.python_version()}, {platform.platform()}\n",
            f"arguments: {list(argv)}\n\n",
            *traceback.format_exception(error),
            f"\nThe last {MAX_RECENT_LINES} lines of the debug log:\n",
            *(f"{line}\n" for line in recent_lines()),
        ]
    )
    summary = str(error).partition("\n")[0]
    return TfsatError(
        what=f"tfsat-host met a bug of its own: {type(error).__name__}: {summary}",
        meaning="The command stopped before it was done; do not rely on what it has printed or written.",
        next_step=f"Please report it, with the file {_keep(text)}",
    )


def _keep(text: str) -> Path:
    """Writes the report where the user's programs keep such things, else among temporary files."""
    stamp = datetime.now(UTC).strftime("%Y%m%dT%H%M%S.%f")
    # The report of a bug must not fail itself: folder of the user, temporary files, at last stderr.
    for is_temporary in (False, True):
        try:
            folder = Path(tempfile.gettempdir()) if is_temporary else state_folder() / "crashes"
            path = folder / f"tfsat-host-{stamp}.txt"
            folder.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        except (OSError, NoUserFolder):
            continue
        return path
    sys.stderr.write(text)
    return Path("(above: no file could be written)")
