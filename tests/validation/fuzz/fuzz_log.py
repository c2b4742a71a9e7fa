"""A fuzz target for atheris: scripts that damage a log, judged by `log_mutations.check`.

Started by `make fuzz-decode`; a finding is shown again with
build/fuzz-decode/venv/bin/python -m tests.validation.fuzz.fuzz_log FINDING
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["tfsat_host.sdlog"]):
    from tests.validation.fuzz.log_mutations import check


def main() -> None:
    """Never returns: libFuzzer ends the process."""
    with tempfile.TemporaryDirectory(prefix="tfsat-fuzz-", dir=_memory()) as folder:
        path = Path(folder) / "SD.bin"

        # Script and file are kept in memory: a million runs.
        def one_input(data: bytes) -> None:
            check(data, path)

        atheris.Setup(sys.argv, one_input)
        atheris.Fuzz()


def _memory() -> Path | None:
    """Files that a million runs write need not wear out a disk."""
    # On Linux a file system in memory.
    shared = Path("/dev/shm")
    return shared if shared.is_dir() else None


if __name__ == "__main__":
    main()
