"""The bias of every gyro at rest: its interval against the emulated robot's truth, and what is no rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.calibration.synthetic_gyro import RATE_HZ
from tests.calibration.test_misalignment import Bench
from tfsat_host.calibration.bias import estimate_biases
from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.calibration.steps.recording import Recording
from tfsat_host.emulated.robot import SETTLE_US, EmulatedRobot


def rest(n: int = 840) -> Recording:
    """Three seconds in which nothing happens, with the noise of an MPU-6050."""
    rng = np.random.default_rng(1)
    return Recording(
        t_s=np.arange(n) / RATE_HZ,
        rate_rad_s=np.radians([1.0, -2.0, 0.5]) + np.radians(0.02) * rng.normal(size=(n, 4, 3)),
        accel_m_s2=np.array([0.0, 0.0, 9.80665]) + 0.02 * rng.normal(size=(n, 4, 3)),
        temperature_c=np.tile([24.0, 25.0, 26.0, 27.0], (n, 1)),
        sensor_angle_rad=np.zeros((n, 6)),
        imu_valid=np.ones((n, 4), dtype=bool),
        clipped=np.zeros((n, 4), dtype=bool),
        samples_lost=0,
        angle_step_rad=2 * np.pi / 4096,
    )


def test_stated_intervals_hold_the_truth_of_emulated_robots() -> None:
    inside, off_deg_s = [], []
    for seed in range(1, 16):
        robot = EmulatedRobot(seed=seed)
        robot.advance(SETTLE_US)
        bench = Bench(robot)
        bench.operator.rest()
        for estimate in estimate_biases(bench.record(3.0)):
            off = estimate.bias_rad_s - robot.imperfections.gyro_bias_rad_s[estimate.body - 1]
            inside += list(np.abs(off) < 1.96 * np.sqrt(np.diag(estimate.covariance)))
            off_deg_s += list(np.degrees(off))
            assert estimate.temperature_c == pytest.approx(25.0, abs=0.5)
        robot.close()
    assert np.sqrt(np.mean(np.square(off_deg_s))) < 0.02
    assert 0.88 <= np.mean(inside) <= 0.99  # of 180


def test_bias_and_temperature_of_each_body() -> None:
    found = estimate_biases(rest())
    assert [one.body for one in found] == [1, 2, 3, 4]
    assert [one.temperature_c for one in found] == [24.0, 25.0, 26.0, 27.0]
    for one in found:
        assert np.degrees(one.bias_rad_s) == pytest.approx([1.0, -2.0, 0.5], abs=0.005)


def test_a_body_that_turns_slowly_is_refused() -> None:
    turning = rest()
    turning.rate_rad_s[:, 2, 1] += np.radians(0.3) * np.linspace(0.0, 1.0, len(turning.t_s))
    with pytest.raises(CalibrationError, match=r"The gyro on body 3 drifted by 0\.15 deg/s"):
        estimate_biases(turning)


def test_a_body_that_is_shaken_is_refused() -> None:
    shaken = rest()
    shaken.accel_m_s2[:, 0, 0] += 9.80665 * 0.1 * np.sin(np.arange(len(shaken.t_s)))
    with pytest.raises(CalibrationError, match=r"Body 1 was shaken: its accelerometer scattered by 0\.07 g"):
        estimate_biases(shaken)


@pytest.mark.parametrize("factor", [0.0, 0.8, 1.2])
def test_a_body_that_does_not_feel_its_weight_is_refused(factor: float) -> None:
    floating = rest()
    floating = replace(floating, accel_m_s2=factor * floating.accel_m_s2)
    with pytest.raises(CalibrationError, match=f"reads {factor:.2f} g at rest, not 1 g"):
        estimate_biases(floating)


def test_the_offset_of_a_real_accelerometer_is_no_reason() -> None:
    real = rest()
    real.accel_m_s2[:] += 0.06 * 9.80665
    assert len(estimate_biases(real)) == 4
