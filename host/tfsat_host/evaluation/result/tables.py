"""All tables of what was found in a drop, in the order in which one reads them."""

from __future__ import annotations

from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.result.checks import check_table
from tfsat_host.evaluation.result.fall import clock_table
from tfsat_host.evaluation.result.model import error_table, offset_table
from tfsat_host.evaluation.result.motion import joint_table, standing_table, stroke_table
from tfsat_host.quantity import Table


def tables_of(found: Evaluation) -> list[Table]:
    """Those that there is something for."""
    made = (
        stroke_table,
        joint_table,
        standing_table,
        error_table,
        offset_table,
        check_table,
        clock_table,
    )
    tables = [table(found) for table in made]
    return [table for table in tables if table.rows]
