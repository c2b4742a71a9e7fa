"""`make calibration-report`: calibrates thirty emulated robots and writes docs/calibration-proof.md."""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor

from rich.console import Console
from rich.progress import track

from tests.paths import DOCS
from tests.validation.calibration_proof.page import COVERED, TARGETS, covered, page, rms, robots_csv
from tests.validation.calibration_proof.robots import Errors, calibrated, errors_of, recorded_day
from tests.validation.provenance import seal
from tfsat_host.emulated.build import ensure_built

ROBOTS = 30


def one(seed: int) -> tuple[int, dict[str, Errors]]:
    """Calibrates one robot."""
    day = recorded_day(seed)
    return seed, errors_of(day, calibrated(day))


def main() -> int:
    """Writes the page; 1 if a target is missed."""
    parser = argparse.ArgumentParser(prog="make calibration-report", description=__doc__)
    parser.add_argument("--robots", type=int, default=ROBOTS, help="how many, from number 1")
    robots = parser.parse_args().robots
    ensure_built(progress=print)
    proved = seal("calibration-proof")
    with ProcessPoolExecutor() as pool:
        shown = Console(stderr=True)
        results = dict(track(pool.map(one, range(1, robots + 1)), "robots", total=robots, console=shown))
    (DOCS / "calibration-proof.md").write_text(page(results) + proved, encoding="utf-8")
    (DOCS / "calibration-proof" / "robots.csv").write_text(robots_csv(results), encoding="utf-8")
    missed = 0
    for name, target in TARGETS.items():
        good = rms(results, name) <= target and COVERED[0] <= covered(results, name) <= COVERED[1]
        missed += not good
        share = 100 * covered(results, name)
        print(
            f"{name}: rms {rms(results, name):.4f} of {target:g}, {share:.1f} % covered: {'good' if good else 'MISSED'}"
        )
    print("docs/calibration-proof.md is written.")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
