"""`bundle`: everything of a drop is in it, what is missing is named, and the same run gives the same bytes."""

from __future__ import annotations

import hashlib
import json
import os
import zipfile
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from tests.bundle.commands import command, result
from tests.evaluation.run_folder import CERTIFICATE, run_folder
from tfsat_host import __version__
from tfsat_host.run.record import sign


def manifest_in(archive: Path) -> Any:
    with zipfile.ZipFile(archive) as opened:
        return json.loads(opened.read("manifest.json"))


def test_all_of_a_drop_is_in_it_with_its_hash(run: Path) -> None:
    before = {path: path.read_bytes() for path in run.rglob("*") if path.is_file()}
    said = result("bundle", "run")
    assert said["bundle"] == "run.tfsat.zip"
    with zipfile.ZipFile("run.tfsat.zip") as opened:
        contents = {name: opened.read(name) for name in opened.namelist()}
        assert opened.testzip() is None
    assert list(contents) == [
        "environment.json",
        "evaluation.json",
        "facility/cosmotorre.toml",
        "manifest.json",
        "report.html",
        "robot/drop_tower.toml",
        "run/SD.bin",
        f"run/{CERTIFICATE}",
        "run/maneuver.toml",
        "run/notes.txt",
        "run/preflight.json",
        "run/record.json",
    ]
    manifest = json.loads(contents.pop("manifest.json"))
    assert {name: file["sha256"] for name, file in manifest["files"].items()} == {
        name: hashlib.sha256(data).hexdigest() for name, data in contents.items()
    }
    assert manifest["images"]["sequencer"]["image_crc"] == "1a2b3c4d"
    assert manifest["images"]["logger"]["firmware"] == "0.2.0"
    assert manifest["left_out"].keys() == {"SD.csv"}
    environment = json.loads(contents["environment.json"])
    assert environment["tfsat"] == __version__ and environment["packages"]["numpy"]
    assert json.loads(contents["evaluation.json"])["recording"]["file"] == "run/SD.bin"
    assert {path: path.read_bytes() for path in run.rglob("*") if path.is_file()} == before, (
        "a run is only read"
    )


def test_the_same_run_gives_the_same_bytes(run: Path, tmp_path: Path) -> None:
    """Wherever it lies, whenever its files were touched."""
    command("bundle", "run", "--out", "one.zip")
    elsewhere = tmp_path / "else where's" / "run"
    elsewhere.parent.mkdir()
    run.rename(elsewhere)
    for number, path in enumerate(sorted(elsewhere.iterdir())):
        os.utime(path, (10**9 + number, 10**9 + number))
        path.chmod(0o600)
    command("bundle", elsewhere, "--out", "two.zip")
    assert Path("one.zip").read_bytes() == Path("two.zip").read_bytes()
    with zipfile.ZipFile("one.zip") as opened:
        names = opened.namelist()
        assert names == sorted(names)
        assert {entry.date_time for entry in opened.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        assert {entry.external_attr >> 16 for entry in opened.infolist()} == {0o100644}


def test_what_is_missing_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    run_folder(tmp_path / "run")
    for name in ("maneuver.toml", CERTIFICATE):
        (tmp_path / "run" / name).unlink()
    said = command("bundle", "run")
    expected = ("maneuver", "calibration", "preflight.json", "record.json", "image of the sequencer")
    assert [one["what"] for one in manifest_in(Path("run.tfsat.zip"))["missing"]] == list(expected)
    assert all(f"Missing {what}: " in said.words for what in expected)


def test_a_file_that_was_changed_after_it_was_signed_is_told(run: Path) -> None:
    (run / "preflight.json").write_text("{}")
    said = command("bundle", "run", expect=3)
    assert "CHANGED" in said.out and "preflight.json was changed" in said.words
    assert len(manifest_in(Path("run.tfsat.zip"))["record"]) == 1


def test_what_was_signed_is_taken_whatever_it_is(run: Path) -> None:
    (run / "photos").mkdir()
    (run / "photos" / "hook.jpg").write_bytes(b"jpg")
    sign(run, [run / "photos" / "hook.jpg"], "a person", datetime(2026, 1, 5, 8, 40, tzinfo=UTC))
    said = result("bundle", "run")
    assert "run/photos/hook.jpg" in said["files"]
    assert said["left_out"].keys() == {"SD.csv"}


def test_a_recording_that_cannot_be_evaluated_is_bundled_all_the_same(run: Path) -> None:
    """It is the one that others are to look at."""
    (run / "SD.bin").write_bytes(b"no recording" * 100)
    said = result("bundle", "run", expect=3)
    assert "report.html" in {one["what"] for one in said["missing"] if one["lost"]}
    assert {"run/SD.bin", f"run/{CERTIFICATE}", "evaluation.json"} <= said["files"].keys()
    again = result("reproduce", "run.tfsat.zip", expect=3)
    assert (again["same"], again["complete"]) == (True, False)
    assert again["compared"][0]["sentence"].startswith("The drop cannot be evaluated")


def test_a_recording_by_itself_takes_what_lies_beside_it(run: Path) -> None:
    (run / "SD.bin").rename(run / "DROP0003.BIN")
    said = result("bundle", "run/DROP0003.BIN")
    assert said["bundle"] == "DROP0003.tfsat.zip" and said["name"] == "DROP0003"
    assert {f"run/{CERTIFICATE}", "run/maneuver.toml", "run/preflight.json"} <= said["files"].keys()
    assert said["left_out"] == {}, "that folder is not the drop's"


def test_files_from_elsewhere_come_along(run: Path, tmp_path: Path) -> None:
    for name in (CERTIFICATE, "maneuver.toml"):
        (run / name).rename(tmp_path / name)
    (tmp_path / "marks.csv").write_text("event,t_s\nrelease,0.0\nlanding,2.5\n")
    said = result("bundle", "run", "--maneuver", "maneuver.toml", "--masses")
    assert said["evaluated"] | {"robot": None, "facility": None} == {
        "recording": "run/SD.bin",
        "maneuver": "maneuver/maneuver.toml",
        "calibration": f"calibration/{CERTIFICATE}",
        "robot": None,
        "facility": None,
        "video": None,
        "laser": None,
        "session": None,
        "masses": True,
        "inertias": False,
        "swarm": False,
    }
    again = result("reproduce", "run.tfsat.zip")
    assert again["same"] is True


def test_one_drop_at_a_time_and_nothing_of_others_is_overwritten(run: Path) -> None:
    assert "holds one" in command("bundle", "run", "run", expect=2).err
    Path("run.tfsat.zip").write_text("something else")
    assert "was not made by this command" in command("bundle", "run", expect=1).err
    assert Path("run.tfsat.zip").read_text() == "something else"
    command("bundle", "run", "--force")
    command("bundle", "run")
    assert "no file gone.toml" in command("bundle", "run", "--calibration", "gone.toml", expect=1).err
    assert sorted(path.name for path in Path().iterdir()) == ["run", "run.tfsat.zip"]
