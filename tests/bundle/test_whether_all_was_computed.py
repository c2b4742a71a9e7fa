"""`reproduce` ends with 0 only if everything was computed anew, nothing was lost, and nothing was changed."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from typing import Any

import pytest

from tests.bundle.commands import command, result
from tests.bundle.rewritten import rewrite
from tests.calibration.bench_day import MODEL, REST, SWINGS, ZERO, done
from tests.evaluation.run_folder import CERTIFICATE, change_headers
from tfsat_host.calibration.certificate.campaign import Campaign
from tfsat_host.calibration.certificate.certificate import Subject
from tfsat_host.errors import TfsatError
from tfsat_host.run.bundle.recomputing import Recomputed

PAGE = '<script type="application/json" id="document">{"a": 1.0}</script>'
RECORDINGS = CERTIFICATE.replace(".toml", "-recordings")


@pytest.fixture
def calibrated(run: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A run with a certificate that rests on recordings, and an evaluation that takes no time."""
    recomputed = Recomputed({"a": [1.0]}, PAGE, None)
    monkeypatch.setattr("tfsat_host.run.bundle.recomputing.recompute", lambda *_: recomputed)
    (run / CERTIFICATE).unlink()
    origin = done(REST).origin
    change_headers(run / "SD.bin", board_serial=list(bytes.fromhex(origin.logger_serial)))
    subject = Subject(MODEL.name, origin.logger_serial, origin.who_am_i, origin.emulated)
    campaign = Campaign(run / CERTIFICATE, MODEL, subject)
    for step in (REST, ZERO, SWINGS[0]):
        campaign.accept(done(step))
    return run


def sole(pattern: str, folder: Path) -> Path:
    (found,) = folder.glob(pattern)
    return found


def test_all_of_it_is_complete(calibrated: Path) -> None:
    result("bundle", "run")
    said = result("reproduce", "run.tfsat.zip")
    assert (said["same"], said["complete"], said["incomplete"]) == (True, True, [])


@pytest.mark.parametrize("damage", ["gone", "changed"])
def test_a_calibration_that_cannot_be_computed_anew_is_said(calibrated: Path, damage: str) -> None:
    recording = sole("*zero*.npz", calibrated / RECORDINGS)
    recording.unlink() if damage == "gone" else recording.write_bytes(b"else")
    command("bundle", "run", expect=3)
    said = result("reproduce", "run.tfsat.zip", expect=3)
    assert (said["same"], said["complete"]) == (True, False)
    assert any(recording.name in sentence for sentence in said["incomplete"])
    words = command("reproduce", "run.tfsat.zip", "--out", "again", expect=3).words
    assert "SAME as far as it could be computed, and not whole: 1 LOST, 1 NOT COMPUTED (above)." in words
    assert "SAME: the raw data give" not in words


def test_a_changed_certificate_in_the_bundle_is_said(calibrated: Path) -> None:
    """Nothing was lost when it was bundled."""
    command("bundle", "run")

    def change(files: dict[str, bytes]) -> None:
        name = next(name for name in files if "zero" in name and name.endswith(".npz"))
        files[name] += b"x"

    rewrite(Path("run.tfsat.zip"), change)
    said = result("reproduce", "run.tfsat.zip", expect=3)
    assert (said["same"], said["complete"]) == (True, False)


def test_changed_evidence_is_said(bundle: Path) -> None:
    def change(files: dict[str, bytes]) -> None:
        files["run/preflight.json"] = files["run/preflight.json"].replace(b"1a2b", b"1a2c")

    rewrite(bundle, change)
    said = result("reproduce", bundle, expect=3)
    assert (said["same"], said["complete"]) == (True, False)
    words = command("reproduce", bundle, "--out", "again", expect=3).words
    assert "SAME as far as it could be computed, and not whole: 1 CHANGED (above)." in words
    assert "preflight.json was changed" in words


def test_a_certificate_without_recordings_is_no_loss(bundle: Path) -> None:
    said = result("reproduce", bundle)
    assert (said["same"], said["complete"]) == (True, True)
    assert said["compared"][2]["differences"] is None


def test_a_drop_whose_evaluation_is_refused_is_not_whole(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Refused in the same words then and now."""

    def refuse(*_: Any, **__: Any) -> None:
        raise TfsatError(what="It ends at the release.", meaning="Nothing.", next_step="Another one.")

    monkeypatch.setattr("tfsat_host.run.evaluated.evaluate_run", refuse)
    command("bundle", "run", expect=3)
    said = result("reproduce", "run.tfsat.zip", expect=3)
    assert (said["same"], said["complete"]) == (True, False)
    assert "It ends at the release." in said["compared"][0]["sentence"]
    words = command("reproduce", "run.tfsat.zip", "--out", "again", expect=3).words
    assert "Evaluation: REFUSED. The drop cannot be evaluated, now as then: It ends at the release." in words
    assert words.count("LOST when bundled") == 1 == words.count("LOST (above)") and "same" not in words


@pytest.fixture
def not_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    """An evaluation that takes no time."""
    monkeypatch.setattr(
        "tfsat_host.run.bundle.recomputing.recompute", lambda *_: Recomputed({"a": [1.0]}, None, None)
    )


@pytest.mark.usefixtures("not_computed")
@pytest.mark.parametrize("data", [None, b"", b"\xff", b"[" * 100_000])
def test_an_evaluation_that_is_none_is_said_in_words(bundle: Path, data: bytes | None) -> None:
    def change(files: dict[str, bytes]) -> None:
        if data is None:
            del files["evaluation.json"]
        else:
            files["evaluation.json"] = data

    rewrite(bundle, change)
    (one,) = result("reproduce", bundle, expect=3)["compared"][0]["differences"]
    assert (one["key"], one["recomputed"]) == ("evaluation.json", "an evaluation")
    words = command("reproduce", bundle, "--out", "again", expect=3).words
    assert "The bundle has no evaluation" in words or "The bundled evaluation cannot be read" in words
    assert "None" not in words


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("report.html", "it can be made anew"),
        ("run/notes.txt", "The raw log run/SD.bin is whole"),
        ("run/SD.bin", "decode uses every block of it that is whole"),
    ],
)
def test_a_flipped_bit_says_what_is_still_good(bundle: Path, name: str, expected: str) -> None:
    data = bytearray(bundle.read_bytes())
    with zipfile.ZipFile(bundle) as opened:
        at = opened.getinfo(name).header_offset + 30 + len(name) + 10
    data[at] ^= 0x10
    bundle.write_bytes(data)
    said = command("reproduce", bundle, expect=1)
    err = " ".join(said.err.split())
    assert f"1 of 11 files in {bundle} is not what its manifest says: {name}." in err
    assert expected in err and "Nothing was unpacked." in err
    assert f"unzip {bundle} -d rescued" in err and "tfsat-host bundle rescued/run" in err
    assert not Path("run-reproduced").exists()


def test_the_help_names_the_folder(capsys: pytest.CaptureFixture[str]) -> None:
    from tfsat_host.cli.main import main

    with pytest.raises(SystemExit):
        main(["reproduce", "--help"])
    assert "NAME-reproduced" in capsys.readouterr().out


def test_what_was_changed_before_it_was_bundled_stays_said(run: Path) -> None:
    """Also by a bundle from which the record was taken out."""
    (run / "preflight.json").write_text("{}")
    command("bundle", "run", expect=3)

    def change(files: dict[str, bytes]) -> None:
        manifest = json.loads(files["manifest.json"])
        assert manifest["record"]
        del files["run/record.json"]

    rewrite(Path("run.tfsat.zip"), change)
    said = result("reproduce", "run.tfsat.zip", expect=3)
    assert said["complete"] is False and "preflight.json was changed" in said["record"][0]
