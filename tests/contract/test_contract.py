"""What other programs and later years rely on: documents, exit codes, options, files, Python calls, old data.

An intended difference: `python -m tests.contract [SCENARIO]`, read its diff, and say so in CHANGELOG.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.contract.compare import differences
from tests.contract.running import EXPECTED, options_of_all_commands, results_of
from tests.contract.scenarios import SCENARIOS


def _expected(name: str) -> object:
    return json.loads((EXPECTED / f"{name}.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_commands_give_what_they_gave(scenario: str, tmp_path: Path) -> None:
    found = json.loads(json.dumps(results_of(scenario, tmp_path)))
    assert list(differences(_expected(scenario), found, scenario)) == []


def test_commands_take_what_they_took() -> None:
    found = json.loads(json.dumps(options_of_all_commands()))
    assert list(differences(_expected("options"), found, "options")) == []


def test_a_lost_key_another_number_and_another_name_are_seen() -> None:
    was = {"angle_deg": 23.31, "verdict": "good", "strokes": [1, 2], "gone": None}
    now = {"angle_deg": 23.32, "verdict": "doubtful", "strokes": [1, 3], "more": None}
    assert list(differences(was, was)) == []
    assert len(list(differences(was, now))) == 5
