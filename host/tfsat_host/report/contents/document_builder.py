"""Evaluations as the one document that the page shows.

drop = Reported("drop 1", found, verdict_of(found), sha256_of(found.log.path), certificate)
page = render(document_of([drop], datetime.now(UTC)))
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from tfsat_host import __version__, quantity
from tfsat_host.calibration.certificate.certificate import quantities
from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.result.key_numbers import key_numbers_of
from tfsat_host.evaluation.result.tables import calibration_table, reasons_of, release_time, tables_of, utc
from tfsat_host.evaluation.verdict import Verdict
from tfsat_host.file_hash import sha256_of
from tfsat_host.protocol.limits import PROTOCOL_HASH
from tfsat_host.quantity import UNKNOWN, Column, Quantity
from tfsat_host.report.contents.chart import plot_of
from tfsat_host.report.contents.charts import charts_of
from tfsat_host.report.contents.events import events_of
from tfsat_host.report.contents.replay import replay_of
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
    found = drop.evaluation
    verdict = drop.verdict
    samples = found.motion.samples
    return Drop(
        name=drop.name,
        verdict=PageVerdict(
            level=verdict.level, sentence=verdict.sentence, reasons=list(reasons_of(found, verdict))
        ),
        key_numbers=[key_number(one) for one in key_numbers_of(found)],
        notes=_notes(drop),
        t_s=found.motion.t_s.tolist(),
        window_s=[0.0, samples.until_s],
        events=events_of(found),
        plots=[plot_of(chart) for chart in charts_of(found).values()],
        replay=replay_of(found),
        tables=[table(one) for one in (*tables_of(found), calibration_table(found), provenance_table(drop))],
    )


def _notes(drop: ReportedDrop) -> list[str]:
    """Collect a drop's notes on unusable data and assumptions that its verdict does not give already."""
    found, velocity = drop.evaluation, drop.evaluation.release_velocity
    notes = [*found.notes, *found.micro_gravity.notes, *(velocity.notes if velocity else ()), *drop.remarks]
    return [note for note in dict.fromkeys(notes) if note not in drop.verdict.reasons]


def table(shown: quantity.Table) -> PageTable:
    """Convert a table to the form that the page shows."""
    columns = shown.shown
    made = PageTable(
        title=shown.title,
        columns=[f"{one.label} ({one.unit})" if one.unit else one.label for one in columns],
        rows=[[_text(one, row) for one in columns] for row in shown.rows],
        caption=shown.caption,
    )
    if shown.folded:
        made["fold"] = Fold(first=len(shown.rows) - shown.folded, words=shown.fold)
    return made


def key_number(one: Quantity) -> KeyNumber:
    """Convert a quantity to a key number of the page, with None for values that are not finite."""
    made = KeyNumber(
        label=one.label,
        value=_finite(one.value),
        std=_finite(one.std) if math.isfinite(one.value) else None,
        unit=one.unit,
        note=one.note,
    )
    if one.group:
        made["row"] = one.group
    return made


def _finite(value: float | None) -> float | None:
    return float(value) if value is not None and math.isfinite(value) else None


def _text(column: Column, row: Any) -> str:
    """Numbers with a real minus: a hyphen is shorter than a plus."""
    cell = column.cell(row)
    if isinstance(cell, Quantity):
        return _HYPHEN.sub("−", cell.text())
    is_name = column.words is None and isinstance(column.value(row), str)
    return cell if is_name else _HYPHEN.sub("−", cell)


def provenance_table(drop: ReportedDrop) -> quantity.Table:
    """Files, versions, sensors, time of day."""
    found = drop.evaluation
    log, header = found.log, found.log.header
    rate = f"{log.rate_hz:.2f} Hz" if np.isfinite(log.rate_hz) else "unknown"
    rows = [
        ["recording", str(log.path)],
        ["session", f"{log.session:08x}"],
        ["SHA-256 of the recording", drop.recording_sha256],
        ["released", utc(release_time(log))],
        ["samples", f"{len(log)}, {log.samples_lost} lost; {rate} ({header.rate_hz:g} Hz commanded)"],
        ["logger", _logger(found)],
        [
            "gyros",
            f"± {header.gyro_range_deg_s} deg/s, low-pass setting {header.dlpf_cfg}, WHO_AM_I {header.who_am_i.hex()}",
        ],
        ["robot", f"{found.model.name} ({found.model.path})"],
        [
            "calibration",
            "none" if drop.certificate is None else f"{drop.certificate}, {_measurement_time_text(found)}",
        ],
        ["maneuver", _maneuver(found)],
        *([source.what, f"{source.path}, SHA-256 {source.sha256}"] for source in drop.sources),
        ["options", " ".join(drop.options) or "none"],
        ["tfsat-host", f"{__version__}, protocol {PROTOCOL_HASH.hex()}"],
    ]
    columns = (Column("what", "what"), Column("is", "is"))
    return quantity.Table("Provenance", columns, [{"what": what, "is": text} for what, text in rows])


def _logger(found: Evaluation) -> str:
    header = found.log.header
    firmware = ".".join(map(str, header.firmware_version))
    kind = "emulated" if found.log.is_emulated else f"image {header.image_crc:08x}"
    serial = header.board_serial.hex() if any(header.board_serial) else "unknown"
    return f"serial {serial}, firmware {firmware} ({kind}), protocol {header.protocol_hash.hex()}"


def _measurement_time_text(found: Evaluation) -> str:
    """Format the time when the calibration's quantities were measured.

    The file's own date is that of its last change.
    """
    taken = sorted(one.taken for one in quantities(found.calibration) if one.taken is not None)
    if not taken:
        return "nothing in it was ever measured"
    first, last = utc(taken[0]), utc(taken[-1])
    return f"measured {first}" if first == last else f"measured from {first} to {last}"


def _maneuver(found: Evaluation) -> str:
    if found.schedule is None:
        return "not known"
    strokes = ", ".join(
        f"joint {one.joint} {one.angle_deg:+g} deg at {one.t_s:g} s" for one in found.schedule.strokes
    )
    return strokes or UNKNOWN
