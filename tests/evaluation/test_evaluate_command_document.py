"""docs/evaluation.md names every key that the command prints, and its example runs."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.evaluation.commanded import evaluate
from tests.evaluation.run_folder import run_folder
from tests.evaluation.test_evaluate_command import write_witnesses

DOCUMENT = (Path(__file__).resolve().parents[2] / "docs" / "evaluation.md").read_text(encoding="utf-8")
BY_GROUP = "trades[].growth"
"""Its keys are the names of groups."""


def tables(after: str) -> list[str]:
    """The keys in the first column of the table that follows a line."""
    lines = DOCUMENT[DOCUMENT.index(after) :].splitlines()
    start = next(number for number, line in enumerate(lines) if line.startswith("| key |"))
    rows = []
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            break
        rows.append(line.split(" | ")[0])
    return [key for row in rows for key in re.findall(r"`([^`]+)`", row)]


def paths(value: Any, place: str = "") -> Iterator[str]:
    if isinstance(value, dict) and place != BY_GROUP:
        for key, item in value.items():
            yield from paths(item, f"{place}.{key}" if place else key)
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for item in value:
            yield from paths(item, f"{place}[]")
    else:
        yield place


def check(documented: list[str], printed: set[str]) -> None:
    patterns = [re.compile(re.escape(key).replace(r"\*", "[a-z_]+")) for key in documented]
    assert len(set(documented)) == len(documented)
    assert [path for path in printed if not any(one.fullmatch(path) for one in patterns)] == []
    unused = [
        key for key, one in zip(documented, patterns, strict=True) if not any(map(one.fullmatch, printed))
    ]
    assert unused == []


def test_every_key_is_documented_and_every_documented_key_is_there(run: Path) -> None:
    write_witnesses(run.parent)
    found = evaluate("run", "--video", "video.csv", "--laser", "laser.csv", "--swarm", "--json").json
    check(tables("## The object of `--json`"), set(paths(found)))


def test_every_key_of_several_drops(run: Path) -> None:
    run_folder(run.parent / "second", seed=2)
    found = evaluate("run", "second", "--json").json
    assert found.keys() == {"made_by", "drops", "comparison"}
    check(tables("Of several drops:"), set(paths({"comparison": found["comparison"]})))


def test_the_example_in_python_runs(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (example,) = re.findall(r"```python\n(.*?)```", DOCUMENT, flags=re.DOTALL)
    assert (run / "SD.bin").is_file()
    exec(compile(example, "docs/evaluation.md", "exec"), {})
    assert len(capsys.readouterr().out.splitlines()) >= 4
