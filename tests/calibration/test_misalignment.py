"""Axes and biases against the emulated robot's hidden truth, and how often their intervals hold it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.calibration.bench_day import (
    MODEL,
    REST,
    SWINGS,
    TRUTH,
    prepend_rest_zero,
    record,
    record_good_step,
    true_rotation,
)
from tfsat_host.calibration.bias import estimate_biases
from tfsat_host.calibration.findings import joint_axes
from tfsat_host.calibration.solution import solve
from tfsat_host.calibration.steps.step import PATTERNS
from tfsat_host.emulated.imperfections import draw


def test_patterns_are_the_papers_table() -> None:
    patterns = [(joint, moved) for joint, moved, _ in PATTERNS]
    assert patterns == [(1, (1,)), (1, (2, 3)), (2, (1, 2)), (2, (3, 4)), (3, (4,))]
    covered = {(body, joint % 2) for joint, moved in patterns for body in moved}
    assert covered == {(body, axis) for body in (1, 2, 3, 4) for axis in (0, 1)}  # two axes for each gyro


def test_the_axis_of_every_moved_gyro() -> None:
    gyros = solve(prepend_rest_zero(*map(record_good_step, SWINGS)), MODEL).gyros
    for step in SWINGS:
        rows = joint_axes(gyros, record_good_step(step), MODEL)
        assert [row.gyro.body for row in rows] == list(step.moved)
        for row in rows:
            axis, std_deg = row.axis_sensor, row.std_deg
            true = true_rotation(row.gyro.body).T @ MODEL.joint_axis[step.moving_joint - 1]
            assert axis @ true > 0, "the sign is the joint's opening direction"
            assert np.rad2deg(np.linalg.norm(np.cross(axis, true))) < 4.0 * std_deg < 2.4
            true_angle = np.rad2deg(np.arccos(true @ row.nominal_sensor))
            assert row.angle_deg == pytest.approx(true_angle, abs=4.0 * std_deg)
            assert row.rms_rate_deg_s > 20.0


def test_stated_intervals_of_biases_hold_the_truth() -> None:
    # Eight seeds of 96 rates: the stated intervals are judged together.
    inside, off_deg_s = [], []
    for seed in range(1, 9):
        truth = replace(TRUTH, gyro_bias_rad_s=draw(seed).gyro_bias_rad_s)
        still = record(
            REST,
            truth=truth,
            motion=lambda robot: robot.hold((1, 2, 3, 4)),
            last_s=3.0,
            seed=seed,
            # Held still by hands for three seconds.
        )
        for estimate in estimate_biases(still.recording):
            off = estimate.bias_rad_s - truth.gyro_bias_rad_s[estimate.body - 1]
            inside += list(np.abs(off) < 1.96 * np.sqrt(np.diag(estimate.covariance)))
            off_deg_s += list(np.degrees(off))
            assert estimate.temperature_c == pytest.approx(25.0, abs=0.5)
    assert np.sqrt(np.mean(np.square(off_deg_s))) < 0.02
    assert 0.88 <= np.mean(inside) <= 0.99  # of 96
