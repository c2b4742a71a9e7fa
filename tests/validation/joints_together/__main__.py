"""`make together-report`: searches for what joints that move together reach, and writes docs/joints-together/."""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import Future, ProcessPoolExecutor
from typing import Any, Final

import casadi
import numpy as np
from rich.console import Console
from rich.progress import track

from tests.paths import DOCS
from tests.validation.joints_together.searches import (
    LONGER,
    SETTINGS,
    FreeRatesRow,
    LongSearchRow,
    free_rates_row,
    long_search_row,
    path_angles_rad,
    propose,
    time_limit_row,
)
from tests.validation.joints_together.shape_space import draw_shape_space, maneuver_path_deg
from tests.validation.provenance import CampaignRun
from tests.validation.tables import csv_text
from tests.validation.targets import Target, report_targets, targets_csv
from tfsat_host.arrays import FloatArray
from tfsat_host.maneuver import Maneuver
from tfsat_host.plan.problem import DEFAULT_TIME_LIMIT_S
from tfsat_host.robot import load_robot

TIME_LIMITS_S: Final = (1.0, 1.25, 1.5, 1.55, 1.75, 2.0, 2.5)
TIME_LIMIT_COLUMNS: Final = (
    "time limit / s",
    "one at a time",
    "together",
    "one at a time, without tower",
    "together, without tower",
)
LONG_SEARCH_COLUMNS: Final = ("search", "design / deg", "longer / deg", "gain / deg")
FREE_RATES_COLUMNS: Final = (
    "servos",
    "strokes / deg",
    "free rates / deg",
    "gain / deg",
    "converged",
    "disagreement / deg",
)
PICTURE: Final = DOCS / "pictures" / "shape-space.png"


def find_targets(long_searches: list[LongSearchRow], free_rates: list[FreeRatesRow]) -> list[Target]:
    """Return what is promised of the search."""
    ideal = free_rates[0]
    return [
        Target("reorientation at 170 deg/s without ramps, 1.5 s", ideal.strokes_deg, low=34.6, unit="deg"),
        *(
            Target(
                f"gain of a search {LONGER} times as long: {row.search}", row.gain_deg, high=0.1, unit="deg"
            )
            for row in long_searches
        ),
        Target("gain of free joint rates without ramps", ideal.gain_deg, high=0.2, unit="deg"),
        *(
            Target(
                f"free path by tfsat's own dynamics: {row.servos}",
                row.disagreement_deg,
                high=1e-3,
                unit="deg",
            )
            for row in free_rates
        ),
    ]


def draw_picture(free_path_deg: FloatArray) -> None:
    """Draw both maneuvers and the best path of free joint rates."""
    proposal, robot = propose(DEFAULT_TIME_LIMIT_S), load_robot()
    sequential, written = proposal.sequential, proposal.written
    corners = np.zeros((len(sequential.sequence) + 1, robot.n_joints))
    for k, joint in enumerate(sequential.sequence):
        corners[k + 1] = corners[k]
        corners[k + 1, abs(joint) - 1] += np.sign(joint) * sequential.alpha_deg[abs(joint) - 1]
    maneuver = Maneuver(written.strokes, speed_deg_s=round(np.degrees(proposal.problem.speed_rad_s), 9))
    paths = {
        f"one joint at a time: {sequential.reorientation_deg:.1f} deg": corners,
        f"joints together: {written.reorientation_deg:.1f} deg": maneuver_path_deg(robot, maneuver),
        "free joint rates, without the tower": free_path_deg,
    }
    axis = written.rotation_vector_deg / written.reorientation_deg
    draw_shape_space(robot, paths, axis, PICTURE)


def main() -> int:
    """Write the tables and the picture; 1 if a target is missed."""
    argparse.ArgumentParser(prog="make together-report", description=__doc__).parse_args()
    run = CampaignRun("joints-together")
    console = Console(stderr=True)
    with ProcessPoolExecutor() as pool:
        free = [pool.submit(free_rates_row, ramps) for ramps in (False, True)]
        longer = [pool.submit(long_search_row, setting) for setting in SETTINGS]
        limits = [pool.submit(time_limit_row, limit) for limit in TIME_LIMITS_S]
        jobs: list[Future[Any]] = [*free, *longer, *limits]
        for job in track(jobs, "searches", console=console):
            job.result()
    free_rates = [job.result()[0] for job in free]
    long_searches = [job.result() for job in longer]
    targets = find_targets(long_searches, free_rates)
    draw_picture(np.degrees(path_angles_rad(free[1].result()[1], DEFAULT_TIME_LIMIT_S)))
    tables = {
        "time-limits.csv": csv_text(TIME_LIMIT_COLUMNS, [job.result() for job in limits]),
        "long-searches.csv": csv_text(LONG_SEARCH_COLUMNS, long_searches),
        "free-rates.csv": csv_text(FREE_RATES_COLUMNS, free_rates),
        "targets.csv": targets_csv(targets),
    }
    run.write(tables, {"CasADi": casadi.__version__, "evolutions, times the design's": LONGER})
    return report_targets(targets)


if __name__ == "__main__":
    sys.exit(main())
