"""The robot is not the one that was calibrated, or not as it was then; or a drop has been since."""

from __future__ import annotations

from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.preflight.morning import TRUTH, Morning, check, found_wrong, morning_of, not_made
from tfsat_host.calibration.certificate.certificate import Landing
from tfsat_host.protocol.enums import DropPhase

BY_CERTIFICATE = {"gyros-agree", "joint-sensors", "start-pose"}
"""What takes a calibration of these sensors."""


def other_robot(
    truth: Any,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    **certified: Any,
) -> tuple[set[str], set[str]]:
    with morning_of(tmp_path / "other", monkeypatch, capsys, truth, **certified) as morning:
        result = morning.preflight(expect=4)
    return found_wrong(result), not_made(result)


def test_a_robot_that_trembles(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shaken = replace(TRUTH, gyro_noise_rad_s_rthz=np.deg2rad(0.3))
    with morning_of(tmp_path / "other", monkeypatch, capsys, shaken) as morning:
        result = morning.preflight(expect=4)
    assert found_wrong(result) == {"gyros-still"}
    assert "turns to and fro by" in check(result, "gyros-still")["sentence"]


def test_a_gyro_off_by_more_than_its_data_sheet_allows_even_if_it_was_calibrated_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    bias = TRUTH.gyro_bias_rad_s.copy()
    bias[2, 1] = np.deg2rad(27.0)
    absurd = replace(TRUTH, gyro_bias_rad_s=bias)
    assert other_robot(absurd, tmp_path, monkeypatch, capsys) == ({"gyro-biases"}, set())


@pytest.mark.parametrize("what", ["bias", "mounting"])
def test_a_gyro_that_is_not_any_more_what_was_calibrated(
    what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if what == "bias":
        bias = TRUTH.gyro_bias_rad_s.copy()
        bias[1, 0] += np.deg2rad(0.8)
        changed = replace(TRUTH, gyro_bias_rad_s=bias)
    else:
        mounting = TRUTH.mounting.copy()
        mounting[3] = Rotation.from_rotvec([np.deg2rad(20.0), 0.0, 0.0]).as_matrix() @ mounting[3]
        changed = replace(TRUTH, mounting=mounting)
    found = other_robot(changed, tmp_path, monkeypatch, capsys, certified=TRUTH)
    assert found == ({"gyros-agree"}, set())


def test_a_certificate_of_another_robot(morning: Morning) -> None:
    subject = replace(morning.calibration.subject, logger_serial="0123456789abcdef")
    morning.certify(replace(morning.calibration, subject=subject))
    result = morning.preflight(expect=4)
    assert (found_wrong(result), not_made(result)) == ({"calibration"}, BY_CERTIFICATE)
    assert "0123456789abcdef" in check(result, "calibration")["sentence"]


@pytest.mark.parametrize("text", [None, "nonsense"])
def test_no_certificate_that_could_be_read(morning: Morning, text: str | None) -> None:
    file = morning.folder / "calibration-emulated.toml"
    file.unlink() if text is None else file.write_text(text, encoding="utf-8")
    result = morning.preflight(expect=4)
    assert (found_wrong(result), not_made(result)) == ({"calibration"}, BY_CERTIFICATE)


def test_a_landing_that_only_the_logger_knows_of(morning: Morning) -> None:
    """And it goes on knowing: a recording of the preflight's own would make it forget."""
    logger = morning.logger()
    logger.set_clock(round(1e6 * morning.calibration.written.timestamp()) + 600_000_000)
    logger.start_recording()
    logger.wait_for_card()
    morning.sequencer().arm()
    morning.robot.drop()
    while morning.robot.falling:
        morning.robot.advance(10_000)
    morning.robot.advance(2_000_000)
    logger.stop_recording()
    morning.sequencer().disarm()
    morning.robot.seat()
    morning.robot.advance(3_000_000)
    for _ in range(2):
        result = morning.preflight(expect=4)
        assert (found_wrong(result), not_made(result)) == ({"calibration"}, {"card-writing"})
    assert morning.logger().status().phase == DropPhase.LANDED
    landed = morning.calibration.written + timedelta(minutes=11)
    again = landed + timedelta(minutes=10)
    fresh = replace(morning.calibration, landings=(Landing(landed, "recording"),), written=again)
    morning.certify(fresh)
    assert found_wrong(morning.preflight(expect=4)) == {"calibration"}, (
        "known, and what was measured is older"
    )


def test_a_drop_that_only_ram_has(morning: Morning) -> None:
    logger = morning.logger()
    logger.start_recording()
    logger.wait_for_card()
    morning.sequencer().arm()
    morning.robot.drop()
    morning.robot.advance(1_000_000)
    morning.robot.card_slot.remove()
    while morning.robot.falling:
        morning.robot.advance(10_000)
    morning.robot.advance(40_000_000)
    morning.robot.card_slot.insert()
    morning.sequencer().disarm()
    morning.robot.seat()
    morning.robot.advance(10_000_000)
    assert morning.logger().status().ram_holds_drop
    result = morning.preflight(expect=4)
    assert "ram" in found_wrong(result) and "card-writing" in not_made(result)
    assert morning.logger().status().ram_holds_drop, "and it was not cost by the preflight"
