"""The recorded results in `expected/`: a file a line, named after it, that a person can read and compare."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from tests.contract.running import Result

EXPECTED = Path(__file__).parent / "expected"
MAX_JSON_LINE = 160
MAX_NAME = 96


def path_of(scenario: str, line: str) -> Path:
    """Return where the result of a line is recorded: `expected/SCENARIO/WORDS-OF-THE-LINE.json`, of text `.txt`."""
    words = line.replace(" --json", "").replace("robot/", "")
    suffix = ".json" if "--json" in line else ".txt"
    return EXPECTED / scenario / (re.sub(r"[^\w.]+", "-", words).strip("-")[:MAX_NAME] + suffix)


def write_result(path: Path, result: Result) -> None:
    """Record the result of a line."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if "text" in result:
        path.write_text(result["text"], "utf-8")
    else:
        write_json(path, result)


def read_result(path: Path) -> Result:
    """Return what `write_result` recorded: of a text the whole file."""
    text = path.read_text("utf-8")
    return {"text": text} if path.suffix == ".txt" else json.loads(text)


def write_json(path: Path, value: Any) -> None:
    """Record a JSON value; numbers to six digits, far below every tolerance."""
    rounded = json.loads(json.dumps(value), parse_float=lambda text: float(f"{float(text):.6g}"))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"{format_json(rounded)}\n", "utf-8")


def format_json(value: Any, margin: str = "") -> str:
    """JSON of one line where it fits, else a line an item, whose changes a person can read."""
    line = json.dumps(value, ensure_ascii=False)
    if len(margin) + len(line) <= MAX_JSON_LINE or not isinstance(value, dict | list) or not value:
        return line
    inner = margin + " "
    if isinstance(value, dict):
        items = [f"{inner}{json.dumps(key)}: {format_json(item, inner)}" for key, item in value.items()]
        return "{\n" + ",\n".join(items) + f"\n{margin}}}"
    return "[\n" + ",\n".join(inner + format_json(item, inner) for item in value) + f"\n{margin}]"
