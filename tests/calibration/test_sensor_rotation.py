"""Rotation and scale of a gyro from its responses, against the truth of a hundred drawn ones."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.calibration.synthetic_gyro import (
    RATE_HZ,
    Gyro,
    angle_reading,
    sway_between,
    sweeps,
    swings,
)
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.misalignment import Misalignment, solve_misalignment
from tfsat_host.calibration.mounting_checks import describe_misalignment
from tfsat_host.calibration.response import Response, direction, length_between_rests, with_length
from tfsat_host.calibration.sensors.gyro import SCALE_STD
from tfsat_host.calibration.statistics import mean_and_covariance, student_t_factor

X, Y, Z = np.eye(3)


def response(
    gyro: Gyro, axis: FloatArray, rng: np.random.Generator, *, angle_rad: float = np.pi / 3
) -> Response:
    """Measure the response: bias at rest, direction from swings, length from sweeps between rests."""
    bias, _ = mean_and_covariance(gyro.reads(np.zeros((int(3 * RATE_HZ), 3)), rng))
    angle, unsteady = swings(rng, 20.0)
    rate = np.gradient(angle, 1.0 / RATE_HZ)
    axis_response = direction(gyro.reads(rate[:, None] * axis + unsteady, rng) - bias, axis, rate)
    angle, rests = sweeps(8, angle_rad)
    rate = np.gradient(angle, 1.0 / RATE_HZ)
    reading = gyro.reads(rate[:, None] * axis + sway_between(rests, rng, len(rate)), rng) - bias
    t_s = np.arange(len(angle)) / RATE_HZ
    angles = np.array([angle_reading(angle[rest], rng) for rest in rests])
    return with_length(
        axis_response, *length_between_rests(t_s, reading @ axis_response.reading, rests, angles)
    )


def errors(gyro: Gyro, mounting: Misalignment) -> tuple[FloatArray, FloatArray]:
    """(9,) errors, rotation vector in sensor axes, scale and skew, and their stated standard deviations."""
    off = Rotation.from_matrix(mounting.rotation.T @ gyro.mounting).as_rotvec()
    others = mounting.scale - gyro.scale, mounting.skew - gyro.skew
    return np.concatenate([off, *others]), np.sqrt(np.diag(mounting.covariance))


@pytest.mark.parametrize("robots", [30, pytest.param(100, marks=pytest.mark.prove)])
def test_rotation_and_scale_of_many_gyros_and_their_intervals(robots: int) -> None:
    off, stated = np.empty((robots, 9)), np.empty((robots, 9))
    misfits = []
    for seed in range(robots):
        rng = np.random.default_rng(seed)
        gyro = Gyro.draw_random(rng)
        turned = response(gyro, Z, rng, angle_rad=2.0 * np.pi)  # by hand, through a full turn
        mounting = solve_misalignment([response(gyro, X, rng), response(gyro, Y, rng), turned], gyro.nominal)
        off[seed], stated[seed] = errors(gyro, mounting)
        misfits.append(mounting.misfit / mounting.degrees_of_freedom)
    assert np.degrees(np.sqrt((off[:, :3] ** 2).sum(axis=1).mean())) < 0.05
    assert np.sqrt((off[:, 3:6] ** 2).mean()) < 0.002
    inside = np.abs(off) < 1.96 * stated
    assert 0.90 <= inside[:, :3].mean() <= 0.99
    assert 0.90 <= inside[:, 3:6].mean() <= 0.99
    assert 0.90 <= inside[:, 6:].mean() <= 0.99
    assert 0.5 < np.mean(misfits) < 2.0


def test_the_axis_that_no_joint_turns_keeps_the_datasheets_tolerance() -> None:
    rng = np.random.default_rng(3)
    gyro = Gyro(np.eye(3), np.array([1.02, 0.98, 1.025]), np.zeros(3))
    mounting = solve_misalignment([response(gyro, X, rng), response(gyro, Y, rng)], gyro.nominal)
    off, stated = errors(gyro, mounting)
    assert stated[5] == pytest.approx(SCALE_STD, rel=0.02)
    assert np.abs(off[3:5]).max() < 0.003
    assert np.degrees(np.abs(off[:3]).max()) < 0.1


def test_directions_alone_tell_the_mounting_of_a_gyro_with_equal_scales() -> None:
    rng = np.random.default_rng(4)
    gyro = Gyro(Rotation.from_rotvec([0.02, -0.05, 0.08]).as_matrix(), np.full(3, 1.02), np.zeros(3))
    responses = []
    for axis in (X, Y):
        angle, unsteady = swings(rng, 20.0)
        rate = np.gradient(angle, 1.0 / RATE_HZ)
        responses.append(direction(gyro.reads(rate[:, None] * axis + unsteady, rng), axis, rate))
    assert not any(response.has_length for response in responses)
    off, _ = errors(gyro, solve_misalignment(responses, gyro.nominal))
    assert np.degrees(np.abs(off[:3]).max()) < 0.1


def test_a_response_about_another_axis_than_it_says_shows_as_misfit() -> None:
    rng = np.random.default_rng(5)
    gyro = Gyro.draw_random(rng)
    wrong = response(gyro, Rotation.from_rotvec([0.0, 0.0, 0.1]).apply(Y), rng)
    wrong = Response(Y, wrong.reading, wrong.covariance, True)
    mounting = solve_misalignment([response(gyro, X, rng), wrong], gyro.nominal)
    right = solve_misalignment([response(gyro, X, rng), response(gyro, Y, rng)], gyro.nominal)
    assert right.misfit < 12.0  # six numbers
    assert mounting.misfit > 22.5  # by chance once in a thousand


def test_a_swing_shortened_by_the_low_pass_would_be_wrong_but_rests_are_not() -> None:
    rng = np.random.default_rng(7)
    gyro = Gyro(np.eye(3), np.array([1.03, 1.0, 1.0]), np.zeros(3))
    assert np.linalg.norm(response(gyro, X, rng).reading) == pytest.approx(1.03, abs=0.003)


def test_the_other_sensor_says_which_way_the_axis_points() -> None:
    rng = np.random.default_rng(8)
    gyro = Gyro(np.eye(3), np.ones(3), np.zeros(3))
    angle, unsteady = swings(rng, 10.0)
    rate = np.gradient(angle, 1.0 / RATE_HZ)
    reads = gyro.reads(rate[:, None] * Y + unsteady, rng)
    assert direction(reads, Y, rate).reading == pytest.approx(Y, abs=0.01)
    assert direction(reads, Y, -rate).reading == pytest.approx(-Y, abs=0.01)


def test_the_rests_take_off_what_is_left_of_the_bias() -> None:
    """Half a deg/s over sweeps of different length would be a scale error of several percent."""
    rng = np.random.default_rng(9)
    gyro = Gyro(np.eye(3), np.array([1.02, 1.0, 1.0]), np.radians([0.5, 0.0, 0.0]))
    angle, rests = sweeps(8, np.pi / 3)
    rate = np.gradient(angle, 1.0 / RATE_HZ)
    reads = gyro.reads(rate[:, None] * X, rng)
    t_s = np.arange(len(angle)) / RATE_HZ
    ups = rests[:-1]  # one sweep more out than back, so that the bias does not cancel
    angles = np.array([angle_reading(angle[rest], rng) for rest in ups])
    length, std = length_between_rests(t_s, reads[:, 0], ups, angles)
    assert length == pytest.approx(1.02, abs=4.0 * std)
    assert std < 0.005
    drifting = reads[:, 0] + np.radians(2.0)
    shifted, _ = length_between_rests(t_s, drifting, ups, angles)
    assert shifted == pytest.approx(length, abs=1e-9)


def test_few_numbers_widen_a_variance() -> None:
    assert student_t_factor(4) == 2.0
    assert student_t_factor(1000) == pytest.approx(1.0, abs=0.003)
    with pytest.raises(ValueError, match="no variance"):
        student_t_factor(2)


def test_batch_means_know_that_filtered_noise_repeats_itself() -> None:
    """White noise of 1 through 5 Hz: the naive standard error is several times too small."""
    naive, stated, off = [], [], []
    for seed in range(200):
        rng = np.random.default_rng(seed)
        gyro = Gyro(np.eye(3), np.ones(3), np.zeros(3))
        still = gyro.reads(np.zeros((int(3 * RATE_HZ), 3)), rng)
        mean, covariance = mean_and_covariance(still)
        naive.append(still[:, 0].std() / np.sqrt(len(still)))
        stated.append(np.sqrt(covariance[0, 0]))
        off.append(mean[0])
    assert np.std(off) > 2.5 * np.mean(naive)
    assert np.mean(np.abs(off) < 1.96 * np.array(stated)) > 0.90


@pytest.mark.parametrize(
    ("turn_deg", "says"),
    [
        ((0, 0, 0), ""),
        ((3, -4, 2), ""),
        ((0, 0, 90), "x and y exchanged (its x, y, z lie along y, -x, z)"),
        ((90, 0, 0), "y and z exchanged (its x, y, z lie along x, z, -y)"),
        ((0, 0, 180), "looks turned: its x, y, z lie along -x, -y, z"),
    ],
)
def test_how_a_sensor_sits_is_said_in_words(turn_deg: tuple[float, ...], says: str) -> None:
    nominal = Rotation.from_euler("xyz", [90, 0, 90], degrees=True).as_matrix()
    rotation = nominal @ Rotation.from_rotvec(np.radians(turn_deg)).as_matrix()
    description = describe_misalignment(rotation, nominal)
    assert description.endswith(says) or says in description
    assert bool(description) == bool(says)
