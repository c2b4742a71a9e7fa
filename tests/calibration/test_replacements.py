"""A part of the robot is replaced: what rests on it ends, all else holds with its dates, old drops stay readable."""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from tests.calibration.bench_day import (
    MODEL,
    REST,
    STEPS,
    SWEEPS,
    SWINGS,
    TRUTH,
    add_rate,
    change_counts,
    day,
    later,
    record,
    record_good_step,
    true_scale,
)
from tests.calibration.some_calibration import MEASURED, whole_calibration
from tests.cli.process import RunCli
from tfsat_host.calibration.calibration_errors import CalibrationError, NotKeptError
from tfsat_host.calibration.certificate import calibration_campaign
from tfsat_host.calibration.certificate.calibration_campaign import Campaign
from tfsat_host.calibration.certificate.certificate import Subject, quantities
from tfsat_host.calibration.certificate.file import format_calibration, parse_calibration
from tfsat_host.calibration.replacements import PARTS, Replacement, Specimens
from tfsat_host.calibration.solution import SensorKnowledge, solve
from tfsat_host.calibration.steps.step import StepKind
from tfsat_host.run.certificate_check import check_certificate

NOON = record_good_step(STEPS[0]).recorded_at + timedelta(hours=4)
OF_BODY_2 = {
    "bias of body 2",
    *(f"misalignment of body 2 about {axis}" for axis in "xy"),
    *(f"scale factor {axis} of body 2" for axis in "xyz"),
}
ZEROS = {f"zero point of joint {joint}" for joint in (1, 2, 3)}


def replaced(*parts: str, at: datetime = NOON) -> Specimens:
    return Specimens(tuple(Replacement(at, part) for part in parts))


def same_gyro(first: SensorKnowledge, second: SensorKnowledge, body: int) -> bool:
    gyro, other = first.gyros[body - 1], second.gyros[body - 1]
    dates = (gyro.bias_recorded_at, gyro.axes, gyro.scaled)
    return dates == (other.bias_recorded_at, other.axes, other.scaled) and all(
        np.array_equal(getattr(gyro, name), getattr(other, name))
        for name in ("bias_rad_s", "rotation", "scale", "skew", "covariance")
    )


def test_of_a_replaced_imu_nothing_is_known_and_all_others_keep_value_and_date() -> None:
    before, after = solve(day(), MODEL), solve(day(), MODEL, specimens=replaced("imu-2"))
    new = after.gyros[1]
    assert (new.bias_recorded_at, new.axes, new.scaled) == (None, {}, {})
    assert np.array_equal(new.rotation, MODEL.imus[1].sensor_to_body)
    assert [same_gyro(before, after, body) for body in (1, 2, 3, 4)] == [True, False, True, True]
    assert [joint.zero_recorded_at for joint in after.joints] == [
        joint.zero_recorded_at for joint in before.joints
    ]


def test_steps_with_the_new_imu_are_its_own() -> None:
    """The new one reads 3 % less and has another bias: old steps of body 2 do not spoil it, nor it theirs."""
    other = np.array([[1.0], [0.97], [1.0], [1.0]])
    truth = replace(
        TRUTH,
        gyro_scale=TRUTH.gyro_scale * other,
        gyro_cross_axis=TRUTH.gyro_cross_axis * other[:, None],
        gyro_bias_rad_s=TRUTH.gyro_bias_rad_s
        + np.deg2rad([[0.0] * 3, [2.0, -1.0, 3.0], [0.0] * 3, [0.0] * 3]),
    )
    # Joint 1 moves body 1 or bodies 2 to 4; only what turns body 2 is done again.
    again = [REST, *(step for step in (*SWINGS, *SWEEPS) if 2 in step.moved)]
    fresh = [later(record(step, truth=truth), 300.0) for step in again]
    solution = solve([*day(), *fresh], MODEL, specimens=replaced("imu-2"))
    gyro = solution.gyros[1]
    assert np.rad2deg(gyro.bias_rad_s) == pytest.approx(np.rad2deg(truth.gyro_bias_rad_s[1]), abs=0.02)
    for axis in (0, 1):
        found = gyro.rotation[axis] @ np.diag(gyro.scale) @ gyro.rotation[axis]
        assert found == pytest.approx(0.97 * true_scale(2, axis), abs=4e-3)
    assert set(gyro.axes) == set("xy")
    assert min(gyro.axes.values()) > NOON


def test_what_the_old_imu_said_of_a_held_body_still_counts() -> None:
    """Its bias of that day: else a body that was held would seem to have turned by 5 deg/s all along."""
    biased = [change_counts(entry, add_rate(2, lambda t_s: np.full((len(t_s), 3), 5.0))) for entry in day()]
    before, after = solve(biased, MODEL), solve(biased, MODEL, specimens=replaced("imu-2"))
    for body in (1, 3, 4):
        apart = before.gyros[body - 1].scale - after.gyros[body - 1].scale
        assert np.abs(apart).max() < 3e-4


@pytest.mark.parametrize(("part", "gone"), [("logger", (1, 2, 3)), ("angle-2", (2,)), ("imu-1", ())])
def test_zero_points_rest_on_the_converter_and_on_their_sensors(part: str, gone: tuple[int, ...]) -> None:
    after = solve(day(), MODEL, specimens=replaced(part))
    assert tuple(joint.joint for joint in after.joints if joint.zero_recorded_at is None) == gone
    assert tuple(joint.joint for joint in after.joints if joint.bend_recorded_at is None) == (
        (2,) if part == "angle-2" else ()
    )


@pytest.fixture
def campaign(tmp_path: Path) -> Campaign:
    made = open_campaign(tmp_path)
    for entry in day(StepKind.TURN):
        made.accept(entry)
    return made


SUBJECT = Subject(MODEL.name, "0a" * 8, "68" * 4, False)


def open_campaign(folder: Path, subject: Subject = SUBJECT, *parts: str) -> Campaign:
    return Campaign(folder / "calibration.toml", MODEL, subject, replaced=parts)


def lacking(campaign: Campaign) -> set[str]:
    assert campaign.calibration is not None
    return {entry.name for entry in quantities(campaign.calibration) if entry.measured_at is None}


def test_a_robot_keeps_its_calibration_through_three_repairs(campaign: Campaign, tmp_path: Path) -> None:
    missing = lacking(campaign)
    first = open_campaign(tmp_path, SUBJECT, "imu-2")
    first.replace_parts(NOON)
    assert lacking(first) - missing == OF_BODY_2 - missing
    # The Teensy breaks: another serial number is refused, until it is told.
    other_logger = replace(SUBJECT, logger_serial="0b" * 8)
    with pytest.raises(CalibrationError, match="another calibration") as refused:
        open_campaign(tmp_path, other_logger)
    assert "tfsat-host calibrate replaced PART" in refused.value.next_step
    second = open_campaign(tmp_path, other_logger, "logger")
    second.replace_parts(NOON + timedelta(days=1))
    assert lacking(second) - missing == (OF_BODY_2 | ZEROS) - missing
    # An MPU-6500 in place of body 3's chip.
    other_chip = replace(other_logger, who_am_i="68687068")
    third = open_campaign(tmp_path, other_chip, "imu-3")
    calibration = third.replace_parts(NOON + timedelta(days=2))
    # A whole chain: what the robot was at each time, and by which logger it is known.
    assert [entry.part for entry in calibration.replacements] == ["imu-2", "logger", "imu-3"]
    assert calibration.subject_at(None) == other_chip
    assert calibration.subject_at(NOON + timedelta(days=1.5)) == other_logger
    assert calibration.subject_at(NOON) == SUBJECT
    assert calibration.first_logger == SUBJECT.logger_serial
    # What is measured now counts for the new parts.
    third.accept(later(record_good_step(REST), 60 * 24 * 3))
    assert not {name for name in lacking(third) if "bias" in name}
    assert open_campaign(tmp_path, other_chip).calibration is not None


def test_a_silent_imu_is_looked_for_before_it_counts_as_replaced(campaign: Campaign, tmp_path: Path) -> None:
    assert campaign.calibration is not None
    with pytest.raises(CalibrationError) as refused:
        open_campaign(tmp_path, replace(SUBJECT, who_am_i="68006868"))
    assert "imu-2 was an IMU with WHO_AM_I 68 and is silent." in refused.value.what
    assert refused.value.next_step.startswith("Check plug and cable of imu-2: tfsat-host monitor. If a part")


def test_a_part_of_another_robot_is_no_replacement(campaign: Campaign, tmp_path: Path) -> None:
    both = Subject(MODEL.name, "0b" * 8, "68687068", False)
    with pytest.raises(CalibrationError, match="another calibration"):
        open_campaign(tmp_path, both, "logger")
    with pytest.raises(CalibrationError, match="does not exist"):
        open_campaign(tmp_path / "elsewhere", both, "logger").replace_parts(NOON)
    assert campaign.calibration is not None


def test_the_file_holds_the_replacements_and_reads_older_ones() -> None:
    calibration = whole_calibration()
    text = format_calibration(calibration)
    assert "replaced" not in text
    assert parse_calibration(text).replacements == ()
    told = tuple(Replacement(NOON + timedelta(days=day), part, "68") for day, part in enumerate(PARTS))
    again = parse_calibration(format_calibration(replace(calibration, replacements=told)))
    assert again.replacements == told


def test_a_drop_from_before_a_repair_is_not_evaluated_silently_by_the_new_parts() -> None:
    repaired = replace(
        whole_calibration(), replacements=(Replacement(MEASURED + timedelta(hours=3), "imu-2"),)
    )

    def objections(hours: float) -> tuple[str, ...]:
        dropped = MEASURED + timedelta(hours=hours)
        return check_certificate(repaired, None, Path("calibration.toml"), dropped, servos=False).objections

    (sentence,) = objections(1)
    assert "Replaced only after these samples: imu-2." in sentence
    assert objections(4) == ()


def test_a_repair_keeps_the_step_that_a_second_terminal_accepted_meanwhile(
    campaign: Campaign, tmp_path: Path
) -> None:
    second = open_campaign(tmp_path, replace(SUBJECT, logger_serial="0b" * 8), "logger")
    accepted = later(record_good_step(REST), 60)
    campaign.accept(accepted)
    calibration = second.replace_parts(accepted.recorded_at + timedelta(minutes=1))
    assert [entry.part for entry in calibration.replacements] == ["logger"]
    assert accepted.recorded_at in {entry.recorded_at for entry in calibration.recordings}


def test_a_repair_that_cannot_be_written_says_so(
    campaign: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(28, "No space left on device")

    before = campaign.certificate.read_bytes()
    monkeypatch.setattr(calibration_campaign, "write_certificate", refuse)
    repair = open_campaign(tmp_path, SUBJECT, "imu-2")
    with pytest.raises(NotKeptError) as refused:
        repair.replace_parts(NOON)
    assert refused.value.meaning.startswith("That imu-2 was replaced is not kept")
    assert campaign.certificate.read_bytes() == before
    assert repair.calibration is not None
    assert repair.calibration.replacements == ()


def test_an_emulated_robots_imu_is_replaced_on_the_command_line(tfsat_host: RunCli) -> None:
    tfsat_host("calibrate", "bias", "--emulated", "--yes")
    tfsat_host("calibrate", "zero", "--all", "--emulated", "--yes")
    refused = tfsat_host("calibrate", "replaced", "logger", "--emulated", expect=2)
    assert "is the one that was calibrated" in refused.stderr
    assert (
        "Parts: logger, sequencer, imu-1"
        in tfsat_host("calibrate", "replaced", "leg", "--emulated", expect=2).stderr
    )
    done = tfsat_host("calibrate", "replaced", "imu-2", "--emulated")
    assert "Replaced: imu-2 (IMU of body 2: all of its gyro)" in done.stderr
    assert "tfsat-host calibrate bias --emulated" in done.stdout
    shown = json.loads(tfsat_host("calibrate", "show", "--emulated", "--json").stdout)
    states = {row["quantity"]: row["state"] for row in shown["quantities"]}
    assert [states[f"bias of body {body}"] for body in (1, 2, 3, 4)] == ["valid", "missing", "valid", "valid"]
    assert [entry["part"] for entry in shown["replaced"]] == ["imu-2"]
    tfsat_host("calibrate", "bias", "--emulated", "--yes")
    again = json.loads(tfsat_host("calibrate", "show", "--emulated", "--json").stdout)
    assert {row["state"] for row in again["quantities"] if "bias" in row["quantity"]} == {"valid"}
