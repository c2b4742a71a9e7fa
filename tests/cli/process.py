"""The command line as a user has it: a process with arguments, two streams and an exit code."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

# Runs the command with no serial port on the computer, whatever is plugged in.
_WITHOUT_PORTS = """
import sys
import serial.tools.list_ports
serial.tools.list_ports.comports = lambda *args, **kwargs: []
from tfsat_host.cli.main import main
sys.exit(main())
"""


def clean_environment(home: Path) -> dict[str, str]:
    """Variables that keep a command inside `home` and out of the terminal."""
    return {
        "HOME": str(home),
        "XDG_STATE_HOME": str(home / "state"),
        "XDG_CACHE_HOME": os.environ.get("XDG_CACHE_HOME") or str(Path("~/.cache").expanduser()),
        "NO_COLOR": "1",
    }


class RunCli:
    """Runs `tfsat-host`; an exit code that was not expected shows what the command said."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def __call__(
        self,
        *args: object,
        expect: int | None = 0,
        without_ports: bool = False,
        environ: Mapping[str, str] | None = None,
        timeout_s: float = 120.0,
    ) -> subprocess.CompletedProcess[str]:
        start = ["-c", _WITHOUT_PORTS] if without_ports else ["-m", "tfsat_host"]
        done = subprocess.run(
            [sys.executable, *start, *map(str, args)],
            cwd=self.folder,
            env={**os.environ, **(environ or {})},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=timeout_s,
            check=False,
        )
        assert "Traceback" not in done.stderr, done.stderr
        if expect is not None:
            assert done.returncode == expect, (done.args, done.returncode, done.stdout, done.stderr)
        return done

    def json(self, *args: object, expect: int = 0, **options: Any) -> Any:
        """The one JSON object that the command prints."""
        return json.loads(self(*args, "--json", expect=expect, **options).stdout)
