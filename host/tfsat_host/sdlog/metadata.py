"""What a recording is, as plain values: for summaries and for the files that carry metadata."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from .droplog import DropLog

Json = dict[str, Any]


def metadata(log: DropLog) -> Json:
    """All that `DropLog` knows besides its columns; bytes as hexadecimal text."""
    return {
        "source": log.path.name,
        "session": f"{log.session:08x}",
        "other_sessions": [f"{other:08x}" for other in log.other_sessions],
        "verdict": log.verdict,
        "samples": len(log),
        "samples_lost": log.samples_lost,
        "blocks_lost": log.blocks_lost,
        "duration_s": log.duration_s,
        "rate_hz": log.rate_hz if log.rate_hz == log.rate_hz else None,
        "release_us": log.release_us,
        "release_uncertainty_us": log.release_uncertainty_us,
        "release_interval_us": [log.release.earliest_us, log.release.latest_us] if log.release else None,
        "t_s_origin": log.t_s_origin,
        "doubts": list(log.doubts),
        "header": _plain(log.header) | {"is_copy": log.header_is_copy},
        "footer": _plain(log.footer) if log.footer else None,
        "set_aside": asdict(log.set_aside),
        "gaps": [asdict(gap) for gap in log.gaps],
        "events": [asdict(event) | {"t_s": log.seconds(event.t_us)} for event in log.events],
    }


def _plain(record: Any) -> Json:
    return {
        name: value.hex() if isinstance(value, bytes) else value for name, value in asdict(record).items()
    }
