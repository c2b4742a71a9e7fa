"""A Dask cluster in a process of its own: it prints its address, and ends with its stdin.

So Dask's threads, event loops and warnings stay out of the tests' process, and the command meets the cluster as a
user's does: at an address.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def cluster(workers: int, folder: Path) -> Iterator[str]:
    """Yield the address of a running cluster with `workers` processes and scratch files in `folder`."""
    process = subprocess.Popen(
        [sys.executable, __file__, str(workers), str(folder)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdin is not None and process.stdout is not None
    with process:
        try:
            address = process.stdout.readline().strip()
            assert address.startswith("tcp://"), "the cluster did not start"
            yield address
        finally:
            process.stdin.close()


def main() -> None:
    """Serves until stdin ends."""
    from distributed import LocalCluster

    with LocalCluster(  # type: ignore[no-untyped-call]
        n_workers=int(sys.argv[1]),
        threads_per_worker=1,
        processes=True,
        host="127.0.0.1",
        dashboard_address=None,
        local_directory=sys.argv[2],
    ) as running:
        sys.stdout.write(f"{running.scheduler_address}\n")
        sys.stdout.flush()
        sys.stdin.read()


if __name__ == "__main__":
    main()
