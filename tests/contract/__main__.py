"""`python -m tests.contract`: records what the commands give now as what they must give from now on."""

from __future__ import annotations

import json
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

from tests.cli.process import clean_environment
from tests.contract.running import EXPECTED, options_of_all_commands, results_of
from tests.contract.scenarios import SCENARIOS

DEPTH = 4
"""Down to here a value has lines of its own."""


def written(value: Any, depth: int = 0) -> str:
    """JSON whose changes a person can read."""
    if depth < DEPTH and value and isinstance(value, dict | list):
        margin = "\n" + " " * (depth + 1)
        pairs = value.items() if isinstance(value, dict) else enumerate(value)
        items = [
            (f"{json.dumps(key)}: " if isinstance(value, dict) else "") + written(item, depth + 1)
            for key, item in pairs
        ]
        opened, closed = "{}" if isinstance(value, dict) else "[]"
        return opened + margin + ("," + margin).join(items) + margin[:-1] + closed
    return json.dumps(value, separators=(",", ":"))


def record(name: str, results: object) -> None:
    """Numbers to nine digits: far below every tolerance."""
    rounded = json.loads(json.dumps(results), parse_float=lambda text: float(f"{float(text):.9g}"))
    (EXPECTED / f"{name}.json").write_text(written(rounded) + "\n", encoding="utf-8")


EXPECTED.mkdir(exist_ok=True)
record("options", options_of_all_commands())
for scenario in sys.argv[1:] or SCENARIOS:
    with tempfile.TemporaryDirectory() as made:
        home, folder = Path(made) / "home", Path(made) / "work"
        folder.mkdir()
        os.environ.update(clean_environment(home))
        record(scenario, results_of(scenario, folder))
