"""What a certificate says before a drop: each quantity's state, its recordings, what is missing, the next command."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timedelta
from functools import cached_property
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from tfsat_host.calibration.certificate.certificate import (
    QUANTITY_NAMES,
    Calibration,
    Quantity,
    Recording,
    Subject,
    commands_of,
    in_words,
    measured_in_future,
    quantities,
    summarize_shortcomings,
)
from tfsat_host.calibration.certificate.recordings_archive import recordings_folder
from tfsat_host.calibration.finding_tables import VALUES
from tfsat_host.calibration.findings import certificate_values
from tfsat_host.calibration.servos.servo_findings import DYNAMICS
from tfsat_host.calibration.steps.evidence import sha256
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.limits import PROTOCOL_HASH
from tfsat_host.quantity import UNKNOWN, Column, Columns, Table, columns_of, fields, number, vector
from tfsat_host.robot import RobotModel

_AGES = ((timedelta(hours=2), timedelta(minutes=1), "min"), (timedelta(days=2), timedelta(hours=1), "h"))
_NO_VALUE: Columns = tuple(Column(key, of=lambda _value: None) for key in ("value", "std", "unit"))


@dataclass(frozen=True, eq=False)
class ReviewedQuantity:
    """A quantity with its value.

    Attributes:
        quantity: Its name, state and command.
        value: What `findings.VALUES` takes its columns from; None: never measured.
        age: Since it was measured; None: never.
    """

    quantity: Quantity
    value: Any
    age: timedelta | None

    @property
    def columns(self) -> Columns:
        """Of value, standard deviation, unit and whatever else the quantity has."""
        return columns_of("value", _NO_VALUE if self.value is None else VALUES[self.quantity.kind])

    def take(self, key: str) -> Any:
        """Return what the column of this key has: `value`, `std` or `unit`."""
        return next(column.value(self) for column in self.columns if column.key == key)


@dataclass(frozen=True, slots=True)
class CheckedRecording:
    """A recording of the certificate: its entry, its age, and its state.

    The state is `matches`, `changed`, `gone` or `unreadable`.
    """

    recording: Recording
    age: timedelta
    state: str


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
        ReviewedQuantity(quantity, None, None)
        if quantity.measured_at is None
        else ReviewedQuantity(quantity, values[quantity.name], now - quantity.measured_at)
        for quantity in quantities(calibration)
    )
    recordings = tuple(
        CheckedRecording(recording, now - recording.recorded_at, _recording_state(file, recording))
        for recording in calibration.recordings
    )
    return Review(file, calibration, reviewed, recordings, now)


def _recording_state(certificate: Path, recording: Recording) -> str:
    """Compare a recording with the certificate: `matches`, `changed`, `gone` or `unreadable`."""
    try:
        data = (recordings_folder(certificate) / recording.file).read_bytes()
    except FileNotFoundError:
        return "gone"
    except OSError:
        return "unreadable"
    return "matches" if sha256(data) == recording.sha256 else "changed"


def age_words(age: timedelta) -> str:
    """Format an age in words, such as `3 h ago`."""
    if age < timedelta(minutes=-1):
        return "in the future"
    if age < timedelta(minutes=2):
        return "just now"
    older = (f"{age // step} {unit} ago" for limit, step, unit in _AGES if age < limit)
    return next(older, f"{age.days} days ago")


_NAME: Columns = fields("quantity=quantity.name state=quantity.state")
_TIMES: Columns = (
    *fields("taken=quantity.measured_at"),
    Column("age_s", of=lambda row: None if row.age is None else row.age.total_seconds()),
    Column("command", of=lambda row: Advice(row.quantity.command)),
)
_RECORDING: Columns = (
    *fields("step=recording.step taken=recording.recorded_at file=recording.file"),
    *fields("sha256=recording.sha256 state"),
)
REVIEW: Columns = (
    *fields("file"),
    Column("subject", of="calibration.subject", columns=fields("robot logger_serial who_am_i emulated")),
    *fields("written=calibration.written tool_version=calibration.tool_version"),
    *fields("protocol_hash=calibration.protocol_hash same_protocol"),
    Column("ready", of=lambda result: not result.defects),
    Column("quantities", columns=lambda row: (*_NAME, *row.columns, *_TIMES)),
    Column("servos", of="calibration.servo_dynamics", columns=DYNAMICS),
    *fields("drawn=calibration.simulated_quantities"),
    Column("commands", of=lambda result: [Advice(command) for command in commands_of(result.shortcomings)]),
    Column("recordings", columns=_RECORDING),
    Column("landings", of="calibration.landings", columns=fields("at told_by")),
    Column("replaced", of="calibration.replacements", columns=fields("at part was")),
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


def _servo_words(result: Review) -> str:
    """Format which joints' servos were measured for a prediction; no drop needs them."""
    joints = sorted({fit.joint for fit in result.calibration.servo_dynamics})
    return f"measured of joint {', '.join(map(str, joints))}" if joints else ""


def _replaced_words(result: Review) -> str:
    """List the parts that were replaced, with their dates."""
    return ", ".join(f"{entry.part} {entry.at:%Y-%m-%d}" for entry in result.calibration.replacements)


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
    Column("", "Replaced", words=_replaced_words),
    Column("", "Servo speeds", words=_servo_words),
    Column("", "Recordings", words=_recording_words),
    Column("", "Simulated", words=lambda result: in_words(result.calibration.simulated_quantities)),
)
"""Of a review, for people, below its verdict."""


Rows = list[ReviewedQuantity]
"""All quantities of a kind."""


def _std_words(rows: Rows) -> str:
    """Format the largest standard deviation."""
    measured = [row for row in rows if row.value is not None]
    if not measured:
        return UNKNOWN
    largest, unit = max(float(np.max(row.take("std"))) for row in measured), measured[0].take("unit")
    return f"{number(largest, '.2g')} {'' if unit == '1' else unit}".rstrip()


def _oldest_words(rows: Rows) -> str:
    ages = [row.age for row in rows if row.age is not None]
    return age_words(max(ages)) if ages else UNKNOWN


def _state_words(rows: Rows) -> str:
    """Format how many are missing or stale; `valid` where none is."""
    states = [row.quantity.state for row in rows]
    parts = [f"{states.count(state)} {state}" for state in ("missing", "stale") if state in states]
    return ", ".join(parts) or "valid"


def group_by_kind(result: Review) -> list[Rows]:
    """Return a certificate's quantities, kind by kind."""
    return [list(rows) for _, rows in groupby(result.quantities, key=lambda row: row.quantity.kind)]


_KIND_NAMES = {**QUANTITY_NAMES, "scale": "scale factors of the gyros", "servo": "servo maps (backlash)"}
KINDS: Columns = (
    Column("", "calibration", words=lambda rows: _KIND_NAMES[rows[0].quantity.kind]),
    Column("", "measured", words=lambda rows: f"{sum(row.value is not None for row in rows)} of {len(rows)}"),
    Column("", "max. std", words=_std_words),
    Column("", "oldest", words=_oldest_words),
    Column("", "next drop", words=_state_words),
)
"""Of `group_by_kind`, for people: a row a kind."""


def _value_words(row: ReviewedQuantity) -> str:
    """Format value, standard deviation and unit; of several the largest deviation."""
    if row.value is None:
        return UNKNOWN
    values, stds = (np.atleast_1d(row.take(key)).tolist() for key in ("value", "std"))
    unit = row.take("unit")
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
    Column("step", "recording", of="recording.step"),
    Column("", "measured", words=lambda recording: age_words(recording.age)),
    Column("file", "file", of="recording.file"),
    Column("", "SHA-256", words=lambda recording: _RECORDING_STATES[recording.state]),
)
_FRAMES = dict.fromkeys(("bias", "zero"), "sensor axes") | dict.fromkeys(
    ("misalignment", "scale"), "body axes"
)


def full_tables(result: Review) -> list[Table]:
    """Return every value of a certificate, and its recordings."""
    return [
        *(
            Table(", ".join(filter(None, (_KIND_NAMES[kind], _FRAMES.get(kind)))), _VALUE_COLUMNS, rows)
            for kind, rows in ((rows[0].quantity.kind, rows) for rows in group_by_kind(result))
        ),
        Table("servos: speed, acceleration, delay", DYNAMICS, result.calibration.servo_dynamics),
        Table("recordings", _RECORDING_COLUMNS, result.recordings),
    ]


def _validity_words(calibration: Calibration) -> str:
    """Format what a drop needs besides, or until when the calibration is valid."""
    shortcomings = calibration.shortcomings()
    if not shortcomings:
        return "ready, valid until the next landing"
    return Advice(f"{summarize_shortcomings(shortcomings)} (list: ", NextStep("calibrate show"), ")")


def _next_words(calibration: Calibration) -> str:
    """Return the command that measures what is missing first; empty: nothing is missing."""
    commands = commands_of(calibration.shortcomings())
    return Advice(commands[0]) if commands else ""


_EMULATED = "emulated, of no use for a real one"
CERTIFICATE: Columns = (
    Column("", "Certificate", words=lambda campaign: str(campaign.certificate)),
    Column("", "Robot", words=lambda campaign: _EMULATED if campaign.calibration.subject.emulated else ""),
    Column("", "Next drop", words=lambda campaign: _validity_words(campaign.calibration)),
    Column("", "Next", words=lambda campaign: _next_words(campaign.calibration)),
)
"""Of a `Campaign`, for people: what stands last on the screen of a `calibrate` command."""
