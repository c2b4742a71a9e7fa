"""Which certificate a recording is held against, and what its landing does to the one that lies there."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from tests.calibration.some_calibration import SUBJECT
from tests.cli.certified import (
    DROPPED,
    HOUR,
    MEASURED,
    certificate,
    join_sentences,
    whole_calibration,
    write_drop,
)
from tests.cli.process import RunCli
from tfsat_host.calibration.certificate.certificate import Calibration, Landing, with_landing
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.calibration.certificate.recordings_archive import certificate_for, measured_after
from tfsat_host.run.certificate_check import check_certificate

FILE = Path("calibration.toml")
COPIED = DROPPED + 2 * HOUR


def timeless(folder: Path, copied: datetime = COPIED) -> Path:
    """Write a drop whose recording has no time of day, in a file of that date."""
    log = write_drop(folder, at=None)
    # The date of the file is all that tells when it was recorded.
    os.utime(log, (copied.timestamp(),) * 2)
    return log


def archive_certificate(folder: Path, calibration: Calibration, written: datetime) -> Path:
    """Write an earlier certificate into the archive of recordings."""
    archive = folder / "calibration-recordings"
    archive.mkdir(exist_ok=True)
    return certificate(
        archive, replace(calibration, written=written), f"certificate-{written:%Y%m%dT%H%M%S.%f}.toml"
    )


def test_without_a_time_of_day_nobody_knows_whether_the_calibration_is_older(tfsat_host: RunCli) -> None:
    file = certificate(tfsat_host.folder, whole_calibration())
    log = timeless(tfsat_host.folder)
    process = tfsat_host("decode", log)
    assert "valid for this recording" not in process.stderr
    assert "not known whether the calibration is older or newer than this fall" in process.stderr
    assert "record start" in process.stderr
    assert "knows of the landing at 2024-07-01 12:30:00 UTC (by its file, at the latest" in process.stderr
    (landing,) = read_calibration(file).landings
    assert landing == Landing(COPIED, "recording 1234abcd, which has no time of day: by its file")
    assert tfsat_host.json("calibrate", "show")["ready"] is False
    os.utime(log, (COPIED.timestamp() + 86400,) * 2)
    again = tfsat_host.json("decode", log)
    # Copied a day later: it is the same landing.
    assert read_calibration(file).landings == (landing,), "it landed once, however often it is decoded"
    assert again["calibration"]["usable"] is False
    (sentence,) = again["calibration"]["sentences"]
    assert sentence.startswith("The recording has no time of day"), "its own landing is no objection"


def test_without_a_time_of_day_every_other_landing_counts(tfsat_host: RunCli) -> None:
    file = certificate(tfsat_host.folder, with_landing(whole_calibration(), Landing(DROPPED, "a test")))
    result = tfsat_host.json("decode", timeless(tfsat_host.folder))
    assert join_sentences(result).startswith("Measured before the last landing")
    assert "The recording has no time of day" in join_sentences(result)
    assert len(read_calibration(file).landings) == 2


@pytest.mark.parametrize("copied", [datetime(1980, 1, 1, tzinfo=UTC), datetime(2099, 1, 1, tzinfo=UTC)])
def test_a_file_whose_date_says_nothing_landed_by_now(tfsat_host: RunCli, copied: datetime) -> None:
    began = datetime.now(UTC)
    file = certificate(tfsat_host.folder, whole_calibration())
    tfsat_host("decode", timeless(tfsat_host.folder, copied))
    (landing,) = read_calibration(file).landings
    # The date of the file is absurd: the landing is put to now, at the latest.
    assert began - timedelta(seconds=1) <= landing.at <= datetime.now(UTC)
    assert landing.told_by.endswith("by the clock")


def test_the_certificate_of_the_drop_is_found_among_the_recordings(tfsat_host: RunCli) -> None:
    """Dropped, measured again, decoded again: by what held when it fell."""
    here = tfsat_host.folder
    archive_certificate(here, whole_calibration(), MEASURED)
    mine = archive_certificate(here, whole_calibration(), MEASURED + HOUR / 2)
    archive_certificate(
        # Of another logger, and written later: it must not be taken.
        here,
        whole_calibration(subject=replace(SUBJECT, logger_serial="00c0ffee")),
        DROPPED - HOUR / 4,
    )
    # Measured after the drop: it did not hold then.
    archive_certificate(here, whole_calibration(measured_at=DROPPED + HOUR), DROPPED + HOUR)
    (here / "calibration-recordings" / "certificate-of-mine.toml").write_text("")
    present = certificate(here, whole_calibration(measured_at=DROPPED + HOUR))
    result = tfsat_host.json("decode", write_drop(here))
    assert result["calibration"] == {"file": str(mine), "usable": True, "shortcomings": [], "sentences": []}
    process = tfsat_host("decode", write_drop(here))
    assert f"{present} was measured again after this fall: {mine} is the certificate" in process.stderr
    assert f"{mine} (valid for this recording)" in process.stderr
    assert len(read_calibration(present).landings) == 1
    # A kept certificate stays as it was written.
    assert read_calibration(mine).landings == (), "what was written once stays as it was"


def test_a_kept_certificate_knows_of_the_landings_since(tfsat_host: RunCli) -> None:
    """Apply later landings to a kept certificate.

    A landing between its last step and this fall may be noted after the certificate was kept.
    """
    here = tfsat_host.folder
    mine = archive_certificate(here, whole_calibration(), MEASURED)
    anew = with_landing(whole_calibration(measured_at=DROPPED + HOUR), Landing(MEASURED + HOUR / 2, "a test"))
    certificate(here, anew)
    result = tfsat_host.json("decode", write_drop(here))
    assert result["calibration"]["file"] == str(mine)
    assert join_sentences(result).startswith("Measured before the last landing")
    assert result["calibration"]["shortcomings"][0]["command"] == "tfsat-host calibrate bias"


def test_a_kept_certificate_that_is_damaged_is_passed_over_with_a_warning(tfsat_host: RunCli) -> None:
    here = tfsat_host.folder
    mine = archive_certificate(here, whole_calibration(), MEASURED)
    newer = archive_certificate(here, whole_calibration(), MEASURED + HOUR / 2)
    newer.write_text("nonsense")
    certificate(here, whole_calibration(measured_at=DROPPED + HOUR))
    process = tfsat_host("decode", write_drop(here))
    assert f"Warning: {newer}: is not valid TOML" in process.stderr
    assert f"{mine} (valid for this recording)" in process.stderr


def test_certificate_for_takes_the_present_one_unless_something_in_it_is_too_young(tmp_path: Path) -> None:
    landed = DROPPED + timedelta(seconds=3)
    archive_certificate(tmp_path, whole_calibration(), MEASURED)
    present = certificate(tmp_path, whole_calibration())
    assert certificate_for(present, DROPPED, landed).path == present
    young = whole_calibration()
    young = replace(
        young, joints=(replace(young.joints[0], zero_recorded_at=landed + HOUR), *young.joints[1:])
    )
    certificate(tmp_path, young)
    assert certificate_for(present, DROPPED, landed).path.parent.name == "calibration-recordings"
    scaled = whole_calibration()
    scaled = replace(scaled, gyros=tuple(replace(gyro, scaled={"x": landed + HOUR}) for gyro in scaled.gyros))
    certificate(tmp_path, scaled)
    # Scale factors are of silicon: no landing changes them.
    assert certificate_for(present, DROPPED, landed).path == present, "no landing changes a scale factor"
    certificate(tmp_path, young)
    first = certificate_for(present, MEASURED - HOUR, MEASURED - HOUR)
    assert first.path == present, "nothing was written before"
    assert "zero point of joint 1" in measured_after(first.calibration, landed)


def test_what_was_measured_in_the_future_is_not_usable(tfsat_host: RunCli) -> None:
    certificate(tfsat_host.folder, whole_calibration(measured_at=datetime(2199, 1, 1, tzinfo=UTC)))
    result = tfsat_host.json("decode", timeless(tfsat_host.folder))
    assert result["calibration"]["usable"] is False
    assert "were measured in the future (2199-01-01 00:00 UTC)" in join_sentences(result)
    assert "the clock was wrong then or is now; landings cannot end it" in join_sentences(result)
    assert "tfsat-host calibrate bias --out" in join_sentences(
        result
    ) and "calibration-anew.toml" in join_sentences(result)


def test_one_quantity_of_the_future() -> None:
    calibration = whole_calibration()
    early = replace(
        calibration,
        joints=(replace(calibration.joints[0], zero_recorded_at=DROPPED), *calibration.joints[1:]),
    )
    (sentence,) = check_certificate(early, None, FILE, now=MEASURED + HOUR / 2).objections
    assert sentence.startswith("zero point of joint 1 was measured in the future (2024-07-01 10:30 UTC): ")
    assert sentence.endswith(": tfsat-host calibrate zero --joint 1 --out calibration-anew.toml")
    # Half a minute before: clocks may differ by as much.
    state = check_certificate(early, None, FILE, now=DROPPED - timedelta(seconds=30))
    assert state.objections == (), "clocks differ by seconds"


@contextmanager
def inside(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    with monkeypatch.context() as patched:
        patched.chdir(folder)
        yield


@pytest.mark.parametrize(
    ("emulated", "name", "options"),
    [
        (False, "calibration.toml", ""),
        (True, "calibration-emulated.toml", " --emulated"),
        (False, "my own.toml", " --out 'my own.toml'"),
        (True, "calibration.toml", " --out calibration.toml --emulated"),
    ],
)
def test_commands_can_be_typed_as_they_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, emulated: bool, name: str, options: str
) -> None:
    calibration = whole_calibration(subject=replace(SUBJECT, emulated=emulated))
    with inside(tmp_path, monkeypatch):
        landed = with_landing(calibration, Landing(DROPPED, "a test"))
        (sentence,) = check_certificate(landed, None, Path(name)).objections
    first, second = (f"tfsat-host calibrate {step}{options}" for step in ("bias", "zero --all"))
    assert f"To measure: {first}, {second}, " in sentence
