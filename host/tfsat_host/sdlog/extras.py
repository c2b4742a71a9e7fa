"""Formats whose libraries are not installed with the package."""

from __future__ import annotations

from importlib.util import find_spec

from tfsat_host.errors import TfsatError

MODULES = {
    "parquet": ("pyarrow",),
    "mcap": ("mcap", "mcap_protobuf", "foxglove_schemas_protobuf"),
}
"""What each extra brings, by the extra's name, which is the format's name too."""


class MissingExtraError(TfsatError):
    """A format was asked for whose extra is not installed (exit code 1)."""


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
            next_step=f"In tfsat's folder: python -m pip install '.[{name}]'",
        )
