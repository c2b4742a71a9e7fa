"""All tables of a drop, in the order in which one reads them."""

from __future__ import annotations

from tfsat_host.report.contents.reported import Reported
from tfsat_host.report.contents.tables.calibration import calibration_table
from tfsat_host.report.contents.tables.checks import check_table
from tfsat_host.report.contents.tables.evidence import clock_table, provenance_table
from tfsat_host.report.contents.tables.model import error_table, offset_table
from tfsat_host.report.contents.tables.motion import joint_table, standing_table, stroke_table
from tfsat_host.report.document import Table


def tables_of(drop: Reported) -> list[Table]:
    """Those that there is something for."""
    found = drop.evaluation
    tables = (
        stroke_table(found),
        joint_table(found),
        standing_table(found),
        error_table(found),
        offset_table(found),
        check_table(found),
        clock_table(found),
        calibration_table(found),
        provenance_table(drop),
    )
    return [table for table in tables if table is not None]
