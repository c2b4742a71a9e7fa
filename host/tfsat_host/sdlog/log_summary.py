"""A recording in numbers and sentences: the metadata of its files, and what `decode` shows and prints as JSON."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite
from operator import itemgetter

import numpy as np

from tfsat_host.arrays import BoolArray
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.notices import printable, utc
from tfsat_host.protocol.limits import FALL_US, RING_BLOCKS
from tfsat_host.protocol.messages import LogFooter, LogHeader
from tfsat_host.quantity import Column, Columns, columns_of, fields

from .contradictions import two_releases
from .droplog import SENSORS_PER_JOINT, DropLog
from .ledger import Gap
from .recordings import Recording, SetAside


@dataclass(frozen=True, slots=True)
class LateSamples:
    """Samples that came late: how many, the timer's ticks missed before them, the longest step and when it ended."""

    count: int
    ticks_missed: int
    longest_us: int | None
    longest_s: float | None


@dataclass(frozen=True, slots=True)
class SensorCount:
    """One sensor's samples: valid, invalid and clipped ones (None for angle sensors)."""

    sensor: str
    valid: int
    invalid: int
    clipped: int | None


@dataclass(frozen=True, slots=True)
class Clipping:
    """When IMUs were at full scale, the end of the fall, and how many such samples lie in it.

    Clipping at the landing is no fault. In the fall a clipped value is a lower bound of the truth.
    """

    first_s: float
    last_s: float
    fall_s: float
    in_fall: int


def _columns_of(kind: type) -> Columns:
    """Return a column for each field of a dataclass or named tuple."""
    return fields(" ".join(kind.__annotations__))


def _hex(value: int) -> str:
    return f"{value:08x}"


def count_late_samples(log: DropLog) -> LateSamples:
    """Count the late samples and the sampling timer's ticks missed, and find the longest step."""
    rows = log.late_rows
    if not len(rows):
        return LateSamples(0, 0, None, None)
    step_us = log.t_us[rows] - log.t_us[rows - 1]
    longest = int(np.argmax(step_us))
    # A step of k nominal periods left k - 1 ticks without a sample.
    ticks_missed = int((np.rint(step_us * (log.header.rate_hz / 1e6)) - 1).sum())
    return LateSamples(
        len(rows), ticks_missed, int(step_us[longest]), log.seconds(int(log.t_us[rows[longest]]))
    )


SENSORS: Columns = (
    Column("sensor", "sensor"),
    Column("valid", "valid"),
    Column("invalid", "invalid"),
    Column("clipped", "clipped"),
)


def count_sensors(log: DropLog) -> list[SensorCount]:
    """Count each sensor's samples: IMUs first, then angle sensors."""
    rows = []
    for i, valid in enumerate(log.imu_valid.T):
        clipped = int(np.count_nonzero(log.clipped[:, i] & valid))
        rows.append(_count_sensor(f"IMU of body {i + 1}", valid, clipped))
    for i, valid in enumerate(log.angle_valid.T):
        joint, sensor = divmod(i, SENSORS_PER_JOINT)
        rows.append(_count_sensor(f"joint {joint + 1} angle sensor {sensor + 1}", valid, None))
    return rows


def _count_sensor(name: str, valid: BoolArray, clipped: int | None) -> SensorCount:
    count = int(np.count_nonzero(valid))
    return SensorCount(name, count, len(valid) - count, clipped)


def count_clipped(log: DropLog) -> Clipping | None:
    """Count the clipped samples in the fall; None if no IMU was ever at full scale."""
    clipped = (log.clipped & log.imu_valid).any(axis=1)
    if not clipped.any():
        return None
    times = log.t_s[clipped]
    landings = (log.seconds(event.t_us) for event in log.events if event.name == "landing")
    # The fall ends at the first landing after t = 0, at the latest after the facility's time of fall.
    fall_s = min([FALL_US / 1e6, *(t_s for t_s in landings if t_s > 0.0)])
    in_fall = np.count_nonzero((times >= 0.0) & (times < fall_s)) if log.release is not None else 0
    return Clipping(float(times[0]), float(times[-1]), fall_s, int(in_fall))


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
    rows = zip(count_sensors(log), valid.T, strict=True)
    # Isolated misses are bridged by their neighbours: leave out exactly those sensors' lines.
    light = {_missed_line(log, row) for row, is_valid in rows if single_misses(is_valid)}
    return [line for line in warnings(log) if line not in light]


def _missed_line(log: DropLog, row: SensorCount) -> str:
    return f"The {row.sensor} gave no value in {row.invalid} of {len(log)} samples."


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
        blocks = f"{log.blocks_lost} block{'' if log.blocks_lost == 1 else 's'}"
        places = f"{len(gaps)} place{'' if len(gaps) == 1 else 's'}"
        lines.append(f"{log.samples_lost} of {total} samples are lost ({blocks}), in {places}.")
    lines += [_gap_line(log, gap) for gap in gaps[:_GAPS_SHOWN]]
    if len(gaps) > _GAPS_SHOWN:
        lines.append(f"  … and {len(gaps) - _GAPS_SHOWN} more (all of them with --json).")
    if len(log.late_rows):
        lines.append(_late_line(log))
    if log.footer is None:
        lines.append(_open_end_line(log))
    clipping = count_clipped(log)
    if clipping is not None and clipping.in_fall:
        lines.append(f"{clipping.in_fall} samples in the fall are clipped (lower bounds).")
    lines += [_missed_line(log, row) for row in count_sensors(log) if row.invalid]
    return lines


_GAPS_SHOWN = 5


def _late_line(log: DropLog) -> str:
    late = count_late_samples(log)
    return (
        f"The logger took {late.count} samples late and none in {late.ticks_missed} ticks before them "
        f"(longest step {(late.longest_us or 0) / 1e3:.3f} ms, up to {late.longest_s:.3f} s): "
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
        f"Nothing is known after the last sample, at {last_s:.3f} s."
    )


def _fits_in_ram(log: DropLog) -> bool:
    return not log.other_sessions and log.recordings[0].blocks <= RING_BLOCKS


def _gap_line(log: DropLog, gap: Gap) -> str:
    start = "the start" if gap.start_us is None else f"{log.seconds(gap.start_us):.3f} s"
    end = "the end" if gap.end_us is None else f"{log.seconds(gap.end_us):.3f} s"
    cause = f", {gap.samples_dropped} of them dropped by the logger" if gap.samples_dropped else ""
    return f"  {start} to {end}: {gap.samples} samples{cause}, {gap.blocks} block{'' if gap.blocks == 1 else 's'}"


_HEADER: Columns = (
    *columns_of("header", _columns_of(LogHeader)),
    Column("schema", of=lambda log: log.header.schema.rstrip(b"\0").decode("ascii", errors="replace")),
    *fields("is_copy=header_is_copy time_us=header_time_us"),
)
_FOOTER: Columns = (*_columns_of(LogFooter), Column("stop_reason", of=lambda footer: int(footer.stop_reason)))
_EVENT_KEYS = ("t_us", "t_s", "name", "index", "arg", "value")
_EVENT: Columns = tuple(Column(name, of=itemgetter(place)) for place, name in enumerate(_EVENT_KEYS))
METADATA: Columns = (
    Column("source", of=lambda log: printable(log.path.name)),
    Column("session", of=lambda log: _hex(log.session)),
    Column("other_sessions", of=lambda log: list(map(_hex, log.other_sessions))),
    *fields("chosen_by"),
    Column(
        "recordings",
        columns=(
            Column("session", of=lambda recording: _hex(recording.session)),
            *_columns_of(Recording)[1:],
        ),
    ),
    *fields("verdict"),
    Column("samples", of=len),
    *fields("samples_lost blocks_lost"),
    Column("first_s", of=lambda log: log.seconds(int(log.t_us[0]))),
    Column("last_s", of=lambda log: log.seconds(int(log.t_us[-1]))),
    *fields("duration_s"),
    # JSON has no NaN.
    Column("rate_hz", of=lambda log: log.rate_hz if isfinite(log.rate_hz) else None),
    *fields("release_us release_uncertainty_us"),
    *fields("release_interval_us=release.interval_us t_s_origin doubts"),
    Column("header", of=lambda log: log, columns=_HEADER),
    *fields("unix_offset_us"),
    Column("footer", columns=_FOOTER),
    Column("set_aside", columns=_columns_of(SetAside)),
    Column("gaps", columns=_columns_of(Gap)),
    Column("late_samples", of=count_late_samples, columns=_columns_of(LateSamples)),
    Column("events", of=lambda log: log.event_rows(), columns=_EVENT),
)
"""All that `DropLog` holds besides its columns; bytes as hexadecimal text, except the schema."""
SUMMARY: Columns = (
    *METADATA,
    Column("sensors", of=count_sensors, columns=SENSORS),
    Column("clipping", of=count_clipped, columns=_columns_of(Clipping)),
    Column("warnings", of=warnings),
)


_RECORDINGS_LISTED = 20
_CHOSEN = {
    "asked for": "which was asked for",
    "time of day": "the newest by the time of day in the headers",
    "header": "the first in the file that has a header, without which nothing can be decoded",
    "place": "the first in the file, because not every one of them tells its time of day",
}


def recordings_lines(
    log: DropLog, file: object, command: str = "decode", verb: str = "Decoded"
) -> Iterator[str]:
    """Yield lines that list the several recordings of `file`, the one taken and how to get another with `command`.

    `verb` tells what the command did with the one taken.
    """
    others = len(log.other_sessions)
    if not others:
        return
    yield f"{file} holds {others + 1} recordings. {verb}: {_hex(log.session)}, {_CHOSEN[log.chosen_by]}."
    listed = log.recordings[:_RECORDINGS_LISTED]
    for recording in listed:
        started = "-" if recording.started_unix_us is None else utc(recording.started_unix_us)
        whole = "whole" if recording.has_end else "without an end"
        yield (
            f"  {_hex(recording.session)}  {started:<23}  about {recording.samples} samples in "
            f"{recording.blocks} blocks, {whole if recording.is_unbroken else 'parts of it'}"
        )
    if others + 1 > len(listed):
        yield f"  … and {others + 1 - len(listed)} more (--json names them)."
    yield Advice("Another one: ", NextStep(command, (str(file), "--session", "ID")))
