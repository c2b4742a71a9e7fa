"""What the proofs of both boards share: a campaign's declaration, jobs on all cores, a page with its tables."""

from __future__ import annotations

import argparse
import csv
import io
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from enum import Enum
from functools import partial
from pathlib import Path
from typing import Any

from tests.arduino_sequencer.avr.building import BuildError
from tests.paths import REPOSITORY

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


def write_proof(board: str, prove: Callable[[Path, Progress], Mapping[str, str]]) -> int:
    """`make BOARD-report`: writes the files that `prove` gives, by their paths in docs/; it may use an empty folder.

    Exit code 0 when everything held; 1, and no new file, when not.
    """
    parser = argparse.ArgumentParser(prog=f"make {board}-report")
    parser.add_argument("--out", type=Path, default=REPOSITORY / "docs", help="folder of the page")
    arguments = parser.parse_args()
    started_s = time.monotonic()

    def progress(what: str) -> None:
        print(f"  {time.monotonic() - started_s:4.0f} s  {what}", flush=True)

    with tempfile.TemporaryDirectory() as name:
        try:
            files = prove(Path(name), progress)
        except (AssertionError, BuildError) as error:
            print(f"Error: {error}\n  The {board} is not proven; its page is as it was.", file=sys.stderr)
            return 1
    for path, text in files.items():
        place = arguments.out / path
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text, encoding="utf-8")
    print(f"Written: {', '.join(files)}")
    return 0


def declared(campaigns: Sequence[Campaign]) -> str:
    """The campaigns as CSV: what was judged, in how many jobs, from which seed on."""
    return csv_text(
        ("campaign", "jobs", "first seed", "step", "judged"),
        [(one.name, len(one.jobs), *_seeds(one), one.judged) for one in campaigns],
    )


def _seeds(one: Campaign) -> tuple[object, object]:
    return ("", "") if one.seed is None else (one.seed, one.step)


def results_csv(results: Sequence[Any]) -> str:
    """Results that are named tuples of one type, a row each."""
    return csv_text(results[0]._fields, results)


def csv_text(columns: Sequence[object], rows: Iterable[Sequence[object]]) -> str:
    """A table as CSV."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(map(cell, row) for row in (columns, *rows))
    return text.getvalue()


def table(columns: Sequence[object], rows: Iterable[Sequence[object]]) -> str:
    """A table in Markdown."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join("| " + " | ".join(map(cell, line)) + " |" for line in lines)


def cell(value: object) -> str:
    """A value as the tables show it: numbers to four decimals, enumerations by their words."""
    if isinstance(value, Enum):
        return value.value if isinstance(value.value, str) else value.name.lower()
    if isinstance(value, float):
        return f"{value + 0.0:.4f}".rstrip("0").rstrip(".")
    if type(value) is tuple:
        return " ".join(map(cell, value))
    return str(value)


def output(*command: str) -> str:
    """What a tool prints, such as its version."""
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
