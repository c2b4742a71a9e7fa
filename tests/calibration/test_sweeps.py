"""Sweeps from rest to rest: scale factors within their intervals, and what is no sweep."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.calibration.bench_day import (
    MODEL,
    SWEEPS,
    SWINGS,
    TRUTH,
    accept,
    add_angle,
    changed,
    done,
    hands_move,
    known,
    record,
    refused,
)
from tfsat_host.calibration.solution import solve
from tfsat_host.calibration.steps.evidence import Evidence

SWEEP = SWEEPS[0]
UP_AND_DOWN = [15.0, 30.0, 45.0, 60.0, 75.0, 90.0, 60.0, 30.0, 0.0]


def swept(stops_deg: list[float], leg_s: float = 1.0, rest_s: float = 1.0) -> Evidence:
    """Body 1 about joint 1 by steady hands."""
    move, last_s = hands_move(1, SWEEP.held, stops_deg, leg_s, rest_s)
    return record(SWEEP, motion=move, last_s=last_s)


def test_scale_factors_of_two_axes_within_their_intervals() -> None:
    found = solve(known(*map(done, SWINGS), *map(done, SWEEPS)), MODEL)
    for gyro, scale in zip(found.gyros[:2], TRUTH.gyro_scale[:2], strict=True):
        stated = np.sqrt(np.diag(gyro.covariance))[6:8]
        assert np.all(stated < 0.004)
        assert np.all(np.abs(gyro.scale[:2] - scale[:2]) < 3.5 * stated)
        assert set(gyro.scaled) == {"x", "y"}
        assert gyro.covariance[8, 8] > 0.01**2  # about z nothing turned


def test_the_angle_sensors_bend_is_not_taken_for_a_scale_factor() -> None:
    found = solve(known(done(SWINGS[0]), done(SWEEP)), MODEL)
    apart = found.joints[0].bend[0] - found.joints[0].bend[1]
    true = TRUTH.angle_nonlinearity_rad[0] - TRUTH.angle_nonlinearity_rad[1]
    assert found.joints[0].bend_taken == done(SWEEP).taken
    assert np.all(np.abs(apart - true) < 4.0 * np.sqrt(2.0) * np.deg2rad(0.05))


def test_a_sweep_without_rests() -> None:
    error = refused(swept([30.0, 60.0, 90.0, 60.0, 30.0, 0.0] * 2, rest_s=0.0), known(done(SWINGS[0])))
    assert error.what.startswith("The sweep of joint 1 has ")
    assert "at least 6 are needed" in error.what
    assert "resting a second at each" in error.next_step


def test_a_sweep_whose_rests_are_too_short() -> None:
    error = refused(swept([30.0, 60.0, 90.0, 60.0, 30.0, 0.0], rest_s=0.2), known())
    assert "at least 6 are needed" in error.what
    accept(swept([30.0, 60.0, 90.0, 60.0, 30.0, 0.0], rest_s=0.7), known())


def test_a_swing_is_no_sweep() -> None:
    swing = replace(done(SWINGS[0]), step=SWEEP)
    assert "at least 6 are needed" in refused(swing, known()).what


def test_a_sweep_one_way_only() -> None:
    error = refused(swept([15.0, 30.0, 45.0, 60.0, 75.0, 90.0]), known())
    assert error.what == "The sweep of joint 1 went one way only."
    assert "and back in the same steps" in error.next_step


def test_there_and_back_in_other_steps_is_a_sweep() -> None:
    accept(swept(UP_AND_DOWN), known())


def test_a_hurried_leg_does_no_harm_and_one_beyond_the_full_scale_is_refused() -> None:
    quick = swept(UP_AND_DOWN, leg_s=0.4)
    accept(quick, known())
    found = solve(known(quick), MODEL).gyros[0]
    stated = np.sqrt(found.covariance[6, 6])
    assert abs(found.scale[0] - TRUTH.gyro_scale[0, 0]) < 3.5 * stated < 0.02
    error = refused(swept([90.0, 0.0] * 4, leg_s=0.25), known())
    assert "at its full scale" in error.what
    assert "slower than 500 deg/s" in error.next_step


@pytest.mark.parametrize("sensor", [1, 2])
def test_an_angle_sensor_that_bends_by_a_degree(sensor: int) -> None:
    bent = TRUTH.angle_nonlinearity_rad.copy()
    bent[sensor - 1, :2] += np.deg2rad([0.7, 0.7])
    truth = replace(TRUTH, angle_nonlinearity_rad=bent)
    error = refused(record(SWEEP, truth=truth), known())
    assert error.what.startswith(f"Angle sensor {sensor} of joint 1 bends by at least ")
    assert "times what the robot file says" in error.what
    assert error.next_step.endswith("tfsat-host calibrate scale --turn x 360")


def test_a_robot_file_that_says_so_takes_a_bent_sensor() -> None:
    bent = TRUTH.angle_nonlinearity_rad.copy()
    bent[0, :2] += np.deg2rad([0.7, 0.7])
    evidence = record(SWEEP, truth=replace(TRUTH, angle_nonlinearity_rad=bent))
    sensors = [replace(sensor, nonlinearity_rad=np.deg2rad(0.7)) for sensor in MODEL.angle_sensors]
    model = replace(MODEL, angle_sensors=tuple(sensors))
    accept(evidence, known(), model)
    gyro = solve(known(evidence), model).gyros[0]
    off, stated = gyro.scale[0] - TRUTH.gyro_scale[0, 0], np.sqrt(gyro.covariance[6, 6])
    assert abs(off) < 3.5 * stated
    assert not gyro.scaled  # too doubtful


def test_a_sensor_that_slips_by_less_than_is_refused_widens_the_interval() -> None:
    slipped = changed(done(SWEEP), add_angle(1, lambda share: 0.5 * (share > 0.5)))
    found, clean = (solve(known(done(SWINGS[0]), one), MODEL).gyros[0] for one in (slipped, done(SWEEP)))
    assert found.covariance[6, 6] > 2.0 * clean.covariance[6, 6]
    assert abs(found.scale[0] - TRUTH.gyro_scale[0, 0]) < 3.5 * np.sqrt(found.covariance[6, 6])
