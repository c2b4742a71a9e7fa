"""Preflight asks for the acceptance of the boards that are there."""

from __future__ import annotations

import json
from datetime import UTC, datetime

import pytest

from tests.preflight.ready_robot import ReadyRobot, check
from tfsat_host.acceptance.record import StepResult
from tfsat_host.devices.board_identity import BoardIdentity
from tfsat_host.preflight.preflight_check import no_go

FILE = "acceptance-emulated.json"


def test_an_emulated_robot_needs_none(ready: ReadyRobot) -> None:
    assert check(ready.preflight(expect=0), "acceptance")["verdict"] == "go"


def test_boards_without_one_are_no_go(ready: ReadyRobot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(BoardIdentity, "runs_natively", property(lambda _: False))
    missing = check(ready.preflight(expect=4), "acceptance")
    assert missing["verdict"] == "not-made"
    assert "acceptance.json" in missing["sentence"]
    assert missing["next_step"].startswith("tfsat-host acceptance")


def test_one_of_these_boards_that_was_passed_is_go(ready: ReadyRobot) -> None:
    ready.accept()
    found = check(ready.preflight(expect=0), "acceptance")
    assert (found["verdict"], found["evidence"]["file"]) == ("go", f"{ready.folder}/{FILE}")
    assert "2026-11-02" in found["sentence"]


def test_one_with_a_step_left_is_no_go(ready: ReadyRobot) -> None:
    stuck = no_go("switch 2 never opens", "mend it")
    ready.accept(StepResult("switches", datetime(2026, 11, 2, tzinfo=UTC), (stuck,)))
    found = check(ready.preflight(expect=4), "acceptance")
    assert (found["verdict"], "not passed: switches" in found["sentence"]) == ("no-go", True)


@pytest.mark.parametrize("board", ["sequencer", "logger"])
def test_one_of_another_board_is_no_go(ready: ReadyRobot, board: str) -> None:
    ready.accept()
    record = json.loads((ready.folder / FILE).read_text(encoding="utf-8"))
    record[board]["serial"] = "0123"
    (ready.folder / FILE).write_text(json.dumps(record), encoding="utf-8")
    assert f"another {board}" in check(ready.preflight(expect=4), "acceptance")["sentence"]


def test_one_of_another_robot_file_is_no_go(ready: ReadyRobot) -> None:
    ready.accept()
    record = json.loads((ready.folder / FILE).read_text(encoding="utf-8"))
    (ready.folder / FILE).write_text(json.dumps(record | {"parts_sha256": "0" * 64}), encoding="utf-8")
    assert "of other parts" in check(ready.preflight(expect=4), "acceptance")["sentence"]


def test_one_that_cannot_be_read_is_not_passed_over(ready: ReadyRobot) -> None:
    (ready.folder / FILE).write_text("{", encoding="utf-8")
    assert check(ready.preflight(expect=4), "acceptance")["verdict"] == "no-go"
