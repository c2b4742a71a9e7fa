"""The folders of this user in which tfsat keeps what outlives a command."""

from __future__ import annotations

import os
from pathlib import Path

from tfsat_host.errors import TfsatError


class NoUserFolder(TfsatError):
    """This user has no folder of that kind: no home, and no variable that names one (exit code 1)."""


def state_folder() -> Path:
    """Return the folder of what must not be lost: notes of fetched recordings, uploaded maneuvers, the emulated robot.

    Raises:
        NoUserFolder: it is not known.
    """
    return _user_folder("XDG_STATE_HOME", "remembers recordings, maneuvers and the emulated robot")


def cache_folder() -> Path:
    """Return the folder of what can be built again: the emulated robot's library.

    Raises:
        NoUserFolder: it is not known.
    """
    return _user_folder("XDG_CACHE_HOME", "keeps the emulated robot that it built")


def _user_folder(variable: str, purpose: str) -> Path:
    """Return the user's folder from its XDG variable on every system, else the system's own.

    Errors can then name the variable.
    """
    import platformdirs

    chosen = Path(os.environ.get(variable, ""))
    # By the XDG specification a relative path is to be ignored.
    if chosen.is_absolute():
        return chosen / "tfsat"
    find = platformdirs.user_state_dir if variable == "XDG_STATE_HOME" else platformdirs.user_cache_dir
    try:
        folder = Path(find("tfsat"))
    except (RuntimeError, KeyError):
        # No home: neither the environment nor the system's list of users names one.
        folder = Path()
    if not folder.is_absolute():
        raise NoUserFolder(
            what=f"The folder in which tfsat {purpose} is not known: this user has no home folder.",
            meaning="Nothing was done.",
            next_step=f"Set {variable} to a folder that you may write to, such as: export {variable}=/tmp/tfsat",
        )
    return folder
