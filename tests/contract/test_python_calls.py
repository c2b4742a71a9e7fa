"""The Python calls that the guide documents: every name can be imported, and the example gives its numbers."""

from __future__ import annotations

import importlib
import inspect
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.contract.running import unpack_drop
from tests.paths import DOCS

PYTHON_NAMES = json.loads((Path(__file__).parent / "python_names.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("path", PYTHON_NAMES)
def test_a_documented_name_is_there_and_takes_what_it_took(path: str) -> None:
    module, _, name = path.rpartition(".")
    named = getattr(importlib.import_module(module), name)
    if PYTHON_NAMES[path] is not None:
        parameters = list(inspect.signature(named).parameters)
        # A new parameter breaks no caller; a missing one does.
        assert [parameter for parameter in PYTHON_NAMES[path] if parameter not in parameters] == []


def test_every_documented_name_is_in_the_contract() -> None:
    text = "\n".join(page.read_text(encoding="utf-8") for page in DOCS.rglob("*.md"))
    named = set(re.findall(r"\.\. auto\w+:: (tfsat_host\.[\w.]+)", text))
    for module, names in re.findall(r"^ *from (tfsat_host[\w.]*) import ([\w, ]+)$", text, re.MULTILINE):
        named |= {f"{module}.{name}" for name in names.split(", ")}
    # Modules, not names: they are imported whole.
    assert named - set(PYTHON_NAMES) - {"tfsat_host.dynamics", "tfsat_host.errors"} == set()


def test_the_guides_example_gives_its_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    unpack_drop(tmp_path)
    monkeypatch.chdir(tmp_path)
    example = re.search(r"```python\n(.*?)```", (DOCS / "guide/python-api.md").read_text("utf-8"), re.DOTALL)
    assert example is not None
    names: dict[str, Any] = {}
    # The printed pair becomes a variable: full digits instead of those on the screen.
    exec(example[1].replace("print(", "printed_pair = ("), names)
    assert np.degrees(names["printed_pair"]) == pytest.approx([26.7834387, 0.0455653], rel=1e-4)
