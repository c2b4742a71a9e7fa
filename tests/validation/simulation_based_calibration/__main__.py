"""`make sbc-report`: over a thousand drops with everything drawn, for docs/simulation-based-calibration.md."""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from rich.console import Console
from rich.progress import track

from tests.paths import DOCS
from tests.validation.evaluation_proof.figures import percent
from tests.validation.provenance import CampaignRun
from tests.validation.simulation_based_calibration.drops import MANEUVERS, judge_drop
from tests.validation.simulation_based_calibration.results import describe_campaign, make_tables, rows
from tfsat_host.emulated.build import ensure_built

DROPS = 600
"""Of each kind of maneuver."""
PROCESSES = 2


def main() -> int:
    """Write the tables; 1 if a quantity is not as it should be."""
    parser = argparse.ArgumentParser(prog="make sbc-report", description=__doc__)
    parser.add_argument("--drops", type=int, default=DROPS, help="of each kind of maneuver, from seed 1")
    parser.add_argument("--out", type=Path, default=DOCS, help="folder of the pages")
    arguments = parser.parse_args()
    ensure_built(progress=print)
    run = CampaignRun("simulation-based-calibration")
    with ProcessPoolExecutor(PROCESSES) as pool:
        drops, seeds = {}, range(1, arguments.drops + 1)
        for kind in MANEUVERS:
            outcomes = pool.map(partial(judge_drop, kind), seeds, chunksize=5)
            drops[kind] = list(track(outcomes, kind, total=len(seeds), console=Console(stderr=True)))
    run.write(make_tables(drops), describe_campaign(drops), arguments.out)
    judgement = {kind: rows(judged) for kind, judged in drops.items()}
    for kind, kind_rows in judgement.items():
        for row in kind_rows:
            met = "met" if row.met else "MISSED"
            held = f"{percent(row.half)}, {percent(row.most)}"
            print(f"{kind}, {row.name}: p {row.p:.2g}, z {row.z:.3f}, {held}: {met}")
    return 0 if all(row.met for kind_rows in judgement.values() for row in kind_rows) else 1


if __name__ == "__main__":
    sys.exit(main())
