"""What is compared of a result: names, shapes, units, numbers and names of choices; not sentences.

Numbers that are text of a moment (hashes, temporary folders, versions of libraries) are replaced by their kind. A long
list of numbers is compared by its length, mean, spread, first and last.
"""

from __future__ import annotations

import csv
import io
import json
import re
import tomllib
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

LONG_LIST = 12
_ROBOTS = re.compile(r"/\S*/robots/")
_HASH = re.compile(r"\b[0-9a-f]{64}\b")
_SESSION = re.compile(r"\bRAM-[0-9a-f]{8}\b")
_TIME = re.compile(r"\b20\d\d-?\d\d-?\d\dT\d\d:?\d\d:?\d\d(\.\d+)?(Z|\+00:00)?")
_MOMENTARY = frozenset({"environment", "age_s", "seconds", "bytes", "session"})
_NOT_DETERMINED = frozenset({"directions"})
"""Eigenvectors of the singular part of a fit: as good with another sign or mixed."""


def outline(value: Any, folder: Path) -> Any:
    """A JSON value without sentences, temporary folders, hashes and long lists.

    Args:
        value: Any JSON value.
        folder: The scenario's folder, whose path stands in texts.
    """
    if isinstance(value, dict):
        return {
            key: "momentary" if key in _MOMENTARY | _NOT_DETERMINED else outline(item, folder)
            for key, item in value.items()
        }
    if isinstance(value, list):
        numbers = _numbers(value)
        return numbers if numbers is not None else [outline(item, folder) for item in value]
    if isinstance(value, str):
        return _name(value, folder)
    return value


def _numbers(value: list[Any]) -> Any:
    """The outline of a long list of numbers, or of equally long lists of numbers; else None."""
    if len(value) <= LONG_LIST:
        return None
    try:
        array = np.array([[np.nan if x is None else x for x in row] if isinstance(row, list) else
                          np.nan if row is None else row for row in value])  # fmt: skip
    except ValueError:
        return None
    return array_outline(array) if array.dtype.kind in "fiub" else None


def array_outline(array: np.ndarray[Any, Any]) -> dict[str, Any]:
    """Shape and kind of an array, and of numbers the mean, the spread and how many are none."""
    outlined: dict[str, Any] = {"shape": list(array.shape), "kind": array.dtype.kind}
    if array.dtype.names:
        return {**outlined, "fields": list(array.dtype.names)}
    if array.dtype.kind in "fiub" and array.size:
        numbers = array.astype(np.float64)
        finite = numbers[np.isfinite(numbers)]
        outlined |= {"not_finite": int(numbers.size - finite.size)}
        if finite.size:
            outlined |= {"mean": float(finite.mean()), "rms": float(np.sqrt(np.mean(finite**2)))}
    return outlined


def _name(text: str, folder: Path) -> str:
    text = _ROBOTS.sub("ROBOTS/", text.replace(str(folder), "FOLDER"))
    if " " in text.strip() or "\n" in text:
        return "(a sentence)"
    return without_moments(_SESSION.sub("RAM-SESSION", _HASH.sub("(a SHA-256)", text)))


def without_moments(text: str) -> str:
    """A text, such as a file's name, with every date and time replaced."""
    return _TIME.sub("TIME", text)


def without_numbers(value: Any) -> Any:
    """An outline's keys and names alone."""
    if isinstance(value, dict):
        return {key: without_numbers(item) for key, item in value.items()}
    if isinstance(value, list):
        return [without_numbers(item) for item in value]
    return value if isinstance(value, str | bool) or value is None else "(a number)"


def file_outline(path: Path, folder: Path) -> Any:
    """What is compared of a file that a command wrote."""
    match path.suffix:
        case ".json":
            return outline(json.loads(path.read_text(encoding="utf-8")), folder)
        case ".toml":
            return outline(
                json.loads(json.dumps(tomllib.loads(path.read_text(encoding="utf-8")), default=str)), folder
            )
        case ".csv":
            return _csv(path)
        case ".npz":
            with np.load(path, allow_pickle=False) as arrays:
                return {name: array_outline(arrays[name]) for name in sorted(arrays)}
        case ".mat":
            from scipy.io import whosmat

            return {name: [list(shape), kind] for name, shape, kind in whosmat(path)}
        case ".parquet":
            from pyarrow import parquet

            schema = parquet.read_schema(path)
            return {
                field.name: [
                    str(field.type),
                    sorted((k.decode(), v.decode()) for k, v in (field.metadata or {}).items()),
                ]
                for field in schema
            }
        case ".mcap":
            return _mcap(path)
        case ".html":
            return _page(path, folder)
        case ".zip":
            with zipfile.ZipFile(path) as archive:
                return sorted(archive.namelist())
        case ".bin":
            return {"bytes": path.stat().st_size}
    return "(a file)"


def _csv(path: Path) -> dict[str, Any]:
    lines = path.read_text(encoding="utf-8").splitlines()
    body = [line for line in lines if not line.startswith("#")]
    header, *rows = csv.reader(io.StringIO("\n".join(body)))
    columns: dict[str, Any] = {}
    for name, column in zip(header, zip(*rows, strict=True) if rows else [()] * len(header), strict=True):
        try:
            columns[name] = array_outline(np.array([float(x) if x else np.nan for x in column]))
        except ValueError:
            columns[name] = "(text)"
    return {"comments": len(lines) - len(body), "rows": len(rows), "columns": columns}


def _mcap(path: Path) -> dict[str, Any]:
    from mcap.reader import make_reader

    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None and summary.statistics is not None
    return {
        channel.topic: [
            channel.message_encoding,
            summary.schemas[channel.schema_id].name,
            summary.statistics.channel_message_counts[number],
        ]
        for number, channel in summary.channels.items()
    }


def _page(path: Path, folder: Path) -> Any:
    """The document that a report page draws: whole where the page is called so, else its headings."""
    found = re.search(
        r'<script type="application/json" id="document">(.*?)</script>', path.read_text("utf-8"), re.DOTALL
    )
    assert found
    document = json.loads(found[1])
    if path.name == "page.html":
        return outline(document, folder)
    return {"keys": sorted(document), "drops": [sorted(drop) for drop in document["drops"]]}
