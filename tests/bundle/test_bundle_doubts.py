"""`bundle` names what stands against a drop: another robot's recording, samples lost, a rehearsal edited afterwards."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.bundle.commands import command, result
from tests.bundle.rewritten import rewrite
from tests.evaluation.run_folder import change_headers, remove_blocks
from tfsat_host.file_hash import sha256_of
from tfsat_host.run.bundle.manifest import BundleError, parse_manifest
from tfsat_host.run.bundle.recomputing import Recomputed

OTHER = bytes.fromhex("00c0ffee00c0ffee")
PAGE = '<script type="application/json" id="document">{"a": 1.0}</script>'


@pytest.fixture
def quick(run: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A run whose evaluation takes no time."""
    recomputed = Recomputed({"a": [1.0]}, PAGE, None)
    monkeypatch.setattr("tfsat_host.run.bundle.recomputing.recompute", lambda *_: recomputed)
    return run


def test_a_recording_of_another_robot_is_named(quick: Path) -> None:
    serial = bytes(8).hex()
    (quick / "record.json").unlink()
    (quick / "preflight.json").write_text(json.dumps({"boards": {"logger": {"serial": serial}}}))
    change_headers(quick / "SD.bin", board_serial=list(OTHER))
    of_preflight, of_certificate = result("bundle", "run", expect=3)["doubts"]
    assert f"of logger {OTHER.hex()}, preflight.json of logger {serial}" in of_preflight
    assert "the certificate of logger" in of_certificate
    said = result("reproduce", "run.tfsat.zip", expect=3)
    assert said["same"] is True and said["doubts"] == [of_preflight, of_certificate]
    assert "DOUBTFUL" in command("reproduce", "run.tfsat.zip", "--out", "again", expect=3).words


def test_samples_that_were_lost_are_told(quick: Path) -> None:
    said = command("bundle", "run")
    assert "Recording run/SD.bin, complete:" in said.words and " 0 lost" in said.words
    remove_blocks(quick / "SD.bin", 3.0, 3.5)
    said = command("bundle", "run", expect=3)
    assert "samples are lost" in said.words and " 0 lost" not in said.words


def test_what_a_rehearsal_did_not_leave_so_is_named(quick: Path) -> None:
    for name in ("truth.json", "truth.csv", "summary.json", "report.html"):
        (quick / name).write_text("{}")
    names = ("truth.json", "truth.csv", "summary.json", "report.html", "SD.bin")
    lines = [f"{sha256_of(quick / name)}  {name}" for name in names]
    (quick / ".tfsat-rehearsal").write_text("\n".join(["made by tfsat-host rehearse", *lines]) + "\n")
    assert result("bundle", "run")["doubts"] == []
    (quick / "truth.json").write_text('{"edited": true}')
    (quick / "summary.json").unlink()
    (quick / "report.html").write_text("made anew by report")
    truth, summary = result("bundle", "run", expect=3)["doubts"]
    assert truth == "truth.json was changed since the rehearsal left it."
    assert summary == "summary.json is gone: the rehearsal left it."


def test_what_is_kept_and_not_computed_anew_is_named(quick: Path) -> None:
    for name in ("truth.json", "summary.json", "report.html"):
        (quick / name).write_text("{}")
    command("bundle", "run")
    said = result("reproduce", "run.tfsat.zip")
    assert said["not_computed"] == ["run/report.html", "run/summary.json", "run/truth.json"]
    words = command("reproduce", "run.tfsat.zip", "--out", "again").words
    assert "not computed: run/report.html, run/summary.json, run/truth.json" in words


def test_a_bundle_of_an_older_program_has_no_doubts(bundle: Path) -> None:
    def older(files: dict[str, bytes]) -> None:
        manifest = json.loads(files["manifest.json"])
        del manifest["doubts"]
        files["manifest.json"] = json.dumps(manifest).encode()

    rewrite(bundle, older)
    assert result("reproduce", bundle)["doubts"] == []


@pytest.mark.parametrize(
    ("manifest", "words"),
    [
        ({"format": 1}, "it has no made_by"),
        ([1], "it is no list of files"),
        ({}, "it has no format"),
    ],
)
def test_a_manifest_that_is_none_is_told_in_words(manifest: object, words: str) -> None:
    with pytest.raises(BundleError) as told:
        parse_manifest(json.dumps(manifest).encode(), "a.zip")
    assert told.value.what == f"The manifest of a.zip cannot be understood: {words}."


def test_what_is_no_bundle_is_told_from_one(run: Path) -> None:
    del run
    said = command("reproduce", "run", expect=1)
    assert "run is a folder; BUNDLE is a file that tfsat-host bundle makes" in said.err
    assert "There is no file nope.zip; BUNDLE is a file" in command("reproduce", "nope.zip", expect=1).err
