"""Evaluations as the one document that the page shows.

drop = ReportedDrop("drop 1", found, verdict_of(found), sha256_of(found.log.path), certificate)
page = render(document_of([drop], datetime.now(UTC)))
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from tfsat_host import __version__, quantity
from tfsat_host.calibration.certificate.certificate import quantities
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.result.evaluation_tables import (
    calibration_table,
    reasons_of,
    release_time,
    tables_of,
    utc,
)
from tfsat_host.evaluation.result.first_screen import change_sentence, prediction_table, stroke_summary
from tfsat_host.evaluation.result.key_numbers import key_numbers_of
from tfsat_host.evaluation.verdict import Verdict
from tfsat_host.file_hash import sha256_of
from tfsat_host.next_step import name_recording
from tfsat_host.protocol.limits import PROTOCOL_HASH
from tfsat_host.quantity import UNKNOWN, Column, Columns, Quantity, fields, record
from tfsat_host.report.contents.chart import PLOT
from tfsat_host.report.contents.charts import charts_of
from tfsat_host.report.contents.event_marks import EVENT, events_of
from tfsat_host.report.contents.replay import replay_columns, replay_of
from tfsat_host.report.contents.withheld_curves import failed_check

FORMAT = 2
"""Version of this layout; the page says so when it gets another one."""
_HYPHEN = re.compile(r"(?:(?<=^)|(?<=[\s(]))-(?=\d)|(?<=\de)-(?=\d)")
"""Before a number, or its power of ten."""


@dataclass(frozen=True, slots=True)
class Source:
    """A file that the evaluation took something from, as it was then.

    Attributes:
        what: Such as `calibration`.
        path: Where it lay.
        sha256: Of its bytes, hexadecimal.
    """

    what: str
    path: Path
    sha256: str

    @classmethod
    def of(cls, what: str, path: Path) -> Source:
        """Build the source of a file, with its hash as it is now."""
        return cls(what, path, sha256_of(path))


@dataclass(frozen=True, eq=False)
class ReportedDrop:
    """One drop.

    Attributes:
        name: For people; the same in no two drops of a report.
        evaluation: What is known of it.
        verdict: What that is worth, by `verdict.verdict_of`.
        recording_sha256: Of the file that was evaluated, hexadecimal.
        certificate: The file of the calibration; None: there was none.
        sources: Other files besides the recording that were read.
        options: What else was asked for, as it is typed.
        remarks: What else a reader should know, such as that no maneuver was given; a sentence each.
    """

    name: str
    evaluation: Evaluation
    verdict: Verdict
    recording_sha256: str
    certificate: Path | None
    remarks: tuple[str, ...] = ()
    sources: tuple[Source, ...] = ()
    options: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class ReportPage:
    """One page.

    Attributes:
        drops: One or more; their names differ.
        made_at: Creation time with its time zone.
        tables: Of all drops together.
        lacking: Drops that were asked for and are missing, and why; a sentence or more each.
    """

    drops: Sequence[ReportedDrop]
    made_at: datetime
    tables: Sequence[quantity.Table]
    lacking: Sequence[str]

    @property
    def title(self) -> str:
        """The robots and the drops."""
        robots = dict.fromkeys(drop.evaluation.model.name for drop in self.drops)
        kind = "EMULATED " if any(drop.evaluation.log.is_emulated for drop in self.drops) else ""
        return f"{kind}{', '.join(robots)}: {', '.join(drop.name for drop in self.drops)}"


def document_of(
    drops: Sequence[ReportedDrop],
    made_at: datetime,
    *,
    tables: Sequence[quantity.Table] = (),
    lacking: Sequence[str] = (),
) -> dict[str, Any]:
    """Build the JSON document that the page's script shows; see `ReportPage`.

    Times are seconds after release, ascending. Wherever a number may be missing it is None; the page leaves a gap
    there. Strings may come from a hostile log: the page shows them as text, whatever they hold.
    """
    return record(_PAGE, ReportPage(drops, made_at, tables, lacking))


def _with_named_recording(drop: ReportedDrop) -> ReportedDrop:
    """Return the drop with its recording in the commands: a reader elsewhere does not know of which they speak."""
    evaluation = drop.evaluation
    checks = tuple(
        replace(
            check, next_step=check.next_step and name_recording(check.next_step, str(evaluation.log.path))
        )
        for check in evaluation.checks
    )
    return replace(drop, evaluation=replace(evaluation, checks=checks))


def _notes(drop: ReportedDrop) -> list[str]:
    """Collect a drop's notes on unusable data and assumptions that its verdict does not give already."""
    evaluation, velocity = drop.evaluation, drop.evaluation.release_velocity
    notes = [
        *evaluation.notes,
        *evaluation.micro_gravity.notes,
        *(velocity.notes if velocity else ()),
        *drop.remarks,
    ]
    return [note for note in dict.fromkeys(notes) if note not in drop.verdict.reasons]


def _change_text(evaluation: Evaluation) -> str:
    return _HYPHEN.sub("−", change_sentence(evaluation)).replace(" ± ", "\u00a0±\u00a0")


def _why_no_replay(evaluation: Evaluation) -> str:
    return "" if evaluation.is_given() else f"Replay withheld: “{failed_check(evaluation)}” (check failed)"


def _tables(drop: ReportedDrop) -> list[quantity.Table]:
    return [*tables_of(drop.evaluation), calibration_table(drop.evaluation), provenance_table(drop)]


def _finite(value: float | None) -> float | None:
    return float(value) if value is not None and math.isfinite(value) else None


def _text(column: Column, row: Any) -> str:
    """Numbers with a real minus: a hyphen is shorter than a plus."""
    cell = column.cell(row)
    if isinstance(cell, Quantity):
        return _HYPHEN.sub("−", cell.text())
    # Names keep their hyphens: only numbers get a real minus.
    is_name = column.words is None and isinstance(column.value(row), str)
    return cell if is_name else _HYPHEN.sub("−", cell)


def provenance_table(drop: ReportedDrop) -> quantity.Table:
    """Files, versions, sensors, time of day."""
    evaluation = drop.evaluation
    log, header = evaluation.log, evaluation.log.header
    rate = f"{log.rate_hz:.2f} Hz" if np.isfinite(log.rate_hz) else "unknown"
    rows = [
        ["recording", str(log.path)],
        ["session", f"{log.session:08x}"],
        ["SHA-256 of the recording", drop.recording_sha256],
        ["released", utc(release_time(log))],
        ["samples", f"{len(log)}, {log.samples_lost} lost; {rate} ({header.rate_hz:g} Hz commanded)"],
        ["logger", _logger(evaluation)],
        [
            "gyros",
            f"± {header.gyro_range_deg_s} deg/s, low-pass setting {header.dlpf_cfg}, WHO_AM_I {header.who_am_i.hex()}",
        ],
        ["robot", f"{evaluation.model.name} ({evaluation.model.path})"],
        [
            "calibration",
            "none"
            if drop.certificate is None
            else f"{drop.certificate}, {_measurement_time_text(evaluation)}",
        ],
        ["maneuver", _maneuver(evaluation)],
        *([source.what, f"{source.path}, SHA-256 {source.sha256}"] for source in drop.sources),
        ["options", " ".join(drop.options) or "none"],
        ["tfsat-host", f"{__version__}, protocol {PROTOCOL_HASH.hex()}"],
    ]
    columns = (Column("what", "what"), Column("is", "is"))
    return quantity.Table("Provenance", columns, [{"what": what, "is": text} for what, text in rows])


def _logger(evaluation: Evaluation) -> str:
    header = evaluation.log.header
    firmware = ".".join(map(str, header.firmware_version))
    # An emulated logger has no flashed image whose CRC could tell its firmware.
    kind = "emulated" if evaluation.log.is_emulated else f"image {header.image_crc:08x}"
    serial = header.board_serial.hex() if any(header.board_serial) else "unknown"
    return f"serial {serial}, firmware {firmware} ({kind}), protocol {header.protocol_hash.hex()}"


def _measurement_time_text(evaluation: Evaluation) -> str:
    """Format the time when the calibration's quantities were measured.

    The file's own date is that of its last change.
    """
    measurement_times = sorted(
        measurement.measured_at
        for measurement in quantities(evaluation.calibration)
        if measurement.measured_at is not None
    )
    if not measurement_times:
        return "no measured quantity"
    first, last = utc(measurement_times[0]), utc(measurement_times[-1])
    return f"measured {first}" if first == last else f"measured from {first} to {last}"


def _maneuver(evaluation: Evaluation) -> str:
    if evaluation.schedule is None:
        return "not known"
    strokes = ", ".join(
        f"joint {stroke.joint} {stroke.angle_deg:+g} deg at {stroke.t_s:g} s"
        for stroke in evaluation.schedule.strokes
    )
    return strokes or UNKNOWN


_TABLE: Columns = (
    *fields("title caption"),
    Column(
        "columns",
        of=lambda table: [
            f"{column.label} ({column.unit})" if column.unit else column.label for column in table.shown
        ],
    ),
    Column("rows", of=lambda table: [[_text(column, row) for column in table.shown] for row in table.rows]),
)
_FOLD: Columns = (Column("first", of=lambda table: len(table.rows) - table.folded), *fields("words=fold"))
_FOLDED_TABLE: Columns = (*_TABLE, Column("fold", of=lambda table: table, columns=_FOLD))


def table_columns(table: quantity.Table) -> Columns:
    """Return the columns of a table for the page: rows of text under column heads, some of them folded away."""
    return _FOLDED_TABLE if table.folded else _TABLE


_KEY_NUMBER: Columns = (
    *fields("label unit note"),
    Column("value", of=lambda key_quantity: _finite(key_quantity.value)),
    Column(
        "std",
        of=lambda key_quantity: _finite(key_quantity.std) if math.isfinite(key_quantity.value) else None,
    ),
)


def key_number_columns(key_quantity: Quantity) -> Columns:
    """Return the columns of a quantity for the page; those of one `row` stand side by side under its name."""
    return (*_KEY_NUMBER, *fields("row=group")) if key_quantity.group else _KEY_NUMBER


_VERDICT: Columns = (
    *fields("level=verdict.level sentence=verdict.sentence"),
    Column("reasons", of=lambda drop: list(reasons_of(drop.evaluation, drop.verdict))),
)
_DROP: Columns = (
    *fields("name"),
    Column("verdict", of=lambda drop: drop, columns=_VERDICT),
    Column("prediction", of=lambda drop: prediction_table(drop.evaluation), columns=table_columns),
    Column("change", of=lambda drop: _change_text(drop.evaluation)),
    Column("strokes", of=lambda drop: stroke_summary(drop.evaluation), columns=table_columns),
    Column("key_numbers", of=lambda drop: list(key_numbers_of(drop.evaluation)), columns=key_number_columns),
    Column("notes", of=_notes),
    Column("t_s", of=lambda drop: drop.evaluation.motion.t_s.round(6)),
    Column("window_s", of=lambda drop: [0.0, drop.evaluation.motion.samples.until_s]),
    Column("events", of=lambda drop: events_of(drop.evaluation), columns=EVENT),
    Column("plots", of=lambda drop: list(charts_of(drop.evaluation).values()), columns=PLOT),
    Column("replay", of=lambda drop: replay_of(drop.evaluation), columns=replay_columns),
    Column("no_replay", of=lambda drop: _why_no_replay(drop.evaluation)),
    Column("tables", of=_tables, columns=table_columns),
)
"""`prediction`, `change` and `strokes` stand on the first screen; `t_s` belongs to the plots without x."""
_PAGE: Columns = (
    Column("format", of=lambda _: FORMAT),
    *fields("title lacking"),
    Column("made_by", of=lambda _: f"tfsat-host {__version__}"),
    Column("made_at", of=lambda page: f"{page.made_at.astimezone(UTC):%Y-%m-%d %H:%M} UTC"),
    Column("tables", columns=table_columns),
    Column("drops", of=lambda page: list(map(_with_named_recording, page.drops)), columns=_DROP),
)
