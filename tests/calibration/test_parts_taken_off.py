"""A part is taken off the robot, or put on: its certificate stays, and nothing else is measured again."""

from __future__ import annotations

from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest

from tests.calibration.bench_day import MODEL, REST, SWINGS, TURN, ZERO, day, later, record_good_step
from tests.calibration.test_replacements import NOON, SUBJECT, same_gyro
from tests.cli.process import RunCli
from tests.robot.fewer_parts import robot_text, smaller_robot
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.certificate.calibration_campaign import Campaign
from tfsat_host.calibration.certificate.certificate import Calibration, quantities
from tfsat_host.calibration.sensors.gyro import SCALE
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.robot import RobotModel
from tfsat_host.robot.absent_parts import fill_places

OF_BODY_4 = {
    "bias of body 4",
    *(f"misalignment of body 4 about {axis}" for axis in "xy"),
    *(f"scale factor {axis} of body 4" for axis in "xyz"),
}
SERVOS = {f"servo of joint {joint}" for joint in (1, 2, 3)}


@pytest.fixture
def whole(tmp_path: Path) -> Calibration:
    campaign = open_campaign(tmp_path, MODEL)
    for entry in day():
        campaign.accept(entry)
    assert campaign.calibration is not None
    return campaign.calibration


@pytest.fixture
def without_imu_4(tmp_path: Path) -> RobotModel:
    return fill_places(smaller_robot(tmp_path, without_imu=[4]))


def open_campaign(folder: Path, model: RobotModel, who: str = "68" * 4, *replaced: str) -> Campaign:
    return Campaign(folder / "calibration.toml", model, replace(SUBJECT, who_am_i=who), replaced=replaced)


def at(evidence: Evidence, hours: float) -> Evidence:
    return later(evidence, 60.0 * hours)


def lacking(campaign: Campaign) -> set[str]:
    assert campaign.calibration is not None
    return {entry.name for entry in quantities(campaign.calibration) if entry.measured_at is None}


@pytest.mark.parametrize("pins_read", ["68686868", "68686800"])
def test_an_imu_is_taken_off_and_all_others_keep_value_and_date(
    pins_read: str, whole: Calibration, without_imu_4: RobotModel, tmp_path: Path
) -> None:
    fewer = open_campaign(tmp_path, without_imu_4, pins_read)
    swing = next(step for step in SWINGS if step.moved == (1,))
    calibration = fewer.accept(at(record_good_step(swing), 10.0))
    for body in (1, 2, 3):
        before, after = whole.gyros[body - 1], calibration.gyros[body - 1]
        assert after.bias_recorded_at == before.bias_recorded_at
        assert after.scaled == before.scaled
        moved = np.abs(after.scale - before.scale) / np.sqrt(np.diag(before.covariance)[SCALE])
        assert moved.max() < 0.3
    assert [gyro.body for gyro in calibration.present_gyros] == [1, 2, 3]
    assert calibration.subject.who_am_i == "68686800"
    assert calibration.gyros[3].bias_recorded_at is None
    assert lacking(fewer) == SERVOS


def test_an_imu_is_put_on_and_measured(whole: Calibration, without_imu_4: RobotModel, tmp_path: Path) -> None:
    fewer = open_campaign(tmp_path, without_imu_4)
    for step in (REST, TURN):
        fewer.accept(at(record_good_step(step), 4.5))
    with pytest.raises(CalibrationError) as refused:
        open_campaign(tmp_path, MODEL)
    assert refused.value.what.endswith("holds another calibration: imu-4 was absent.")
    assert "tfsat-host calibrate replaced imu-4" in refused.value.next_step
    again = open_campaign(tmp_path, MODEL, "68" * 4, "imu-4")
    calibration = again.replace_parts(NOON + timedelta(hours=6))
    assert [same_gyro(whole, calibration, body) for body in (1, 2, 3)] == [False] * 3  # a newer rest and turn
    assert lacking(again) == OF_BODY_4 | SERVOS
    again.accept(at(record_good_step(REST), 12.0))
    again.accept(at(record_good_step(TURN), 12.0))
    assert lacking(again) == (OF_BODY_4 | SERVOS) - {"bias of body 4", "scale factor z of body 4"}


def test_a_body_is_taken_off(whole: Calibration, without_imu_4: RobotModel, tmp_path: Path) -> None:
    model = fill_places(smaller_robot(tmp_path, bodies=3))
    fewer = open_campaign(tmp_path, model, "68686800")
    calibration = fewer.accept(at(record_good_step(REST), 10.0))
    assert [sensors.joint for sensors in calibration.present_joints] == [1, 2]
    assert calibration.joints[1].zero_recorded_at == whole.joints[1].zero_recorded_at
    assert lacking(fewer) == SERVOS - {"servo of joint 3"}
    assert {entry.step.joint for entry in fewer.evidence} == {None, 1, 2}
    # Put on again without its IMU, and with it: what was measured of its joint before does not come back.
    with pytest.raises(CalibrationError, match="angle-3 was absent"):
        open_campaign(tmp_path, without_imu_4)
    with pytest.raises(CalibrationError) as refused:
        open_campaign(tmp_path, MODEL)
    assert "tfsat-host calibrate replaced imu-4 angle-3" in refused.value.next_step
    again = open_campaign(tmp_path, MODEL, "68" * 4, "imu-4", "angle-3")
    again.replace_parts(NOON + timedelta(hours=8))
    assert lacking(again) == OF_BODY_4 | SERVOS | {"zero point of joint 3"}
    again.accept(at(record_good_step(ZERO), 16.0))
    assert lacking(again) == OF_BODY_4 | SERVOS


def test_what_is_to_be_typed_first_for_a_part_that_was_put_on_is_shown(tfsat_host: RunCli) -> None:
    """Each step that `calibrate show` names would be refused before it."""
    text = robot_text(without_imu=[2]).replace("smaller robot", MODEL.name)
    (tfsat_host.folder / "small.toml").write_text(text, encoding="utf-8")
    tfsat_host("calibrate", "bias", "--emulated", "--yes", "--robot", "small.toml")
    shown = tfsat_host("calibrate", "show", "--emulated").stdout
    first, second = shown[shown.index("To measure:") :].splitlines()[1:3]
    assert first == "  tfsat-host calibrate replaced imu-2 --emulated (put on since), then"
    assert "To measure:\n  tfsat-host calibrate bias" in tfsat_host(*first.split()[1:5]).stdout
    tfsat_host(*second.split()[1:], "--yes")
