"""Robots whose IMUs are other parts than the MPU-6050, all of a kind and mixed."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from tests.evaluation import drops
from tests.evaluation.drops import Drop, certificate, moved
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.recording import Recording
from tfsat_host.evaluation.motion.motion import Motion

ALL_ICM_20689 = bytes([0x98] * 4)
MIXED = bytes([0x68, 0x70, 0x68, 0x98])
PARTS = pytest.mark.parametrize("parts", [ALL_ICM_20689, MIXED], ids=bytes.hex)


@cache
def flown(parts: bytes) -> tuple[Drop, Motion]:
    one = drops.flown(1, parts=parts)
    return one, moved(one.log, certificate(one, 1))


@PARTS
def test_the_log_names_them_and_their_temperatures_are_right(parts: bytes) -> None:
    one, _ = flown(parts)
    assert one.log.header.who_am_i == parts
    assert one.log.imu_valid[one.log.t_s > -1.0].all()
    for temperature_c in (
        one.log.temperature_c,
        Recording.from_counts(Counts.from_log(one.log)).temperature_c,
    ):
        assert np.abs(np.nanmean(temperature_c, axis=0) - 25.0).max() < 0.1


@PARTS
def test_their_low_pass_is_taken_off(parts: bytes) -> None:
    """By the sheets 5.9 ms of the ICM-20689, 4.8 ms of the MPU-6050, half a millisecond of age besides."""
    _, found = flown(parts)
    expected_s = 6.4e-3 if parts == ALL_ICM_20689 else 5.3e-3
    assert found.lag.measured and found.lag.expected_s == pytest.approx(expected_s)
    assert found.lag.delay_s == pytest.approx(expected_s, abs=1e-4)


@PARTS
def test_angles_and_attitudes_are_as_right_as_with_the_papers_part(parts: bytes) -> None:
    one, found = flown(parts)
    fall = found.t_s >= 0.0
    error = np.rad2deg(found.angles_rad - one.true_angles_rad(found.t_s))[fall]
    assert np.sqrt((error**2).mean(axis=0)).max() < 0.05
    for body, track in enumerate(found.bodies, 1):
        true = one.true_turn(body, track.t_s[0], track.t_s[-1])
        off_rad = (track.attitude[-1] * true.inv()).magnitude()
        assert np.rad2deg(off_rad) < 0.06
        assert off_rad < 4.0 * np.sqrt(np.linalg.eigvalsh(track.covariance()).max())
