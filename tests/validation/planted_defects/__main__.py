"""`python -m tests.validation.planted_defects [NAME]`: plants defects in copies of the host; a test must see each."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from tests.fixtures.planting import Edit, plant
from tests.paths import REPOSITORY

HOST = "host"
NOT_LINKED = frozenset({HOST, "build", ".git"})


@dataclass(frozen=True)
class Defect:
    """A line of the host package that is wrong.

    Attributes:
        name: Of the package, and what of it.
        edit: The change, of a file of the repository.
        tests: Of which at least one must fail.
    """

    name: str
    edit: Edit
    tests: tuple[str, ...]


def read_defects() -> list[Defect]:
    """Read all of `defects.toml`."""
    listed = tomllib.loads(Path(__file__).with_name("defects.toml").read_text(encoding="utf-8"))["defect"]
    return [
        Defect(entry["name"], Edit(entry["file"], entry["old"], entry["new"]), tuple(entry["tests"]))
        for entry in listed
    ]


def find_red_test(defect: Defect) -> str:
    """Return the first test that fails with the defect; empty: none."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        for entry in REPOSITORY.iterdir():
            # Links to everything but the host package, which is copied and edited.
            if entry.name not in NOT_LINKED:
                (copy / entry.name).symlink_to(entry)
        shutil.copytree(REPOSITORY / HOST, copy / HOST, ignore=shutil.ignore_patterns("__pycache__"))
        plant(copy, [defect.edit])
        process = subprocess.run(
            [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *defect.tests],
            cwd=copy,
            # PYTHONPATH: pytest must import the copy, not the installed package.
            env={**os.environ, "PYTHONPATH": str(copy / HOST), "OPENBLAS_NUM_THREADS": "1"},
            capture_output=True,
            text=True,
            check=False,
        )
    # The first failing test, so that a report says which one would catch it.
    failed = re.search(r"^(?:FAILED|ERROR) (\S+)", process.stdout, re.MULTILINE)
    return failed[1] if failed else ""


def main(names: Sequence[str]) -> int:
    """Plant all, or those whose name begins so; 1 if one stays unseen."""
    chosen = [defect for defect in read_defects() if not names or defect.name.startswith(tuple(names))]
    unseen = 0
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for defect, red in zip(chosen, pool.map(find_red_test, chosen), strict=True):
            unseen += not red
            print(f"{'red ' if red else 'GREEN'}  {defect.name}: {red or 'no test failed'}", flush=True)
    print(f"{len(chosen) - unseen} of {len(chosen)} planted defects are seen.")
    return min(unseen, 1)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
