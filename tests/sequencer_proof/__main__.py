"""`make sequencer-report`: every campaign in full, and what came of it in docs/sequencer-proof.md."""

from __future__ import annotations

import sys
from pathlib import Path

from tests.emulator_avr.building import SEQUENCER, build_board_library, build_changed_sequencer, build_sketch
from tests.proof.campaign import Progress, run_jobs, write_page
from tests.sequencer.board import build_board_library as build_native_library
from tests.sequencer_proof.campaigns import Proof, all_jobs, judge_all
from tests.sequencer_proof.one_rule import build_rule
from tests.sequencer_proof.report import Tools, render
from tests.sequencer_proof.resets import HANG
from tests.sequencer_proof.rigs import Bench


def prove(folder: Path, progress: Progress) -> str:
    """Builds, runs every campaign, and returns the page. Raises Broken, BuildError."""
    progress("building")
    for part in ("avr", "native"):
        (folder / part).mkdir()
    bench = Bench.of(build_sketch(SEQUENCER, folder / "sequencer"), build_board_library(folder / "avr"))
    hanging = build_changed_sequencer([HANG], folder / "hanging", bench.image)
    rule = build_rule(folder / "rule.so")
    native = build_native_library(folder / "native")
    proof = Proof(**run_jobs(all_jobs(bench, hanging, native, rule), progress))
    judge_all(proof, bench.image)
    return render(proof, bench.image, Tools.found())


if __name__ == "__main__":
    sys.exit(write_page("sequencer", prove))
