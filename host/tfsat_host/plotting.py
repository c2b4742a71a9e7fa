"""Matplotlib, the extra `figures`: whether it is there, and as files need it."""

from __future__ import annotations

import os
from importlib.util import find_spec
from typing import Any

from tfsat_host.errors import TfsatError
from tfsat_host.next_step import install_extra

MODULE = "matplotlib"


class MissingMatplotlibError(TfsatError):
    """Figures were asked for and matplotlib is not installed (exit code 1)."""


def check_matplotlib(option: str, instead: str) -> None:
    """Does nothing if figures, which `option` asks for, can be drawn; `instead` is what to do without them.

    Raises MissingMatplotlibError: they cannot.
    """
    if find_spec(MODULE) is None:
        raise MissingMatplotlibError(
            what=f"{option} needs matplotlib, which is not installed.",
            meaning="Nothing was drawn or written.",
            next_step=f"{install_extra('figures')}; or {instead}.",
        )


def load_matplotlib() -> Any:
    """Return matplotlib, imported without the backend that a notebook names in MPLBACKEND: files need none."""
    # Taken out for the import alone; child processes find it as it was.
    backend = os.environ.pop("MPLBACKEND", None)
    try:
        import matplotlib as mpl
    finally:
        if backend is not None:
            os.environ["MPLBACKEND"] = backend
    return mpl
