"""A rehearsal replaces the folder of the one before whole or not at all, and nothing of other runs beneath it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.bundle.commands import command
from tests.rehearsal.test_result_folder import everything
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.plan.facility import load_tower
from tfsat_host.rehearsal import rehearse as rehearsal
from tfsat_host.rehearsal.drop import Drop
from tfsat_host.rehearsal.preflight import Preflight
from tfsat_host.rehearsal.replaced import WAITING, Before
from tfsat_host.rehearsal.result_folder import ResultFolder
from tfsat_host.rehearsal.run_folder import RunFolder
from tfsat_host.rehearsal.truth import drawn_truth
from tfsat_host.robot import load_robot
from tfsat_host.run import reporting
from tfsat_host.run.files import REHEARSED

ANOTHER = ("rehearse", "59", "70", "--seed", "2", "--out", "run")
FIGURE = b"made by tfsat-host report"
PAGE = b"<title>tfsat report</title>"


@pytest.fixture(scope="module")
def other_drop() -> Drop:
    """Of seed 2."""
    filed, schedule = load_robot(), schedule_maneuver(four_stroke(59.0, 70.0))
    preflight = Preflight.of(schedule, filed, load_tower(None), None, despite=False)
    return rehearsal.rehearse(schedule, filed, drawn_truth(filed, 2), preflight=preflight)


@pytest.fixture
def flown(other_drop: Drop, monkeypatch: pytest.MonkeyPatch) -> None:
    """The day of seed 2 need not be lived again for each of its endings."""
    monkeypatch.setattr(rehearsal, "rehearse", lambda *_, **__: other_drop)


def interrupted_at(patch: pytest.MonkeyPatch, owner: Any, name: str, call: int, *, after: bool) -> None:
    """Ctrl-C before or after so many calls of a function."""
    whole: Callable[..., Any] = getattr(owner, name)
    calls = iter(range(1, 1000))

    def cut(*args: Any, **options: Any) -> Any:
        now = next(calls) == call
        if now and not after:
            raise KeyboardInterrupt
        value = whole(*args, **options)
        if now:
            raise KeyboardInterrupt
        return value

    patch.setattr(owner, name, cut)


@pytest.mark.usefixtures("flown")
@pytest.mark.parametrize("after", [False, True])
@pytest.mark.parametrize(
    ("owner", "name", "call"),
    [
        (Before, "begin", 1),
        (Before, "set_aside", 1),
        (Before, "set_aside", 4),
        (ResultFolder, "file", 1),
        (ResultFolder, "file", 6),
        (RunFolder, "_write_preflight", 1),
        (RunFolder, "_write_card", 1),
        (RunFolder, "_note_landing", 1),
        (reporting, "report", 1),
    ],
)
def test_ctrl_c_leaves_every_byte_of_the_rehearsal_before(
    run: Path, monkeypatch: pytest.MonkeyPatch, owner: Any, name: str, call: int, after: bool
) -> None:
    (run / "mine.txt").write_text("keep")
    command("evaluate", "run", "--out", "run/evaluation.json")
    before = everything(run)
    interrupted_at(monkeypatch, owner, name, call, after=after)
    command(*ANOTHER, expect=130)
    assert everything(run) == before


@pytest.mark.usefixtures("flown")
def test_ctrl_c_leaves_no_folder_where_there_was_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    interrupted_at(monkeypatch, RunFolder, "_write_card", 1, after=True)
    command(*ANOTHER, expect=130)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("flown")
@pytest.mark.parametrize(("owner", "name"), [(RunFolder, "write_summary"), (Before, "forget")])
def test_ctrl_c_when_the_new_files_are_whole_leaves_these(
    run: Path, monkeypatch: pytest.MonkeyPatch, owner: Any, name: str
) -> None:
    before = everything(run)
    with monkeypatch.context() as patch:
        interrupted_at(patch, owner, name, 1, after=True)
        command(*ANOTHER, expect=130)
    found = everything(run)
    assert found["truth.json"] != before["truth.json"] and b'"seed": 2' in found["summary.json"]
    assert "report.html" in found and not any(name.startswith(WAITING) for name in found)
    assert "GOOD" in command("evaluate", "run").words


@pytest.mark.usefixtures("flown")
@pytest.mark.parametrize(("owner", "name"), [(RunFolder, "_note_landing"), (Before, "begin")])
def test_what_a_killed_program_left_is_put_back_by_the_next(
    run: Path, monkeypatch: pytest.MonkeyPatch, owner: Any, name: str
) -> None:
    before = everything(run)
    with monkeypatch.context() as killed:
        interrupted_at(killed, owner, name, 1, after=True)
        killed.setattr(Before, "put_back", lambda *_: None)
        command(*ANOTHER, expect=130)
    assert (run / WAITING).exists()
    RunFolder(run, force=False)
    assert everything(run) == before


@pytest.mark.usefixtures("flown")
def test_runs_in_subfolders_keep_their_reports(run: Path) -> None:
    """Of figures that `report` put into a subfolder nothing is left: they are of the recording that went."""
    files = {
        "sub/report.html": PAGE,
        f"sub/{REHEARSED}": b"made by tfsat-host rehearse",
        "real/SD.BIN": b"a card",
        "real/motion.png": FIGURE,
        "kept/report.html": PAGE,
        "figures/motion.png": FIGURE,
        "figures/mine.png": b"mine",
    }
    for name, data in files.items():
        (run / name).parent.mkdir(exist_ok=True)
        (run / name).write_bytes(data)
    command(*ANOTHER)
    assert {name for name in files if not (run / name).exists()} == {"figures/motion.png"}
