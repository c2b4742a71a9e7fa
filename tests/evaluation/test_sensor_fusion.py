"""What gyros and angle sensors make of each other's holes, silence and slips, next to the emulated robot's truth.

Every error must lie within what is stated of it, and that must not be so wide that it says nothing.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.signal import lsim, savgol_filter

from tests.evaluation import drops
from tests.evaluation.corrupted import failures_by_name, gyro_plus, silence_imu, with_angles
from tests.evaluation.drops import (
    STDS,
    angle_off_deg,
    assert_angle_holds,
    certificate,
    estimate_motion,
    few_of,
    fly_drop,
    motion,
    turn_off,
)
from tests.fixtures.emulated_drop import Drop
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.sensors.gyro import MOUNTING, PARAMETERS, SCALE
from tfsat_host.calibration.sensors.joint_sensors import JointSensors
from tfsat_host.dynamics.multibody import across
from tfsat_host.evaluation.checks.drop_checks import checks_of
from tfsat_host.evaluation.motion import sensor_fusion
from tfsat_host.evaluation.motion.gyro_signal import FINE_S, Lag
from tfsat_host.evaluation.motion.joints import (
    END_SHARE,
    SMOOTHED,
    SMOOTHED_SHARE,
    SensedJoint,
    errors_by_sensors,
    smooth_savitzky_golay,
)
from tfsat_host.evaluation.motion.motion import Motion, notes_of
from tfsat_host.sdlog import DropLog

HOLE_S = 0.05
HOLES = pytest.mark.parametrize(("seed", "from_s"), few_of((1, 1.045), (2, 1.10), (3, 1.38)))
"""The first stroke of joint 2 begins in the first, lasts all through the second, and ends in or after the third."""
SEEDS = pytest.mark.parametrize("seed", few_of(1, 2, 3))


def motion_in(drop: Drop, seed: int, log: DropLog) -> Motion:
    return estimate_motion(log, certificate(drop, seed), drop.model)


def no_gyro(log: DropLog, from_s: float, until_s: float) -> DropLog:
    for body in range(1, 5):
        log = silence_imu(log, body, from_s, until_s)
    return log


def sensors_silent_after(log: DropLog, columns: slice, from_s: float) -> DropLog:
    valid = log.angle_valid.copy()
    valid[log.t_s >= from_s, columns] = False
    return replace(log, angle_valid=valid)


def slip_sensor(log: DropLog, column: int, from_s: float, by_deg: float) -> DropLog:
    """Return the log with an angle sensor slipped on its shaft by `by_deg` from `from_s` on."""
    counts = log.angle_counts[:, column].astype(np.int64)
    counts[log.t_s >= from_s] += round(by_deg / 360.0 * log.header.angle_counts_per_turn)
    return with_angles(log, column, counts)


@HOLES
def test_a_hole_in_all_gyros_within_a_stroke_is_carried_over(seed: int, from_s: float) -> None:
    drop = fly_drop(seed)
    estimate = motion_in(drop, seed, no_gyro(drop.log, from_s, from_s + HOLE_S))
    for joint in (1, 2, 3):
        assert_angle_holds(drop, estimate, joint, widest_deg=0.03)
    for body in (1, 2, 3, 4):
        off, without = turn_off(drop, estimate, body), turn_off(drop, motion(seed), body)
        assert off.stds < STDS
        assert off.std_deg > 5.0 * without.std_deg
        fastest_deg_s = np.rad2deg(np.linalg.norm(estimate.bodies[body - 1].rate_rad_s, axis=1).max())
        assert off.std_deg < fastest_deg_s * HOLE_S / np.sqrt(3.0), "it might have turned either way"


@HOLES
def test_where_no_angle_sensor_answers_the_others_tell_what_the_joint_turned_in_the_hole(
    seed: int, from_s: float
) -> None:
    """Estimate a joint's rotation in a gyro gap without its angle sensors.

    A wrong angle would show in the gyros off the joint's axis, and in the rates of its neighbors.
    """
    drop = fly_drop(seed)
    silent = sensors_silent_after(drop.log, slice(2, 4), 0.9)
    estimate = motion_in(drop, seed, no_gyro(silent, from_s, from_s + HOLE_S))
    assert_angle_holds(drop, estimate, 2, widest_deg=0.05)
    std, without = (angle_off_deg(drop, each, 2)[1] for each in (estimate, motion(seed)))
    assert std.max() > 1.5 * without.max()


@SEEDS
def test_over_a_hole_at_the_release_the_robot_turns_on_evenly(seed: int) -> None:
    drop = fly_drop(seed)
    estimate = motion_in(drop, seed, no_gyro(drop.log, -0.02, 0.095))
    for joint in (1, 2, 3):
        assert_angle_holds(drop, estimate, joint, widest_deg=0.03)
    for body in (1, 2, 3, 4):
        off = turn_off(drop, estimate, body, from_s=0.0)
        assert off.stds < STDS
        assert off.error_deg < 0.05, "it turned by 0.11 deg meanwhile"
        assert np.hypot(turn_off(drop, motion(seed), body).std_deg, 0.015) < off.std_deg < 0.1


@pytest.mark.parametrize(("seed", "body", "joint"), few_of((1, 1, 1), (2, 4, 3), (3, 1, 1)))
def test_beside_a_dead_gyro_of_an_end_body_the_joint_angle_is_less_sure_and_right(
    seed: int, body: int, joint: int
) -> None:
    drop = fly_drop(seed)
    estimate = motion_in(drop, seed, silence_imu(drop.log, body, -100.0, 100.0))
    for other in (1, 2, 3):
        assert_angle_holds(drop, estimate, other, widest_deg=0.06)
    std, without = (angle_off_deg(drop, each, joint)[1] for each in (estimate, motion(seed)))
    assert std.max() > 2.0 * without.max()
    assert (std > without).all()


@pytest.mark.parametrize(
    ("seed", "column", "by_deg"), few_of((1, 0, 20.0), (1, 3, -30.0), (2, 1, 20.0), (2, 2, 8.0), least=2)
)
def test_an_angle_sensor_that_slipped_before_the_release_is_named_and_not_used(
    seed: int, column: int, by_deg: float
) -> None:
    drop = fly_drop(seed)
    motion = motion_in(drop, seed, slip_sensor(drop.log, column, -1.0, by_deg))
    joint, sensor = column // 2 + 1, column % 2
    distrusted = [sensed.distrusted for sensed in motion.fusion.joints]
    assert distrusted == [sensor if number == joint else None for number in (1, 2, 3)]
    named = [
        note for note in notes_of(motion) if note.startswith(f"Angle sensor {sensor + 1} of joint {joint} ")
    ]
    assert len(named) == 1
    assert not motion.contradicted
    for other in (1, 2, 3):
        assert_angle_holds(drop, motion, other, widest_deg=0.03)


@pytest.mark.parametrize(
    ("column", "from_s", "by_deg"), few_of((0, 0.9, 20.0), (1, 1.9, -8.0), (3, 1.2, 8.0))
)
def test_a_check_fails_where_an_angle_sensor_slips_in_the_fall(
    column: int, from_s: float, by_deg: float
) -> None:
    drop = fly_drop(1)
    log = slip_sensor(drop.log, column, from_s, by_deg)
    failures = failures_by_name(
        checks_of(motion_in(drop, 1, log), None, log, certificate(drop, 1), drop.model)
    )
    cause = failures[f"angle sensors of joint {column // 2 + 1}"].cause or ""
    assert f"angle sensor {column % 2 + 1} of joint {column // 2 + 1}" in cause


@pytest.mark.parametrize(
    ("seed", "column", "from_s", "by_deg"),
    few_of((1, 0, 0.3, 20.0), (1, 3, 0.9, 20.0), (2, 1, 1.2, -30.0), (2, 2, 1.9, 20.0), least=2),
)
def test_an_angle_sensor_that_slips_in_the_fall_is_named_and_not_used(
    seed: int, column: int, from_s: float, by_deg: float
) -> None:
    drop = fly_drop(seed)
    motion = motion_in(drop, seed, slip_sensor(drop.log, column, from_s, by_deg))
    joint, sensor = column // 2 + 1, column % 2
    assert [sensed.distrusted for sensed in motion.fusion.joints][joint - 1] == sensor
    assert any(note.startswith(f"Angle sensor {sensor + 1} of joint {joint} ") for note in notes_of(motion))
    assert not motion.contradicted
    for other in (1, 2, 3):
        assert_angle_holds(drop, motion, other, widest_deg=0.03)


UNKNOWN_SCALE = 0.03
"""Scale factors of a chip that nobody calibrated (PS-MPU-6000A rev. 3.4, section 6.1)."""
DROPS = pytest.mark.parametrize(("seed", "body"), few_of((1, 1), (2, 3)))


def with_unknown_scale(calibration: Calibration, body: int) -> Calibration:
    """Return the calibration with one body's gyro scale uncalibrated: off, and stated as uncertain.

    The scale factors are as far off as those of such a chip.
    """
    gyro = calibration.gyros[body - 1]
    covariance = gyro.covariance.copy()
    covariance[6:9, 6:9] = UNKNOWN_SCALE**2 * np.eye(3)
    off = UNKNOWN_SCALE * np.random.default_rng(body).choice([-1.0, 1.0], 3)
    unknown = replace(gyro, scale=gyro.scale + off, covariance=covariance)
    gyros = tuple(unknown if sensor.body == body else sensor for sensor in calibration.gyros)
    return replace(calibration, gyros=gyros)


def test_no_drop_tells_a_turn_of_all_mountings_and_axes_together() -> None:
    """It is another choice of every body's axes: rates that seemed to tell it would be believed."""
    drop = fly_drop(1)
    calibration = certificate(drop, 1)
    motion = estimate_motion(drop.log, calibration, drop.model)
    prior, jacobians = motion.fusion.prior, motion.solved.jacobians
    for turn_rad in np.deg2rad(0.1) * np.eye(3):
        tilts = np.array([across(axis) @ turn_rad for axis in drop.model.joint_axis])
        mountings = np.zeros((4, PARAMETERS))
        mountings[:, MOUNTING] = [gyro.rotation.T @ turn_rad for gyro in calibration.gyros]
        errors = np.zeros(len(prior))
        errors[prior.tilts] = tilts.ravel() / prior.tilt
        errors[prior.gyro] = np.linalg.pinv(prior.gyro_root) @ mountings.ravel()
        left_rad_s = (jacobians.gyros - jacobians.bodies) @ errors
        # The axes as they are turn the rates by a hundred times as much.
        assert np.rad2deg(np.abs(left_rad_s)).max() < 0.005
        errors[prior.tilts] = 0.0
        left_rad_s = (jacobians.gyros - jacobians.bodies) @ errors
        assert np.rad2deg(np.abs(left_rad_s)).max() > 0.2


def gyro_learnt(motion: Motion, body: int) -> tuple[FloatArray, FloatArray]:
    """(12,) what was taken off the parameters of a gyro, and (12,) how far they may still be off."""
    prior, solved = motion.fusion.prior, motion.solved
    root = prior.gyro_root[PARAMETERS * (body - 1) : PARAMETERS * body]
    covariance = root @ solved.jacobians.covariance[prior.gyro, prior.gyro] @ root.T
    return prior.parameters_of(solved.errors)[body - 1], np.sqrt(np.diag(covariance))


@DROPS
def test_neighbours_teach_a_gyro_the_scale_factors_that_nobody_knows(
    seed: int, body: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    drop = fly_drop(seed)
    calibration = with_unknown_scale(certificate(drop, seed), body)
    believed, true = calibration.gyros[body - 1].scale, drop.imperfections.gyro_scale[body - 1]

    def remaining_error(other_estimate: Motion) -> tuple[FloatArray, FloatArray]:
        learnt, std = gyro_learnt(other_estimate, body)
        return believed + learnt[SCALE] - true, std[SCALE]

    estimate = estimate_motion(drop.log, calibration, drop.model)
    with monkeypatch.context() as patched:
        patched.setattr(
            sensor_fusion,
            "information_by_neighbours",
            lambda _t, _f, _l, _v, errors, _k, _x: (
                np.zeros((len(errors), len(errors))),
                np.zeros(len(errors)),
            ),
        )
        by_angles = estimate_motion(drop.log, calibration, drop.model)
    assert not estimate.contradicted
    error, std = remaining_error(estimate)
    assert (np.abs(error) < STDS * std).all()
    assert std.max() < 1e-3, "of three per cent"
    error_by_angles, std_by_angles = remaining_error(by_angles)
    assert (np.abs(error_by_angles) < STDS * std_by_angles).all()
    assert np.linalg.norm(error) < np.linalg.norm(error_by_angles)
    assert np.linalg.norm(std) < 0.5 * np.linalg.norm(std_by_angles)
    turned, turned_by_angles = (turn_off(drop, motion, body) for motion in (estimate, by_angles))
    assert turned.stds < STDS
    assert turned.std_deg < min(turned_by_angles.std_deg, 0.1)
    for joint in (1, 2, 3):
        assert_angle_holds(drop, estimate, joint, widest_deg=0.05)


@DROPS
def test_gyros_that_contradict_each_other_are_named_and_none_corrects_another(seed: int, body: int) -> None:
    """Name gyros that contradict each other, and let none correct another.

    From the release on one shows 2 deg/s too much about each axis: far more than the loss of its weight causes.
    """
    drop = fly_drop(seed)
    calibration = certificate(drop, seed)
    log = gyro_plus(drop.log, body, np.outer(drop.log.t_s > 0.0, (2.0, 2.0, 2.0)))
    motion = estimate_motion(log, calibration, drop.model)
    assert motion.contradicted
    assert any(note.startswith("The sensors would have the gyros farther off") for note in notes_of(motion))
    for other in (1, 2, 3, 4):
        learnt, std = gyro_learnt(motion, other)
        assert not learnt.any()
        assert std == pytest.approx(np.sqrt(np.diag(motion.samples.parameter_covariance[other - 1])))
        if other != body:
            off = turn_off(drop, motion, other)
            assert off.stds < STDS
            assert off.std_deg < 0.4
    checks = failures_by_name(checks_of(motion, None, log, calibration, drop.model))
    pairs = {f"gyros of bodies {inner} and {inner + 1}" for inner in (body - 1, body) if 1 <= inner <= 3}
    assert pairs <= checks.keys()
    assert all(
        (checks[pair].cause or "").startswith(f"gyro of body {body}: its bias jumped") for pair in pairs
    )


@pytest.mark.parametrize("seed", few_of(1, 2, 3))
def test_healthy_gyros_do_not(seed: int) -> None:
    motion = drops.motion(seed)
    assert not motion.contradicted
    assert notes_of(motion) == []


SAMPLES = 800
NOISE_RAD = np.deg2rad(0.053)
BEND_STD_RAD = np.deg2rad(0.04)
ZERO_STD_RAD = np.deg2rad(0.002)
START_STD_RAD = np.pi


def make_standing_joint(angle_rad: float, seed: int) -> SensedJoint:
    """Return a joint at rest at an angle, with its sensors as calibrated up to the bend's uncertainty."""
    random = np.random.default_rng(seed)
    sensors = JointSensors(
        joint=3,
        direction=np.array([1.0, -1.0]),
        zero_rad=np.array([5.1, 1.8]),
        zero_covariance=ZERO_STD_RAD**2 * np.eye(2),
        bend=np.zeros((2, 4)),
        bend_covariance=BEND_STD_RAD**2 * np.eye(8),
        noise_rad=np.full(2, NOISE_RAD),
        zero_recorded_at=None,
        bend_recorded_at=None,
    )
    readings_rad = (
        sensors.zero_rad + sensors.direction * angle_rad + NOISE_RAD * random.standard_normal((SAMPLES, 2))
    )
    return SensedJoint.of(sensors, readings_rad, 0.0, np.zeros(SAMPLES))


@pytest.mark.parametrize("angle_deg", [-20.0, -2.2, 0.0, 2.2, 20.0])
def test_a_standing_joints_bend_does_not_follow_the_sensors_noise(angle_deg: float) -> None:
    """Noise times itself, sample for sample, would look like a bend of slope one: some percent of the angle."""
    by_start = np.full((SAMPLES, 1, 1), START_STD_RAD)
    off_deg = []
    for seed in range(20):
        joint = make_standing_joint(np.deg2rad(angle_deg), seed)
        begin = np.full((SAMPLES, 1), joint.mean_rad.mean())
        errors, *_ = errors_by_sensors(
            [joint], begin, by_start, np.zeros(1), np.ones(1, bool), (np.zeros((1, 1)), np.zeros(1))
        )
        found_rad = begin[0, 0] + START_STD_RAD * errors[0]
        off_deg.append(np.rad2deg(found_rad) - angle_deg)
    mean_std_deg = np.rad2deg(NOISE_RAD) / np.sqrt(2 * SAMPLES * len(off_deg))
    assert abs(np.mean(off_deg)) < 4.0 * mean_std_deg


FINITE = st.floats(-1e100, 1e100)


def assert_close(ours: FloatArray, theirs: FloatArray, given_to_both: FloatArray) -> None:
    """Assert equality to within rounding of the largest input."""
    np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=1e-9 * float(np.abs(given_to_both).max()))


@given(
    arrays(np.float64, st.tuples(st.integers(2, 60), st.integers(1, 3)), elements=FINITE),
    st.floats(1e-4, 0.05),
)
def test_a_lag_of_one_pole_is_that_pole(readings: FloatArray, constant_s: float) -> None:
    """Lag of one pole equals that pole's response.

    The signal is linear between samples and settled before the first of them.
    """
    t_s = FINE_S * np.arange(len(readings), dtype=np.float64)
    lag = Lag(constant_s, 0.0, 0.0, constant_s, measured=True)
    pole = ([[-1.0 / constant_s]], [[1.0 / constant_s]], [[1.0]], [[0.0]])
    late = np.column_stack([lsim(pole, column, t_s, X0=column[:1])[1] for column in readings.T])
    assert_close(lag.apply(t_s, readings), late, readings)


@given(arrays(np.float64, st.integers(SMOOTHED + 1, 60), elements=FINITE))
def test_smoothed_is_the_filter_of_savitzky_and_golay(values: FloatArray) -> None:
    smooth, half = smooth_savitzky_golay(values), SMOOTHED // 2
    assert_close(smooth[half:-half], savgol_filter(values, SMOOTHED, 3)[half:-half], values)


def test_the_ends_keep_no_more_of_a_samples_noise_than_is_stated() -> None:
    """A cubic's end keeps 0.96 of it: a joint without its gyro seemed to jerk just before the landing."""
    responses = np.stack([smooth_savitzky_golay(impulse) for impulse in np.eye(3 * SMOOTHED)])
    shares = np.sqrt((responses**2).sum(axis=0))
    assert shares.max() == pytest.approx(END_SHARE, abs=1e-3) and shares.argmax() in (0, len(shares) - 1)
    assert shares[1:-1].max() == pytest.approx(SMOOTHED_SHARE, abs=6e-3)
