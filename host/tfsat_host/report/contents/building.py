"""Evaluations as the one document that the page shows.

drop = Reported("drop 1", found, verdict_of(found), sha256_of(found.log.path), certificate)
page = render(document_of([drop], datetime.now(UTC)))
"""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime

from tfsat_host import __version__
from tfsat_host.evaluation.result.key_numbers import key_numbers_of
from tfsat_host.evaluation.result.tables import calibration_table, reasons_of, tables_of
from tfsat_host.report.contents import tables as written
from tfsat_host.report.contents.chart import plot_of
from tfsat_host.report.contents.charts.of_drop import charts_of
from tfsat_host.report.contents.events import events_of
from tfsat_host.report.contents.provenance import provenance_table
from tfsat_host.report.contents.replay import replay_of
from tfsat_host.report.contents.reported import Reported
from tfsat_host.report.document import FORMAT, Document, Drop, Table, Verdict


def document_of(
    drops: Sequence[Reported],
    made_at: datetime,
    *,
    tables: Sequence[Table] = (),
    lacking: Sequence[str] = (),
) -> Document:
    """All drops in one document.

    Args:
        drops: One or more; their names differ.
        made_at: With its time zone; it stands in the document.
        tables: Of all drops together.
        lacking: Which drops were asked for and are not here, and why; a sentence or more each.
    """
    robots = dict.fromkeys(drop.evaluation.model.name for drop in drops)
    return Document(
        format=FORMAT,
        title=f"{', '.join(robots)}: {', '.join(drop.name for drop in drops)}",
        made_by=f"tfsat-host {__version__}",
        made_at=f"{made_at.astimezone(UTC):%Y-%m-%d %H:%M} UTC",
        lacking=list(lacking),
        tables=list(tables),
        drops=[_drop(drop) for drop in drops],
    )


def _drop(drop: Reported) -> Drop:
    found = drop.evaluation
    verdict = drop.verdict
    samples = found.motion.samples
    return Drop(
        name=drop.name,
        verdict=Verdict(
            level=verdict.level, sentence=verdict.sentence, reasons=list(reasons_of(found, verdict))
        ),
        key_numbers=[written.key_number(one) for one in key_numbers_of(found)],
        notes=_notes(drop),
        t_s=found.motion.t_s.tolist(),
        window_s=[0.0, samples.until_s],
        events=events_of(found),
        plots=[plot_of(chart) for chart in charts_of(found).values()],
        replay=replay_of(found),
        tables=[
            written.table(one)
            for one in (*tables_of(found), calibration_table(found), provenance_table(drop))
        ],
    )


def _notes(drop: Reported) -> list[str]:
    """What could not be used, and what was assumed: what the verdict does not say already."""
    found, velocity = drop.evaluation, drop.evaluation.release_velocity
    notes = [*found.notes, *found.micro_gravity.notes, *(velocity.notes if velocity else ()), *drop.remarks]
    return [note for note in dict.fromkeys(notes) if note not in drop.verdict.reasons]
