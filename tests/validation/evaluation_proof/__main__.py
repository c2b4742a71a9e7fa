"""`make evaluation-report`: evaluates emulated drops, for evaluation-proof, paper-setting and causes in docs/."""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from rich.console import Console
from rich.progress import track

from tests.paths import DOCS
from tests.validation.evaluation_proof.campaign import Proof, judge_mismatch, prove
from tests.validation.evaluation_proof.causes import CAUSES, one_cause
from tests.validation.evaluation_proof.learning import FIRST_SEED, robot
from tests.validation.evaluation_proof.learning import ROBOTS as TAUGHT
from tests.validation.evaluation_proof.mismatch_tables import summaries
from tests.validation.evaluation_proof.mismatches import DROPS, ROWS, Judged, seeds_of
from tests.validation.evaluation_proof.results import describe_campaign, make_tables
from tests.validation.evaluation_proof.summary import find_targets
from tests.validation.provenance import CampaignRun
from tests.validation.targets import report_targets
from tfsat_host.emulated.build import ensure_built

ROBOTS = 20
PROCESSES = 2


def prove_robot(seed: int) -> tuple[int, Proof]:
    """Proves one robot."""
    return seed, prove(seed)


def of_row(drop: tuple[str, int]) -> Judged:
    """Evaluate one drop whose robot or sensors differ from the filed ones."""
    return judge_mismatch(*drop)


def main() -> int:
    """Write the tables; 1 if a target is missed."""
    parser = argparse.ArgumentParser(prog="make evaluation-report", description=__doc__)
    parser.add_argument("--robots", type=int, default=ROBOTS, help="how many, from number 1")
    parser.add_argument(
        "--drops", type=int, default=DROPS, help="of each row of what is not as filed, and of each cause"
    )
    parser.add_argument(
        "--taught", type=int, default=TAUGHT, help="robots dropped with the maneuver that learns"
    )
    parser.add_argument("--out", type=Path, default=DOCS, help="folder of the pages")
    arguments = parser.parse_args()
    ensure_built(progress=print)
    run = CampaignRun("evaluation-proof")
    seeds = range(1, arguments.robots + 1)
    with ProcessPoolExecutor(PROCESSES) as pool:
        console = Console(stderr=True)
        # Seeds are fixed by the row, so that a shorter campaign flies the first drops of a longer one.
        wrong = [(row.name, seed) for row in ROWS for seed in seeds_of(row, arguments.drops)]
        drops = list(track(pool.map(of_row, wrong), "mismatches", total=len(wrong), console=console))
        proofs = dict(track(pool.map(prove_robot, seeds), "robots", total=len(seeds), console=console))
        causes = dict(
            track(
                pool.map(partial(one_cause, drops=arguments.drops), CAUSES),
                "causes",
                total=len(CAUSES),
                console=console,
            )
        )
        taught = range(FIRST_SEED, FIRST_SEED + arguments.taught)
        lessons = list(track(pool.map(robot, taught), "lessons", total=len(taught), console=console))
    rows = {row.name: drops[k * arguments.drops :][: arguments.drops] for k, row in enumerate(ROWS)}
    results = (proofs, rows, causes, lessons)
    run.write(make_tables(*results), describe_campaign(*results), arguments.out)
    judgement = summaries(rows)
    for row in judgement:
        print(f"{row.row.name}: {'met' if row.met else 'MISSED'}")
    missed = report_targets(find_targets(proofs))
    return missed if all(row.met for row in judgement) else 1


if __name__ == "__main__":
    sys.exit(main())
