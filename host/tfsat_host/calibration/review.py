"""What a certificate says before a drop: each quantity's state, its recordings, what is missing, the next command."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime, timedelta
from functools import cached_property
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from tfsat_host.calibration.certificate.certificate import (
    DRAWABLE,
    Calibration,
    Paper,
    Quantity,
    Subject,
    commands_of,
    in_words,
    measured_in_future,
    quantities,
    summarize_shortcomings,
)
from tfsat_host.calibration.certificate.recordings_archive import recordings_folder
from tfsat_host.calibration.findings import VALUES, certificate_values
from tfsat_host.calibration.steps.evidence import sha256
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.limits import PROTOCOL_HASH
from tfsat_host.quantity import UNKNOWN, Column, Columns, Table, fields, number, record, vector
from tfsat_host.robot import RobotModel

_AGES = ((timedelta(hours=2), timedelta(minutes=1), "min"), (timedelta(days=2), timedelta(hours=1), "h"))
_NO_VALUE: Columns = tuple(Column(key, of=lambda _value: None) for key in ("value", "std", "unit"))


@dataclass(frozen=True, eq=False)
class ReviewedQuantity:
    """A quantity with its value.

    Attributes:
        quantity: Its name, state and command.
        value: What `findings.VALUES` takes its columns from; None: never measured.
        now: Time to which its age counts.
    """

    quantity: Quantity
    value: Any
    now: datetime

    @property
    def age(self) -> timedelta | None:
        """Since it was measured; None: never."""
        return None if self.quantity.measured_at is None else self.now - self.quantity.measured_at

    @property
    def shown(self) -> dict[str, Any]:
        """Value, standard deviation, unit and whatever else the quantity has, by key in JSON."""
        return record(_NO_VALUE if self.value is None else VALUES[self.quantity.kind], self.value)


@dataclass(frozen=True, slots=True)
class CheckedRecording:
    """A recording of the certificate.

    Attributes:
        paper: The certificate's entry.
        state: `matches`, `changed`, `gone` or `unreadable`.
        now: Time to which its age counts.
    """

    paper: Paper
    state: str
    now: datetime


@dataclass(frozen=True, eq=False)
class Review:
    """A certificate before a drop.

    Attributes:
        file: The certificate.
        calibration: Its contents.
        quantities: All that a drop needs, in measuring order.
        recordings: As they are now.
        now: Time to which ages count.
    """

    file: Path
    calibration: Calibration
    quantities: tuple[ReviewedQuantity, ...]
    recordings: tuple[CheckedRecording, ...]
    now: datetime

    @property
    def same_protocol(self) -> bool:
        """Whether this program's protocol is that of the one that wrote the certificate."""
        return self.calibration.protocol_hash == PROTOCOL_HASH.hex()

    @cached_property
    def shortcomings(self) -> tuple[Quantity, ...]:
        """What the next drop cannot rely on."""
        return self.calibration.shortcomings()

    @cached_property
    def defects(self) -> list[str]:
        """What blocks a drop, a few words each; empty: the certificate is ready."""
        altered = [recording for recording in self.recordings if recording.state != "matches"]
        early = measured_in_future(self.calibration, self.now)
        # Values count only with their proof: each recording as it was when they were computed.
        counts = ((altered, "recording", "altered or missing"), (early, "calibration", "dated in the future"))
        return [
            *filter(None, [summarize_shortcomings(self.shortcomings)]),
            *(f"{len(rows)} {noun}{'s' * (len(rows) > 1)} {words}" for rows, noun, words in counts if rows),
        ]

    @property
    def verdict(self) -> str:
        """READY or NOT READY, and why."""
        if self.defects:
            return f"NOT READY: {', '.join(self.defects)}"
        total = len(self.quantities)
        return f"READY: {total} of {total} calibrations valid until the next landing"


def review(file: Path, calibration: Calibration, model: RobotModel, now: datetime) -> Review:
    """Collect all that a drop needs, with its proof.

    Args:
        file: The certificate.
        calibration: Its contents.
        model: The robot.
        now: Time to which ages count.
    """
    values = certificate_values(calibration, model)
    reviewed = tuple(
        ReviewedQuantity(quantity, None if quantity.measured_at is None else values[quantity.name], now)
        for quantity in quantities(calibration)
    )
    recordings = tuple(
        CheckedRecording(paper, _recording_state(file, paper), now) for paper in calibration.papers
    )
    return Review(file, calibration, reviewed, recordings, now)


def _recording_state(certificate: Path, paper: Paper) -> str:
    """Compare a recording with the certificate: `matches`, `changed`, `gone` or `unreadable`."""
    try:
        data = (recordings_folder(certificate) / paper.file).read_bytes()
    except FileNotFoundError:
        return "gone"
    except OSError:
        return "unreadable"
    return "matches" if sha256(data) == paper.sha256 else "changed"


def age_words(age: timedelta) -> str:
    """Format an age in words, such as `3 h ago`."""
    if age < timedelta(minutes=-1):
        return "in the future"
    if age < timedelta(minutes=2):
        return "just now"
    older = (f"{age // step} {unit} ago" for limit, step, unit in _AGES if age < limit)
    return next(older, f"{age.days} days ago")


def _time(of: Callable[[Any], datetime | None]) -> Callable[[Any], str | None]:
    """Build the ISO text of a row's time; None where it has none."""

    def text(row: Any) -> str | None:
        when = of(row)
        return None if when is None else when.isoformat()

    return text


def _quantity_objects(result: Review) -> list[dict[str, Any]]:
    """Return the quantities for JSON: each kind has keys of its own next to value, std and unit."""
    return [{**record(_NAME, row), **row.shown, **record(_TIMES, row)} for row in result.quantities]


_NAME: Columns = fields("quantity=quantity.name state=quantity.state")
_TIMES: Columns = (
    Column("taken", of=_time(lambda row: row.quantity.measured_at)),
    Column("age_s", of=lambda row: None if row.age is None else row.age.total_seconds()),
    Column("command", of=lambda row: Advice(row.quantity.command)),
)
REVIEW: Columns = (
    Column("file"),
    Column("subject", of="calibration.subject", columns=fields("robot logger_serial who_am_i emulated")),
    Column("written", of=_time(lambda result: result.calibration.written)),
    *fields("tool_version=calibration.tool_version protocol_hash=calibration.protocol_hash same_protocol"),
    Column("ready", of=lambda result: not result.defects),
    Column("quantities", of=_quantity_objects),
    Column("drawn", of="calibration.drawn"),
    Column("commands", of=lambda result: [Advice(command) for command in commands_of(result.shortcomings)]),
    Column(
        "recordings",
        columns=(
            *fields("step=paper.step"),
            Column("taken", of=_time(lambda recording: recording.paper.taken)),
            *fields("file=paper.file sha256=paper.sha256 state"),
        ),
    ),
    Column(
        "landings",
        of="calibration.landings",
        columns=(Column("at", of=_time(lambda landing: landing.at)), *fields("told_by")),
    ),
)
"""Of a review, for `calibrate show --json`."""


def _robot_words(subject: Subject) -> str:
    return f"{subject.describe()}{' (of no use for a real one)' if subject.emulated else ''}"


def landing_words(calibration: Calibration, now: datetime) -> str:
    """Format the last landing."""
    if not calibration.landings:
        return "none known (decode and evaluate enter landings)"
    *earlier, last = calibration.landings
    earlier_note = f"; {len(earlier)} earlier" if earlier else ""
    return f"{last.at:%Y-%m-%d %H:%M:%S} UTC, {age_words(now - last.at)} ({last.told_by}{earlier_note})"


def _recording_words(result: Review) -> str:
    unmodified = sum(recording.state == "matches" for recording in result.recordings)
    total = len(result.recordings)
    return f"{unmodified} of {total} unmodified (SHA-256)" if total else "none"


SUMMARY: Columns = (
    Column("", "Certificate", words=lambda result: str(result.file)),
    Column("", "Robot", words=lambda result: _robot_words(result.calibration.subject)),
    Column(
        "",
        "Written",
        words=lambda result: (
            f"{result.calibration.written:%Y-%m-%d %H:%M} UTC, tfsat {result.calibration.tool_version}"
            + ("" if result.same_protocol else ", another protocol (its values are valid all the same)")
        ),
    ),
    Column("", "Last landing", words=lambda result: landing_words(result.calibration, result.now)),
    Column("", "Recordings", words=_recording_words),
    Column("", "Simulated", words=lambda result: in_words(result.calibration.drawn)),
)
"""Of a review, for people, below its verdict."""


@dataclass(frozen=True, eq=False)
class KindSummary:
    """All quantities of a kind.

    Attributes:
        kind: Of `DRAWABLE`.
        rows: The quantities.
    """

    kind: str
    rows: tuple[ReviewedQuantity, ...]

    @property
    def measured(self) -> list[ReviewedQuantity]:
        """Those that were measured."""
        return [row for row in self.rows if row.value is not None]

    def std_words(self) -> str:
        """Format the largest standard deviation."""
        if not self.measured:
            return UNKNOWN
        largest = max(float(np.max(row.shown["std"])) for row in self.measured)
        unit = self.measured[0].shown["unit"]
        return f"{number(largest, '.2g')} {'' if unit == '1' else unit}".rstrip()

    def age_words(self) -> str:
        """Format the age of the oldest."""
        ages = [row.age for row in self.rows if row.age is not None]
        return age_words(max(ages)) if ages else UNKNOWN

    def state_words(self) -> str:
        """Format how many are missing or stale; `valid` where none is."""
        states = [row.quantity.state for row in self.rows]
        parts = [f"{states.count(state)} {state}" for state in ("missing", "stale") if state in states]
        return ", ".join(parts) or "valid"


def kinds_table(result: Review) -> Table:
    """Summarize a certificate's quantities, a row a kind."""
    by_kind = groupby(result.quantities, key=lambda row: row.quantity.kind)
    return Table("", _KIND_COLUMNS, [KindSummary(kind, tuple(rows)) for kind, rows in by_kind])


_KIND_NAMES = {**DRAWABLE, "scale": "scale factors of the gyros", "servo": "maps of the servos (backlash)"}
_KIND_COLUMNS: Columns = (
    Column("", "calibration", words=lambda row: _KIND_NAMES[row.kind]),
    Column("", "measured", words=lambda row: f"{len(row.measured)} of {len(row.rows)}"),
    Column("", "max. std", words=KindSummary.std_words),
    Column("", "oldest", words=KindSummary.age_words),
    Column("", "next drop", words=KindSummary.state_words),
)


def _value_words(row: ReviewedQuantity) -> str:
    """Format value, standard deviation and unit; of several the largest deviation."""
    if row.value is None:
        return UNKNOWN
    values, stds = (np.atleast_1d(row.shown[key]).tolist() for key in ("value", "std"))
    unit = row.shown["unit"]
    return f"{vector(values, stds)} {'' if unit == '1' else unit}".rstrip()


def _part_words(row: ReviewedQuantity) -> str:
    """Format what the quantity is of: `body 1`, `body 1 about x`, `joint 3`."""
    measured, _, part = row.quantity.name.partition(" of ")
    return f"{part} about {measured[-1]}" if row.quantity.kind == "scale" else part


_RECORDING_STATES = {
    "matches": "unmodified",
    "changed": "CHANGED",
    "gone": "NOT THERE",
    "unreadable": "UNREADABLE",
}
_VALUE_COLUMNS: Columns = (
    Column("", "of", words=_part_words),
    Column("", "value ± std", words=_value_words),
    Column("", "measured", words=lambda row: UNKNOWN if row.age is None else age_words(row.age)),
    Column("", "next drop", of="quantity.state"),
)
_RECORDING_COLUMNS: Columns = (
    Column("step", "recording", of="paper.step"),
    Column("", "measured", words=lambda recording: age_words(recording.now - recording.paper.taken)),
    Column("file", "file", of="paper.file"),
    Column("", "SHA-256", words=lambda recording: _RECORDING_STATES[recording.state]),
)
_FRAMES = dict.fromkeys(("bias", "zero"), "sensor axes") | dict.fromkeys(
    ("misalignment", "scale"), "body axes"
)


def full_tables(result: Review) -> list[Table]:
    """Return every value of a certificate, and its recordings."""
    return [
        *(
            Table(", ".join(filter(None, (_KIND_NAMES[kind], _FRAMES.get(kind)))), _VALUE_COLUMNS, list(rows))
            for kind, rows in groupby(result.quantities, key=lambda row: row.quantity.kind)
        ),
        Table("recordings", _RECORDING_COLUMNS, result.recordings),
    ]


@dataclass(frozen=True, eq=False)
class KeptSteps:
    """A certificate into which steps have just gone.

    Attributes:
        file: The certificate.
        calibration: Its contents.
    """

    file: Path
    calibration: Calibration

    def validity_words(self) -> str:
        """Format what a drop needs besides, or until when the calibration is valid."""
        shortcomings = self.calibration.shortcomings()
        if not shortcomings:
            return "ready, valid until the next landing"
        return Advice(f"{summarize_shortcomings(shortcomings)} (list: ", NextStep("calibrate show"), ")")

    def next_words(self) -> str:
        """Return the command that measures what is missing first; empty: nothing is missing."""
        commands = commands_of(self.calibration.shortcomings())
        return Advice(commands[0]) if commands else ""


KEPT_STEPS: Columns = (
    Column("", "Certificate", words=lambda kept: str(kept.file)),
    Column(
        "",
        "Robot",
        words=lambda kept: "emulated, of no use for a real one" if kept.calibration.subject.emulated else "",
    ),
    Column("", "Next drop", words=KeptSteps.validity_words),
    Column("", "Next", words=KeptSteps.next_words),
)
"""What stands last on the screen of a `calibrate` command."""
