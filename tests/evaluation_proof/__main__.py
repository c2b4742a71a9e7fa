"""`make evaluation-report`: evaluates a hundred emulated drops and writes docs/evaluation-proof.md and its tables."""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from rich.console import Console
from rich.progress import track

from tests.evaluation_proof.campaign import Proof, prove
from tests.evaluation_proof.page import files
from tests.evaluation_proof.summary import judged
from tests.proof.pages import seal
from tfsat_host.emulated.build import ensure_built

DOCS = Path(__file__).parents[2] / "docs"
ROBOTS = 50
PROCESSES = 2


def one(seed: int) -> tuple[int, Proof]:
    """Proves one robot."""
    return seed, prove(seed)


def main() -> int:
    """Writes the page; 1 if a target is missed."""
    parser = argparse.ArgumentParser(prog="make evaluation-report", description=__doc__)
    parser.add_argument("--robots", type=int, default=ROBOTS, help="how many, from number 1")
    parser.add_argument("--out", type=Path, default=DOCS, help="folder of the page and its tables")
    arguments = parser.parse_args()
    ensure_built(progress=print)
    proved = seal("evaluation-proof")
    seeds = range(1, arguments.robots + 1)
    with ProcessPoolExecutor(PROCESSES) as pool:
        shown = Console(stderr=True)
        proofs = dict(track(pool.map(one, seeds), "robots", total=len(seeds), console=shown))
    for name, text in files(proofs).items():
        place = arguments.out / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text + (proved if name.endswith(".md") else ""), encoding="utf-8")
    targets = judged(proofs)
    for target in targets:
        print(f"{target.what}: {target.found} of {target.wanted}: {'good' if target.met else 'MISSED'}")
    print(f"{arguments.out}/evaluation-proof.md and its tables are written.")
    return 0 if all(target.met for target in targets) else 1


if __name__ == "__main__":
    sys.exit(main())
