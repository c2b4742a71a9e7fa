"""A recorded step and its origin: what a calibration is computed from, and what is kept of it."""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from functools import cached_property
from typing import Any

import numpy as np

from tfsat_host import __version__
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.steps.counts import COLUMNS, Counts, Scales
from tfsat_host.calibration.steps.sensor_samples import SensorSamples
from tfsat_host.calibration.steps.step import Step, StepKind
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.limits import PROTOCOL_HASH
from tfsat_host.protocol.live_sample import LiveSample
from tfsat_host.protocol.messages import LiveReply

FORMAT = 1


@dataclass(frozen=True, slots=True)
class Origin:
    """Whose sensors they are.

    Attributes:
        logger_serial: Of the board that they hang on, hexadecimal.
        who_am_i: Register 0x75 of IMUs 1 to 4, hexadecimal.
        emulated: They are no real robot's.
        firmware: The logger's version.
        image_crc: Of its image, 8 hexadecimal digits.
    """

    logger_serial: str
    who_am_i: str
    emulated: bool
    firmware: str
    image_crc: str


@dataclass(frozen=True, slots=True)
class Visit:
    """A servo held at a commanded angle, on the logger's clock.

    Attributes:
        pulse_us: As commanded.
        direction: +1 or -1: the way by which the joint came there.
        from_us, to_us: In between it stood still.
    """

    pulse_us: float
    direction: int
    from_us: int
    to_us: int


@dataclass(frozen=True, slots=True)
class CommandedStroke:
    """A stroke of one joint in a recording.

    Attributes:
        line_us: When the stroke line rose, on the logger's clock.
        angle_cdeg: Commanded change of the joint's angle, 0.01 deg.
    """

    line_us: int
    angle_cdeg: int


@dataclass(frozen=True, eq=False)
class Evidence:
    """One recorded step.

    Attributes:
        step: What was done.
        counts: What the sensors gave.
        recorded_at: When it was begun, with its time zone.
        origin: Whose sensors.
        tool_version, protocol_hash: Of the program that recorded it.
        visits: Of a servo step.
        servo_setting: Of a servo step: zero_us, ns_per_deg, reversed of the joint on the board at that time.
        strokes: Of a step of strokes, in order of time.
    """

    step: Step
    counts: Counts
    recorded_at: datetime
    origin: Origin
    tool_version: str = __version__
    protocol_hash: str = PROTOCOL_HASH.hex()
    visits: tuple[Visit, ...] = ()
    servo_setting: tuple[int, int, int] | None = None
    strokes: tuple[CommandedStroke, ...] = ()

    @cached_property
    def recording(self) -> SensorSamples:
        """In SI units."""
        return SensorSamples.from_counts(self.counts)

    @property
    def bodies_sensed(self) -> tuple[int, ...]:
        """Numbers of the bodies (1 to 4) whose IMU answered at all."""
        return tuple(int(body) + 1 for body in np.flatnonzero(self.counts.imu_valid.any(axis=0)))


def file_name(evidence: Evidence) -> str:
    """Sorts by purpose, then by time."""
    # UTC, so that names sort by time in any time zone.
    return f"{evidence.step.key}-{evidence.recorded_at.astimezone(UTC):%Y%m%dT%H%M%S.%f}.npz"


def to_bytes(evidence: Evidence) -> bytes:
    """Serialize evidence to a compressed NPZ archive; the same evidence gives the same bytes."""
    # All but the columns as JSON text: so the archive can be read without pickles.
    header = {
        "format": FORMAT,
        "step": asdict(evidence.step),
        "taken": evidence.recorded_at.isoformat(),
        "origin": asdict(evidence.origin),
        "scales": asdict(evidence.counts.scales),
        "samples_lost": evidence.counts.samples_lost,
        "tool_version": evidence.tool_version,
        "protocol_hash": evidence.protocol_hash,
        "visits": [asdict(visit) for visit in evidence.visits],
        "servo_setting": evidence.servo_setting,
        **({"strokes": [asdict(stroke) for stroke in evidence.strokes]} if evidence.strokes else {}),
    }
    columns: dict[str, Any] = {name: getattr(evidence.counts, name) for name in COLUMNS}
    buffer = io.BytesIO()
    np.savez_compressed(buffer, papers=np.array(json.dumps(header)), **columns)
    return buffer.getvalue()


def from_bytes(data: bytes, *, source: str) -> Evidence:
    """Parse the evidence that `to_bytes` wrote; `source` is its name in errors.

    Raises:
        CalibrationError: it is no such archive, or damaged.
    """
    try:
        # No pickles: they run code, and a recording is plain arrays.
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            header = json.loads(str(archive["papers"][()]))
            columns = {name: archive[name] for name in COLUMNS}
        if header["format"] != FORMAT:
            raise ValueError(f"its format is {header['format']}, this program reads {FORMAT}")
        return _evidence(header, columns)
    except (ValueError, KeyError, TypeError, OSError, EOFError, zipfile.BadZipFile) as error:
        raise CalibrationError(
            what=f"{source} is no recording of a calibration step, or it is damaged: {error}.",
            meaning="What was measured with it cannot be computed again.",
            next_step=Advice(
                "Take it from a copy, or repeat the step; ", NextStep("calibrate show"), " names the steps."
            ),
        ) from error


def _with_tuples(values: dict[str, Any]) -> dict[str, Any]:
    # JSON turns tuples into lists; the frozen classes hold tuples.
    return {name: tuple(value) if isinstance(value, list) else value for name, value in values.items()}


def _evidence(header: dict[str, Any], columns: dict[str, Any]) -> Evidence:
    step, scales = (_with_tuples(header[part]) for part in ("step", "scales"))
    setting = header["servo_setting"]
    return Evidence(
        step=Step(**{**step, "kind": StepKind(step["kind"])}),
        counts=Counts(**columns, samples_lost=header["samples_lost"], scales=Scales(**scales)),
        recorded_at=datetime.fromisoformat(header["taken"]),
        origin=Origin(**header["origin"]),
        tool_version=header["tool_version"],
        protocol_hash=header["protocol_hash"],
        visits=tuple(Visit(**visit) for visit in header["visits"]),
        servo_setting=None if setting is None else (setting[0], setting[1], setting[2]),
        strokes=tuple(CommandedStroke(**stroke) for stroke in header.get("strokes", ())),
    )


def sha256(data: bytes) -> str:
    """Hexadecimal."""
    return hashlib.sha256(data).hexdigest()


def newest(evidence: Iterable[Evidence]) -> dict[str, Evidence]:
    """Return the newest recording of each step, by the step's key."""
    by_key: dict[str, Evidence] = {}
    for entry in sorted(evidence, key=lambda entry: entry.recorded_at):
        # In order of time, so a repetition replaces what was recorded before.
        by_key[entry.step.key] = entry
    return by_key


Enough = Callable[[Sequence[LiveSample]], bool]
"""Given the samples that have just come: whether they are the last."""


@dataclass(frozen=True)
class LiveSource:
    """A logger that samples live.

    Attributes:
        fresh: Samples that have arrived since the last call, at least one.
        scales: As the logger named them.
        origin: Whose sensors they are.
        now: The time of day, with its time zone.
    """

    fresh: Callable[[], Sequence[LiveSample]]
    scales: LiveReply
    origin: Origin
    now: Callable[[], datetime]


def pass_over(live: LiveSource, lead_s: float) -> None:
    """Reads and forgets the samples of the time in which a person gets ready, on the logger's clock."""
    if lead_s <= 0:
        return
    first_us = live.fresh()[0].time_us
    while live.fresh()[-1].time_us < first_us + lead_s * 1e6:
        pass


def read_step(step: Step, live: LiveSource, enough: Enough) -> Evidence:
    """Reads until there is enough. Raises what `live.fresh` does."""
    recorded_at = live.now()
    samples: list[LiveSample] = []
    while True:
        fresh = live.fresh()
        samples += fresh
        if enough(fresh):
            return Evidence(step, Counts.from_live(samples, live.scales), recorded_at, live.origin)


def until_s(duration_s: float) -> Enough:
    """Enough after so long a time on the logger's clock."""
    first_us: int | None = None

    def enough(fresh: Sequence[LiveSample]) -> bool:
        nonlocal first_us
        # Time starts with the first sample that comes, on the logger's clock.
        first_us = fresh[0].time_us if first_us is None else first_us
        return fresh[-1].time_us - first_us >= duration_s * 1e6

    return enough
