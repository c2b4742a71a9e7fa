"""A rehearsal's folder: the same bytes again; replaced whole or not at all; nothing of anybody else's touched."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.evaluation.run_folder import tell_time
from tests.rehearsal.days import SCHEDULE, Rehearsing, preflight
from tests.run.bundle.commands import command, result
from tests.run.campaign.test_campaign import contents
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.maneuver import four_stroke
from tfsat_host.rehearsal import day as days
from tfsat_host.rehearsal import rehearsed_drop as drops
from tfsat_host.rehearsal import series
from tfsat_host.rehearsal.folder import WAITING, Before, ResultFolder
from tfsat_host.rehearsal.rehearsed_drop import Drop
from tfsat_host.rehearsal.run_folder import RunFolder
from tfsat_host.rehearsal.series import RehearsedDrop
from tfsat_host.rehearsal.truth import drawn_truth
from tfsat_host.robot import load_robot
from tfsat_host.run import drop_report
from tfsat_host.run.bundle.reproducing import document_in
from tfsat_host.run.files import REHEARSED

RECORDINGS = "calibration-emulated-recordings"
AGAIN = ("rehearse", "59", "70", "--out", "run")
ANOTHER = (*AGAIN, "--seed", "2")
# The marks by which `report` knows its own files.
FIGURE = b"made by tfsat-host report"
PAGE = b"<title>tfsat report</title>"


def read_files(folder: Path) -> dict[str, bytes]:
    """Hidden files, too."""
    files = {path: path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    return {name: path.read_bytes() for path, name in files.items()}


@pytest.fixture(scope="module")
def other_drop() -> Drop:
    """Return a drop of seed 2."""
    filed = load_robot()
    return drops.rehearse(SCHEDULE, filed, drawn_truth(filed, 2), preflight=preflight(despite=False))


@pytest.fixture
def canned_rehearsal(other_drop: Drop, monkeypatch: pytest.MonkeyPatch) -> None:
    """Replace the rehearsal by the drop of seed 2, made once for all tests."""
    monkeypatch.setattr(drops, "rehearse", lambda *_, **__: other_drop)


@pytest.fixture
def canned_series(monkeypatch: pytest.MonkeyPatch) -> None:
    """Replace the series by two drops without numbers: here their files matter."""
    drop = RehearsedDrop(1, 1, "", "", ())
    monkeypatch.setattr(series, "fly_many", lambda *_, **__: (drop, replace(drop, number=2)))


def interrupted_at(patch: pytest.MonkeyPatch, owner: Any, name: str, call: int, *, after: bool) -> None:
    """Ctrl-C before or after so many calls of a function."""
    original: Callable[..., Any] = getattr(owner, name)
    calls = iter(range(1, 1000))

    def cut(*args: Any, **options: Any) -> Any:
        now = next(calls) == call
        # Before: the function has changed nothing yet. After: all of it.
        if now and not after:
            raise KeyboardInterrupt
        value = original(*args, **options)
        if now:
            raise KeyboardInterrupt
        return value

    patch.setattr(owner, name, cut)


def test_the_same_rehearsal_gives_the_same_bytes(run: Path, tmp_path: Path) -> None:
    before = read_files(run)
    (tmp_path / "elsewhere").mkdir()
    with contextlib.chdir(tmp_path / "elsewhere"):
        command(*AGAIN)
        assert read_files(Path("run")) == before
    # Two pages of one minute would be the same by any clock.
    assert document_in((run / "report.html").read_text())["made_at"] == "2026-01-05 09:00 UTC"


def test_a_recording_without_the_time_of_day_is_dated_by_the_rehearsals_clock(
    other_drop: Drop, tmp_path: Path
) -> None:
    (tmp_path / "SD.bin").write_bytes(other_drop.card)
    # A logger that was not told the time of day: its header has zero.
    tell_time(tmp_path / "SD.bin", None)
    undated = replace(other_drop, card=(tmp_path / "SD.bin").read_bytes())
    folder = RunFolder(tmp_path / "run", force=False)
    with folder.replace_files():
        folder.write(four_stroke(59.0, 70.0), undated, load_robot().path.read_bytes(), "{}\n")
        folder.seal()
    (landing,) = read_calibration(tmp_path / "run" / "calibration-emulated.toml").landings
    assert landing.at == other_drop.collected


@pytest.mark.usefixtures("canned_rehearsal")
def test_nothing_is_left_of_the_rehearsal_before(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mine = run / RECORDINGS / "mine.txt"
    # A user's file among the rehearsal's own: it must survive.
    mine.write_text("keep")
    before = {path.name for path in (run / RECORDINGS).iterdir()}
    command(*ANOTHER)
    after = {path.name for path in (run / RECORDINGS).iterdir()}
    assert len(after) == len(before) and mine.read_text() == "keep"
    # With the real rehearsal: the canned drop has a card.
    monkeypatch.undo()
    monkeypatch.chdir(run.parent)
    command(*AGAIN, "--fault", "card-missing", expect=4)
    assert not (run / "SD.bin").exists() and len(list((run / RECORDINGS).glob("certificate-*"))) == 1


@pytest.mark.usefixtures("canned_rehearsal")
def test_a_card_that_was_copied_over_the_rehearsals_stays(run: Path) -> None:
    # The mix-up to be feared: a real drop copied into the rehearsal's folder, which cannot be flown again.
    (run / "SD.bin").write_bytes(b"the real card")
    before = read_files(run)
    refused = command(*AGAIN, expect=2)
    assert "run/SD.bin is not as the rehearsal made it" in refused.err and "--force" in refused.err
    assert read_files(run) == before
    command(*AGAIN, "--force")
    assert (run / "SD.bin").read_bytes() != b"the real card"


def test_a_card_stays_where_the_rehearsal_left_none(shared_rehearsal: Rehearsing, tmp_path: Path) -> None:
    # NO-GO: no card was written, so the mark names none.
    faulty = shared_rehearsal("59", "70", "--fault", "card-full", "--fault", "servo-dead@falling", expect=4)
    shutil.copytree(faulty.folder, tmp_path / "run")
    (tmp_path / "run" / "SD.bin").write_bytes(b"of a real drop")
    with contextlib.chdir(tmp_path):
        assert "SD.bin is not as the rehearsal made it" in command(*AGAIN, expect=2).err
    assert (tmp_path / "run" / "SD.bin").read_bytes() == b"of a real drop"


def test_a_report_that_was_made_again_is_no_obstacle(run: Path) -> None:
    command("report", "run")
    RunFolder(run, force=False)


def test_a_card_that_is_copied_while_the_rehearsal_goes_on_stays(
    run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun = days.begin_day

    def copy_card(*args: Any, **others: Any) -> Any:
        (run / "SD.bin").write_bytes(b"the real card")
        return begun(*args, **others)

    # After the first check and before the files are replaced: minutes lie between the two.
    monkeypatch.setattr(days, "begin_day", copy_card)
    assert "is not as the rehearsal made it" in command(*AGAIN, expect=2).err
    assert (run / "SD.bin").read_bytes() == b"the real card"


def test_a_drop_of_a_campaign_is_never_rehearsed_over(run: Path) -> None:
    command("campaign", "init", "camp")
    output = command("campaign", "add", "camp", "run")
    assert "emulated robot" in output.words
    drop = Path("camp/drop-0001")
    assert not (drop / REHEARSED).exists() and (run / REHEARSED).exists()
    assert result("campaign", "list", "camp")["drops"][0]["robot"] == "emulated"
    # Even with the mark in it, as a user's copy of all files has: a campaign's drop is evidence.
    shutil.copy(run / REHEARSED, drop)
    before = contents(drop)
    for force in ((), ("--force",)):
        refused = command("rehearse", "59", "70", "--out", drop, *force, expect=2)
        assert "is a drop of a campaign" in refused.err
        refused = command("rehearse", "59", "70", "--out", "camp", *force, expect=2)
        assert "is a campaign: it holds campaign.json" in refused.err
    assert contents(drop) == before


@pytest.mark.usefixtures("canned_series")
def test_the_robot_and_the_maneuver_in_the_folder_itself_can_be_flown_again(run: Path) -> None:
    before = read_files(run)
    again = command("rehearse", "--file", "run/maneuver.toml", "--robot", "run/robot.toml", "--out", "run")
    assert "GOOD" in again.words
    after = read_files(run)
    # The inputs lie in the folder that is replaced: they are read before they are moved.
    changed = {name for name in before if before[name] != after.get(name)}
    assert changed <= {REHEARSED, "summary.json", "report.html"}
    command("rehearse", "59", "70", "--runs", "2", "--robot", "run/robot.toml", "--out", "run", expect=3)
    assert (run / "robot.toml").read_bytes() == before["robot.toml"]
    file_names = {path.name for path in run.iterdir() if path.is_file()}
    assert file_names == {REHEARSED, "maneuver.toml", "robot.toml", "runs.csv", "runs.json"}


@pytest.mark.parametrize("options", [(), ("--runs", "2")])
def test_a_folder_of_somebody_else_is_left_alone(tmp_path: Path, options: tuple[str, ...]) -> None:
    (tmp_path / "precious").mkdir()
    (tmp_path / "precious" / "runs.csv").write_text("mine")
    (tmp_path / "file").write_text("mine")
    with contextlib.chdir(tmp_path):
        refused = command("rehearse", "59", "70", "--out", "precious", *options, expect=2).err
        assert "holds files that no rehearsal made" in refused
        refused = command("rehearse", "59", "70", "--out", "file", "--force", *options, expect=2).err
        assert "Give the name of a folder" in refused and "--force" not in refused
        refused = command("rehearse", "59", "70", "--out", "file/many", *options, expect=1).err
        assert "is a file, not a folder" in refused
    assert [path.read_text() for path in (tmp_path / "precious").iterdir()] == ["mine"]


@pytest.fixture(scope="module")
def evaluated_run(shared_rehearsal: Rehearsing, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a rehearsed drop's folder with an evaluation and a user's notes in it."""
    folder = Path(
        shutil.copytree(shared_rehearsal("59", "70").folder, tmp_path_factory.mktemp("evaluated") / "run")
    )
    (folder / "mine.txt").write_text("keep")
    with contextlib.chdir(folder.parent):
        command("evaluate", "run", "--out", "run/evaluation.json")
    return folder


@pytest.mark.usefixtures("canned_rehearsal")
@pytest.mark.parametrize("after", [False, True])
@pytest.mark.parametrize(
    ("owner", "name", "call"),
    [
        (days, "begin_day", 1),
        (Before, "begin", 1),
        (Before, "set_aside", 1),
        (Before, "set_aside", 4),
        (ResultFolder, "file", 1),
        (ResultFolder, "file", 6),
        (RunFolder, "_write_preflight", 1),
        (RunFolder, "_write_card", 1),
        (RunFolder, "_note_landing", 1),
        (drop_report, "report", 1),
    ],
)
def test_ctrl_c_leaves_every_byte_of_the_rehearsal_before(
    evaluated_run: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    owner: Any,
    name: str,
    call: int,
    after: bool,
) -> None:
    run = Path(shutil.copytree(evaluated_run, tmp_path / "run"))
    before = read_files(run)
    # Interrupted at the beginning of the real day: the canned one never begins.
    if owner is days:
        monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    interrupted_at(monkeypatch, owner, name, call, after=after)
    # 128 + SIGINT.
    command(*ANOTHER, expect=130)
    assert read_files(run) == before


@pytest.mark.usefixtures("canned_rehearsal")
def test_ctrl_c_leaves_no_folder_where_there_was_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    interrupted_at(monkeypatch, RunFolder, "_write_card", 1, after=True)
    command(*ANOTHER, expect=130)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("canned_rehearsal")
@pytest.mark.parametrize(("owner", "name"), [(RunFolder, "write_summary"), (Before, "forget")])
def test_ctrl_c_when_the_new_files_are_whole_leaves_these(
    run: Path, monkeypatch: pytest.MonkeyPatch, owner: Any, name: str
) -> None:
    before = read_files(run)
    with monkeypatch.context() as patch:
        interrupted_at(patch, owner, name, 1, after=True)
        command(*ANOTHER, expect=130)
    files = read_files(run)
    # All new or all old, never a mixture: from the sealed mark on the new files count.
    assert files["truth.json"] != before["truth.json"] and b'"seed": 2' in files["summary.json"]
    assert "report.html" in files and not any(name.startswith(WAITING) for name in files)
    assert "GOOD" in command("evaluate", "run").words


@pytest.mark.usefixtures("canned_rehearsal")
@pytest.mark.parametrize(("owner", "name"), [(RunFolder, "_note_landing"), (Before, "begin")])
def test_what_a_killed_program_left_is_put_back_by_the_next(
    run: Path, monkeypatch: pytest.MonkeyPatch, owner: Any, name: str
) -> None:
    before = read_files(run)
    with monkeypatch.context() as killed:
        interrupted_at(killed, owner, name, 1, after=True)
        # SIGKILL lets no handler run: nothing is put back by the program itself.
        killed.setattr(Before, "put_back", lambda *_: None)
        command(*ANOTHER, expect=130)
    assert (run / WAITING).exists()
    RunFolder(run, force=False)
    assert read_files(run) == before


@pytest.mark.usefixtures("canned_rehearsal")
def test_runs_in_subfolders_keep_their_reports(run: Path) -> None:
    """Keep reports of runs in subfolders.

    Figures that `report` put into a subfolder are removed with the replaced recording that they show.
    """
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
    # Only the figures of the replaced recording may go.
    command(*ANOTHER)
    assert {name for name in files if not (run / name).exists()} == {"figures/motion.png"}
