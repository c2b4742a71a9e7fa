"""What a command's exit code says to a script."""

from __future__ import annotations

from enum import IntEnum


class ExitCode(IntEnum):
    """How a command ended; every error has one of these (`errors.TfsatError.exit_code`)."""

    DONE = 0
    """Done, and nothing is doubtful."""
    FAILED = 1
    """It could not be done."""
    USAGE = 2
    """It was called in a way that it does not understand."""
    DATA_LOSS = 3
    """Done, but data was lost or is doubtful."""
    REFUSED = 4
    """An interlock refused; nothing was changed."""
    INTERRUPTED = 130
    """Ctrl-C, as shells report it."""
