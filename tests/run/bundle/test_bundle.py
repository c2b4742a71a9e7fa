"""`bundle`: everything of a drop is in it, what is missing or doubtful is named, the same run gives the same bytes."""

from __future__ import annotations

import hashlib
import json
import os
import zipfile
from datetime import UTC, datetime
from pathlib import Path

import pytest

from tests.evaluation.run_folder import CERTIFICATE, change_headers, remove_blocks, run_folder
from tests.run.bundle.commands import command, result, rewrite_json
from tfsat_host import __version__
from tfsat_host.file_hash import sha256_of
from tfsat_host.run.bundle.manifest import BundleError, parse_manifest
from tfsat_host.run.signed_record import sign

# Serial number of a logger that is no test robot's.
OTHER = bytes.fromhex("00c0ffee00c0ffee")
AT = datetime(2026, 1, 5, 8, 40, tzinfo=UTC)


def test_all_of_a_drop_is_in_it_with_its_hash(run: Path) -> None:
    before = {path: path.read_bytes() for path in run.rglob("*") if path.is_file()}
    summary = result("bundle", "run")
    assert summary["bundle"] == "run.tfsat.zip"
    with zipfile.ZipFile("run.tfsat.zip") as opened:
        contents = {name: opened.read(name) for name in opened.namelist()}
        assert opened.testzip() is None
    # Also what lay outside of the folder and was used: the tower's and the robot's file.
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
    # From preflight.json: the sequencer records nothing itself. The logger's is in the recording.
    assert manifest["images"]["sequencer"]["image_crc"] == "1a2b3c4d"
    assert manifest["images"]["logger"]["firmware"] == "0.2.0"
    # The decoded table follows from the recording, so it stays out.
    assert manifest["left_out"].keys() == {"SD.csv"}
    # Without the versions a later difference could not be traced to a package.
    environment = json.loads(contents["environment.json"])
    assert environment["tfsat"] == __version__ and environment["packages"]["numpy"]
    assert json.loads(contents["evaluation.json"])["recording"]["file"] == "run/SD.bin"
    after = {path: path.read_bytes() for path in run.rglob("*") if path.is_file()}
    assert after == before, "a run is only read"


def test_the_same_run_gives_the_same_bytes(run: Path, tmp_path: Path) -> None:
    """Wherever it lies, whenever its files were touched."""
    command("bundle", "run", "--out", "one.zip")
    elsewhere = tmp_path / "else where's" / "run"
    elsewhere.parent.mkdir()
    # Blanks and a quotation mark in the path, other times and other rights: none of it may reach the archive.
    run.rename(elsewhere)
    for number, path in enumerate(sorted(elsewhere.iterdir())):
        os.utime(path, (10**9 + number, 10**9 + number))
        path.chmod(0o600)
    command("bundle", elsewhere, "--out", "two.zip")
    assert Path("one.zip").read_bytes() == Path("two.zip").read_bytes()
    with zipfile.ZipFile("one.zip") as opened:
        assert opened.namelist() == sorted(opened.namelist())
        # The earliest time a ZIP can hold, and one mode: no clock and no umask reaches the bytes.
        assert {entry.date_time for entry in opened.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        assert {entry.external_attr >> 16 for entry in opened.infolist()} == {0o100644}


def test_what_is_missing_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    run_folder(tmp_path / "run")
    for name in ("maneuver.toml", CERTIFICATE):
        (tmp_path / "run" / name).unlink()
    output, missing = command("bundle", "run"), result("bundle", "run")["missing"]
    # A drop without these can be bundled: the raw log is worth keeping by itself.
    expected = ["maneuver", "calibration", "preflight.json", "record.json", "image of the sequencer"]
    assert [entry["what"] for entry in missing] == expected
    assert f"Missing: {', '.join(expected)} (why: --full)" in output.words
    assert (
        output.words.startswith("Bundle: run.tfsat.zip (")
        and "Manifest (for the logbook): SHA-256 " in output.words
    )
    words = command("bundle", "run", "--full").words
    assert "Missing: 5 " in words and all(f"- {what}: " in words for what in expected)


def test_what_was_signed_is_taken_whatever_it_is_and_named_if_it_was_changed(
    quick_run: Path, tmp_path: Path
) -> None:
    (quick_run / "photos").mkdir()
    for name in ("hook.jpg", "gone.jpg"):
        (quick_run / "photos" / name).write_bytes(b"jpg")
        sign(quick_run, [quick_run / "photos" / name], "a person", AT)
    summary = result("bundle", "run")
    assert "run/photos/hook.jpg" in summary["files"] and summary["left_out"].keys() == {"SD.csv"}
    (quick_run / "photos/gone.jpg").rename(tmp_path / "gone.jpg")
    # What leads out of the folder stays out, although it was signed.
    (quick_run / "photos/gone.jpg").symlink_to(tmp_path / "gone.jpg")
    # The signed check itself is changed afterwards.
    (quick_run / "preflight.json").write_text("{}")
    # A signature promises the file: that it cannot come along is a loss, not a choice.
    summary = result("bundle", "run", expect=3)
    assert "run/photos/gone.jpg" not in summary["files"] and len(summary["record"]) == 1
    (lost,) = (entry for entry in summary["missing"] if entry["what"] == "run/photos/gone.jpg")
    assert lost["lost"] is True and "leads out of the folder" in lost["why"]
    words = command("bundle", "run", expect=3).words
    assert "Changed: run/preflight.json was changed" in words and "Lost: run/photos/gone.jpg: " in words


def test_a_recording_that_cannot_be_evaluated_is_bundled_all_the_same(undecodable_run: Path) -> None:
    """It is the one that others are to look at."""
    del undecodable_run
    summary = result("bundle", "run", expect=3)
    assert "report.html" in {entry["what"] for entry in summary["missing"] if entry["lost"]}
    assert {"run/SD.bin", f"run/{CERTIFICATE}", "evaluation.json"} <= summary["files"].keys()
    # Failing in the same way counts as the same, but a bundle without a report is not complete.
    again = result("reproduce", "run.tfsat.zip", expect=3)
    assert (again["same"], again["complete"]) == (True, False)
    assert again["compared"][0]["sentence"].startswith("The drop cannot be evaluated")


def test_a_recording_by_itself_takes_what_lies_beside_it(quick_run: Path) -> None:
    (quick_run / "SD.bin").rename(quick_run / "DROP0003.BIN")
    summary = result("bundle", "run/DROP0003.BIN")
    assert summary["bundle"] == "DROP0003.tfsat.zip" and summary["name"] == "DROP0003"
    assert {f"run/{CERTIFICATE}", "run/maneuver.toml", "run/preflight.json"} <= summary["files"].keys()
    assert summary["left_out"] == {}, "that folder is not the drop's"


def test_files_from_elsewhere_come_along(run: Path, tmp_path: Path) -> None:
    for name in (CERTIFICATE, "maneuver.toml"):
        (run / name).rename(tmp_path / name)
    summary = result("bundle", "run", "--maneuver", "maneuver.toml", "--swarm")
    # Robot and facility are the package's own here: their names are tested above.
    assert summary["evaluated"] | {"robot": None, "facility": None} == {
        "recording": "run/SD.bin",
        "maneuver": "maneuver/maneuver.toml",
        "calibration": f"calibration/{CERTIFICATE}",
        **dict.fromkeys(("robot", "facility", "video", "video_rate", "laser", "session")),
        "masses": False,
        "inertias": False,
        "swarm": True,
    }
    assert result("reproduce", "run.tfsat.zip")["same"] is True


def test_one_drop_at_a_time_and_nothing_of_others_is_overwritten(quick_run: Path) -> None:
    assert "holds one" in command("bundle", "run", "run", expect=2).err
    # Only --force overwrites a file that is no bundle; a bundle is replaced without it.
    Path("run.tfsat.zip").write_text("something else")
    assert "was not made by this command" in command("bundle", "run", expect=1).err
    assert Path("run.tfsat.zip").read_text() == "something else"
    command("bundle", "run", "--force")
    command("bundle", "run")
    assert "no file gone.toml" in command("bundle", "run", "--calibration", "gone.toml", expect=1).err
    assert "'there/' is a folder" in command("bundle", "run", "--out", "there/", expect=2).err
    assert sorted(path.name for path in Path().iterdir()) == ["run", "run.tfsat.zip"]
    # Without raw data there is nothing to bundle, and no evaluation to suggest.
    (quick_run / "SD.bin").unlink()
    output = command("bundle", "run", expect=1)
    assert "Nothing was bundled." in output.err and "evaluate" not in output.err
    assert "tfsat-host bundle SD.bin" in command("bundle", "gone", expect=1).err


def test_a_recording_of_another_robot_is_named(quick_run: Path) -> None:
    serial = bytes(8).hex()
    # The signatures would name the exchanged check as well.
    (quick_run / "record.json").unlink()
    (quick_run / "preflight.json").write_text(json.dumps({"boards": {"logger": {"serial": serial}}}))
    change_headers(quick_run / "SD.bin", board_serial=list(OTHER))
    of_preflight, of_certificate = result("bundle", "run", expect=3)["doubts"]
    assert f"of logger {OTHER.hex()}, preflight.json of logger {serial}" in of_preflight
    assert "the certificate of logger" in of_certificate
    # Numbers of the wrong robot reproduce as well as any: sameness must not hide the mix-up.
    reproduction = result("reproduce", "run.tfsat.zip", expect=3)
    assert reproduction["same"] is True and reproduction["doubts"] == [of_preflight, of_certificate]
    assert "2 doubtful" in command("reproduce", "run.tfsat.zip", "--out", "again", expect=3).words


def test_samples_that_were_lost_are_named(quick_run: Path) -> None:
    output = command("bundle", "run", "--full")
    # The undamaged recording first.
    assert "Recording: run/SD.bin, complete:" in output.words and " 0 lost" in output.words
    # While it hangs, 4 s before the release: the drop itself is whole, the recording is not.
    remove_blocks(quick_run / "SD.bin", 3.0, 3.5)
    output = command("bundle", "run", expect=3)
    assert "samples are lost" in output.words and " 0 lost" not in output.words
    # On this screen the file as it lies here; in the manifest, for readers elsewhere, the bundle's own.
    quick_run.rename("elsewhere")
    assert "missing: tfsat-host decode elsewhere/SD.bin" in command("bundle", "elsewhere", expect=3).words
    with zipfile.ZipFile("elsewhere.tfsat.zip") as opened:
        (doubt,) = json.loads(opened.read("manifest.json"))["doubts"]
    assert doubt.endswith("What is missing: tfsat-host decode run/SD.bin")


def test_what_a_rehearsal_did_not_leave_so_is_named(quick_run: Path) -> None:
    for name in ("truth.json", "truth.csv", "summary.json", "report.html"):
        (quick_run / name).write_text("{}")
    names = ("truth.json", "truth.csv", "summary.json", "report.html", "SD.bin")
    lines = [f"{sha256_of(quick_run / name)}  {name}" for name in names]
    # What a rehearsal leaves: a list of its files with their hashes.
    (quick_run / ".tfsat-rehearsal").write_text("\n".join(["made by tfsat-host rehearse", *lines]) + "\n")
    assert result("bundle", "run")["doubts"] == []
    uncomputed_files = ["run/report.html", "run/summary.json", "run/truth.json"]
    assert result("reproduce", "run.tfsat.zip")["not_computed"] == [
        *uncomputed_files[:2],
        "run/truth.csv",
        uncomputed_files[2],
    ]
    words = command("reproduce", "run.tfsat.zip", "--out", "again", "--full").words
    assert (
        "Verified by SHA-256 only: run/report.html, run/summary.json, run/truth.csv, run/truth.json" in words
    )
    # An edited truth would make any evaluation of the rehearsal look right.
    (quick_run / "truth.json").write_text('{"edited": true}')
    (quick_run / "summary.json").unlink()
    # Only this file may be made again without a doubt.
    (quick_run / "report.html").write_text("made again by report")
    truth, summary = result("bundle", "run", expect=3)["doubts"]
    assert truth == "truth.json was changed since the rehearsal left it."
    assert summary == "summary.json is gone: the rehearsal left it."


def test_links_pipes_and_names_that_nobody_sees_are_left_out(quick_run: Path, tmp_path: Path) -> None:
    (tmp_path / "secret.txt").write_text("of somebody else")
    (quick_run / "outside.txt").symlink_to(tmp_path / "secret.txt")
    (quick_run / "inside.txt").symlink_to("notes.txt")
    (quick_run / "nowhere.txt").symlink_to("gone.txt")
    # A link to itself.
    (quick_run / "round.txt").symlink_to("round.txt")
    (quick_run / "loop").symlink_to(".")
    (quick_run / "note\u202etxt.md").write_text("which way?")  # else no `reproduce` would take the archive
    # Reading a pipe without a writer would hang the command.
    os.mkfifo(quick_run / "pipe.txt")
    summary = result("bundle", "run")
    left_out = summary["left_out"]
    assert left_out["outside.txt"] == f"is a link that leads out of the folder, to {tmp_path / 'secret.txt'}"
    assert left_out["nowhere.txt"] == left_out["round.txt"] == "is a link that leads nowhere"
    assert left_out["loop"] == "is a link to a folder"
    assert left_out["pipe.txt"] == "is a pipe"
    assert left_out["run/note\u202etxt.md"] == "its name holds a character that cannot be seen"
    assert {"run/notes.txt", "run/inside.txt"} <= summary["files"].keys()
    assert not any("secret" in name or "outside" in name for name in summary["files"])
    words = command("bundle", "run").words
    assert "outside.txt" in words and "(why: --full)" in words and "leads out" not in words
    assert "outside.txt is a link that leads out of the folder" in command("bundle", "run", "--full").words
    # What was left out must not make the archive unreadable.
    command("reproduce", "run.tfsat.zip")


@pytest.mark.parametrize("name", ["SD.bin", "maneuver.toml", CERTIFICATE])
def test_a_file_that_counts_and_lies_elsewhere_has_to_be_named(
    quick_run: Path, tmp_path: Path, name: str
) -> None:
    (quick_run / name).rename(tmp_path / f"other-{name}")
    # A link in place of evidence: it could lead to another drop's file tomorrow.
    (quick_run / name).symlink_to(tmp_path / f"other-{name}")
    output = command("bundle", "run", expect=1)
    assert f"run/{name} is a link that leads out of the folder" in output.err.replace("\n", " ")
    assert not Path("run.tfsat.zip").exists()
    # Named by a person it is meant, and is taken.
    option = {"maneuver.toml": ("--maneuver",), CERTIFICATE: ("--calibration",)}.get(name)
    arguments = ("run", *option, f"run/{name}") if option else (f"run/{name}",)
    command("bundle", *arguments, "--out", "named.zip")


def test_a_folder_with_a_long_name_makes_a_bundle_that_reproduces(quick_run: Path) -> None:
    # A file system takes 255 bytes: suffixes have to fit behind the name.
    quick_run.rename("n" * 240)
    assert result("bundle", "n" * 240, "--out", "a.zip")["name"] == "n" * 200
    command("reproduce", "a.zip")


def test_a_bundle_of_an_older_program_has_no_doubts(bundle: Path) -> None:
    # Versions before this entry wrote none: absent means none, not damaged.
    rewrite_json(bundle, "manifest.json", lambda manifest: manifest.pop("doubts"))
    assert result("reproduce", bundle)["doubts"] == []


@pytest.mark.parametrize(
    ("manifest", "words"),
    [({"format": 1}, "it has no made_by"), ([1], "it is no list of files"), ({}, "it has no format")],
)
def test_a_manifest_that_is_none_is_named_in_words(manifest: object, words: str) -> None:
    with pytest.raises(BundleError) as caught:
        parse_manifest(json.dumps(manifest).encode(), "a.zip")
    assert caught.value.what == f"The manifest of a.zip cannot be understood: {words}."
