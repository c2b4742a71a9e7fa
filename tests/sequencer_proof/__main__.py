"""`make sequencer-report`: every campaign in full, and what came of it in docs/sequencer-proof.md."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

from tests.emulator_avr.building import (
    REPOSITORY,
    SEQUENCER,
    BuildError,
    build_board_library,
    build_changed_sequencer,
    build_sketch,
)
from tests.sequencer.board import build_board_library as build_native_library
from tests.sequencer_proof.campaigns import all_jobs, judge_all, run_jobs
from tests.sequencer_proof.one_rule import build_rule
from tests.sequencer_proof.report import Tools, render
from tests.sequencer_proof.resets import HANG
from tests.sequencer_proof.rigs import Bench
from tests.sequencer_proof.signals import Broken

REPORT = REPOSITORY / "docs" / "sequencer-proof.md"


def main() -> int:
    """Exit code 0 when everything held; 1, and no new report, when not."""
    parser = argparse.ArgumentParser(prog="make sequencer-report", description=__doc__)
    parser.add_argument("--out", type=Path, default=REPORT)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        try:
            text = prove(Path(name))
        except (Broken, BuildError) as error:
            print(
                f"Error: {error}\n  The sequencer is not proven; {REPORT.name} is as it was.", file=sys.stderr
            )
            return 1
    arguments.out.write_text(text)
    print(text)
    print(f"Written to {arguments.out}")
    return 0


def prove(folder: Path) -> str:
    """Builds, runs every campaign, and returns the report. Raises Broken, BuildError."""
    started_s = time.monotonic()

    def progress(what: str) -> None:
        print(f"  {time.monotonic() - started_s:4.0f} s  {what}", flush=True)

    progress("building")
    for part in ("avr", "native"):
        (folder / part).mkdir()
    bench = Bench.of(build_sketch(SEQUENCER, folder / "sequencer"), build_board_library(folder / "avr"))
    hanging = build_changed_sequencer([HANG], folder / "hanging", bench.image)
    rule = build_rule(folder / "rule.so")
    native = build_native_library(folder / "native")
    proof = run_jobs(all_jobs(bench, hanging, native, rule), progress)
    judge_all(proof, bench.image)
    return render(proof, bench.image, Tools.found())


if __name__ == "__main__":
    sys.exit(main())
