"""Gyros that feel their own weight: what the bench and the releaser tell of a bias is another one in the fall."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.evaluation.corrupted import failures_by_name, gyro_plus
from tests.evaluation.drops import (
    RATE_RAD_S,
    STDS,
    assert_angle_holds,
    certificate,
    estimate_motion,
    few_of,
    turn_off,
)
from tests.fixtures.emulated_drop import Drop, drop
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.emulated.imperfections import draw_as_built
from tfsat_host.evaluation.checks.consistency import consistency_of
from tfsat_host.evaluation.checks.stated_errors import stated_errors
from tfsat_host.evaluation.evaluation import evaluate
from tfsat_host.evaluation.motion.motion import Motion
from tfsat_host.evaluation.rest import hanging_before_release
from tfsat_host.evaluation.verdict import verdict_of
from tfsat_host.robot import load_robot

SENSITIVITY_DEG_S_G = 0.1
"""PS-MPU-6000A rev. 3.4, section 6.1: linear acceleration sensitivity, static, typical."""
HANGS_UNTIL_S = -0.05
SEEDS = (1, 2)
EACH = pytest.mark.parametrize("seed", few_of(*SEEDS))


@cache
def fly_sensitive_robot(seed: int, times: float = 1.0) -> Drop:
    model, random = load_robot(), np.random.default_rng([seed, 60])
    # Every gyro feels gravity in its own way, per axis.
    felt = times * np.deg2rad(SENSITIVITY_DEG_S_G) * random.standard_normal((4, 3, 3))
    robot = replace(draw_as_built(seed), gyro_g_sensitivity_rad_s_g=felt)
    return drop(model, robot, seed=seed, rate_rad_s=RATE_RAD_S)


@cache
def motion(seed: int) -> Motion:
    drop = fly_sensitive_robot(seed)
    return estimate_motion(drop.log, certificate(drop, seed), drop.model)


@EACH
def test_attitudes_and_joints_hold_the_truth(seed: int) -> None:
    drop, estimate = fly_sensitive_robot(seed), motion(seed)
    assert not estimate.contradicted
    for body in (1, 2, 3, 4):
        off = turn_off(drop, estimate, body)
        assert off.stds < STDS
        assert off.std_deg < 0.1
    for joint in (1, 2, 3):
        assert_angle_holds(drop, estimate, joint, widest_deg=0.03)


def test_neither_surer_nor_less_sure_than_they_are_right() -> None:
    squares = [
        turn_off(fly_sensitive_robot(seed), motion(seed), body).stds ** 2
        for seed in SEEDS
        for body in (1, 2, 3, 4)
    ]
    # Mean square of a three-dimensional error in its own standard deviations.
    assert 0.3 < np.mean(squares) < 6.0, "three on average, were the bodies independent"


@EACH
def test_a_healthy_drop_is_good(seed: int) -> None:
    drop = fly_sensitive_robot(seed)
    evaluation = evaluate(drop.log, drop.model, certificate(drop, seed), drop.schedule)
    assert verdict_of(evaluation).level == "good", verdict_of(evaluation).reasons
    offsets = evaluation.explained.fit
    assert (np.abs(offsets.values) < STDS * offsets.std).all(), "the robot is as its file says"


def test_gyros_that_feel_five_times_as_much_are_named_and_tell_no_attitude() -> None:
    drop = fly_sensitive_robot(1, times=5.0)
    # 0.5 deg/s per g: more than the data sheet's spread explains.
    evaluation = evaluate(drop.log, drop.model, certificate(drop, 1), drop.schedule)
    causes = [check.causes[0].kind for check in evaluation.failed_checks]
    assert causes and set(causes) == {"g-sensitivity"}
    assert {"rates", "attitudes", "offsets"} <= {*evaluation.withheld}
    assert np.isnan(evaluation.reorientation.angle_rad) and verdict_of(evaluation).level == "doubtful"


@EACH
def test_without_a_calibration_the_bias_of_the_releaser_is_as_far_off(seed: int) -> None:
    drop = fly_sensitive_robot(seed)
    evaluation = evaluate(drop.log, drop.model, None, drop.schedule)
    for body in (1, 2, 3, 4):
        assert turn_off(drop, evaluation.motion, body).stds < STDS


def test_what_gyros_show_of_the_hanging_robot_tells_nothing_of_the_fall() -> None:
    """Gyro readings of the hanging robot do not affect the motion in the fall.

    The gyros read as if they felt three times their weight.
    """
    drop, estimate = fly_sensitive_robot(1), motion(1)
    log = drop.log
    for body in (1, 2, 3, 4):
        # While the robot hangs, gravity is added to what the gyros show.
        log = gyro_plus(log, body, np.outer(log.t_s < HANGS_UNTIL_S, (0.3, -0.2, 0.25)))
    other = estimate_motion(log, certificate(drop, 1), drop.model)
    fall = estimate.samples.fall
    assert np.rad2deg(np.abs(other.angles_rad - estimate.angles_rad)[fall].max()) < 1e-3
    for before, after in zip(estimate.bodies, other.bodies, strict=True):
        assert np.rad2deg((after.attitude * before.attitude.inv()).magnitude().max()) < 2e-3


def test_joints_begin_where_their_sensors_saw_them_hang() -> None:
    """Initialize joint angles from the hanging robot's angle sensors, not from its gyros."""
    drop = fly_sensitive_robot(1)
    valid = drop.log.angle_valid.copy()
    # Angle sensors before the release only: the joints begin where they saw them.
    valid[drop.log.t_s >= 0.0] = False
    motion = estimate_motion(replace(drop.log, angle_valid=valid), certificate(drop, 1), drop.model)
    for joint in (1, 2, 3):
        assert_angle_holds(drop, motion, joint, widest_deg=0.5)


def test_a_bias_that_is_wrong_while_the_robot_hangs_is_still_seen() -> None:
    """There the weight is in both, the certificate's bias and what the gyro shows."""
    drop, calibration = fly_sensitive_robot(1), certificate(fly_sensitive_robot(1), 1)
    estimate = motion(1)
    rest = hanging_before_release(drop.log, calibration, drop.model)
    data = consistency_of(estimate, rest, LowPass.of(drop.log.header), calibration, drop.model)
    std = np.sqrt(np.diag(stated_errors(data).covariance))
    for body in range(4):
        # At rest gravity is in both the certificate's bias and the reading: nothing to be uncertain about.
        assert (np.rad2deg(std[data.at_rest(body)]) < 0.02).all()
        # In the fall it is in neither: what the gyro then shows has this uncertainty.
        assert (np.rad2deg(std[data.off_axis(min(body, 2))]) > SENSITIVITY_DEG_S_G).all(), (
            "of two gyros that fall"
        )


def test_a_bias_that_is_not_the_certificates_is_named() -> None:
    drop, calibration = fly_sensitive_robot(2), wrong_bias(certificate(fly_sensitive_robot(2), 2), 2, 0.3)
    checks = failures_by_name(evaluate(drop.log, drop.model, calibration, drop.schedule).checks)
    assert any((check.cause or "").startswith("gyro of body 2") for check in checks.values()), checks


def wrong_bias(calibration: Calibration, body: int, by_deg_s: float) -> Calibration:
    gyros = tuple(
        replace(gyro, bias_rad_s=gyro.bias_rad_s + np.deg2rad(by_deg_s)) if gyro.body == body else gyro
        for gyro in calibration.gyros
    )
    return replace(calibration, gyros=gyros)
