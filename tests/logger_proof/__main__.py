"""`make logger-report`: the whole campaign, both machines, and what came of it in docs/logger-proof.md."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

from tests.emulator_avr.building import REPOSITORY, BuildError
from tests.logger_proof import shared_processor
from tests.logger_proof.broken import Broken
from tests.logger_proof.building import INSTRUCTIONS, build_for_m7, build_for_pc
from tests.logger_proof.campaign import FIRST_SEED, RATES_HZ, SEEDS, run_all
from tests.logger_proof.glitches import run_glitches
from tests.logger_proof.instructions import count_instructions
from tests.logger_proof.m7 import BATCH, FULL_SEEDS, twins
from tests.logger_proof.offsets import measure_offsets
from tests.logger_proof.report import Tools, render

REPORT = REPOSITORY / "docs" / "logger-proof.md"
TOLD_EVERY = 240


def main() -> int:
    """Exit code 0 when everything held; 1, and no new report, when not."""
    parser = argparse.ArgumentParser(prog="make logger-report", description=__doc__)
    parser.add_argument("--out", type=Path, default=REPORT)
    parser.add_argument("--seeds", type=int, default=SEEDS, help="runs of the campaign")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        try:
            text = prove(Path(name), arguments.seeds)
        except (Broken, BuildError) as error:
            print(f"Error: {error}\n  The logger is not proven; {REPORT.name} is as it was.", file=sys.stderr)
            return 1
    arguments.out.write_text(text)
    print(text)
    print(f"Written to {arguments.out}")
    return 0


def prove(folder: Path, seeds: int) -> str:
    """Builds, runs everything, and returns the report. Raises Broken, BuildError."""
    started_s = time.monotonic()

    def progress(what: str) -> None:
        print(f"  {time.monotonic() - started_s:4.0f} s  {what}", flush=True)

    def judged(count: int) -> None:
        if count % TOLD_EVERY == 0:
            progress(f"{count} of {seeds} runs judged")

    progress("building")
    pc = build_for_pc(folder / "pc")
    m7 = build_for_m7(folder / "m7")
    counting = build_for_m7(folder / "instructions", INSTRUCTIONS)
    outcomes = run_all(pc, FIRST_SEED, seeds, judged)
    progress("the same on the Cortex-M7")
    same = twins(pc, m7, [(first, BATCH) for first in range(FIRST_SEED, FIRST_SEED + FULL_SEEDS, BATCH)])
    progress("counting instructions")
    counted = [count_instructions(counting, rate_hz) for rate_hz in RATES_HZ]
    progress("sharing the processor")
    spares = shared_processor.measure(shared_processor.build(folder))
    progress("disturbing single transfers")
    glitches = run_glitches(folder / "glitches", RATES_HZ)
    progress("timing the readings")
    offsets = measure_offsets(folder / "offsets")
    return render(outcomes, same, counted, spares, glitches, offsets, Tools.found())


if __name__ == "__main__":
    sys.exit(main())
