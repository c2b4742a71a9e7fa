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

    def seed_jobs(self) -> list[Callable[[], Any]]:
        """Return the campaign's jobs with their seeds bound, ready to run."""
        if self.seed is None:
            return list(self.jobs)
        return [partial(job, seed=self.seed + i * self.step) for i, job in enumerate(self.jobs)]


def run_campaigns(campaigns: Sequence[Campaign], progress: Progress = lambda _: None) -> dict[str, list[Any]]:
    """Run the jobs of all campaigns on all cores and return the judged results by campaign.

    Raises Broken if a promise was not kept.
    """
    results: dict[str, list[Any]] = {campaign.name: [None] * len(campaign.jobs) for campaign in campaigns}
    # Processes, not threads: each job holds an emulator library with its own state.
    with ProcessPoolExecutor(max_workers=os.cpu_count()) as pool:
        places = {
            # The place of a result is its job's, not its completion's: tables are the same on any number of cores.
            pool.submit(job): (campaign.name, i)
            for campaign in campaigns
            for i, job in enumerate(campaign.seed_jobs())
        }
        try:
            for finished_count, future in enumerate(as_completed(places), start=1):
                name, i = places[future]
                results[name][i] = future.result()
                progress(f"{finished_count} of {len(places)} jobs ({name})")
        # KeyboardInterrupt too: jobs that wait must not keep the pool alive for minutes.
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    for campaign in campaigns:
        # A job may return one result or a list: flatten both into one list of results.
        parts = [part if isinstance(part, list) else [part] for part in results[campaign.name]]
        results[campaign.name] = [result for part in parts for result in part]
        campaign.judge(results[campaign.name])
    return results


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
            tables, facts = prove(Path(folder), progress)
        # A broken promise is an AssertionError of the judge; a page with half a proof is never written.
        except (AssertionError, BuildError) as error:
            print(f"Error: {error}\n  Nothing is proven; docs/{name} is unchanged.", file=sys.stderr)
            return 1
    run.write(tables, facts, arguments.out)
    print(f"Written: docs/{name}")
    return 0


def campaigns_csv(campaigns: Sequence[Campaign]) -> str:
    """Format the campaigns as CSV: name, number of jobs, first seed, step and what was judged."""
    return csv_text(
        ("campaign", "jobs", "first seed", "step", "judged"),
        [(campaign.name, len(campaign.jobs), *_seeds(campaign), campaign.judged) for campaign in campaigns],
    )


def _seeds(campaign: Campaign) -> tuple[object, object]:
    return ("", "") if campaign.seed is None else (campaign.seed, campaign.step)


def output(*command: str) -> str:
    """Run a tool and return what it prints, such as its version."""
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
