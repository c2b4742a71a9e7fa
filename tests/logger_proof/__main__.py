"""`make logger-report`: the whole campaign, both machines, and what came of it in docs/logger-proof.md."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path

from tests.logger_proof.building import INSTRUCTIONS, build_for_m7, build_for_pc
from tests.logger_proof.campaign import FIRST_SEED, RATES_HZ, SEEDS, batches
from tests.logger_proof.m7 import BATCH, FULL_SEEDS, count_instructions, twin_jobs, twins
from tests.logger_proof.measurements import (
    build_shared_processor,
    measure_offsets,
    measure_spares,
    run_glitches,
)
from tests.logger_proof.report import Proof, Tools, render
from tests.proof.campaign import Progress, run_jobs, write_page


def prove(folder: Path, progress: Progress) -> str:
    """Builds, runs everything, and returns the page. Raises Broken, BuildError."""
    progress("building")
    pc = build_for_pc(folder / "pc")
    m7 = build_for_m7(folder / "m7")
    counting = build_for_m7(folder / "instructions", INSTRUCTIONS)
    shared = build_shared_processor(folder)
    firsts = range(FIRST_SEED, FIRST_SEED + FULL_SEEDS, BATCH)
    found = run_jobs(
        {
            "runs": batches(pc, FIRST_SEED, SEEDS),
            "the same on the Cortex-M7": twin_jobs(pc, m7, firsts),
            "instructions": [partial(count_instructions, counting, rate_hz) for rate_hz in RATES_HZ],
            "failed transfers": [partial(run_glitches, folder / "glitches", RATES_HZ)],
            "times of readings": [partial(measure_offsets, folder / "offsets")],
        },
        progress,
        every=10,
    )
    progress("sharing the processor")
    proof = Proof(
        outcomes=[outcome for part in found["runs"] for outcome in part],
        same=twins(found["the same on the Cortex-M7"]),
        counted=found["instructions"],
        spares=measure_spares(shared),
        glitches=found["failed transfers"][0],
        offsets=found["times of readings"][0],
    )
    return render(proof, Tools.found())


if __name__ == "__main__":
    sys.exit(write_page("logger", prove))
