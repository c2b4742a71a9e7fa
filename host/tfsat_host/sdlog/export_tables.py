"""Tables: CSV, and Parquet for pandas, polars, DuckDB and MATLAB's `parquetread`; a row a sample and a row an event.

CSV is written by looking texts up: a sensor has 65,536 different readings, and each is formatted once.
The values of Parquet are those of the CSV, whole. Its delta encoding takes integers only: times and sample numbers
have it. A dictionary holds each physical column, exact to the last bit and smaller than any of the encodings for
floating-point numbers.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tfsat_host.arrays import IntArray
from tfsat_host.quantity import record

from .droplog import EVENT_COLUMNS, CountColumn, DropLog, flag_columns, physical_columns
from .log_errors import check_extra
from .log_summary import METADATA

_CHUNK_ROWS = 8192
_INDEX_COLUMNS = ("sample", "t_us", "t_s")
_DIGITS = tuple(f"{number:03d}".encode() for number in range(1000))
# (1000, 3) ASCII digits: integers are formatted by table, three digits at a time.
_THREE_DIGITS = np.array(_DIGITS, "S3").view(np.uint8).reshape(1000, 3)
_PAD = 0
"""Fills a field up to its column's width; taken out before a row is written."""

PARQUET_MARKER = b"made by tfsat-host decode"
"""Ends the only entry of the file's metadata, which ends the file: how the command knows its own."""
METADATA_KEY = b"tfsat_recording"
"""`json.loads(pyarrow.parquet.read_schema(path).metadata[METADATA_KEY])`: the recording's metadata and `units`."""
_ROW_GROUP = 1 << 17
_UNITS = {"_deg_s": "deg/s", "_m_s2": "m/s^2", "_c": "degC", "_deg": "deg", "_us": "us", "_s": "s"}
"""Unit by the end of a column's name; the first that fits."""

Text = NDArray[np.uint8]


def header_line(log: DropLog) -> bytes:
    """Format the column names as the first line of the samples' file."""
    return _line([*_INDEX_COLUMNS, *(column.name for column in physical_columns(log)), *flag_columns(log)])


def first_row(log: DropLog) -> bytes:
    """Format the first sample's row of the samples' file."""
    return _row_texts(log)(slice(0, 1))


def write_csv(log: DropLog, path: Path) -> None:
    """Write one row a sample (RFC 4180); a reading that was not valid is an empty field."""
    texts = _row_texts(log)
    with path.open("wb") as file:
        file.write(header_line(log))
        for start in range(0, len(log), _CHUNK_ROWS):
            file.write(texts(slice(start, start + _CHUNK_ROWS)))


def write_events_csv(log: DropLog, path: Path) -> None:
    """Write one row an event, by time; index, arg and value as in the protocol's EventCode."""
    path.write_bytes(EVENTS_HEADER_LINE + b"".join(event_lines(log)))


def event_lines(log: DropLog) -> Iterator[bytes]:
    """Yield the rows of the events' file."""
    for t_us, t_s, *event in log.event_rows():
        yield _line((t_us, f"{t_s:.6f}", *event))


def _line(cells: Iterable[object]) -> bytes:
    return ",".join(map(str, cells)).encode("ascii") + b"\r\n"


EVENTS_HEADER_LINE = _line(EVENT_COLUMNS)


def _row_texts(log: DropLog) -> Callable[[slice], bytes]:
    """Return a function that gives the lines of a slice of rows."""
    physical = [_texts(column) for column in physical_columns(log)]
    flags = list(flag_columns(log).values())

    def of(rows: slice) -> bytes:
        fields = [
            _integers(log.sample_index[rows]),
            _integers(log.t_us[rows]),
            _seconds(log.t_us[rows] - log.origin_us),
            *(texts(rows) for texts in physical),
            *(flag[rows, None].astype(np.uint8) + ord("0") for flag in flags),
        ]
        # One row of fixed width a sample, (m, width) bytes, with commas set between the fields beforehand.
        width = sum(field.shape[1] + 1 for field in fields) + 1
        text = np.full((len(fields[0]), width), ord(","), np.uint8)
        at = 0
        for field in fields:
            text[:, at : at + field.shape[1]] = field
            at += field.shape[1] + 1
        # The comma behind the last field and the spare byte become the line's end.
        text[:, -2:] = (ord("\r"), ord("\n"))
        # Take the padding out of all rows in one pass: fields get their natural width.
        return text.tobytes().translate(None, bytes((_PAD,)))

    return of


def _texts(column: CountColumn) -> Callable[[slice], Text]:
    """Return a function that gives a column's texts, (m, width), for a slice of rows.

    Each count that occurs is formatted once.
    """
    # Mark which counts occur: at most 65,536 texts are formatted, however many samples there are.
    least = int(column.counts.min())
    occurs = np.zeros(int(column.counts.max()) - least + 1, bool)
    occurs[column.counts.astype(np.intp) - least] = True
    values = (least + np.flatnonzero(occurs)) * column.scale + column.offset
    formatted = np.array([f"{value:.{column.decimals}f}".encode() for value in values.tolist()])
    # A count's place among the texts is its rank among those that occur: the running sum less one.
    texts, row_of = formatted.view(f"V{formatted.itemsize}"), np.cumsum(occurs) - 1

    def of(rows: slice) -> Text:
        counts, valid = column.counts[rows], column.valid[rows]
        # Texts as raw bytes, (m, width): numpy pads shorter ones with NUL, which is _PAD.
        text = texts.take(row_of.take(counts.astype(np.intp) - least)).view(np.uint8).reshape(len(counts), -1)
        if not valid.all():
            text[~valid] = _PAD
        return text

    return of


def _seconds(time_us: IntArray) -> Text:
    """(m, width) decimal text of µs as seconds with six decimals, exact."""
    # Integer division keeps all six decimals exact; the sign is written apart.
    whole_s, micro = np.divmod(np.abs(time_us), 1_000_000)
    point = np.full((len(time_us), 1), ord("."), np.uint8)
    sign = np.where(time_us < 0, ord("-"), _PAD).astype(np.uint8)[:, None]
    milli, rest = np.divmod(micro, 1000)
    return np.hstack((sign, _integers(whole_s), point, _THREE_DIGITS[milli], _THREE_DIGITS[rest]))


def _integers(values: IntArray) -> Text:
    """(m, width) decimal text of numbers from 0, padded in front."""
    groups = []
    rest = values
    while True:
        # Split off groups of three digits, lowest first, until the largest number is used up.
        rest, group = np.divmod(rest, 1000)
        groups.append(_THREE_DIGITS[group])
        if not rest.any():
            break
    text = np.hstack(groups[::-1])
    # No digit but 0 so far, along each row: leading zeros. The last digit stays, for the number 0.
    leading = np.cumsum(text != ord("0"), axis=1) == 0
    leading[:, -1] = False
    text[leading] = _PAD
    return text


def write_parquet(log: DropLog, path: Path) -> None:
    """Write one row a sample; a reading that was not valid is null. Units are in names and metadata.

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
            *((name, pa.bool_()) for name in flags),
        ]
    )
    # Counters and clock times grow in near-constant steps: as deltas they take next to nothing.
    delta = {"sample": "DELTA_BINARY_PACKED", "t_us": "DELTA_BINARY_PACKED", "t_s": "BYTE_STREAM_SPLIT"}
    with _writer(log, path, schema, [column.name for column in physical], delta) as writer:
        for start in range(0, len(log), _ROW_GROUP):
            rows = slice(start, start + _ROW_GROUP)
            columns = [
                pa.array(log.sample_index[rows]),
                pa.array(log.t_us[rows]),
                pa.array((log.t_us[rows] - log.origin_us) / 1e6),
                *(pa.array(column.values(rows), mask=~column.valid[rows]) for column in physical),
                *(pa.array(flag[rows]) for flag in flags.values()),
            ]
            writer.write_table(pa.Table.from_arrays(columns, schema=schema), row_group_size=_ROW_GROUP)


def unit_of_column(name: str) -> str:
    """Return the unit that the end of a column's name tells; empty for what has none."""
    # The first suffix that fits decides: `_deg_s` stands before `_s` in _UNITS.
    return next((unit for ending, unit in _UNITS.items() if name.endswith(ending)), "")


def write_events_parquet(log: DropLog, path: Path) -> None:
    """Write one row an event, by time; index, arg and value as in the protocol's EventCode.

    Raises:
        MissingExtraError: pyarrow is not installed.
    """
    check_extra("parquet")
    import pyarrow as pa

    types = (pa.int64(), pa.float64(), pa.string(), pa.uint8(), pa.uint16(), pa.int32())
    schema = pa.schema(list(zip(EVENT_COLUMNS, types, strict=True)))
    rows = [dict(zip(EVENT_COLUMNS, row, strict=True)) for row in log.event_rows()]
    with _writer(log, path, schema, ["event"], {"t_us": "DELTA_BINARY_PACKED"}) as writer:
        writer.write_table(pa.Table.from_pylist(rows, schema=schema))


@contextmanager
def _writer(
    log: DropLog, path: Path, schema: Any, dictionaries: list[str], encodings: dict[str, str]
) -> Iterator[Any]:
    """Open a Parquet writer of the columns, which adds the metadata at its end.

    Arrow's own copy of the schema is left out: Parquet's types are enough, and the metadata would be there
    twice.
    """
    from pyarrow import parquet

    # A file, not its name: Arrow takes no name that is not UTF-8.
    with (
        path.open("wb") as file,
        parquet.ParquetWriter(
            file,
            schema,
            compression="zstd",
            use_dictionary=dictionaries,
            column_encoding=encodings,
            store_schema=False,
        ) as writer,
    ):
        yield writer
        units = {name: unit for name in schema.names if (unit := unit_of_column(name))}
        facts = record(METADATA, log) | {"units": units, "made": PARQUET_MARKER.decode()}
        writer.add_key_value_metadata({METADATA_KEY: json.dumps(facts)})
