"""`make calibration-report`: calibrates thirty emulated robots and writes the tables of docs/calibration-proof.md."""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor

from rich.console import Console
from rich.progress import track

from tests.validation.calibration_proof.results import find_targets, make_tables
from tests.validation.calibration_proof.robots import Errors, calibrate_day, errors_of, recorded_day
from tests.validation.provenance import CampaignRun
from tests.validation.targets import report_targets
from tfsat_host.emulated.build import ensure_built

ROBOTS = 30


def calibrate_robot(seed: int) -> tuple[int, dict[str, Errors]]:
    """Calibrate one robot; return its number and its errors by quantity."""
    day = recorded_day(seed)
    return seed, errors_of(day, calibrate_day(day))


def main() -> int:
    """Write the tables; 1 if a target is missed."""
    parser = argparse.ArgumentParser(prog="make calibration-report", description=__doc__)
    parser.add_argument("--robots", type=int, default=ROBOTS, help="how many, from number 1")
    robots = parser.parse_args().robots
    # Build the emulator once, before the workers start: they would build it side by side.
    ensure_built(progress=print)
    run = CampaignRun("calibration-proof")
    with ProcessPoolExecutor() as pool:
        console = Console(stderr=True)
        errors = pool.map(calibrate_robot, range(1, robots + 1))
        results = dict(track(errors, "robots", total=robots, console=console))
    run.write(make_tables(results), {"robots": robots})
    return report_targets(find_targets(results))


if __name__ == "__main__":
    sys.exit(main())
