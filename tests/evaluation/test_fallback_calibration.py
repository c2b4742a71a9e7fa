"""A drop without a calibration, or with one that a landing has ended: what is used instead, and what that costs."""

from __future__ import annotations

from dataclasses import replace
from datetime import timedelta

import numpy as np
import pytest

from tests.evaluation.drops import DROPPED, MORNING, certificate, estimate_motion, few_of, fly_drop
from tests.fixtures.emulated_drop import Drop
from tfsat_host.calibration.certificate.certificate import Calibration, Landing
from tfsat_host.evaluation.fallback_calibration import Fallback, with_fallbacks
from tfsat_host.evaluation.motion.gyro_signal import MIN_DENSITY_RAD_S_RTHZ, noise_densities
from tfsat_host.evaluation.motion.samples import EvaluationError
from tfsat_host.evaluation.rest import rest_before_release


def fill_calibration(drop: Drop, calibration: Calibration | None) -> Fallback:
    return with_fallbacks(calibration, drop.log, drop.model, rest_before_release(drop.log), DROPPED)


def reorientation_error_deg(drop: Drop, calibration: Calibration) -> tuple[float, float]:
    track = estimate_motion(drop.log, calibration).bodies[0]
    angle, std = track.reorientation_rad()
    true = drop.true_turn(1, track.t_s[0], track.t_s[-1]).magnitude()
    return float(np.rad2deg(angle - true)), float(np.rad2deg(std))


def test_a_whole_calibration_is_used_as_it_is() -> None:
    drop = fly_drop(1)
    calibration = certificate(drop, 1)
    fallback = fill_calibration(drop, calibration)
    assert fallback.notes == ()
    assert [gyro.bias_rad_s.tolist() for gyro in fallback.calibration.gyros] == [
        gyro.bias_rad_s.tolist() for gyro in calibration.gyros
    ]


@pytest.mark.parametrize("seed", few_of(1, 2, 3))
def test_without_a_calibration_the_rest_before_the_release_tells_the_biases(seed: int) -> None:
    """Four gyros and six angle sensors tell each other's mountings and scale factors, from the drop itself."""
    drop = fly_drop(seed)
    fallback = fill_calibration(drop, None)
    assert any(note.startswith("The bias of body 1, 2, 3, 4 is that of") for note in fallback.notes)
    assert "There is no calibration" in fallback.notes[0]
    assert sum("zero point not measured" in note for note in fallback.notes) == 3
    for gyro, true in zip(fallback.calibration.gyros, drop.imperfections.gyro_bias_rad_s, strict=True):
        # Three standard deviations of the bias that the rest gave.
        off = np.abs(gyro.bias_rad_s - true)
        assert (off < 3.0 * np.sqrt(np.diag(gyro.covariance)[:3])).all()
    error, std = reorientation_error_deg(drop, fallback.calibration)
    assert abs(error) < 3.0 * std
    calibrated = reorientation_error_deg(drop, certificate(drop, seed))[1]
    # Worse than with a calibration, and still below a degree.
    assert 1.5 * calibrated < std < 1.0


def test_a_bias_from_before_a_landing_gives_way_to_the_rest_before_the_release() -> None:
    drop = fly_drop(1)
    calibration = certificate(drop, 1)
    landed = replace(
        # A landing between calibration and drop.
        calibration,
        landings=(Landing(MORNING + timedelta(minutes=30), "a drop before this one"),),
    )
    fallback = fill_calibration(drop, landed)
    assert any(note.startswith("The bias of body 1, 2, 3, 4 is that of") for note in fallback.notes)
    assert "when the robot is taken to have hung still" in fallback.notes[0]
    assert any(note.startswith("Measured before a landing") for note in fallback.notes)


def test_what_a_landing_may_have_turned_is_less_sure_afterwards() -> None:
    drop = fly_drop(1)
    calibration = certificate(drop, 1)
    landed = replace(
        calibration, landings=(Landing(MORNING + timedelta(minutes=30), "a drop before this one"),)
    )
    before, after = (
        fill_calibration(drop, calibration).calibration,
        fill_calibration(drop, landed).calibration,
    )
    for was, now in zip(before.gyros, after.gyros, strict=True):
        std = np.rad2deg(np.sqrt(np.diag(now.covariance)))
        assert (std[3:6] >= 1.0).all(), "mounting"
        # Scale factors are of silicon: a landing does not change them.
        assert now.covariance[6:, 6:].tolist() == was.covariance[6:, 6:].tolist(), "silicon survives"
    for sensors in after.joints:
        assert (np.rad2deg(np.sqrt(np.diag(sensors.zero_covariance))) >= 1.0).all()
    (note,) = (
        note for note in fill_calibration(drop, landed).notes if note.startswith("Measured before a landing")
    )
    assert "zero point of joint 1" in note


def test_a_landing_after_this_drop_ends_nothing() -> None:
    drop = fly_drop(1)
    later = replace(certificate(drop, 1), landings=(Landing(DROPPED + timedelta(seconds=9), "this drop"),))
    assert fill_calibration(drop, later).notes == ()


def test_a_bias_that_can_be_had_from_nowhere_is_refused_with_the_command_that_measures_it() -> None:
    drop = fly_drop(1)
    swung = drop.log.imu_counts.copy()
    before = drop.log.t_s < 0.0
    # 20 deg/s at 1 Hz before the release: no rest at all.
    swing = (65.5 * 20.0 * np.sin(2.0 * np.pi * drop.log.t_s[before])).astype(np.int16)
    swung[before, 2, 4] += swing
    log = replace(drop.log, imu_counts=swung)
    with pytest.raises(EvaluationError, match="bias of body 3 was never measured") as refused:
        with_fallbacks(None, log, drop.model, rest_before_release(log), DROPPED)
    assert "tfsat-host calibrate bias" in refused.value.next_step


def test_an_angle_sensor_that_says_nothing_before_the_release_has_no_zero_and_is_not_used() -> None:
    drop = fly_drop(1)
    valid = drop.log.angle_valid.copy()
    # The sensor is silent before the release, when its zero would be measured.
    valid[drop.log.t_s < 0.0, 2] = False
    log = replace(drop.log, angle_valid=valid)
    fallback = with_fallbacks(None, log, drop.model, rest_before_release(log), DROPPED)
    joint_notes = [note for note in fallback.notes if "joint 2" in note]
    assert joint_notes == [
        "Angle sensor 1 of joint 2 has no zero point and did not answer before the release: what it shows later is "
        "not used."
    ]
    assert np.isnan(fallback.calibration.joints[1].zero_rad).tolist() == [True, False]
    motion = estimate_motion(log, fallback.calibration)
    off = motion.angles_rad[:, 1] - drop.true_angles_rad(motion.t_s)[:, 1]
    # Its own zero is unknown: the other sensor and where the joint hung have to do.
    assert np.abs(np.rad2deg(off)).max() < 6.0, (
        "by the other sensor, whose zero is that of a joint that hung there"
    )


def test_where_both_sensors_of_a_joint_are_so_its_gyros_count_from_where_its_servo_starts() -> None:
    drop = fly_drop(1)
    valid = drop.log.angle_valid.copy()
    valid[drop.log.t_s < 0.0, 2:4] = False
    log = replace(drop.log, angle_valid=valid)
    fallback = with_fallbacks(None, log, drop.model, rest_before_release(log), DROPPED)
    assert sum("of joint 2 has no zero point" in note for note in fallback.notes) == 2
    assert not any(note.startswith("The zero point of joint 2 ") for note in fallback.notes)
    motion = estimate_motion(log, fallback.calibration)
    assert not motion.joints[1].sensed
    off = motion.angles_rad[:, 1] - drop.true_angles_rad(motion.t_s)[:, 1]
    assert np.abs(np.rad2deg(off)).max() < 8.0


def test_a_dead_gyro_needs_no_bias() -> None:
    drop = fly_drop(1)
    valid = drop.log.imu_valid.copy()
    valid[:, 2] = False
    log = replace(drop.log, imu_valid=valid)
    fallback = with_fallbacks(None, log, drop.model, rest_before_release(log), DROPPED)
    assert any(note.startswith("The bias of body 1, 2, 4 is that of") for note in fallback.notes)


def test_without_a_rest_the_noise_is_the_data_sheets() -> None:
    drop = fly_drop(1)
    rest = rest_before_release(replace(drop.log, release=None))
    assert np.isnan(rest.rate_rad_s).all()
    assert np.rad2deg(rest.densities_rad_s_rthz) == pytest.approx([0.005] * 4)
    by_rest = np.rad2deg(rest_before_release(drop.log).densities_rad_s_rthz)
    # From a rest of some twenty means: half and double of the data sheet.
    assert (by_rest > 0.0025).all() and (by_rest < 0.01).all(), "from some twenty means of each gyro"


def test_a_joint_without_a_zero_point_hung_where_its_servo_starts() -> None:
    drop = fly_drop(1)
    servos = tuple(replace(servo, start_rad=0.1) for servo in drop.model.servos)
    started = with_fallbacks(
        None, drop.log, replace(drop.model, servos=servos), rest_before_release(drop.log), DROPPED
    )
    for was, now in zip(
        fill_calibration(drop, None).calibration.joints, started.calibration.joints, strict=True
    ):
        assert was.zero_rad - now.zero_rad == pytest.approx(0.1 * was.direction)


def test_readings_that_stand_still_are_not_without_noise() -> None:
    """Floor the noise density of readings that do not change: zero noise would be an infinite weight.

    The quantization steps hide the noise, except for a rare step.
    """
    t_s = np.arange(0.0, 10.0, 1.0 / 280.0)
    rates = np.full((len(t_s), 4, 3), 0.01)
    # Steps of a single count, as a still gyro shows them.
    rates[:100] += np.deg2rad(1.0 / 65.5)
    densities = noise_densities(t_s, rates)
    assert (densities == MIN_DENSITY_RAD_S_RTHZ).all() and MIN_DENSITY_RAD_S_RTHZ > 0.0
