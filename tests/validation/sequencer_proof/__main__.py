"""`make sequencer-report`: every campaign in full, and what came of it in the tables of docs/sequencer-proof.md."""

from __future__ import annotations

import sys
from pathlib import Path

from tests.fixtures.sequencer.building import (
    SEQUENCER,
    build_avr_library,
    build_changed_sequencer,
    build_native_library,
    build_sketch,
)
from tests.validation.campaign import Progress, Results, run_campaigns, write_proof
from tests.validation.sequencer_proof.bench import Bench
from tests.validation.sequencer_proof.campaigns import campaigns, judge_stack, least_never_used
from tests.validation.sequencer_proof.one_rule import build_rule
from tests.validation.sequencer_proof.resets import HANG
from tests.validation.sequencer_proof.results import describe_image, make_tables


def prove(folder: Path, progress: Progress) -> Results:
    """Build and run every campaign; return the tables and what they were run with. Raises Broken, BuildError."""
    progress("building")
    for part in ("avr", "native"):
        (folder / part).mkdir()
    bench = Bench.of(build_sketch(SEQUENCER, folder / "sequencer"), build_avr_library(folder / "avr"))
    hanging = build_changed_sequencer([HANG], folder / "hanging", bench.image)
    rule = build_rule(folder / "rule.so")
    declared = campaigns(bench, hanging, build_native_library(folder / "native"), rule)
    results = run_campaigns(declared, progress)
    # The deepest stack of all campaigns, judged together.
    judge_stack(least_never_used(results), bench.image)
    return make_tables(results, declared, bench.image), describe_image(bench.image)


if __name__ == "__main__":
    sys.exit(write_proof("sequencer-proof", "make sequencer-report", prove))
