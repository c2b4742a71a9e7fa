"""What the proofs of both boards share: a campaign's declaration, jobs on all cores, tables that are written."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from tests.fixtures.sequencer.building import BuildError
from tests.paths import DOCS
from tests.validation.provenance import CampaignRun
from tests.validation.tables import csv_text

Progress = Callable[[str], None]
Found = Mapping[str, Sequence[Any]]
"""The results of each campaign by its name, in the order of its jobs."""


class Broken(AssertionError):
    """A promise that a board, the decoder or a measurement did not keep."""


@dataclass(frozen=True)
class Campaign:
    """Runs that try to break one promise.

    Attributes:
        name: Of its results, and of their table.
        judged: What each job holds its runs against; it raises Broken.
        jobs: Each gives a result, or a list of them: the same on every core.
        seed: Of the first job, its argument `seed`; None: the jobs have none.
        step: From the seed of one job to that of the next.
        judge: What only all results together show. Raises Broken.
    """

    name: str
    judged: str
    jobs: Sequence[Callable[..., Any]]
    seed: int | None = None
    step: int = 1
    judge: Callable[[Sequence[Any]], None] = lambda _: None

    def seeded(self) -> list[Callable[[], Any]]:
        """Its jobs, ready to run."""
        if self.seed is None:
            return list(self.jobs)
        return [partial(job, seed=self.seed + i * self.step) for i, job in enumerate(self.jobs)]


def run_campaigns(campaigns: Sequence[Campaign], progress: Progress = lambda _: None) -> dict[str, list[Any]]:
    """All results, judged. Raises Broken."""
    found: dict[str, list[Any]] = {one.name: [None] * len(one.jobs) for one in campaigns}
    with ProcessPoolExecutor(max_workers=os.cpu_count()) as pool:
        places = {pool.submit(job): (one.name, i) for one in campaigns for i, job in enumerate(one.seeded())}
        try:
            for done, future in enumerate(as_completed(places), start=1):
                name, i = places[future]
                found[name][i] = future.result()
                progress(f"{done} of {len(places)} jobs ({name})")
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    for one in campaigns:
        parts = [part if isinstance(part, list) else [part] for part in found[one.name]]
        found[one.name] = [result for part in parts for result in part]
        one.judge(found[one.name])
    return found


Results = tuple[Mapping[str, str], Mapping[str, object]]
"""The tables by their files' names, and what else the campaign was run with: versions of tools, numbers of runs."""


def write_proof(name: str, command: str, prove: Callable[[Path, Progress], Results]) -> int:
    """Run a board's campaigns and write their tables into docs/NAME; `prove` may use an empty folder.

    Exit code 0 when everything held; 1, and no new file, when not.
    """
    parser = argparse.ArgumentParser(prog=command)
    parser.add_argument("--out", type=Path, default=DOCS, help="folder of the pages")
    arguments = parser.parse_args()
    run, started_s = CampaignRun(name), time.monotonic()

    def progress(what: str) -> None:
        print(f"  {time.monotonic() - started_s:4.0f} s  {what}", flush=True)

    with tempfile.TemporaryDirectory() as folder:
        try:
            tables, more = prove(Path(folder), progress)
        except (AssertionError, BuildError) as error:
            print(f"Error: {error}\n  Nothing is proven; docs/{name} is as it was.", file=sys.stderr)
            return 1
    run.write(tables, more, arguments.out)
    print(f"Written: docs/{name}")
    return 0


def declared(campaigns: Sequence[Campaign]) -> str:
    """The campaigns as CSV: what was judged, in how many jobs, from which seed on."""
    return csv_text(
        ("campaign", "jobs", "first seed", "step", "judged"),
        [(one.name, len(one.jobs), *_seeds(one), one.judged) for one in campaigns],
    )


def _seeds(one: Campaign) -> tuple[object, object]:
    return ("", "") if one.seed is None else (one.seed, one.step)


def output(*command: str) -> str:
    """What a tool prints, such as its version."""
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
