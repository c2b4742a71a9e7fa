"""`make fuzz-decode`: atheris damages logs on every core, and a table says what it came to.

atheris has wheels for Linux alone, so it lives in an environment of its own, build/fuzz-decode/venv.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tests.paths import REPOSITORY

FOLDER = REPOSITORY / "build" / "fuzz-decode"
PYTHON = FOLDER / "venv" / "bin" / "python"
# A hang is a finding: an input takes a few milliseconds.
HANG_S = 60
MAX_SCRIPT = 96
RUNS_AT_A_TIME = 50_000
PULSE = re.compile(r"^#\d+\s+\w+\s+cov: (\d+) ft: (\d+) corp: (\d+)/", re.MULTILINE)


def main() -> int:
    """Exit code 0 without findings, 1 with."""
    parser = argparse.ArgumentParser(prog="make fuzz-decode", description=__doc__)
    parser.add_argument("--runs", type=int, default=1_000_000, help="damaged logs to decode")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    arguments = parser.parse_args()
    findings = FOLDER / "findings"
    findings.mkdir(parents=True, exist_ok=True)
    before = set(findings.iterdir())
    started_s = time.monotonic()
    # Ceiling division: no fewer runs than were asked for.
    share = -(-arguments.runs // arguments.jobs)
    with ThreadPoolExecutor(max_workers=arguments.jobs) as pool:
        counts = list(
            # Each job has its own seed and corpus; findings share a folder.
            pool.map(lambda job: _run(job, share, arguments.seed + job, findings), range(arguments.jobs))
        )
    taken_s, executions = time.monotonic() - started_s, sum(counts)
    for job in range(arguments.jobs):
        coverage, features, corpus = (PULSE.findall(_read(job)) or [(0, 0, 0)])[-1]
        print(f"  job {job}: {coverage} edges, {features} features, {corpus} inputs kept")
    new_findings = sorted(set(findings.iterdir()) - before)
    rate = executions / taken_s if taken_s else 0
    summary = f"{executions} damaged logs in {taken_s:.0f} s ({rate:.0f}/s), {len(new_findings)} findings"
    print(f"decoder: {summary}")
    (FOLDER / "summary").write_text(f"{summary}\n", encoding="utf-8")
    for finding in new_findings:
        print(f"Error: the decoder broke on {finding.relative_to(REPOSITORY)}", file=sys.stderr)
        print(
            f"  See it again: {PYTHON.relative_to(REPOSITORY)} -m tests.validation.fuzz.fuzz_log {finding}\n"
            f"  Its report:   {_log(0).parent.relative_to(REPOSITORY)}/job*.log",
            file=sys.stderr,
        )
    # Fewer executions than asked for mean that atheris itself ended early: no success.
    return int(bool(new_findings) or executions < arguments.runs)


def _log(job: int) -> Path:
    return FOLDER / f"job{job}.log"


def _read(job: int) -> str:
    return _log(job).read_text(encoding="utf-8", errors="replace")


def _run(job: int, runs: int, seed: int, findings: Path) -> int:
    """Start atheris again and again, as its memory grows; how many inputs were executed."""
    corpus = FOLDER / f"corpus{job}"
    corpus.mkdir(exist_ok=True)
    paths = os.pathsep.join((str(REPOSITORY / "host"), str(REPOSITORY)))
    executed = 0
    while executed < runs:
        # atheris' memory grows with every run: a new process each 50,000 inputs.
        batch = min(RUNS_AT_A_TIME, runs - executed)
        command = [
            *(str(PYTHON), "-m", "tests.validation.fuzz.fuzz_log", str(corpus)),
            # The seed moves on with each batch, or every batch would draw the same inputs.
            *(f"-runs={batch}", f"-seed={seed + executed}", f"-max_len={MAX_SCRIPT}"),
            *(
                f"-timeout={HANG_S}",
                "-len_control=0",
                "-print_final_stats=1",
                f"-artifact_prefix={findings}/",
            ),
        ]
        # Each batch overwrites its job's log: the last one has the finding.
        with _log(job).open("wb") as log:
            code = subprocess.run(
                command,
                cwd=REPOSITORY,
                env={**os.environ, "PYTHONPATH": paths},
                stdout=log,
                stderr=log,
                check=False,
            ).returncode
        match = re.search(r"^stat::number_of_executed_units:\s+(\d+)$", _read(job), re.MULTILINE)
        executed += int(match[1]) if match else 0
        print(f"  job {job}: {executed} of {runs}", flush=True)
        if code or not match:
            break
    return executed


if __name__ == "__main__":
    sys.exit(main())
