"""What all steps together tell: what was not measured stays doubtful, what is older gives way, order is no matter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from datetime import timedelta

import numpy as np
import pytest
from scipy.signal import savgol_filter
from scipy.spatial.transform import Rotation

from tests.calibration.bench_day import (
    COUNTS_PER_TURN,
    HANDS,
    MODEL,
    REST,
    SWEEPS,
    SWINGS,
    TRUTH,
    TURN,
    ZERO,
    add_angle,
    add_rate,
    change_counts,
    day,
    later,
    prepend_rest_zero,
    record,
    record_good_step,
    slip_sensor,
    true_rotation,
    true_skew,
)
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.misalignment import LANDING_TILT_STD_RAD
from tfsat_host.calibration.sensors.gyro import BIAS_STD_RAD_S, MOUNTING_STD_RAD, SKEW_STD, GyroCalibration
from tfsat_host.calibration.solution import Solution, solve
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.calibration.steps.step import StepKind
from tfsat_host.calibration.steps.step_motion import Motion
from tfsat_host.emulated.manual_motion import Operator

X, Y, Z = np.eye(3)
SOME = (SWINGS[0], SWINGS[2], SWEEPS[0], TURN)


def off_rad(gyro: GyroCalibration) -> FloatArray:
    """(3,) rotation vector from what was found to the truth, sensor axes."""
    return np.asarray(Rotation.from_matrix(gyro.rotation.T @ true_rotation(gyro.body)).as_rotvec())


def along_std_rad(gyro: GyroCalibration, axis_body: FloatArray) -> float:
    """Compute the standard deviation of the gyro's rotation about a body axis."""
    axis = gyro.rotation.T @ axis_body
    return float(np.sqrt(axis @ gyro.covariance[3:6, 3:6] @ axis))


def same(first: Solution, second: Solution) -> bool:
    return all(
        np.array_equal(gyro.rotation, other.rotation)
        and np.array_equal(gyro.scale, other.scale)
        and np.array_equal(gyro.covariance, other.covariance)
        for gyro, other in zip(first.gyros, second.gyros, strict=True)
    )


def test_without_evidence_all_is_as_designed() -> None:
    solution = solve((), MODEL)
    assert solution.used_evidence == ()
    for gyro, imu in zip(solution.gyros, MODEL.imus, strict=True):
        assert np.array_equal(gyro.rotation, imu.sensor_to_body)
        assert np.sqrt(np.diag(gyro.covariance)[:6]) == pytest.approx(
            [BIAS_STD_RAD_S] * 3 + [MOUNTING_STD_RAD] * 3
        )
        assert (gyro.bias_recorded_at, gyro.axes, gyro.scaled) == (None, {}, {})


def test_a_whole_day_is_right_within_what_it_states() -> None:
    solution = solve(day(), MODEL)
    assert [evidence.step.key for evidence in solution.used_evidence] == [
        evidence.step.key for evidence in day()
    ]
    for gyro in solution.gyros:
        stated = np.sqrt(np.diag(gyro.covariance))
        scale_off = gyro.scale - TRUTH.gyro_scale[gyro.body - 1]
        bias_off = gyro.bias_rad_s - TRUTH.gyro_bias_rad_s[gyro.body - 1]
        off = np.concatenate([bias_off, off_rad(gyro), scale_off, gyro.skew - true_skew(gyro.body)])
        assert np.all(np.abs(off) < 4.0 * stated)
        assert np.rad2deg(np.linalg.norm(off_rad(gyro))) < 0.6
        assert set(gyro.axes) == {"x", "y", "z"}


def test_one_joint_alone_leaves_the_turn_about_its_axis_as_designed() -> None:
    gyro = solve(prepend_rest_zero(record_good_step(SWINGS[0])), MODEL).gyros[0]
    assert along_std_rad(gyro, X) == pytest.approx(MOUNTING_STD_RAD, rel=0.02)
    for across in (Y, Z):
        assert along_std_rad(gyro, across) < np.deg2rad(1.5)
    measured, true = gyro.rotation.T @ X, true_rotation(1).T @ X
    # What is seen of the axis is right; scale factors and skews, not known yet, tilt it by up to a degree.
    assert np.rad2deg(np.linalg.norm(np.cross(measured, true))) < 1.2
    assert set(gyro.axes) == {"x"}
    others = solve(prepend_rest_zero(record_good_step(SWINGS[0])), MODEL).gyros[1:]
    assert all(np.array_equal(gyro.rotation, MODEL.imus[gyro.body - 1].sensor_to_body) for gyro in others)


def test_the_newest_of_a_step_replaces_what_was_before() -> None:
    """Replace older recordings of a step by the newest.

    The sensor was loose, and was fastened: the old swings would contradict the new ones.
    """
    slip = slip_sensor(2, (0.0, 0.0, 4.0))
    loose = [change_counts(later(record_good_step(step), -60), slip) for step in SWINGS[1:3]]
    fresh = prepend_rest_zero(record_good_step(SWINGS[1]), record_good_step(SWINGS[2]))
    solution = solve([*fresh, *loose], MODEL)
    assert same(solution, solve(fresh, MODEL))
    assert len(solution.used_evidence) == 4


def test_the_order_of_the_evidence_is_no_matter() -> None:
    steps = day(StepKind.SWEEP)
    shuffled: Sequence[Evidence] = [steps[i] for i in np.random.default_rng(1).permutation(len(steps))]
    assert same(solve(steps, MODEL), solve(shuffled, MODEL))


def test_a_landing_leaves_directions_in_doubt_and_lengths_as_they_were() -> None:
    steps = prepend_rest_zero(
        record_good_step(SWINGS[0]),
        record_good_step(SWINGS[2]),
        record_good_step(SWEEPS[0]),
        record_good_step(SWEEPS[2]),
    )
    landing = steps[-1].recorded_at + timedelta(minutes=10)
    before, after = (solve(steps, MODEL, when).gyros[0] for when in (None, landing))
    for axis in (X, Y):
        # Next to the hinge's half a degree, and the chip's skew: what tilts one axis alone may be either.
        assert along_std_rad(before, axis) < np.deg2rad(0.7)
        assert along_std_rad(after, axis) == pytest.approx(
            np.hypot(LANDING_TILT_STD_RAD, np.hypot(np.deg2rad(0.5), SKEW_STD)), rel=0.1
        )
    assert np.diag(after.covariance)[6:8] == pytest.approx(np.diag(before.covariance)[6:8], rel=0.2)
    assert after.scale[:2] == pytest.approx(before.scale[:2], abs=2e-4)
    assert set(before.axes) == set(after.axes) == {"x", "y"}
    assert max(after.axes.values()) < landing
    half = solve([*steps, later(record_good_step(SWINGS[0]), 600)], MODEL, landing).gyros[0]
    assert half.axes["y"] < landing < half.axes["x"]
    again = solve(
        [*steps, later(record_good_step(SWINGS[0]), 600), later(record_good_step(SWINGS[2]), 600)],
        MODEL,
        landing,
    ).gyros[0]
    assert min(again.axes.values()) > landing
    assert along_std_rad(again, X) < np.deg2rad(0.7)


def test_a_landing_before_all_steps_changes_nothing() -> None:
    steps = prepend_rest_zero(record_good_step(SWINGS[0]), record_good_step(SWINGS[2]))
    assert same(
        solve(steps, MODEL), solve(steps, MODEL, record_good_step(REST).recorded_at - timedelta(days=1))
    )


def test_zeros_that_are_missing_cost_certainty_not_truth() -> None:
    steps = [record_good_step(REST), *map(record_good_step, SWINGS)]
    with_zero, without = solve([*steps, record_good_step(ZERO)], MODEL), solve(steps, MODEL)
    for gyro in without.gyros:
        stated = np.sqrt(np.diag(gyro.covariance)[3:6])
        assert np.all(np.abs(off_rad(gyro)) < 4.0 * stated)
    # Body 3 sees joint 1's axis across joint 2, whose angle is not known well now.
    third = [np.trace(solution.gyros[2].covariance[3:6, 3:6]) for solution in (with_zero, without)]
    assert third[1] > third[0]


def seen_axes_off_deg(solution: Solution) -> list[float]:
    """Compute the errors of the axes measured by swings, in deg, for the bodies that both joints turn."""
    gyros = [solution.gyros[0], solution.gyros[1]]
    pairs = [
        (gyro.rotation @ gyro.inverse_response @ true_rotation(gyro.body).T @ axis, axis)
        for gyro in gyros
        for axis in (X, Y)
    ]
    return [float(np.rad2deg(np.linalg.norm(np.cross(measured_axis, axis)))) for measured_axis, axis in pairs]


def test_what_the_held_body_does_is_taken_off(monkeypatch: pytest.MonkeyPatch) -> None:
    """Hands at three times their limits, gyros without scale errors, whose own share is another matter."""
    truth = replace(TRUTH, gyro_scale=np.ones((4, 3)), gyro_cross_axis=np.zeros((4, 3, 3)))
    shaky = replace(Operator.human(5), sway_deg_s=3.0, reaction=0.03, tremor_deg_s=5.0, pace=HANDS.pace)
    steps = [record(step, truth=truth, hands=shaky) for step in (REST, ZERO, *SWINGS)]
    compensated = max(seen_axes_off_deg(solve(steps, MODEL)))

    def subtract_bias(motion: Motion, body: int) -> FloatArray:
        return np.asarray(motion.recording.rate_rad_s[:, body - 1] - motion.gyros[body - 1].bias_rad_s)

    monkeypatch.setattr(Motion, "readings", subtract_bias)
    plain = max(seen_axes_off_deg(solve(steps, MODEL)))
    assert compensated < 0.025
    assert plain > 0.5


def test_a_new_bias_leaves_what_was_measured_with_the_old_one_alone() -> None:
    """Preserve with a new bias the parameters measured with the old one.

    After a landing, or when warm, the sensors read 5 deg/s more, but did not earlier.
    """
    steps = prepend_rest_zero(*map(record_good_step, SOME))
    warm = change_counts(
        later(record_good_step(REST), 60),
        *(add_rate(body, lambda t_s: np.full((len(t_s), 3), 5.0)) for body in (1, 2, 3, 4)),
    )
    before, after = solve(steps, MODEL), solve([*steps, warm], MODEL)
    for old, new in zip(before.gyros, after.gyros, strict=True):
        assert np.rad2deg(new.bias_rad_s - old.bias_rad_s) == pytest.approx([5.0] * 3, abs=0.02)
        assert np.array_equal(new.rotation, old.rotation)
        assert np.array_equal(new.scale, old.scale)
    assert [evidence.step.key for evidence in after.used_evidence].count("rest") == 2


def test_a_sensor_of_a_joint_that_was_fastened_anew_leaves_the_motions_alone() -> None:
    steps = prepend_rest_zero(*map(record_good_step, SOME))
    moved = change_counts(later(record_good_step(ZERO), 60), add_angle(3, 6.0))
    before, after = solve(steps, MODEL), solve([*steps, moved], MODEL)
    assert np.rad2deg(after.joints[1].zero_rad - before.joints[1].zero_rad) == pytest.approx(
        [6.0, 0.0], abs=0.1
    )
    assert all(
        np.array_equal(gyro.rotation, other.rotation)
        for gyro, other in zip(before.gyros, after.gyros, strict=True)
    )


@pytest.mark.parametrize("degrees", [1.0, pytest.param(1.5, marks=pytest.mark.prove), 6.0])
def test_a_sensor_that_slipped_is_not_believed_half(degrees: float) -> None:
    """Refuse to mix directions from before and after a sensor slipped.

    Everything was measured; then the sensor slipped, and one motion was repeated.
    """
    slipped = change_counts(later(record_good_step(SWINGS[1]), 60), slip_sensor(2, (0.0, 0.0, degrees)))
    with pytest.raises(CalibrationError, match="The gyro on body 2 measured"):
        solve([*day(), slipped], MODEL)


def test_a_joint_that_follows_while_it_should_stay_closed_is_told_by_its_sensors() -> None:
    """Joint 2 opens by 0.8 % of joint 1: body 3 turns about another axis, which its joints' sensors know."""
    motion = record_good_step(SWINGS[1])
    t_s = (motion.counts.t_us - motion.counts.t_us[0]) * 1e-6
    sensor_rad = np.unwrap(motion.counts.angle_counts[:, 0] * (2 * np.pi / COUNTS_PER_TURN))
    joint_1_deg = np.rad2deg(savgol_filter(sensor_rad - sensor_rad[0], 41, 2))
    joint_2_deg = 0.008 * joint_1_deg
    # It turns about joint 2's axis, and joint 1's axis is no longer along its x.
    tilted = np.gradient(joint_1_deg, t_s) * np.sin(np.deg2rad(joint_2_deg))
    rates_deg_s = tilted[:, None] * Z - np.gradient(joint_2_deg, t_s)[:, None] * Y
    followed = change_counts(
        motion,
        add_angle(3, lambda _: joint_2_deg),
        add_angle(4, lambda _: -joint_2_deg),
        add_rate(3, lambda _: np.asarray(rates_deg_s @ true_rotation(3) @ TRUTH.gyro_response[2])),
    )
    closed, followed_gyro = (
        solve([*prepend_rest_zero(evidence), *map(record_good_step, SWINGS[2:4])], MODEL).gyros[2]
        for evidence in (motion, followed)
    )
    # 0.8 % of a radian would be 0.46 deg.
    assert np.rad2deg(np.linalg.norm(off_rad(followed_gyro) - off_rad(closed))) < 0.05


# Sweeps


def test_scale_factors_of_two_axes_within_their_intervals() -> None:
    solution = solve(prepend_rest_zero(*map(record_good_step, SWINGS), *map(record_good_step, SWEEPS)), MODEL)
    for gyro, scale in zip(solution.gyros[:2], TRUTH.gyro_scale[:2], strict=True):
        stated = np.sqrt(np.diag(gyro.covariance))[6:8]
        assert np.all(stated < 0.004)
        assert np.all(np.abs(gyro.scale[:2] - scale[:2]) < 3.5 * stated)
        assert set(gyro.scaled) == {"x", "y"}
        assert gyro.covariance[8, 8] > 0.01**2  # about z nothing turned


def test_the_angle_sensors_bend_is_not_taken_for_a_scale_factor() -> None:
    solution = solve(prepend_rest_zero(record_good_step(SWINGS[0]), record_good_step(SWEEPS[0])), MODEL)
    apart = solution.joints[0].bend[0] - solution.joints[0].bend[1]
    true = TRUTH.angle_nonlinearity_rad[0] - TRUTH.angle_nonlinearity_rad[1]
    assert solution.joints[0].bend_recorded_at == record_good_step(SWEEPS[0]).recorded_at
    assert np.all(np.abs(apart - true) < 4.0 * np.sqrt(2.0) * np.deg2rad(0.05))


def test_a_sensor_that_slips_by_less_than_is_refused_widens_the_interval() -> None:
    slipped = change_counts(record_good_step(SWEEPS[0]), add_angle(1, lambda share: 0.5 * (share > 0.5)))
    slipped_gyro, clean = (
        solve(prepend_rest_zero(record_good_step(SWINGS[0]), evidence), MODEL).gyros[0]
        for evidence in (slipped, record_good_step(SWEEPS[0]))
    )
    assert slipped_gyro.covariance[6, 6] > 2.0 * clean.covariance[6, 6]
    assert abs(slipped_gyro.scale[0] - TRUTH.gyro_scale[0, 0]) < 3.5 * np.sqrt(slipped_gyro.covariance[6, 6])
