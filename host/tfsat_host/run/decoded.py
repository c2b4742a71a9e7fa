"""The files that a decoded recording becomes, beside each other under one name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.output_files import OutputFile, was_made_with, write_all

if TYPE_CHECKING:
    from tfsat_host.sdlog import DropLog

FORMATS = ("csv", "npz", "mat", "parquet", "mcap")


@dataclass(frozen=True)
class Written:
    """What was done.

    Attributes:
        files: Path of each file written, by its name in the JSON result.
        removed: Files of the same name in other formats, decoded from what stood there before.
    """

    files: dict[str, Path]
    removed: tuple[Path, ...]


def write_decoded(log: DropLog, stem: Path, formats: Sequence[str], *, force: bool) -> Written:
    """Writes `stem`.csv and so on, and removes what was decoded under this name from an older recording.

    Two recordings under one name in two formats would be taken for one. A file is of an older one when it
    is older than the recording itself.

    Raises:
        TfsatError: a file exists that is not ours, or a format's library is missing; nothing was written.
    """
    from tfsat_host.sdlog.errors import check_extra

    for name in formats:
        check_extra(name)
    wanted = _outputs(log, stem, formats)
    write_all(list(wanted.values()), force=force)
    # Only of what exists: an export's libraries take longer to load than a recording to decode.
    others = _outputs(log, stem, [name for name in FORMATS if name not in formats and _stands(stem, name)])
    stale = [file.path for file in others.values() if _is_stale(file, log.path)]
    for path in stale:
        path.unlink()
    return Written({name: file.path for name, file in wanted.items()}, tuple(stale))


def _stands(stem: Path, name: str) -> bool:
    return _named(stem, f".{name}").exists() or _named(stem, f".events.{name}").exists()


def _is_stale(file: OutputFile, recording: Path) -> bool:
    if not file.path.is_file() or not was_made_with(file.path, file.marker):
        return False
    return file.path.stat().st_mtime_ns < recording.stat().st_mtime_ns


def _named(stem: Path, ending: str) -> Path:
    return stem.with_name(stem.name + ending)


def _outputs(log: DropLog, stem: Path, formats: Sequence[str]) -> dict[str, OutputFile]:
    """What can be written, by the name it has in the JSON result. A format's libraries are loaded for it alone."""
    files = {}

    def add(key: str, ending: str, marker: bytes, write: Callable[[DropLog, Path], object]) -> None:
        files[key] = OutputFile(_named(stem, ending), marker, partial(write, log))

    if "csv" in formats:
        from tfsat_host.sdlog import export_tables as tables

        add("csv", ".csv", tables.header_line(log), tables.write_csv)
        add("events_csv", ".events.csv", tables.events_header_line(), tables.write_events_csv)
    if "npz" in formats:
        from tfsat_host.sdlog.export_arrays import NPZ_MARKER, write_npz

        add("npz", ".npz", NPZ_MARKER, write_npz)
    if "mat" in formats:
        from tfsat_host.sdlog.export_arrays import MAT_MARKER, write_mat

        add("mat", ".mat", MAT_MARKER, write_mat)
    if "parquet" in formats:
        from tfsat_host.sdlog.export_tables import PARQUET_MARKER, write_events_parquet, write_parquet

        add("parquet", ".parquet", PARQUET_MARKER, write_parquet)
        add("events_parquet", ".events.parquet", PARQUET_MARKER, write_events_parquet)
    if "mcap" in formats:
        from tfsat_host.sdlog.export_mcap import MCAP_MARKER

        add("mcap", ".mcap", MCAP_MARKER, _write_mcap)
    return files


def _write_mcap(log: DropLog, path: Path) -> None:
    """With the bodies' transforms, of the drop tower robot."""
    from tfsat_host.evaluation.body_frames import body_frames
    from tfsat_host.robot import load_robot
    from tfsat_host.sdlog.export_mcap import write_mcap

    write_mcap(log, path, body_frames(log, load_robot()))
