"""What the proofs of both boards share: jobs on all cores, progress, and a page of campaigns that all held."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import textwrap
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from tests.emulator_avr.building import REPOSITORY, BuildError

Job = Callable[[], Any]
"""Part of a campaign: what it finds is the same on every core. Raises Broken."""
Progress = Callable[[str], None]


class Broken(AssertionError):
    """A promise that a board, the decoder or a measurement did not keep."""


def run_jobs(
    jobs: Mapping[str, Sequence[Job]], progress: Progress = lambda _: None, every: int = 1
) -> dict[str, list[Any]]:
    """Each campaign's results in the order of its jobs; `progress` hears of every `every`-th job. Raises Broken."""
    results: dict[str, list[Any]] = {name: [None] * len(part) for name, part in jobs.items()}
    with ProcessPoolExecutor(max_workers=os.cpu_count()) as pool:
        places = {pool.submit(job): (name, i) for name, part in jobs.items() for i, job in enumerate(part)}
        try:
            for done, future in enumerate(as_completed(places), start=1):
                name, i = places[future]
                results[name][i] = future.result()
                if done % every == 0:
                    progress(f"{done} of {len(places)} jobs ({name})")
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return results


def write_page(board: str, prove: Callable[[Path, Progress], str]) -> int:
    """`make BOARD-report`: runs `prove` in an empty folder and writes docs/BOARD-proof.md.

    Exit code 0 when everything held; 1, and no new page, when not.
    """
    page = REPOSITORY / "docs" / f"{board}-proof.md"
    parser = argparse.ArgumentParser(prog=f"make {board}-report")
    parser.add_argument("--out", type=Path, default=page)
    arguments = parser.parse_args()
    started_s = time.monotonic()

    def progress(what: str) -> None:
        print(f"  {time.monotonic() - started_s:4.0f} s  {what}", flush=True)

    with tempfile.TemporaryDirectory() as name:
        try:
            text = prove(Path(name), progress)
        except (AssertionError, BuildError) as error:
            print(f"Error: {error}\n  The {board} is not proven; {page.name} is as it was.", file=sys.stderr)
            return 1
    arguments.out.write_text(text)
    print(f"{text}\nWritten to {arguments.out}")
    return 0


def table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A Markdown table."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)


def output(*command: str) -> str:
    """What a tool prints, such as its version."""
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def paragraph(text: str) -> str:
    """Filled to 120 characters a line."""
    return textwrap.fill(text, 120, break_long_words=False, break_on_hyphens=False)
