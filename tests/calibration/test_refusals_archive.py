"""Recordings and certificates on disk that are not what they were: refused before anything rests on them."""

from __future__ import annotations

import itertools
import time
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.calibration.bench_day import (
    MODEL,
    REST,
    SWINGS,
    ZERO,
    change_counts,
    later,
    record_good_step,
    slip_sensor,
    true_rotation,
)
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.certificate.calibration_campaign import Campaign, note_landing
from tfsat_host.calibration.certificate.certificate import Landing, Subject
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.calibration.steps.evidence import file_name, from_bytes, to_bytes
from tfsat_host.file_lock import one_at_a_time

SUBJECT = Subject(
    "Drop-tower robot",
    record_good_step(REST).origin.logger_serial,
    record_good_step(REST).origin.who_am_i,
    emulated=True,
)


@pytest.fixture
def certificate(tmp_path: Path) -> Path:
    """Create a certificate from a rest, a zero and the swings of joint 1."""
    path = tmp_path / "calibration.toml"
    campaign = Campaign(path, MODEL, SUBJECT)
    for step in (REST, ZERO, *SWINGS[:2]):
        campaign.accept(record_good_step(step))
    return path


def recording_path(certificate: Path) -> Path:
    return certificate.with_name("calibration-recordings") / file_name(record_good_step(ZERO))


def test_what_was_kept_is_read_back(certificate: Path) -> None:
    campaign = Campaign(certificate, MODEL, SUBJECT)
    assert [evidence.step for evidence in campaign.evidence] == [REST, ZERO, *SWINGS[:2]]
    for evidence in campaign.evidence:
        assert np.array_equal(evidence.counts.imu_counts, record_good_step(evidence.step).counts.imu_counts)


@pytest.mark.parametrize(("image", "expected_image"), [("10660001", "10660001"), ("00000000", None)])
def test_the_image_that_the_logger_ran_is_kept(
    certificate: Path, image: str, expected_image: str | None
) -> None:
    """Keep the CRC of the logger's image in the certificate.

    A core that runs natively has no image: its CRC is all zeros.
    """
    step = record_good_step(SWINGS[2])
    Campaign(certificate, MODEL, SUBJECT).accept(replace(step, origin=replace(step.origin, image_crc=image)))
    assert read_calibration(certificate).logger_image == expected_image


def test_a_refused_step_changes_nothing(certificate: Path) -> None:
    before = {path: path.read_bytes() for path in certificate.parent.rglob("*") if path.is_file()}
    campaign = Campaign(certificate, MODEL, SUBJECT)
    with pytest.raises(CalibrationError, match="measured two axes"):
        campaign.accept(change_counts(record_good_step(SWINGS[2]), slip_sensor(2, (0.0, 0.0, 5.0))))
    # Refused before anything was written: every file is as before.
    assert {path: path.read_bytes() for path in certificate.parent.rglob("*") if path.is_file()} == before
    assert len(campaign.evidence) == 4


def test_a_recording_that_is_gone_counts_no_more(certificate: Path) -> None:
    """And the campaign goes on: a lost file must not cost the other steps."""
    recording_path(certificate).unlink()
    campaign = Campaign(certificate, MODEL, SUBJECT)
    assert campaign.left_out[0].endswith("of this calibration does not exist.")
    calibration = campaign.accept(record_good_step(SWINGS[2]))
    # The lost step is missing from the certificate, not the others.
    assert [recording.step for recording in calibration.recordings] == [
        step.key for step in (REST, SWINGS[0], SWINGS[1], SWINGS[2])
    ]
    assert calibration.joints[0].zero_recorded_at is None
    assert Campaign(certificate, MODEL, SUBJECT).left_out == ()


def test_a_recording_that_was_changed_counts_no_more(certificate: Path) -> None:
    other = change_counts(record_good_step(ZERO), lambda counts: replace(counts, samples_lost=1))
    recording_path(certificate).write_bytes(to_bytes(other))
    campaign = Campaign(certificate, MODEL, SUBJECT)
    assert "its SHA-256 differs" in campaign.left_out[0]
    assert ZERO not in [evidence.step for evidence in campaign.evidence]


def test_a_step_that_was_recorded_before_the_one_it_would_replace(certificate: Path) -> None:
    before = certificate.read_bytes()
    with pytest.raises(CalibrationError, match="the computer's clock was set back") as caught:
        # Dated an hour before the recording that it would replace.
        Campaign(certificate, MODEL, SUBJECT).accept(later(record_good_step(ZERO), -60))
    assert "--out" in caught.value.next_step
    assert certificate.read_bytes() == before


def test_two_programs_at_one_certificate_lose_nothing(certificate: Path) -> None:
    """Lose nothing when two programs change one certificate.

    One waits at its prompt while the other adds a step, and decode notes a landing.
    """
    # Both commands hold the certificate open at the same time.
    waiting, other = (Campaign(certificate, MODEL, SUBJECT) for _ in range(2))
    other.accept(record_good_step(SWINGS[2]))
    # The other command decodes a drop meanwhile and notes its landing.
    assert note_landing(
        certificate, Landing(record_good_step(SWINGS[2]).recorded_at + timedelta(minutes=1), "recording 1")
    )
    calibration = waiting.accept(record_good_step(SWINGS[3]))
    assert {recording.step for recording in calibration.recordings} >= {SWINGS[2].key, SWINGS[3].key}
    assert [landing.told_by for landing in calibration.landings] == ["recording 1"]
    # No lock is left behind.
    assert not list(certificate.parent.glob(".*"))


def test_a_writer_that_was_killed_does_not_stop_the_next_one(certificate: Path) -> None:
    """However short ago: it may have been this very step that was begun again."""
    lock = certificate.with_name(".calibration.toml.lock")
    # A lock of a process that no longer runs.
    lock.touch()
    Campaign(certificate, MODEL, SUBJECT).accept(record_good_step(SWINGS[2]))
    assert not lock.exists()


def test_a_step_that_another_program_does_not_let_in_is_not_kept(
    certificate: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = certificate.read_bytes()
    campaign = Campaign(certificate, MODEL, SUBJECT)
    with one_at_a_time(certificate.with_name(".calibration.toml.lock"), "it"):
        # An hour passes at each look at the clock: the wait for the lock ends at once.
        hours_s = itertools.count(step=3600)
        monkeypatch.setattr(time, "monotonic", lambda: next(hours_s))
        with pytest.raises(CalibrationError, match="has been writing the calibration") as caught:
            campaign.accept(record_good_step(SWINGS[2]))
    assert str(certificate) in caught.value.what
    assert caught.value.meaning == "Nothing was changed by this command. No step was kept."
    assert "run this command again" in caught.value.next_step
    assert certificate.read_bytes() == before


def test_a_certificate_behind_a_link(certificate: Path) -> None:
    link = certificate.with_name("link.toml")
    link.symlink_to(certificate)
    written_before = certificate.read_bytes()
    assert note_landing(
        link, Landing(record_good_step(ZERO).recorded_at + timedelta(minutes=90), "recording 1")
    )
    # A link is kept, and its target is written.
    assert link.is_symlink()
    assert certificate.read_bytes() != written_before
    assert b"recording 1" in certificate.read_bytes()


def test_a_certificate_of_another_robot(certificate: Path) -> None:
    another = replace(SUBJECT, logger_serial="00" * 8)
    with pytest.raises(CalibrationError) as caught:
        Campaign(certificate, MODEL, another)
    assert "holds another calibration" in caught.value.what
    assert "--out" in caught.value.next_step
    assert "--force" in caught.value.next_step
    # --force begins anew for this robot.
    assert Campaign(certificate, MODEL, another, force=True).evidence == []
    assert len(Campaign(certificate, MODEL, SUBJECT, force=True).evidence) == 4


def test_the_same_evidence_gives_the_same_bytes_and_comes_back() -> None:
    data = to_bytes(record_good_step(ZERO))
    assert data == to_bytes(record_good_step(ZERO))
    again = from_bytes(data, source="a file")
    assert again.step == ZERO
    assert again.origin == record_good_step(ZERO).origin
    assert to_bytes(again) == data


@pytest.mark.parametrize("size", [0, 10, -100])
def test_a_recording_cut_short(size: int) -> None:
    with pytest.raises(CalibrationError) as caught:
        from_bytes(to_bytes(record_good_step(ZERO))[:size], source="zero.npz")
    assert caught.value.what.startswith("zero.npz is no recording of a calibration step, or it is damaged")
    assert "repeat the step" in caught.value.next_step


def test_a_recording_with_a_byte_that_flipped() -> None:
    data = bytearray(to_bytes(record_good_step(ZERO)))
    # One bit in the middle of the archive.
    data[len(data) // 2] ^= 0x10
    with pytest.raises(CalibrationError, match=r"zero\.npz is no recording"):
        from_bytes(bytes(data), source="zero.npz")


def test_another_archive_of_arrays(tmp_path: Path) -> None:
    path = tmp_path / "other.npz"
    np.savez(path, papers=np.arange(3))
    with pytest.raises(CalibrationError, match="is no recording"):
        from_bytes(path.read_bytes(), source="other.npz")


def test_a_sensor_that_was_moved_can_be_measured_anew(certificate: Path) -> None:
    """Measure a moved sensor anew.

    It moved so far that the old directions, however uncertain, must not be weighed in.
    """
    slip = slip_sensor(2, (0.0, 0.0, 12.0))
    again = [change_counts(later(record_good_step(step), 60), slip) for step in (REST, *SWINGS[:4])]
    campaign = Campaign(certificate, MODEL, SUBJECT)
    campaign.accept(record_good_step(SWINGS[2]))
    before = np.sqrt(np.diag(campaign.solution().gyros[1].covariance)[3:6])
    campaign.accept(again[0])
    # The solve sees the contradiction and names the cure.
    with pytest.raises(CalibrationError, match="--anew"):
        campaign.accept(again[2])
    # The person says so: what was measured before is no longer about this sensor.
    campaign.sensors_moved(again[0].recorded_at - timedelta(seconds=1))
    calibration = [campaign.accept(evidence) for evidence in again[1:]][-1]
    assert [landing.told_by for landing in calibration.landings] == ["a person: sensors were moved"]
    assert not any("misalignment of body 2" in gap.name for gap in calibration.shortcomings())
    gyro = calibration.gyros[1]
    # Twelve degrees are the slip itself.
    moved = Rotation.from_matrix(true_rotation(2).T @ gyro.rotation).magnitude()
    assert np.rad2deg(moved) == pytest.approx(12.0, abs=0.5)
    # Known as well as before: within a factor of two.
    assert np.sqrt(np.diag(gyro.covariance)[3:6]) == pytest.approx(before, rel=1.0)


def test_every_certificate_that_was_written_stays(certificate: Path) -> None:
    """Keep every certificate that was written.

    A drop is evaluated by the one valid when it fell, whatever was measured since.
    """
    folder = certificate.with_name("calibration-recordings")
    last = max(folder.glob("certificate-*.toml"))
    assert last.read_bytes() == certificate.read_bytes()
    Campaign(certificate, MODEL, SUBJECT).accept(later(record_good_step(ZERO), 60))
    assert last.read_bytes() != certificate.read_bytes()
    assert note_landing(
        certificate, Landing(record_good_step(ZERO).recorded_at + timedelta(minutes=90), "recording 1")
    )
    newest_certificate = max(folder.glob("certificate-*.toml"))
    assert newest_certificate.read_bytes() == certificate.read_bytes()
    assert b"recording 1" in newest_certificate.read_bytes()
