"""What is compared of a file that a command wrote: columns, topics, keys, members; of CSV and NPZ means and RMS too."""

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

from tests.contract.outline import common, outline, outline_array, without_numbers


def outline_file(path: Path, folder: str) -> Any:
    """Return the outline of a file, by its suffix.

    Args:
        path: Where it lies.
        folder: The scenario's folder, whose path stands in texts.
    """
    match path.suffix:
        # Versions of packages and the machine: other ones on each computer.
        case ".json" if path.name == "environment.json":
            return "momentary"
        case ".json":
            return without_numbers(outline(json.loads(path.read_text(encoding="utf-8")), folder))
        case ".toml":
            content = json.loads(json.dumps(tomllib.loads(path.read_text(encoding="utf-8")), default=str))
            return without_numbers(outline(content, folder))
        case ".csv":
            return _outline_csv(path)
        case ".npz":
            with np.load(path, allow_pickle=False) as arrays:
                return {name: _line(outline_array(arrays[name])) for name in sorted(arrays)}
        case ".mat":
            from scipy.io import whosmat

            return {name: f"{list(shape)} {kind}" for name, shape, kind in whosmat(path)}
        case ".parquet":
            return _outline_parquet(path)
        case ".mcap":
            return _outline_mcap(path)
        case ".html":
            return _outline_page(path, folder)
        # The members alone: each is outlined where a command writes it.
        case ".zip":
            with zipfile.ZipFile(path) as archive:
                return sorted(archive.namelist())
        case ".bin":
            return {"bytes": path.stat().st_size}
    return "(a file)"


def _line(outlined: dict[str, Any]) -> list[Any]:
    """Shape, kind, and mean and RMS if there are any."""
    return [*outlined.values()]


def _outline_csv(path: Path) -> dict[str, Any]:
    lines = path.read_text(encoding="utf-8").splitlines()
    body = [line for line in lines if not line.startswith("#")]
    header, *rows = csv.reader(io.StringIO("\n".join(body)))
    columns: dict[str, Any] = {}
    for name, column in zip(header, zip(*rows, strict=True) if rows else [()] * len(header), strict=True):
        try:
            numbers = outline_array(np.array([float(x) if x else np.nan for x in column]))
            columns[name] = [numbers[key] for key in ("not_finite", "mean", "rms") if key in numbers]
        except ValueError:
            columns[name] = "(text)"
    return {"comments": len(lines) - len(body), "rows": len(rows), "columns": columns}


def _outline_parquet(path: Path) -> dict[str, Any]:
    from pyarrow import parquet

    return {
        field.name: " ".join(
            [
                str(field.type),
                *(f"{k.decode()}={v.decode()}" for k, v in sorted((field.metadata or {}).items())),
            ]
        )
        for field in parquet.read_schema(path)
    }


def _outline_mcap(path: Path) -> dict[str, Any]:
    from mcap.reader import make_reader

    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None and summary.statistics is not None
    return {
        channel.topic: f"{channel.message_encoding} {summary.schemas[channel.schema_id].name}, "
        f"{summary.statistics.channel_message_counts[number]} messages"
        for number, channel in summary.channels.items()
    }


def _outline_page(path: Path, folder: str) -> Any:
    """Outline the document that a report page draws.

    It is outlined whole if the page is called page.html, else by its headings.
    """
    match = re.search(
        r'<script type="application/json" id="document">(.*?)</script>', path.read_text("utf-8"), re.DOTALL
    )
    assert match
    document = json.loads(match[1])
    if path.name == "page.html":
        return without_numbers(outline(document, folder))
    return {"keys": sorted(document), "drops": common([sorted(drop) for drop in document["drops"]])}
