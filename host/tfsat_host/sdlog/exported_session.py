"""Whether a file that `decode` wrote is of a certain recording: by the session in it, or by its first row."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from .droplog import DropLog
from .export_tables import METADATA_KEY, event_lines, first_row
from .log_errors import MissingExtraError, check_extra


def is_of_recording(path: Path, log: DropLog) -> bool | None:
    """Return whether a file that `decode` wrote belongs to this recording.

    None if the file does not tell, or its library is not installed.
    """
    # A CSV has no metadata: compare its first row, with time and readings, to what would be written now.
    if path.suffix == ".csv":
        return _second_line(path) == _expected_line(path, log)
    read = {".npz": _session_of_npz, ".mat": _session_of_mat, ".parquet": _session_of_parquet}
    try:
        return read.get(path.suffix, _session_of_mcap)(path) == f"{log.session:08x}"
    except (MissingExtraError, OSError, ValueError, KeyError):
        # A damaged or foreign file is no error here: it only does not tell whose it is.
        return None


def _second_line(path: Path) -> bytes:
    with path.open("rb") as file:
        file.readline()
        return file.readline()


def _expected_line(path: Path, log: DropLog) -> bytes:
    """CSV has no metadata: its first row has the time and all readings of one sample, or of one event."""
    return next(event_lines(log), b"") if path.name.endswith(".events.csv") else first_row(log)


def _session_of_npz(path: Path) -> str:
    with np.load(path, allow_pickle=False) as arrays:
        return str(json.loads(str(arrays["metadata"]))["session"])


def _session_of_mat(path: Path) -> str:
    import scipy.io

    drop = scipy.io.loadmat(path, variable_names=["drop"], squeeze_me=True)["drop"]
    return str(drop["info"].item()["session"].item())


def _session_of_parquet(path: Path) -> str:
    check_extra("parquet")
    import pyarrow.parquet

    with path.open("rb") as file:
        metadata: dict[bytes, bytes] = pyarrow.parquet.read_schema(file).metadata
    return str(json.loads(metadata[METADATA_KEY])["session"])


def _session_of_mcap(path: Path) -> str:
    check_extra("mcap")
    from mcap.reader import make_reader

    from .export_mcap import METADATA_NAME

    with path.open("rb") as file:
        records = {record.name: record.metadata for record in make_reader(file).iter_metadata()}
    return str(records[METADATA_NAME]["session"])
