"""A rehearsal's folder: the same bytes again, nothing left of the one before, nothing of anybody else's touched."""

from __future__ import annotations

import contextlib
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from tests.bundle.commands import command, result
from tests.campaign.test_campaign import contents
from tests.evaluation.run_folder import tell_time
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.emulated.robot import EmulatedRobot
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.rehearsal import morning
from tfsat_host.rehearsal.rehearse import rehearse
from tfsat_host.rehearsal.run_folder import RunFolder
from tfsat_host.rehearsal.truth import Truth, drawn_truth
from tfsat_host.robot import RobotModel, load_robot
from tfsat_host.run.bundle.reproducing import document_in
from tfsat_host.run.files import REHEARSED

RECORDINGS = "calibration-emulated-recordings"
AGAIN = ("rehearse", "59", "70", "--out", "run")


def everything(folder: Path) -> dict[str, bytes]:
    """Hidden files, too."""
    files = {path: path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    return {name: path.read_bytes() for path, name in files.items()}


def test_the_same_rehearsal_gives_the_same_bytes(run: Path, tmp_path: Path) -> None:
    before = everything(run)
    (tmp_path / "elsewhere").mkdir()
    with contextlib.chdir(tmp_path / "elsewhere"):
        command(*AGAIN)
        assert everything(Path("run")) == before
    # Two pages of one minute would be the same by any clock.
    assert document_in((run / "report.html").read_text())["made_at"] == "2026-01-05 09:00 UTC"


def test_a_recording_without_the_time_of_day_is_dated_by_the_rehearsals_clock(tmp_path: Path) -> None:
    filed, maneuver = load_robot(), four_stroke(59.0, 70.0)
    drop = rehearse(schedule_maneuver(maneuver), filed, drawn_truth(filed, 1))
    (tmp_path / "SD.bin").write_bytes(drop.card)
    tell_time(tmp_path / "SD.bin", None)
    untold = replace(drop, card=(tmp_path / "SD.bin").read_bytes())
    folder = RunFolder(tmp_path / "run", force=False)
    with folder.replaced():
        folder.write(maneuver, untold, filed.path.read_bytes(), "{}\n")
        folder.sealed()
    (landing,) = read_calibration(tmp_path / "run" / "calibration-emulated.toml").landings
    assert landing.at == drop.collected


def test_nothing_is_left_of_the_rehearsal_before(run: Path) -> None:
    mine = run / RECORDINGS / "mine.txt"
    mine.write_text("keep")
    before = {path.name for path in (run / RECORDINGS).iterdir()}
    command("rehearse", "59", "70", "--seed", "2", "--out", "run")
    after = {path.name for path in (run / RECORDINGS).iterdir()}
    assert len(after) == len(before) and mine.read_text() == "keep"
    command("rehearse", "59", "70", "--fault", "card-missing", "--out", "run", expect=4)
    assert not (run / "SD.bin").exists() and len(list((run / RECORDINGS).glob("certificate-*"))) == 1


def test_the_card_that_somebody_copied_over_the_rehearsals_stays(run: Path) -> None:
    (run / "SD.bin").write_bytes(b"the real card")
    before = everything(run)
    refused = command(*AGAIN, expect=2)
    assert "run/SD.bin is not as the rehearsal made it" in refused.err and "--force" in refused.err
    assert everything(run) == before
    command(*AGAIN, "--force")
    assert (run / "SD.bin").read_bytes() != b"the real card"


def test_a_report_that_was_made_again_is_no_obstacle(run: Path) -> None:
    command("report", "run")
    command("evaluate", "run")
    command(*AGAIN)


def test_a_card_that_is_copied_while_the_rehearsal_goes_on_stays(
    run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lived = morning.lived

    def copied(robot: EmulatedRobot, filed: RobotModel, truth: Truth) -> morning.Morning:
        (run / "SD.bin").write_bytes(b"the real card")
        return lived(robot, filed, truth)

    monkeypatch.setattr(morning, "lived", copied)
    assert "is not as the rehearsal made it" in command(*AGAIN, expect=2).err
    assert (run / "SD.bin").read_bytes() == b"the real card"


def test_an_interrupted_rehearsal_leaves_the_one_before(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = everything(run)

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(morning, "lived", interrupted)
    command(*AGAIN, expect=130)
    assert everything(run) == before


def test_a_drop_of_a_campaign_is_never_rehearsed_over(run: Path) -> None:
    command("campaign", "init", "camp")
    said = command("campaign", "add", "camp", "run")
    assert "EMULATED: no robot fell" in said.words
    drop = Path("camp/drop-0001")
    assert not (drop / REHEARSED).exists() and (run / REHEARSED).exists()
    assert result("campaign", "list", "camp")["drops"][0]["robot"] == "emulated"
    shutil.copy(run / REHEARSED, drop)
    before = contents(drop)
    for force in ((), ("--force",)):
        refused = command("rehearse", "59", "70", "--out", drop, *force, expect=2)
        assert "is a drop of a campaign" in refused.err
        refused = command("rehearse", "59", "70", "--out", "camp", *force, expect=2)
        assert "is a campaign: it holds campaign.json" in refused.err
    assert contents(drop) == before


def test_the_robot_and_the_maneuver_in_the_folder_itself_can_be_flown_again(run: Path) -> None:
    before = everything(run)
    again = command("rehearse", "--file", "run/maneuver.toml", "--robot", "run/robot.toml", "--out", "run")
    assert "GOOD" in again.words
    after = everything(run)
    assert {name for name in before if before[name] != after.get(name)} <= {
        REHEARSED,
        "summary.json",
        "report.html",
    }
    command("rehearse", "59", "70", "--runs", "2", "--robot", "run/robot.toml", "--out", "run")
    assert (run / "robot.toml").read_bytes() == before["robot.toml"]
