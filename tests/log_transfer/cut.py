"""A fetch whose cable is pulled while it runs."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

from tests.emulate.served import TIMEOUT_S
from tests.log_transfer.served_robot import LoggerAtPort


def fetch_and_pull(logger: LoggerAtPort, part: Path) -> dict[str, Any]:
    """Starts to fetch recording 1 and pulls the cable once something of it is there; the error."""
    command = [sys.executable, "-m", "tfsat_host", "log", "fetch", "1", "--json"]
    with subprocess.Popen(
        [*command, "--port", str(logger.served.logger)],
        cwd=logger.folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as fetching:
        while fetching.poll() is None and not _begun(part):
            pass
        logger.hand("cable logger pull")
        said, _ = fetching.communicate(timeout=TIMEOUT_S)
    assert fetching.returncode == 1, said
    error: dict[str, Any] = json.loads(said)["error"]
    return error


def _begun(part: Path) -> bool:
    """A block of ours is on the disk."""
    try:
        with part.open("rb") as file:
            return file.read(4) == b"TFS1"
    except FileNotFoundError:
        return False
