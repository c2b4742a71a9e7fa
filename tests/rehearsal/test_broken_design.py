"""A robot that does not do what a fault demands is called so, of one drop and of many."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.bundle.commands import command
from tfsat_host.rehearsal import many
from tfsat_host.rehearsal.faults import known
from tfsat_host.rehearsal.faults.fault import Outcome, at_any_moment


@pytest.fixture(autouse=True)
def misjudged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Knocks and jolts must not keep the robot from flying; here a jolt is said to."""
    demands = at_any_moment(Outcome.STANDS_STILL)
    wrong = [replace(one, outcomes=demands) if one.name == "crane-jolt" else one for one in known.FAULTS]
    monkeypatch.setattr(known, "FAULTS", tuple(wrong))
    monkeypatch.chdir(tmp_path)


def test_of_one_drop() -> None:
    said = command("rehearse", "59", "70", "--fault", "crane-jolt", "--out", "run", expect=3)
    assert "By design the robot then moves no joint. It did NOT: in truth joints 1, 2, 3 moved by" in said.out
    assert "The evaluation:       GOOD" in said.out


def test_of_many_drops(monkeypatch: pytest.MonkeyPatch) -> None:
    def here(series: many.Series, runs: int, **_: Any) -> tuple[many.Flown, ...]:
        """Not in other processes, which know of no misjudged fault."""
        return tuple(many._flown(series, number) for number in range(1, runs + 1))

    monkeypatch.setattr(many, "fly_many", here)
    typed = ("rehearse", "59", "70", "--fault", "crane-jolt", "--runs", "2", "--out", "many")
    said = command(*typed, expect=3)
    assert "2 good" in said.out
    assert "did NOT do what it must with these faults, by the truth, in drop 1, 2." in said.out
