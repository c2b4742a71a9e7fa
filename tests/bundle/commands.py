"""`tfsat-host` in this process: arguments in, exit code and both streams out."""

from __future__ import annotations

import contextlib
import io
import json
from typing import Any

from tests.evaluation.commanded import Said
from tfsat_host.cli.main import main


def command(*args: object, expect: int = 0) -> Said:
    """Runs a command in the current folder."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(list(map(str, args)))
    said = Said(code, out.getvalue(), err.getvalue())
    assert "Traceback" not in said.err and "a bug of its own" not in said.out + said.err, said
    assert code == expect, (code, said.out[:3000], said.err)
    return said


def result(*args: object, expect: int = 0) -> Any:
    """The object that it prints."""
    return json.loads(command(*args, "--json", expect=expect).out)
