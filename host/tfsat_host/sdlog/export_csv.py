"""CSV, written by looking texts up: a sensor has 65,536 different readings, and each is formatted once."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .columns import CountColumn, FlagColumn, flag_columns, physical_columns
from .droplog import DropLog

_CHUNK_ROWS = 8192
_INDEX_COLUMNS = ("sample", "t_us", "t_s")
_EVENT_COLUMNS = ("t_us", "t_s", "event", "index", "arg", "value")
_DIGITS = tuple(f"{number:03d}".encode() for number in range(1000))
_THREE_DIGITS = np.array(_DIGITS, "S3").view(np.uint8).reshape(1000, 3)
_PAD = 0
"""Fills a field up to its column's width; taken out before a row is written."""

Text = NDArray[np.uint8]


def header_line(log: DropLog) -> bytes:
    """The first line of the samples' file: the column names."""
    names = [*_INDEX_COLUMNS, *(c.name for c in physical_columns(log)), *(c.name for c in flag_columns(log))]
    return ",".join(names).encode() + b"\r\n"


def events_header_line() -> bytes:
    """The first line of the events' file."""
    return ",".join(_EVENT_COLUMNS).encode() + b"\r\n"


def write_csv(log: DropLog, path: Path) -> None:
    """Write one row a sample (RFC 4180); a reading that was not valid is an empty field."""
    physical = [(column, _texts(column)) for column in physical_columns(log)]
    flags = flag_columns(log)
    with path.open("wb") as file:
        file.write(header_line(log))
        for start in range(0, len(log), _CHUNK_ROWS):
            rows = slice(start, start + _CHUNK_ROWS)
            file.write(_rows(log, rows, physical, flags))


def write_events_csv(log: DropLog, path: Path) -> None:
    """Write one row an event, by time; index, arg and value as in the protocol's EventCode."""
    with path.open("w", newline="", encoding="ascii") as file:
        file.write(events_header_line().decode())
        writer = csv.writer(file)
        for event in log.events:
            t_s = f"{log.seconds(event.t_us):.6f}"
            writer.writerow((event.t_us, t_s, event.name, event.index, event.arg, event.value))


def _rows(
    log: DropLog,
    rows: slice,
    physical: list[tuple[CountColumn, _Texts]],
    flags: list[FlagColumn],
) -> bytes:
    fields = [
        _integers(log.sample_index[rows]),
        _integers(log.t_us[rows]),
        _seconds(log.t_us[rows] - log.origin_us),
    ]
    for column, texts in physical:
        text = texts.of(column.counts[rows])
        valid = column.valid[rows]
        if not valid.all():
            text[~valid] = _PAD
        fields.append(text)
    fields += [flag.values[rows, None].astype(np.uint8) + ord("0") for flag in flags]
    width = sum(field.shape[1] + 1 for field in fields) + 1
    text = np.full((len(fields[0]), width), ord(","), np.uint8)
    at = 0
    for field in fields:
        text[:, at : at + field.shape[1]] = field
        at += field.shape[1] + 1
    text[:, -2:] = (ord("\r"), ord("\n"))
    return text.tobytes().translate(None, bytes((_PAD,)))


@dataclass(frozen=True, eq=False)
class _Texts:
    """The text of each count of a column that occurs.

    Attributes:
        least: The least of them.
        row: (m,) by count - least, where its text stands.
        text: (k,) those texts.
    """

    least: int
    row: NDArray[np.intp]
    text: NDArray[np.void]

    def of(self, counts: NDArray[np.integer]) -> Text:
        """(n, width)."""
        found = self.text.take(self.row.take(counts.astype(np.intp) - self.least))
        return found.view(np.uint8).reshape(len(counts), -1)


def _texts(column: CountColumn) -> _Texts:
    least = int(column.counts.min())
    occurs = np.zeros(int(column.counts.max()) - least + 1, bool)
    occurs[column.counts.astype(np.intp) - least] = True
    values = (least + np.flatnonzero(occurs)) * column.scale + column.offset
    texts = np.array([f"{value:.{column.decimals}f}".encode() for value in values.tolist()])
    return _Texts(least, np.cumsum(occurs) - 1, texts.view(f"V{texts.itemsize}"))


def _seconds(time_us: NDArray[np.int64]) -> Text:
    """(m, width) decimal text of µs as seconds with six decimals, exact."""
    whole, micro = np.divmod(np.abs(time_us), 1_000_000)
    point = np.full((len(time_us), 1), ord("."), np.uint8)
    sign = np.where(time_us < 0, ord("-"), _PAD).astype(np.uint8)[:, None]
    milli, rest = np.divmod(micro, 1000)
    return np.hstack((sign, _integers(whole), point, _THREE_DIGITS[milli], _THREE_DIGITS[rest]))


def _integers(values: NDArray[np.int64]) -> Text:
    """(m, width) decimal text of numbers from 0, padded in front."""
    groups = []
    rest = values
    while True:
        rest, group = np.divmod(rest, 1000)
        groups.append(_THREE_DIGITS[group])
        if not rest.any():
            break
    text = np.hstack(groups[::-1])
    leading = np.cumsum(text != ord("0"), axis=1) == 0
    leading[:, -1] = False
    text[leading] = _PAD
    return text
