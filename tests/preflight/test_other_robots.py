"""The robot is not the one that was calibrated, or not as it was then; or a drop has been since."""

from __future__ import annotations

from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.preflight.ready_robot import TRUTH, ReadyRobot, check, found_wrong, not_made, ready_robot
from tfsat_host.calibration.certificate.certificate import Landing
from tfsat_host.emulated.imperfections import Imperfections
from tfsat_host.protocol.enums import DropPhase

BY_CERTIFICATE = {"gyros-agree", "joint-sensors", "start-pose"}
"""What takes a calibration of these sensors."""


def _more_bias(body: int, axis: int, deg_s: float) -> Imperfections:
    bias = TRUTH.gyro_bias_rad_s.copy()
    # Of one axis only.
    bias[body, axis] += np.deg2rad(deg_s)
    return replace(TRUTH, gyro_bias_rad_s=bias)


def _turned_imu() -> Imperfections:
    mounting = TRUTH.mounting.copy()
    # Loose on its body: turned by 20 deg about the first axis.
    mounting[3] = Rotation.from_rotvec([np.deg2rad(20.0), 0.0, 0.0]).as_matrix() @ mounting[3]
    return replace(TRUTH, mounting=mounting)


TREMBLING = replace(TRUTH, gyro_noise_rad_s_rthz=np.deg2rad(0.3))
ABSURD = _more_bias(2, 1, 27.0)
"""More than the data sheet allows, even if it was calibrated so."""


@pytest.mark.parametrize(
    ("truth", "certified", "red", "words"),
    [
        pytest.param(
            TREMBLING, TREMBLING, "gyros-still", "rate scatter 2.4 deg/s (limit 1 deg/s)", id="trembles"
        ),
        pytest.param(ABSURD, ABSURD, "gyro-biases", "body 3", id="absurd bias"),
        # Calibrated as it was before.
        pytest.param(_more_bias(1, 0, 0.8), TRUTH, "gyros-agree", "body 2", id="other bias"),
        pytest.param(_turned_imu(), TRUTH, "gyros-agree", "body 4", id="turned"),
    ],
)
def test_a_robot_that_is_not_the_calibrated_one(
    truth: Imperfections,
    certified: Imperfections,
    red: str,
    words: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    with ready_robot(tmp_path / "other", monkeypatch, capsys, truth, certified) as ready:
        result = ready.preflight(expect=4)
    assert found_wrong(result) == {red}
    assert words in check(result, red)["sentence"]


def test_a_certificate_of_another_robot(ready: ReadyRobot) -> None:
    subject = replace(ready.calibration.subject, logger_serial="0123456789abcdef")
    ready.certify(replace(ready.calibration, subject=subject))
    result = ready.preflight(expect=4)
    assert (found_wrong(result), not_made(result)) == ({"calibration"}, BY_CERTIFICATE)
    assert "0123456789abcdef" in check(result, "calibration")["sentence"]


@pytest.mark.parametrize("text", [None, "nonsense"])
def test_no_certificate_that_could_be_read(ready: ReadyRobot, text: str | None) -> None:
    file = ready.folder / "calibration-emulated.toml"
    # Gone, or something else.
    file.unlink() if text is None else file.write_text(text, encoding="utf-8")
    result = ready.preflight(expect=4)
    assert (found_wrong(result), not_made(result)) == ({"calibration"}, BY_CERTIFICATE)


def test_a_landing_that_only_the_logger_knows_of(ready: ReadyRobot) -> None:
    """And it goes on knowing: a recording of the preflight's own would make it forget."""
    logger = ready.logger()
    # Recorded ten minutes after the certificate was written.
    logger.set_clock(round(1e6 * ready.calibration.written.timestamp()) + 600_000_000)
    logger.start_recording()
    logger.wait_for_card()
    ready.sequencer().arm()
    ready.robot.drop()
    while ready.robot.falling:
        ready.robot.advance(10_000)
    ready.robot.advance(2_000_000)
    logger.stop_recording()
    ready.sequencer().disarm()
    ready.robot.seat()
    ready.robot.advance(3_000_000)
    # Twice: the first preflight must not use up what the second needs.
    for _ in range(2):
        result = ready.preflight(expect=4)
        assert (found_wrong(result), not_made(result)) == ({"calibration"}, {"card-writing"})
    assert ready.logger().status().phase == DropPhase.LANDED
    landed = ready.calibration.written + timedelta(minutes=11)
    # A certificate that names the landing, but whose measurements were made before it.
    again = landed + timedelta(minutes=10)
    fresh = replace(ready.calibration, landings=(Landing(landed, "recording"),), written=again)
    ready.certify(fresh)
    assert found_wrong(ready.preflight(expect=4)) == {"calibration"}, "known, and what was measured is older"


def test_a_drop_that_only_ram_has(ready: ReadyRobot) -> None:
    logger = ready.logger()
    logger.start_recording()
    logger.wait_for_card()
    ready.sequencer().arm()
    ready.robot.drop()
    ready.robot.advance(1_000_000)
    # In the fall: what came until then is on the card, the rest in RAM.
    ready.robot.card_slot.remove()
    while ready.robot.falling:
        ready.robot.advance(10_000)
    ready.robot.advance(40_000_000)
    ready.robot.card_slot.insert()
    ready.sequencer().disarm()
    ready.robot.seat()
    ready.robot.advance(10_000_000)
    assert ready.logger().status().ram_holds_drop
    result = ready.preflight(expect=4)
    assert "ram" in found_wrong(result) and "card-writing" in not_made(result)
    assert ready.logger().status().ram_holds_drop, "and it was not cost by the preflight"
