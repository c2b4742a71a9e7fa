"""Why a file gives no drop log."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.next_step import Advice, NextStep, install_extra

LOOK_AGAIN = Advice(
    "Copy the recording (DROP0001.BIN and up) off the card once more and decode the copy: ",
    NextStep("decode", ("SD.bin",)),
)
MODULES = {
    "parquet": ("pyarrow",),
    "pandas": ("pandas",),
    "xarray": ("xarray",),
    "mcap": ("foxglove",),
}
"""What each extra brings, by the extra's name, which is the format's name too."""


class LogError(TfsatError):
    """The file is no log, or one that would decode to wrong values (exit code 1)."""

    def __init__(self, what: str, next_step: str, meaning: str = "Nothing was decoded.") -> None:
        super().__init__(what=what, meaning=meaning, next_step=next_step)


class NoBlockError(LogError):
    """The file holds not one undamaged block (exit code 1)."""


class SessionError(UsageError):
    """The recording asked for is not in the file (exit code 2)."""


class MissingExtraError(TfsatError):
    """A format was asked for whose extra is not installed (exit code 1)."""


def unreadable(path: Path, error: OSError) -> LogError:
    """Return the error for a file that the operating system refused to read."""
    return LogError(
        f"{path} cannot be read: {error.strerror or error}.",
        "Check the permissions; if it is on the card, copy the whole card to an image first "
        "(ddrescue) and decode the image.",
        "Nothing was decoded; what is on the card is untouched.",
    )


def not_seekable(path: Path) -> LogError:
    """Return the error for a pipe, a socket or an endless device."""
    return LogError(
        f"{path} is not a file that can be read from any place: it is a pipe or a stream.",
        Advice(
            "Save it to a file first, and decode that: cat ... >SD.bin; ", NextStep("decode", ("SD.bin",))
        ),
        "Nothing was decoded: a recording is put together from all over its file.",
    )


def changed_while_read(path: Path) -> LogError:
    """Return the error for a file that got shorter or whose blocks changed between two reads."""
    return LogError(
        f"{path} changed while it was read.",
        "Wait until the copy from the card has ended, then run the same command again.",
    )


def check_extra(name: str) -> None:
    """Do nothing if format `name` can be written.

    Raises:
        MissingExtraError: a module of its extra is not installed.
    """
    missing = [module for module in MODULES.get(name, ()) if find_spec(module) is None]
    if missing:
        raise MissingExtraError(
            what=f"The format {name} needs {missing[0]}, which is not installed.",
            meaning="Nothing was written; the recording is untouched.",
            next_step=install_extra(name),
        )
