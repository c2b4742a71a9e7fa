"""Evaluations as the one document that the page shows.

drop = Reported("drop 1", found, verdict_of(found), sha256_of(found.log.path), certificate)
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
from tfsat_host.evaluation.evaluation import Evaluation
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
from tfsat_host.quantity import UNKNOWN, Column, Quantity
from tfsat_host.report.contents.chart import plot_of
from tfsat_host.report.contents.charts import charts_of
from tfsat_host.report.contents.event_marks import events_of
from tfsat_host.report.contents.replay import replay_of
from tfsat_host.report.contents.withheld_curves import failed_check
from tfsat_host.report.document import FORMAT, Document, Drop, Fold, KeyNumber, PageTable, PageVerdict

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


def document_of(
    drops: Sequence[ReportedDrop],
    made_at: datetime,
    *,
    tables: Sequence[PageTable] = (),
    lacking: Sequence[str] = (),
) -> Document:
    """Build one document of all drops.

    Args:
        drops: One or more; their names differ.
        made_at: Creation time with its time zone; shown in the document.
        tables: Tables about all drops together.
        lacking: Drops that were asked for and are missing, and why; a sentence or more each.
    """
    robots = dict.fromkeys(drop.evaluation.model.name for drop in drops)
    kind = "EMULATED " if any(drop.evaluation.log.is_emulated for drop in drops) else ""
    return Document(
        format=FORMAT,
        title=f"{kind}{', '.join(robots)}: {', '.join(drop.name for drop in drops)}",
        made_by=f"tfsat-host {__version__}",
        made_at=f"{made_at.astimezone(UTC):%Y-%m-%d %H:%M} UTC",
        lacking=list(lacking),
        tables=list(tables),
        drops=[_drop(drop) for drop in drops],
    )


def _drop(drop: ReportedDrop) -> Drop:
    # Whoever reads the page elsewhere has no command line that knows the recording.
    recording = str(drop.evaluation.log.path)
    evaluation = replace(
        drop.evaluation,
        checks=tuple(
            replace(check, next_step=check.next_step and name_recording(check.next_step, recording))
            for check in drop.evaluation.checks
        ),
    )
    verdict = drop.verdict
    samples = evaluation.motion.samples
    return Drop(
        name=drop.name,
        verdict=PageVerdict(
            level=verdict.level, sentence=verdict.sentence, reasons=list(reasons_of(evaluation, verdict))
        ),
        prediction=table(prediction_table(evaluation)),
        change=_HYPHEN.sub("−", change_sentence(evaluation)).replace(" ± ", "\u00a0±\u00a0"),
        strokes=table(stroke_summary(evaluation)),
        key_numbers=[key_number(key_quantity) for key_quantity in key_numbers_of(evaluation)],
        notes=_notes(drop),
        t_s=evaluation.motion.t_s.round(6).tolist(),
        window_s=[0.0, samples.until_s],
        events=events_of(evaluation),
        plots=[plot_of(chart) for chart in charts_of(evaluation).values()],
        replay=replay_of(evaluation) if evaluation.is_given() else None,
        no_replay=""
        if evaluation.is_given()
        else f"Replay withheld: “{failed_check(evaluation)}” (check failed)",
        tables=[
            table(source_table)
            for source_table in (
                *tables_of(evaluation),
                calibration_table(evaluation),
                provenance_table(drop),
            )
        ],
    )


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


def table(source_table: quantity.Table) -> PageTable:
    """Convert a table to the form that the page shows."""
    columns = source_table.shown
    page_table = PageTable(
        title=source_table.title,
        columns=[f"{column.label} ({column.unit})" if column.unit else column.label for column in columns],
        rows=[[_text(column, row) for column in columns] for row in source_table.rows],
        caption=source_table.caption,
    )
    if source_table.folded:
        page_table["fold"] = Fold(first=len(source_table.rows) - source_table.folded, words=source_table.fold)
    return page_table


def key_number(key_quantity: Quantity) -> KeyNumber:
    """Convert a quantity to a key number of the page, with None for values that are not finite."""
    entry = KeyNumber(
        label=key_quantity.label,
        value=_finite(key_quantity.value),
        std=_finite(key_quantity.std) if math.isfinite(key_quantity.value) else None,
        unit=key_quantity.unit,
        note=key_quantity.note,
    )
    if key_quantity.group:
        entry["row"] = key_quantity.group
    return entry


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
