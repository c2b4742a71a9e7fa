"""A recording in numbers and sentences: the metadata of its files, and what `decode` shows and prints as JSON."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from tfsat_host.arrays import BoolArray
from tfsat_host.notices import printable
from tfsat_host.protocol.limits import FALL_US, RING_BLOCKS

from .contradictions import two_releases
from .droplog import SENSORS_PER_JOINT, DropLog
from .ledger import Gap

Json = dict[str, Any]


def metadata(log: DropLog) -> Json:
    """Return all that `DropLog` holds besides its columns; bytes as hexadecimal text, except the schema."""
    return {
        "source": printable(log.path.name),
        "session": f"{log.session:08x}",
        "other_sessions": [f"{other:08x}" for other in log.other_sessions],
        "chosen_by": log.chosen_by,
        "recordings": [
            asdict(log_recording) | {"session": f"{log_recording.session:08x}"}
            for log_recording in log.recordings
        ],
        "verdict": log.verdict,
        "samples": len(log),
        "samples_lost": log.samples_lost,
        "blocks_lost": log.blocks_lost,
        "first_s": log.seconds(int(log.t_us[0])),
        "last_s": log.seconds(int(log.t_us[-1])),
        "duration_s": log.duration_s,
        # JSON has no NaN, which alone is unequal to itself.
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
        "late_samples": _late_samples(log),
        "events": [asdict(event) | {"t_s": log.seconds(event.t_us)} for event in log.events],
    }


def _late_samples(log: DropLog) -> Json:
    """Count the late samples and the sampling timer's ticks missed, and find the longest step."""
    rows = log.late_rows
    if not len(rows):
        return {"count": 0, "ticks_missed": 0, "longest_us": None, "longest_s": None}
    step_us = log.t_us[rows] - log.t_us[rows - 1]
    longest = int(np.argmax(step_us))
    return {
        "count": len(rows),
        # A step of k nominal periods left k - 1 ticks without a sample.
        "ticks_missed": int((np.rint(step_us * (log.header.rate_hz / 1e6)) - 1).sum()),
        "longest_us": int(step_us[longest]),
        "longest_s": log.seconds(int(log.t_us[rows[longest]])),
    }


def _plain(record: Any) -> Json:
    values = asdict(record)
    if "schema" in values:
        values["schema"] = values["schema"].rstrip(b"\0").decode("ascii", errors="replace")
    return {
        name: value.hex() if isinstance(value, bytes) else list(value) if isinstance(value, tuple) else value
        for name, value in values.items()
    }


def summary(log: DropLog) -> Json:
    """Return the metadata, and per sensor the number of samples valid, invalid and clipped."""
    return metadata(log) | {
        "sensors": _sensor_rows(log),
        "clipping": _clipping_facts(log),
        "warnings": warnings(log),
    }


def _sensor_rows(log: DropLog) -> list[Json]:
    """Return a row per sensor: name, samples valid, invalid and clipped (None for angle sensors)."""
    rows: list[Json] = []
    for i in range(log.imu_valid.shape[1]):
        clipped = int(np.count_nonzero(log.clipped[:, i] & log.imu_valid[:, i]))
        rows.append(_row(f"IMU of body {i + 1}", log.imu_valid[:, i], clipped))
    for i in range(log.angle_valid.shape[1]):
        joint, sensor = divmod(i, SENSORS_PER_JOINT)
        rows.append(_row(f"joint {joint + 1} angle sensor {sensor + 1}", log.angle_valid[:, i], None))
    return rows


def _clipping_facts(log: DropLog) -> Json | None:
    """Return when IMUs were at full scale and how many such samples lie in the fall; None if never.

    Clipping at the landing is no fault. In the fall a clipped value is a lower bound of the truth.
    """
    clipped = (log.clipped & log.imu_valid).any(axis=1)
    if not clipped.any():
        return None
    times = log.t_s[clipped]
    landings = (log.seconds(event.t_us) for event in log.events if event.name == "landing")
    # The fall ends at the first landing after t = 0, at the latest after the facility's time of fall.
    fall_s = min([FALL_US / 1e6, *(t_s for t_s in landings if t_s > 0.0)])
    released = log.release_us is not None
    return {
        "first_s": float(times[0]),
        "last_s": float(times[-1]),
        "fall_s": fall_s,
        "in_fall": int(np.count_nonzero((times >= 0.0) & (times < fall_s))) if released else 0,
    }


def _row(name: str, valid: BoolArray, clipped: int | None) -> Json:
    count = int(np.count_nonzero(valid))
    return {"sensor": name, "valid": count, "invalid": len(valid) - count, "clipped": clipped}


MAX_SINGLE_MISSES = 0.01
"""Of a sensor's readings: so many, each alone, are bridged by their neighbours without a trace in any result."""


def single_misses(valid: BoolArray) -> bool:
    """Return whether a sensor's missed readings, if any, are few and isolated.

    Isolated means that each stands between two readings that the sensor gave.
    """
    missed = ~valid
    in_row = missed[1:] & missed[:-1]
    return not in_row.any() and float(np.mean(missed)) <= MAX_SINGLE_MISSES


def grave_warnings(log: DropLog) -> list[str]:
    """Return those of `warnings` that concern more than single readings."""
    valid = np.concatenate([log.imu_valid, log.angle_valid], axis=1)
    rows = zip(_sensor_rows(log), valid.T, strict=True)
    # Isolated misses are bridged by their neighbours: leave out exactly those sensors' lines.
    light = {_missed_line(log, row) for row, is_valid in rows if single_misses(is_valid)}
    return [line for line in warnings(log) if line not in light]


def _missed_line(log: DropLog, row: Json) -> str:
    return f"The {row['sensor']} gave no value in {row['invalid']} of {len(log)} samples."


def warnings(log: DropLog) -> list[str]:
    """Sentences on everything that was lost or is doubtful; empty for a recording without fault."""
    lines = [f"Doubtful: {doubt}." for doubt in log.doubts]
    if (ambiguous := two_releases(log.release)) is not None:
        lines.append(ambiguous)
    if log.header_is_copy and log.late_start is None:
        lines.append("The first block is lost; the scales come from a copy of the header.")
    gaps = [gap for gap in log.gaps if not gap.late_start]
    if log.late_start is not None:
        lines.append(_late_start_line(log, log.late_start))
    if log.samples_lost or log.blocks_lost:
        total = len(log) + log.samples_lost
        lines.append(
            f"{log.samples_lost} of {total} samples are lost ({log.blocks_lost} blocks), in {len(gaps)} places."
        )
    lines += [_gap_line(log, gap) for gap in gaps[:_GAPS_SHOWN]]
    if len(gaps) > _GAPS_SHOWN:
        lines.append(f"  … and {len(gaps) - _GAPS_SHOWN} more (all of them with --json).")
    if len(log.late_rows):
        lines.append(_late_line(log))
    if log.footer is None:
        lines.append(_open_end_line(log))
    clipped = _clipping_facts(log)
    if clipped is not None and clipped["in_fall"]:
        lines.append(f"{clipped['in_fall']} samples in the fall are clipped: they are lower bounds.")
    lines += [_missed_line(log, row) for row in _sensor_rows(log) if row["invalid"]]
    return lines


_GAPS_SHOWN = 5


def _late_line(log: DropLog) -> str:
    late = _late_samples(log)
    return (
        f"The logger took {late['count']} samples late and none in {late['ticks_missed']} ticks before them "
        f"(longest step {late['longest_us'] / 1e3:.3f} ms, up to {late['longest_s']:.3f} s): "
        "nothing that existed is lost, but rates change unseen there."
    )


def _late_start_line(log: DropLog, gap: Gap) -> str:
    begins = f"The recording begins at block {gap.blocks}"
    if _fits_in_ram(log):
        return f"{begins}: RAM kept the newest {log.duration_s:.1f} s."
    return f"{begins}: what came before it is not in this file."


def _open_end_line(log: DropLog) -> str:
    last_s = log.seconds(int(log.t_us[-1]))
    if log.late_start is not None and _fits_in_ram(log):
        return f"It was not closed on a card: it ends with the newest sample that RAM had, at {last_s:.3f} s."
    return (
        "The recording has no end: power was cut, the card failed, or the file is a partial copy. "
        f"What came after the last sample, at {last_s:.3f} s, is unknown."
    )


def _fits_in_ram(log: DropLog) -> bool:
    return not log.other_sessions and log.recordings[0].blocks <= RING_BLOCKS


def _gap_line(log: DropLog, gap: Gap) -> str:
    start = "the start" if gap.start_us is None else f"{log.seconds(gap.start_us):.3f} s"
    end = "the end" if gap.end_us is None else f"{log.seconds(gap.end_us):.3f} s"
    cause = f", {gap.samples_dropped} of them dropped by the logger" if gap.samples_dropped else ""
    return f"  {start} to {end}: {gap.samples} samples{cause}, {gap.blocks} blocks"
