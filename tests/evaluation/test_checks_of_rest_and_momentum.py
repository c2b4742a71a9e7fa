"""Integrity checks of the rest, of readings that are missing, and of momentum."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.evaluation.corrupted import (
    ACCEL,
    GYRO,
    Flown,
    axes_exchanged,
    failures_by_name,
    gyro_plus,
    healthy_drop,
    silence_imu,
    with_imu,
    without_samples,
)
from tests.evaluation.drops import MODEL, estimate_motion
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.sensors.gyro import by_design
from tfsat_host.calibration.sensors.joint_sensors import sensors_by_design
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses
from tfsat_host.evaluation.checks.drop_checks import AS_FILED, checks_of
from tfsat_host.evaluation.checks.rest_checks import across_std
from tfsat_host.evaluation.micro_gravity import AtRest
from tfsat_host.sdlog import DropLog

SEED = 1
GYROS_12, GYROS_23, GYROS_34 = (f"gyros of bodies {b} and {b + 1}" for b in (1, 2, 3))
SENSORS_1, SENSORS_2, SENSORS_3 = (f"angle sensors of joint {j}" for j in (1, 2, 3))
BOTH_1, BOTH_2, BOTH_3 = (f"angle sensors and gyros of joint {j}" for j in (1, 2, 3))
BIAS, LAG, ATTITUDE = "gyro bias at rest", "lag of the gyros", "attitude by each gyro"
THROUGHOUT, BEFORE_AFTER = "momentum throughout the fall", "momentum before and after the maneuver"


@pytest.fixture(scope="module")
def healthy() -> Flown:
    return healthy_drop()


def test_a_gyro_mounted_anew_keeps_its_bias(healthy: Flown) -> None:
    """Turned by a right angle since the calibration: at rest it shows what it always did."""
    gyro = healthy.calibration.gyros[1]
    # A quarter turn about z.
    turn = np.array(((0, 1, 0), (-1, 0, 0), (0, 0, 1)), dtype=float)

    def turn_gyro(log: DropLog) -> DropLog:
        per_count = float(np.deg2rad(1.0 / log.header.gyro_lsb_per_deg_s))
        # Counts are undone to true rates, turned, and made counts again: bias and scale stay the chip's own.
        true = (log.imu_counts[:, 1, GYRO] * per_count - gyro.bias_rad_s) / gyro.scale
        counts: FloatArray = ((true @ turn.T) * gyro.scale + gyro.bias_rad_s) / per_count
        return with_imu(log, 2, GYRO, counts)

    failures = failures_by_name(healthy.run_checks(turn_gyro))
    assert BIAS not in failures
    assert failures[GYROS_12].cause == "gyro of body 2: x and y exchanged, y reversed"


def test_a_stale_certificate_is_told_from_a_warm_gyro(healthy: Flown) -> None:
    """Bias at rest counts by what the certificate and the temperature since leave open."""
    gyro = healthy.calibration.gyros[2]
    # Certified 30 deg colder: the bias may have drifted by as much as is added.
    wide = replace(gyro, temperature_c=gyro.temperature_c - 30.0)
    gyros = (*healthy.calibration.gyros[:2], wide, healthy.calibration.gyros[3])
    log = gyro_plus(healthy.drop.log, 3, (0.5, 0.0, 0.0))
    warm = replace(healthy.calibration, gyros=gyros)
    checks = checks_of(estimate_motion(log, warm, MODEL), None, log, warm, MODEL)
    assert failures_by_name(checks) == {}


def test_accelerometers_are_tried_on_gravity(healthy: Flown) -> None:
    def louder(log: DropLog) -> DropLog:
        # 25 % more: beyond what an accelerometer's data sheet allows.
        return with_imu(log, 1, ACCEL, 1.25 * log.imu_counts[:, 0, ACCEL].astype(np.float64))

    loud = failures_by_name(healthy.run_checks(louder))
    assert set(loud) == {"gravity at rest"}
    assert str(loud["gravity at rest"].cause).startswith("accelerometer of body 1: its range or its scale")
    turned = failures_by_name(
        healthy.run_checks(lambda log: axes_exchanged(log, 2, ((0, 0, 1), (1, 0, 0), (0, 1, 0)), ACCEL))
    )
    assert set(turned) == {"down at rest"}
    cause = "accelerometer of body 2 feels up along +x where it is +z: its axes are exchanged or reversed"
    assert turned["down at rest"].cause == cause


def test_a_direction_is_as_uncertain_as_the_errors_square_to_it() -> None:
    force = AtRest(np.array([0.6, 0.0, 0.8]), np.array([1.0, 2.0, 3.0]), 0.0)
    # Across (0.6, 0, 0.8) in the x-z plane the errors weigh by 0.8² and 0.6²; y counts whole.
    assert across_std(force) == pytest.approx(np.sqrt(0.64 * 1.0 + 4.0 + 0.36 * 9.0))


def test_a_robot_that_sways_has_no_rest_to_check(healthy: Flown) -> None:
    def sway_robot(log: DropLog) -> DropLog:
        # Swaying of 5 deg/s at 0.7 Hz, ended just before the release.
        rate = np.outer(5.0 * np.sin(2 * np.pi * 0.7 * log.t_s) * (log.t_s < -0.05), (0.0, 0.0, 1.0))
        for body in (1, 2, 3, 4):
            log = gyro_plus(log, body, rate)
        return log

    verdicts = {check.name: check.verdict for check in healthy.run_checks(sway_robot)}
    for name in ("gravity at rest", "down at rest", BIAS):
        assert verdicts[name] == "not possible"
    assert "failed" not in verdicts.values()


def test_noise_cannot_hide_a_contradiction(healthy: Flown) -> None:
    """Fail a noisy gyro for its noise, which would otherwise explain any contradiction."""
    # 5 deg/s of white noise, far above the sensor's own.
    noise = np.random.default_rng(1).normal(0.0, 5.0, (len(healthy.drop.log), 3))
    failures = failures_by_name(healthy.run_checks(lambda log: gyro_plus(log, 3, noise)))
    assert set(failures) == {"gyro noise"}
    assert str(failures["gyro noise"].cause).startswith("gyro of body 3")


def test_what_is_missing_in_the_fall_is_counted(healthy: Flown) -> None:
    failures = failures_by_name(healthy.run_checks(lambda log: silence_imu(log, 3, 0.2, 0.3)))
    assert set(failures) == {"answers in the fall"}
    # In percent: 0.1 s of a fall of about 2.45 s.
    assert failures["answers in the fall"].value == pytest.approx(4.1, abs=0.2)
    assert failures["answers in the fall"].cause == "IMU of body 3: cable, connector or bus"
    # Before the release a silent IMU costs no result.
    assert failures_by_name(healthy.run_checks(lambda log: silence_imu(log, 3, -3.0, -0.1))) == {}

    def clip_samples(log: DropLog) -> DropLog:
        flags = log.clipped.copy()
        # Three samples at full scale: each counts.
        flags[np.flatnonzero(log.t_s > 0.9)[:3], 1] = True
        return replace(log, clipped=flags)

    failures = failures_by_name(healthy.run_checks(clip_samples))
    assert set(failures) == {"full scale in the fall"}
    assert failures["full scale in the fall"].value == 3.0

    # In the middle of a stroke: what is integrated across the hole is not compared.
    checks = healthy.run_checks(lambda log: without_samples(log, 0.90, 0.95))
    assert set(failures_by_name(checks)) == {"holes in the fall"}
    assert failures_by_name(checks)["holes in the fall"].value == pytest.approx(53.6, abs=3.6)
    assert {check.verdict for check in checks if check.name in (LAG, BOTH_1)} == {"not possible"}


def test_a_dead_gyro_leaves_the_other_checks(healthy: Flown) -> None:
    # Silent from before the recording to behind its end.
    checks = {check.name: check for check in healthy.run_checks(lambda log: silence_imu(log, 1, -9.0, 9.0))}
    assert checks[GYROS_12].verdict == checks[BOTH_1].verdict == "not possible"
    for name in (GYROS_23, GYROS_34, SENSORS_1, BOTH_2, BIAS, ATTITUDE):
        assert checks[name].verdict == "passed", name


def test_without_angle_sensors_gyros_are_still_compared(healthy: Flown) -> None:
    def blind(log: DropLog) -> DropLog:
        return replace(log, angle_valid=np.zeros_like(log.angle_valid))

    checks = {check.name: check for check in healthy.run_checks(blind)}
    assert {checks[name].verdict for name in (GYROS_12, GYROS_23, GYROS_34)} == {"passed"}
    assert {checks[name].verdict for name in (SENSORS_1, BOTH_1, LAG)} == {"not possible"}
    reversed_z = ((1, 0, 0), (0, 1, 0), (0, 0, -1))
    failures = failures_by_name(healthy.run_checks(lambda log: blind(axes_exchanged(log, 4, reversed_z))))
    assert failures[GYROS_34].cause == "gyro of body 4: z reversed"


def test_without_a_calibration_little_is_checked_and_nothing_fails(healthy: Flown) -> None:
    """Gyros by their design: 12 deg/s and 5 deg; angle sensors with a zero anywhere."""
    gyros = tuple(by_design(b + 1, MODEL.imus[b].sensor_to_body) for b in range(4))
    joints = tuple(sensors_by_design(MODEL, joint) for joint in (1, 2, 3))
    bare = replace(healthy, calibration=replace(healthy.calibration, gyros=gyros, joints=joints))
    checks = {check.name: check.verdict for check in bare.run_checks()}
    assert "failed" not in checks.values()
    assert checks[GYROS_12] == "passed"
    # Without zero points and scale factors nothing but the neighbouring gyros can be compared.
    assert {checks[name] for name in (SENSORS_1, BOTH_1, LAG, ATTITUDE)} == {"not possible"}


PUSHED_S = 1.3


def push_robot(healthy: Flown, log: DropLog) -> DropLog:
    """Something gives the robot 1 deg/s at 1.3 s, and all gyros show it."""
    base = estimate_motion(log, healthy.calibration, MODEL).bodies[MODEL.base]
    # Attitudes exist in the fall alone: samples before and after it take the nearest.
    nearest = np.clip(np.searchsorted(base.t_s, log.t_s), 0, len(base.t_s) - 1)
    # The push lasts 50 ms, as a hand's would.
    inertial_deg_s = np.outer(np.clip((log.t_s - PUSHED_S) / 0.05, 0.0, 1.0), (0.4, 1.0, -0.5))
    rate = base.attitude[nearest].inv().apply(inertial_deg_s)
    rotation, _ = poses(Multibody.of(MODEL), healthy.drop.true_angles_rad(log.t_s))
    for body, gyro in enumerate(healthy.calibration.gyros):
        # The same inertial rate in each body's own frame, by the true joint angles.
        own = np.einsum("nji,nj->ni", rotation[:, body], rate)
        log = gyro_plus(log, body + 1, gyro.readings(own))
    return log


def test_a_push_from_outside_changes_momentum_and_nothing_else(healthy: Flown) -> None:
    failures = failures_by_name(healthy.run_checks(lambda log: push_robot(healthy, log), fitted=True))
    assert set(failures) == {THROUGHOUT, BEFORE_AFTER, AS_FILED.name}
    for check in failures.values():
        assert check.cause == "a push from outside at 1.3 s: something touched the robot"
    # The push is of 1.2 deg/s.
    assert failures[BEFORE_AFTER].value > 0.5


def test_a_robot_file_that_is_wrong_breaks_momentum(healthy: Flown) -> None:
    # CoM of body 1 40 mm off in z and of body 3 30 mm off in x: beyond the fit's bounds of 10 mm.
    com = MODEL.com_m + np.array([(0.0, 0.0, 0.04), (0.0, 0.0, 0.0), (0.03, 0.0, 0.0), (0.0, 0.0, 0.0)])
    failures = failures_by_name(healthy.run_checks(fitted=True, model=replace(MODEL, com_m=com)))
    assert THROUGHOUT in failures
    cause = str(failures[THROUGHOUT].cause)
    assert cause.startswith("the robot file: body 1 CoM")
    assert "body 1 CoM z" in cause
    assert cause.endswith("would have to be off by more than its bound")


def test_sensors_that_contradict_each_other_explain_a_momentum_that_changes(healthy: Flown) -> None:
    reversed_z = ((1, 0, 0), (0, 1, 0), (0, 0, -1))
    failures = failures_by_name(
        healthy.run_checks(lambda log: axes_exchanged(log, 4, reversed_z), fitted=True)
    )
    assert failures[THROUGHOUT].cause == "gyro of body 4: z reversed"
