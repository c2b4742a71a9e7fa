"""A certificate in a bundle, computed anew from the recordings beside it."""

from __future__ import annotations

from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest

from tests.bundle.commands import result
from tests.bundle.rewritten import rewrite
from tests.calibration.bench_day import MODEL, REST, SWINGS, ZERO, done
from tests.evaluation.run_folder import CERTIFICATE, run_folder
from tfsat_host.calibration.certificate.campaign import Campaign, note_landing
from tfsat_host.calibration.certificate.certificate import Landing, Subject
from tfsat_host.calibration.certificate.file import format_calibration, read_calibration
from tfsat_host.calibration.steps.evidence import to_bytes

STEPS = (REST, ZERO, SWINGS[0])
RECORDINGS = f"run/{CERTIFICATE.removesuffix('.toml')}-recordings"


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A certificate that rests on recordings, beside a drop that cannot be evaluated: that would take its time."""
    monkeypatch.chdir(tmp_path)
    run_folder(tmp_path / "run")
    (tmp_path / "run" / "SD.bin").write_bytes(b"no recording" * 100)
    certificate = tmp_path / "run" / CERTIFICATE
    certificate.unlink()
    origin = done(REST).origin
    campaign = Campaign(
        certificate, MODEL, Subject(MODEL.name, origin.logger_serial, origin.who_am_i, origin.emulated)
    )
    for step in STEPS:
        campaign.accept(done(step))
    return tmp_path / "run"


def calibration_in(said: dict[str, list[dict[str, object]]]) -> dict[str, object]:
    return next(one for one in said["compared"] if one["what"] == "calibration")


def test_it_gives_the_same_values(run: Path) -> None:
    said = result("bundle", "run", expect=3)
    kept = [name for name in said["files"] if name.startswith(RECORDINGS)]
    assert sum(name.endswith(".npz") for name in kept) == len(STEPS)
    assert "raw data of the calibration" not in {one["what"] for one in said["missing"]}
    again = calibration_in(result("reproduce", "run.tfsat.zip", expect=3))
    assert again["differences"] == [] and "computed anew from 3 recordings" in str(again["sentence"])


def test_a_landing_that_was_noted_later_did_not_change_it(run: Path) -> None:
    """It was not known when the values were computed, though it lies before the last step."""
    between = done(REST).taken + timedelta(seconds=30)
    note_landing(run / CERTIFICATE, Landing(between, "recording 0000abcd"))
    note_landing(run / CERTIFICATE, Landing(between + timedelta(days=300), "recording 0000abce"))
    result("bundle", "run", expect=3)
    assert calibration_in(result("reproduce", "run.tfsat.zip", expect=3))["differences"] == []


def test_values_that_the_recordings_do_not_tell_are_named(run: Path) -> None:
    found = read_calibration(run / CERTIFICATE)
    bias = found.gyros[1].bias_rad_s + np.array([0.0, 1e-4, 0.0])
    gyros = (found.gyros[0], replace(found.gyros[1], bias_rad_s=bias), *found.gyros[2:])
    (run / CERTIFICATE).write_text(format_calibration(replace(found, gyros=gyros)))
    result("bundle", "run", expect=3)
    again = result("reproduce", "run.tfsat.zip", expect=3)
    differs = calibration_in(again)["differences"]
    assert isinstance(differs, list)
    assert [one["key"] for one in differs] == ["gyro[1].bias.value[1]"]


def test_recordings_that_are_gone_or_changed_are_lost(run: Path) -> None:
    rest, zero = (read_calibration(run / CERTIFICATE).papers[i].file for i in (0, 1))
    folder = run / Path(RECORDINGS).name
    (folder / rest).unlink()
    (folder / zero).write_bytes(to_bytes(done(SWINGS[0])))
    said = result("bundle", "run", expect=3)
    assert {one["what"] for one in said["missing"] if one["lost"]} == {
        f"{RECORDINGS}/{rest}",
        f"{RECORDINGS}/{zero}",
        "report.html",
    }
    again = calibration_in(result("reproduce", "run.tfsat.zip", expect=3))
    assert again["differences"] is None and rest in str(again["sentence"])


def test_a_recording_that_was_changed_in_the_bundle_does_not_pass(run: Path) -> None:
    """Not even with a manifest made to fit: the certificate names it by its hash."""
    result("bundle", "run", expect=3)

    def change(files: dict[str, bytes]) -> None:
        name = next(name for name in files if "zero" in name and name.endswith(".npz"))
        files[name] = to_bytes(replace(done(ZERO), tool_version="another"))

    rewrite(Path("run.tfsat.zip"), change)
    again = calibration_in(result("reproduce", "run.tfsat.zip", expect=3))
    assert again["differences"] is None and "SHA-256 differs" in str(again["sentence"])
