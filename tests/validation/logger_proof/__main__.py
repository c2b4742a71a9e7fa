"""`make logger-report`: all campaigns on both machines, then the tables of docs/logger-proof.md."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path

from tests.validation.campaign import Campaign, Progress, Results, run_campaigns, write_proof
from tests.validation.logger_proof.building import INSTRUCTIONS, build_for_m7, build_for_pc
from tests.validation.logger_proof.campaign import RATES_HZ, SEEDS, runs
from tests.validation.logger_proof.m7 import BATCH, FULL_SEEDS, compare, count_instructions
from tests.validation.logger_proof.measurements import (
    SPARES,
    compile_shared_processor,
    measure_offsets,
    measure_spare,
    run_glitches,
    run_slow_buses,
)
from tests.validation.logger_proof.results import describe_machines, make_tables


def campaigns(folder: Path) -> list[Campaign]:
    """Builds what they run, in this folder."""
    pc, m7 = build_for_pc(folder / "pc"), build_for_m7(folder / "m7")
    counting = build_for_m7(folder / "instructions", INSTRUCTIONS)
    processor = compile_shared_processor(folder)
    return [
        runs(pc, SEEDS),
        # Equal jobs: run_campaigns binds another seed to each.
        Campaign("twins", "the same bytes from the PC and the Cortex-M7",
                 [partial(compare, pc, m7, count=BATCH)] * (FULL_SEEDS // BATCH), 0, BATCH),
        Campaign("instructions", "at most a tenth of the processor",
                 [partial(count_instructions, counting, rate_hz) for rate_hz in RATES_HZ]),
        Campaign("failed-transfers", "the sample that was hit, and after a timeout at 1 kHz the next",
                 [partial(run_glitches, folder / "glitches", RATES_HZ)]),
        Campaign("slow-buses", "no sample is lost, none late, on a bus that docs/wiring.md permits",
                 [partial(run_slow_buses, folder / "slow_bus", RATES_HZ)]),
        Campaign("read-times", "each IMU is read when the log says, within 0.1 ms",
                 [partial(measure_offsets, folder / "offsets")]),
        Campaign("shared-processor", "no sample is dropped",
                 [partial(measure_spare, processor, *case) for case in SPARES]),
    ]  # fmt: skip


def prove(folder: Path, progress: Progress) -> Results:
    """Build and run everything; return the tables and what they were run with. Raises Broken, BuildError."""
    progress("building")
    declared = campaigns(folder)
    results = run_campaigns(declared, progress)
    return make_tables(results, declared), describe_machines(results)


if __name__ == "__main__":
    sys.exit(write_proof("logger-proof", "make logger-report", prove))
