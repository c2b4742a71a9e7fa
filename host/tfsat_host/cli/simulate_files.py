"""The file of a simulated motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.errors import UsageError
from tfsat_host.output_files import OutputFile, check_may_write, write_all

if TYPE_CHECKING:
    from tfsat_host.dynamics import Flight

_NAME_IN_FOLDER = "simulation.csv"


@dataclass(frozen=True)
class MotionFile:
    """Where the motion goes.

    Attributes:
        path: A file ending in .csv or .npz.
        force: Overwrite what this command did not make.
    """

    path: Path
    force: bool

    @property
    def format(self) -> str:
        """csv or npz."""
        return self.path.suffix.lower()[1:]

    @property
    def marker(self) -> bytes:
        """How the command knows a file of its own."""
        from tfsat_host.dynamics.flight_file import CSV_MARKER, NPZ_MARKER

        return CSV_MARKER if self.format == "csv" else NPZ_MARKER

    def write(self, flight: Flight, metadata: Mapping[str, Any]) -> None:
        """Writes the file whole.

        Raises:
            TfsatError: something else is there.
        """
        from tfsat_host.dynamics.flight_file import write_flight_csv, write_flight_npz

        def write(path: Path) -> None:
            if self.format == "csv":
                write_flight_csv(flight, path)
            else:
                write_flight_npz(flight, path, metadata)

        write_all([OutputFile(self.path, self.marker, write)], force=self.force)


def output_file(out: Path, history: Path | None, *, force: bool) -> MotionFile:
    """The file that `--out` names, checked before anything is computed.

    Raises:
        UsageError: no format has such an ending, or it is the file that the joint history is read from.
        TfsatError: something else is there.
    """
    path = out / _NAME_IN_FOLDER if out.is_dir() or not out.suffix else out
    if path.suffix.lower() not in (".csv", ".npz"):
        raise UsageError(
            what=f"--out {out} ends neither in .csv nor in .npz.",
            meaning="Nothing was done.",
            next_step="Name a file with one of these endings, or a folder.",
        )
    if history is not None and path.exists() and history.exists() and path.samefile(history):
        raise UsageError(
            what=f"--out {path} is the file that the joint history is read from.",
            meaning="Nothing was done.",
            next_step="Give another name to --out.",
        )
    file = MotionFile(path, force)
    check_may_write(path, marker=file.marker, force=force)
    return file
