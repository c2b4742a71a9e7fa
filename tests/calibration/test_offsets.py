"""Readings taken after their sample's time are told for that time."""

from __future__ import annotations

import numpy as np
import pytest

from tfsat_host.calibration.steps.sensor_samples import at_sample_times

T_S = np.arange(400) / 280.0
OFFSET_S = np.array([0.0, 390e-6])


def test_a_slow_motion_is_told_to_a_thousandth_of_what_the_offset_made_of_it() -> None:
    true = np.sin(6.0 * T_S)
    read = np.stack([true, np.sin(6.0 * (T_S + OFFSET_S[1]))], axis=1)[..., None]
    aligned_readings = at_sample_times(T_S, read, OFFSET_S, np.ones((400, 2), bool))
    # The ends have no slope of their own and stay as they were read.
    inner = slice(1, -1)
    assert np.array_equal(aligned_readings[:, 0], read[:, 0])
    # The offset alone is worth 2.3 thousandths.
    assert np.abs(read[:, 1, 0] - true).max() > 2.3e-3
    # Moved back along the slope between neighbours, 500 times less is left.
    assert np.abs(aligned_readings[inner, 1, 0] - true[inner]).max() < 5e-6


def test_angles_wrap_and_what_is_invalid_tells_no_slope() -> None:
    turned = 3.0 * T_S + 5.0
    read = np.stack([turned, turned + 3.0 * OFFSET_S[1]], axis=1) % (2 * np.pi)
    valid = np.ones((400, 2), bool)
    valid[[0, 7, 100, 101], 1] = False
    read[~valid] = 0.0
    aligned_readings = at_sample_times(T_S, read, OFFSET_S, valid, angles=True)
    assert aligned_readings[valid] == pytest.approx(
        np.stack([turned, turned], axis=1)[valid] % (2 * np.pi), abs=1e-9
    )
    # What is invalid stays what it was.
    assert (aligned_readings[~valid] == 0.0).all()


def test_without_an_offset_nothing_changes_and_noise_hardly_grows() -> None:
    noise = np.random.default_rng(1).normal(size=(4000, 2, 3))
    t_s, valid = np.arange(4000) / 280.0, np.ones((4000, 2), bool)
    assert np.array_equal(at_sample_times(t_s, noise, np.zeros(2), valid), noise)
    aligned_noise = at_sample_times(t_s, noise, OFFSET_S, valid)
    # A shift by a ninth of the interval weighs two readings: noise grows by less than 1 %.
    assert aligned_noise[:, 1].std() / noise[:, 1].std() == pytest.approx(1.0, abs=0.01)
