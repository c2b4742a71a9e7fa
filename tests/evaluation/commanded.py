"""`tfsat-host evaluate` in this process: arguments in, exit code and both streams out."""

from __future__ import annotations

import contextlib
import io
import json
from dataclasses import dataclass
from typing import Any

from tfsat_host.cli.main import main


@dataclass(frozen=True)
class Said:
    """What the command did."""

    code: int
    out: str
    err: str

    @property
    def words(self) -> str:
        """What it printed, without line breaks."""
        return " ".join(self.out.split())

    @property
    def json(self) -> Any:
        """The one object that it printed."""
        return json.loads(self.out)


def evaluate(*args: object, full: bool = True) -> Said:
    """Run the command in the current folder; `full`: with every number and table."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(["evaluate", *map(str, args), *(["--full"] if full else [])])
    result = Said(code, out.getvalue(), err.getvalue())
    # A crash report in place of a result must never pass as an answer.
    assert "Traceback" not in result.err and "a bug of its own" not in result.out + result.err, result
    return result


def evaluate_to_json(*args: object, expect: int = 0) -> Any:
    """Run `evaluate --json` and return the object it prints."""
    result = evaluate(*args, "--json")
    assert result.code == expect, (result.code, result.out[:3000], result.err)
    return result.json
