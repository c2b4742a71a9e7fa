"""A run, and the bundle of it, made once and copied."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from shutil import copyfile

import pytest

from tests.calibration.bench_day import MODEL, REST, SWINGS, ZERO, record_good_step
from tests.evaluation.run_folder import CERTIFICATE, change_headers, run_folder
from tests.run.bundle.commands import command, keep_evaluations
from tfsat_host.calibration.certificate.calibration_campaign import Campaign
from tfsat_host.calibration.certificate.certificate import Subject
from tfsat_host.run.bundle.making import RecomputedEvaluation
from tfsat_host.run.signed_record import sign

# The only source of the sequencer's firmware: a recording names the logger's alone.
PREFLIGHT = '{"go": true, "boards": {"sequencer": {"firmware": "0.1.0", "image_crc": "1a2b3c4d"}}}\n'
PAGE = '<script type="application/json" id="document">{"a": 1.0}</script>'
# Gyros at rest (biases), joints at zero, one swing (misalignment): three recordings to solve and compare.
STEPS = (REST, ZERO, SWINGS[0])


def signed_run(folder: Path) -> None:
    """Create a drop with all its documents, signed."""
    run_folder(folder)
    (folder / "preflight.json").write_text(PREFLIGHT)
    (folder / "notes.txt").write_text("wind from the west\n")
    # What decode wrote: a bundle leaves it out.
    (folder / "SD.csv").write_text("decoded\n")
    # Half an hour before the drop.
    at = datetime(2026, 1, 5, 8, 30, tzinfo=UTC)
    sign(folder, [folder / "preflight.json"], "tfsat-host preflight: GO", at)


@pytest.fixture(autouse=True)
def _kept_evaluations(monkeypatch: pytest.MonkeyPatch) -> None:
    keep_evaluations(monkeypatch)


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Create a signed drop in the folder `run` of the current folder."""
    monkeypatch.chdir(tmp_path)
    signed_run(tmp_path / "run")
    return tmp_path / "run"


@pytest.fixture
def undecodable_run(run: Path) -> Path:
    """Return a run whose recording cannot be decoded."""
    (run / "SD.bin").write_bytes(b"no recording" * 100)
    return run


@pytest.fixture
def fixed_evaluation(monkeypatch: pytest.MonkeyPatch) -> Callable[[str | None], None]:
    """Makes every evaluation this page and next to nothing else, at once."""

    # One number each: enough to compare, without the seconds of a real evaluation.
    def fix_evaluation(page: str | None) -> None:
        recomputation = RecomputedEvaluation({"a": [1.0]}, page, None)
        monkeypatch.setattr("tfsat_host.run.bundle.making.recompute", lambda *_: recomputation)

    return fix_evaluation


@pytest.fixture
def quick_run(run: Path, fixed_evaluation: Callable[[str | None], None]) -> Path:
    """Return a run whose evaluation takes no time."""
    fixed_evaluation(PAGE)
    return run


@pytest.fixture
def calibrated_run(quick_run: Path) -> Path:
    """Return a run with a certificate based on recordings and an evaluation that takes no time."""
    # The ready certificate is based on no recordings: a campaign writes another.
    (quick_run / CERTIFICATE).unlink()
    origin = record_good_step(REST).origin
    # The drop and the certificate's recordings come from the same logger.
    change_headers(quick_run / "SD.bin", board_serial=list(bytes.fromhex(origin.logger_serial)))
    subject = Subject(MODEL.name, origin.logger_serial, origin.who_am_i, origin.emulated)
    campaign = Campaign(quick_run / CERTIFICATE, MODEL, subject)
    for step in STEPS:
        campaign.accept(record_good_step(step))
    return quick_run


@pytest.fixture(scope="session")
def session_bundle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Create a bundle once per session, which must not be changed."""
    # A bundle evaluates the drop: made once for all tests that only read it.
    folder = tmp_path_factory.mktemp("bundle")
    with contextlib.chdir(folder), pytest.MonkeyPatch.context() as patch:
        keep_evaluations(patch)
        signed_run(folder / "run")
        command("bundle", "run")
    return folder / "run.tfsat.zip"


@pytest.fixture
def bundle(session_bundle: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Copy the bundle into the current folder."""
    monkeypatch.chdir(tmp_path)
    copyfile(session_bundle, tmp_path / "run.tfsat.zip")
    return tmp_path / "run.tfsat.zip"
