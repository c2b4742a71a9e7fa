"""Parquet: a row a sample and a row an event, for pandas, polars, DuckDB and MATLAB's `parquetread`.

The values are those of the CSV, whole. Parquet's delta encoding takes integers only: times and sample numbers
have it. A sensor has 65,536 different readings at most, so a dictionary holds each physical column, exact
to the last bit and smaller than any of the encodings for floating-point numbers.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from .columns import flag_columns, physical_columns
from .droplog import DropLog
from .extras import check_extra
from .metadata import metadata

PARQUET_MARKER = b"made by tfsat-host decode"
"""Ends the only entry of the file's metadata, which ends the file: how the command knows its own."""
METADATA_KEY = b"tfsat_recording"
"""`json.loads(pyarrow.parquet.read_schema(path).metadata[METADATA_KEY])`: the recording's metadata and `units`."""
_ROW_GROUP = 1 << 17
_UNITS = {"_deg_s": "deg/s", "_m_s2": "m/s^2", "_c": "degC", "_deg": "deg", "_us": "us", "_s": "s"}
"""Unit by the end of a column's name; the first that fits."""


def write_parquet(log: DropLog, path: Path) -> None:
    """Write one row a sample; a reading that was not valid is null. Units stand in names and metadata.

    Raises:
        MissingExtraError: pyarrow is not installed.
    """
    check_extra("parquet")
    import pyarrow as pa

    physical, flags = physical_columns(log), flag_columns(log)
    schema = pa.schema(
        [
            ("sample", pa.int64()),
            ("t_us", pa.int64()),
            ("t_s", pa.float64()),
            *((column.name, pa.float64()) for column in physical),
            *((column.name, pa.bool_()) for column in flags),
        ],
    )
    delta = {"sample": "DELTA_BINARY_PACKED", "t_us": "DELTA_BINARY_PACKED", "t_s": "BYTE_STREAM_SPLIT"}
    with _writer(log, path, schema, [column.name for column in physical], delta) as writer:
        for start in range(0, len(log), _ROW_GROUP):
            rows = slice(start, start + _ROW_GROUP)
            columns = [
                pa.array(log.sample_index[rows]),
                pa.array(log.t_us[rows]),
                pa.array((log.t_us[rows] - log.origin_us) / 1e6),
            ]
            for column in physical:
                values = column.counts[rows] * np.float64(column.scale) + column.offset
                columns.append(pa.array(values, mask=~column.valid[rows]))
            columns += [pa.array(column.values[rows]) for column in flags]
            writer.write_table(pa.Table.from_arrays(columns, schema=schema), row_group_size=_ROW_GROUP)


def write_events_parquet(log: DropLog, path: Path) -> None:
    """Write one row an event, by time; index, arg and value as in the protocol's EventCode.

    Raises:
        MissingExtraError: pyarrow is not installed.
    """
    check_extra("parquet")
    import pyarrow as pa

    events = log.events
    columns = {
        "t_us": pa.array([event.t_us for event in events], pa.int64()),
        "t_s": pa.array([log.seconds(event.t_us) for event in events], pa.float64()),
        "event": pa.array([event.name for event in events], pa.string()),
        "index": pa.array([event.index for event in events], pa.uint8()),
        "arg": pa.array([event.arg for event in events], pa.uint16()),
        "value": pa.array([event.value for event in events], pa.int32()),
    }
    schema = pa.schema([(name, column.type) for name, column in columns.items()])
    with _writer(log, path, schema, ["event"], {"t_us": "DELTA_BINARY_PACKED"}) as writer:
        writer.write_table(pa.Table.from_arrays(list(columns.values()), schema=schema))


@contextmanager
def _writer(
    log: DropLog, path: Path, schema: Any, dictionaries: list[str], encodings: dict[str, str]
) -> Iterator[Any]:
    """A writer of the columns, which adds the metadata at its end.

    Without Arrow's own copy of the schema: Parquet's types say it all, and the metadata would stand twice.
    """
    from pyarrow import parquet

    with parquet.ParquetWriter(
        path,
        schema,
        compression="zstd",
        use_dictionary=dictionaries,
        column_encoding=encodings,
        store_schema=False,
    ) as writer:
        yield writer
        units = {
            name: next(unit for ending, unit in _UNITS.items() if name.endswith(ending))
            for name in schema.names
            if name.endswith(tuple(_UNITS))
        }
        facts = metadata(log) | {"units": units, "made": PARQUET_MARKER.decode()}
        writer.add_key_value_metadata({METADATA_KEY: json.dumps(facts)})
