"""What a recording is, as plain values: for summaries and for the files that carry metadata."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from .droplog import DropLog

Json = dict[str, Any]


def metadata(log: DropLog) -> Json:
    """All that `DropLog` knows besides its columns; bytes as hexadecimal text, but for the schema."""
    return {
        "source": log.path.name,
        "session": f"{log.session:08x}",
        "other_sessions": [f"{other:08x}" for other in log.other_sessions],
        "chosen_by": log.chosen_by,
        "recordings": [asdict(one) | {"session": f"{one.session:08x}"} for one in log.recordings],
        "verdict": log.verdict,
        "samples": len(log),
        "samples_lost": log.samples_lost,
        "blocks_lost": log.blocks_lost,
        "first_s": log.seconds(int(log.t_us[0])),
        "last_s": log.seconds(int(log.t_us[-1])),
        "duration_s": log.duration_s,
        "rate_hz": log.rate_hz if log.rate_hz == log.rate_hz else None,
        "release_us": log.release_us,
        "release_uncertainty_us": log.release_uncertainty_us,
        "release_interval_us": list(log.release.interval_us) if log.release else None,
        "t_s_origin": log.t_s_origin,
        "doubts": list(log.doubts),
        "header": _plain(log.header) | {"is_copy": log.header_is_copy, "time_us": log.header_time_us},
        "unix_offset_us": log.unix_offset_us,
        "footer": _plain(log.footer) if log.footer else None,
        "set_aside": asdict(log.set_aside),
        "gaps": [asdict(gap) for gap in log.gaps],
        "late_samples": late_samples(log),
        "events": [asdict(event) | {"t_s": log.seconds(event.t_us)} for event in log.events],
    }


def late_samples(log: DropLog) -> Json:
    """How often the sampling timer's ticks passed without a sample, how many did, and the longest time."""
    rows = log.late_rows
    if not len(rows):
        return {"count": 0, "ticks_missed": 0, "longest_us": None, "longest_s": None}
    step_us = log.t_us[rows] - log.t_us[rows - 1]
    longest = int(np.argmax(step_us))
    return {
        "count": len(rows),
        "ticks_missed": int((np.rint(step_us * (log.header.rate_hz / 1e6)) - 1).sum()),
        "longest_us": int(step_us[longest]),
        "longest_s": log.seconds(int(log.t_us[rows[longest]])),
    }


def _plain(record: Any) -> Json:
    values = asdict(record)
    if "schema" in values:
        values["schema"] = values["schema"].rstrip(b"\0").decode("ascii", errors="replace")
    return {name: _json_value(value) for name, value in values.items()}


def _json_value(value: Any) -> Any:
    if isinstance(value, bytes):
        return value.hex()
    return list(value) if isinstance(value, tuple) else value
