"""The command line as a user has it: arguments in, two streams and an exit code out."""

from __future__ import annotations

import contextlib
import io
import json
import os
import subprocess
import sys
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from tfsat_host.cli.main import main


def clean_environment(home: Path) -> dict[str, str]:
    """Variables that keep a command inside `home` and out of the terminal."""
    return {
        # State and cache go below the test's own home.
        "HOME": str(home),
        "XDG_STATE_HOME": str(home / "state"),
        # The cache holds the built robot: every test would build it anew.
        "XDG_CACHE_HOME": os.environ.get("XDG_CACHE_HOME") or str(Path("~/.cache").expanduser()),
        "NO_COLOR": "1",
    }


class RunCli:
    """Runs `tfsat-host`; an exit code that was not expected shows what the command printed."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def __call__(
        self,
        *args: object,
        expect: int | None = 0,
        without_ports: bool = False,
        environ: Mapping[str, str] | None = None,
        process: bool = False,
        timeout_s: float = 120.0,
    ) -> subprocess.CompletedProcess[str]:
        """Run one command, with no terminal and no input.

        Args:
            args: Its arguments.
            expect: The exit code; None for any.
            without_ports: Run as on a computer with no serial port, whatever is plugged in.
            environ: Variables besides those of this process.
            process: Run in a separate process, to test what Python does before and after the command.
            timeout_s: Timeout of such a process.
        """
        argv = list(map(str, args))
        result = (
            self._process(argv, environ, timeout_s) if process else self._here(argv, environ, without_ports)
        )
        # No command may end in a traceback, whatever a test expects of it.
        assert "Traceback" not in result.stderr, result.stderr
        if expect is not None:
            assert result.returncode == expect, (result.args, result.returncode, result.stdout, result.stderr)
        return result

    def _process(
        self, argv: list[str], environ: Mapping[str, str] | None, timeout_s: float
    ) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, "-m", "tfsat_host", *argv],
            cwd=self.folder,
            env={**os.environ, **(environ or {})},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=timeout_s,
            check=False,
        )

    def _here(
        self, argv: list[str], environ: Mapping[str, str] | None, without_ports: bool
    ) -> subprocess.CompletedProcess[str]:
        out, err = io.StringIO(), io.StringIO()
        with ExitStack() as stack:
            patch = stack.enter_context(pytest.MonkeyPatch.context())
            for name, value in (environ or {}).items():
                patch.setenv(name, value)
            if without_ports:
                # As on a computer without serial ports.
                patch.setattr("serial.tools.list_ports.comports", lambda *_args, **_options: [])
            # No terminal and no input: a question would be a usage error.
            patch.setattr("sys.stdin", stack.enter_context(Path(os.devnull).open(encoding="utf-8")))
            patch.setattr("sys.argv", ["tfsat-host", *argv])
            stack.enter_context(contextlib.chdir(self.folder))
            stack.enter_context(contextlib.redirect_stdout(out))
            stack.enter_context(contextlib.redirect_stderr(err))
            try:
                code = main()
            except SystemExit as ended:  # argparse's --help and --version
                code = int(ended.code or 0)
        return subprocess.CompletedProcess(argv, code, out.getvalue(), err.getvalue())

    def json(self, *args: object, expect: int = 0, **options: Any) -> Any:
        """Run the command with `--json` and return the one object it prints."""
        return json.loads(self(*args, "--json", expect=expect, **options).stdout)
