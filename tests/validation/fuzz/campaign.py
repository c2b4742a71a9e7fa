"""`make fuzz`: a long run of every fuzz target, and a table of what it came to.

What it finds lies in build/fuzz/TARGET/findings. `--keep` renews the committed corpus from what it has learnt.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import time
from pathlib import Path

from tests.paths import REPOSITORY
from tests.validation.fuzz.fuzzing import BOARD, FRAME, Outcome, Target, build, fuzz, minimise

FOLDER = REPOSITORY / "build" / "fuzz"
# Inputs that once broke something. They stay, even when others reach the same code.
REGRESSION = "regression-"


def main() -> int:
    """Exit code 0 without findings, 1 with."""
    parser = argparse.ArgumentParser(prog="make fuzz", description=__doc__)
    parser.add_argument("--runs", type=int, default=10_000_000, help="inputs for the frame receiver")
    parser.add_argument("--board-runs", type=int, default=1_000_000, help="inputs for the whole board")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", action="store_true", help="minimise into tests/validation/fuzz/corpus")
    arguments = parser.parse_args()
    has_findings = False
    for target, runs in ((FRAME, arguments.runs), (BOARD, arguments.board_runs)):
        print(f"{target.name}: building", flush=True)
        program = build(target, FOLDER / target.name)
        started_s = time.monotonic()
        outcome = fuzz(
            program, target, runs, seed=arguments.seed, progress=lambda line: print(f"  {line}", flush=True)
        )
        _print_outcome(target, outcome, time.monotonic() - started_s)
        has_findings = has_findings or bool(outcome.findings)
        if arguments.keep:
            _keep(program, target)
    return int(has_findings)


def _print_outcome(target: Target, outcome: Outcome, taken_s: float) -> None:
    print(
        f"{target.name}: {outcome.executions} executions in {taken_s:.0f} s ({outcome.executions_per_s}/s), "
        f"{outcome.coverage} edges and {outcome.features} features covered by {outcome.corpus_size} inputs, "
        f"{len(outcome.findings)} findings",
        flush=True,
    )
    for finding in outcome.findings:
        _print_finding(target, outcome.defect, _short(finding))


def _print_finding(target: Target, defect: str, finding: Path) -> None:
    folder = _short(FOLDER / target.name)
    lines = [
        f"Error: {defect or 'the target broke'}",
        f"  The input that does it: {finding}; the whole report: {folder / 'log.txt'}",
        f"  See it again:           {folder / 'fuzz'} {finding}",
        f"  Keep it in the corpus:  cp {finding} {_short(target.corpus)}/{REGRESSION}WHAT",
    ]
    print("\n".join(lines), file=sys.stderr)


def _keep(program: Path, target: Target) -> None:
    fresh = program.parent / "kept"
    shutil.rmtree(fresh, ignore_errors=True)
    minimise(program, target, fresh)
    # A regression input stays although a merge finds it redundant.
    for path in target.corpus.iterdir():
        if not path.name.startswith(REGRESSION):
            path.unlink()
    for path in fresh.iterdir():
        shutil.copyfile(path, target.corpus / path.name)
    print(f"{target.name}: {len(list(target.corpus.iterdir()))} inputs in {_short(target.corpus)}")


def _short(path: Path) -> Path:
    return path.relative_to(REPOSITORY)


if __name__ == "__main__":
    sys.exit(main())
