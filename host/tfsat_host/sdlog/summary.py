"""A recording in numbers: what `decode` shows and prints as JSON."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.limits import FALL_US, RING_BLOCKS

from .doubts import two_releases
from .droplog import DropLog
from .gaps import Gap
from .metadata import late_samples, metadata

Json = dict[str, Any]


def summary(log: DropLog) -> Json:
    """The metadata, and per sensor how many samples were valid, invalid and clipped."""
    return metadata(log) | {
        "sensors": sensor_rows(log),
        "clipping": clipping(log),
        "warnings": warnings(log),
    }


def sensor_rows(log: DropLog) -> list[Json]:
    """One row a sensor: name, samples valid, invalid and clipped (None for angle sensors)."""
    rows: list[Json] = []
    for i in range(log.imu_valid.shape[1]):
        clipped = int(np.count_nonzero(log.clipped[:, i] & log.imu_valid[:, i]))
        rows.append(_row(f"IMU of body {i + 1}", log.imu_valid[:, i], clipped))
    rows += [
        _row(f"joint {i // 2 + 1} angle sensor {i % 2 + 1}", log.angle_valid[:, i], None)
        for i in range(log.angle_valid.shape[1])
    ]
    return rows


def clipping(log: DropLog) -> Json | None:
    """When IMUs were at their full scale, and how many such samples lie in the fall; None if never.

    The landing clips: that is no fault. In the fall a clipped value is a lower bound of the truth.
    """
    clipped = (log.clipped & log.imu_valid).any(axis=1)
    if not clipped.any():
        return None
    times = log.t_s[clipped]
    landings = (log.seconds(event.t_us) for event in log.events if event.name == "landing")
    fall_s = min([FALL_US / 1e6, *(t_s for t_s in landings if t_s > 0.0)])
    released = log.release_us is not None
    return {
        "first_s": float(times[0]),
        "last_s": float(times[-1]),
        "fall_s": fall_s,
        "in_fall": int(np.count_nonzero((times >= 0.0) & (times < fall_s))) if released else 0,
    }


def _row(name: str, valid: NDArray[np.bool_], clipped: int | None) -> Json:
    count = int(np.count_nonzero(valid))
    return {"sensor": name, "valid": count, "invalid": len(valid) - count, "clipped": clipped}


MOST_SINGLE_MISSES = 0.01
"""Of a sensor's readings: so many, each alone, are bridged by their neighbours without a trace in any result."""


def single_misses(valid: NDArray[np.bool_]) -> bool:
    """Whether the readings that a sensor missed, if any, are few and each stands between two that it gave."""
    missed = ~valid
    in_row = missed[1:] & missed[:-1]
    return not in_row.any() and float(np.mean(missed)) <= MOST_SINGLE_MISSES


def grave_warnings(log: DropLog) -> list[str]:
    """Of `warnings`, those on more than single readings."""
    valid = np.concatenate([log.imu_valid, log.angle_valid], axis=1)
    rows = zip(sensor_rows(log), valid.T, strict=True)
    light = {_missed_line(log, row) for row, given in rows if single_misses(given)}
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
    clipped = clipping(log)
    if clipped is not None and clipped["in_fall"]:
        lines.append(f"{clipped['in_fall']} samples in the fall are clipped: they are lower bounds.")
    lines += [_missed_line(log, row) for row in sensor_rows(log) if row["invalid"]]
    return lines


_GAPS_SHOWN = 5


def _late_line(log: DropLog) -> str:
    late = late_samples(log)
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
