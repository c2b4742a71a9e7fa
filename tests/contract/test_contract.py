"""What other programs, later years and a person at a terminal rely on: documents, exit codes, files, options, texts.

An intended difference: `make contract`, read its diff, and say so in CHANGELOG.
"""

from __future__ import annotations

import json
from typing import Any

import pytest

from tests.contract.compare import differences, text_differences
from tests.contract.recorded import EXPECTED, path_of, read_result
from tests.contract.running import Result, options_of_all_commands, run_scenario
from tests.contract.scenarios import SCENARIOS, SERVED
from tests.fixtures.once import Once

LINES = [(scenario, line) for scenario, lines in SCENARIOS.items() for line in lines]
COMMANDS = sorted(path.stem for path in (EXPECTED / "options").iterdir())


@pytest.fixture
def result(scenario: str, line: str, once: Once) -> Result:
    """Return the result of a line; its scenario is run once."""
    results: list[Result] = once(f"contract, {scenario}", lambda: run_scenario(scenario))
    return next(result for result in results if result["typed"] == line)


@pytest.mark.parametrize(
    ("scenario", "line"), LINES, ids=[f"{name}: tfsat-host {line}" for name, line in LINES]
)
def test_a_command_gives_what_it_gave(scenario: str, line: str, result: Result) -> None:
    expected = read_result(path_of(scenario, line))
    if "text" in result:
        changed = text_differences(expected["text"], result["text"], numbers=scenario not in SERVED)
        assert not changed, "\n".join(changed)
    else:
        changed = list(differences(expected, result))
        assert not changed, "\n".join(changed)


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_takes_what_it_took(command: str) -> None:
    expected = json.loads((EXPECTED / f"options/{command}.json").read_text("utf-8"))
    assert list(differences(expected, _options()[command], command)) == []


def test_every_command_and_nothing_else_is_recorded() -> None:
    recorded = {path for path in EXPECTED.rglob("*") if path.is_file()}
    lines = [path_of(scenario, line) for scenario, line in LINES]
    assert len(set(lines)) == len(lines), "two lines have one name"
    assert recorded == {*lines, *(EXPECTED / f"options/{command}.json" for command in _options())}
    # A reviewer reads the diff of this folder: it must stay small enough to be read.
    assert sum(path.stat().st_size for path in recorded) <= 300_000


def _options() -> dict[str, Any]:
    return {command.replace(" ", "-"): options for command, options in options_of_all_commands().items()}


def test_a_lost_key_another_number_and_another_name_are_seen() -> None:
    was = {"angle_deg": 23.31, "verdict": "good", "strokes": [1, 2], "gone": None}
    now = {"angle_deg": 23.41, "verdict": "doubtful", "strokes": [1, 3], "more": None}
    assert list(differences(was, was)) == []
    # A number, a name, an item, a key that is gone and one that is new.
    assert len(list(differences(was, now))) == 5


def test_a_number_may_change_by_a_part_of_its_standard_deviation() -> None:
    was = {"angle_deg": 23.31, "angle_deg_std": 0.2, "rates": [0.1, 5.0], "rates_std": [0.01, 1.0]}
    # 5 % of 0.2 is 0.01; of 0.01 and 1.0 in the list 0.0005 and 0.05. Just within, then just beyond.
    assert list(differences(was, {**was, "angle_deg": 23.319, "rates": [0.1004, 5.04]})) == []
    assert len(list(differences(was, {**was, "angle_deg": 23.321, "rates": [0.1006, 5.06]}))) == 3


def test_a_text_may_change_in_the_last_digits_of_numbers_alone() -> None:
    was = "Angle: 23.31 ± 0.13 deg, body 1\nok\n"
    assert text_differences(was, was.replace("23.31", "23.32")) == []
    # Three units of the last digit, a digit less, and the other sign.
    for now in ("23.34", "23.3", "-23.31"):
        assert text_differences(was, was.replace("23.31", now)) != []
    assert text_differences(was, was.replace("body 1", "body 2")) != []
    assert text_differences(was, was.replace("ok", "doubtful")) != []
    # A line that breaks elsewhere changes the screen.
    assert text_differences(was, was.replace(", body", ",\n  body")) != []
    assert (
        text_differences(was, was.replace("23.31", "7").replace(", body", ",\n  body"), numbers=False) == []
    )
    assert text_differences(was, was.replace("ok", "doubtful"), numbers=False) != []
