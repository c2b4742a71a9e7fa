"""Minutes on the crane's hook, compressed: what is slow goes on, and nothing else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.emulator.fault_bench import SEED
from tests.fixtures.emulated_drop import read_card, releaser
from tfsat_host.emulated.emulated_robot import BoardIndex
from tfsat_host.emulated.imperfections import Imperfections, ideal
from tfsat_host.sdlog import DropLog

WARM = replace(
    ideal(), gyro_bias_slope_rad_s_c=np.full((4, 3), np.deg2rad(0.4)), warming_c=8.0, warming_s=180.0
)


def record_wait(wrong: Imperfections, *waits_s: float, powered: bool = True) -> tuple[DropLog, int]:
    """Record a second, wait, record another second; return the log and the virtual time passed waiting."""
    with releaser(seed=SEED, imperfections=wrong) as (robot, _, logger):
        robot.advance(500_000)
        if not powered:
            robot.set_power(BoardIndex.LOGGER, False)
        before_us = robot.now_us
        if powered:
            logger.start_recording()
            robot.advance(1_000_000)
            before_us = robot.now_us
        for wait_s in waits_s:
            robot.wait(wait_s)
        passed_us = robot.now_us - before_us
        if not powered:
            robot.set_power(BoardIndex.LOGGER, True)
            robot.advance(500_000)
            logger.start_recording()
        robot.advance(1_000_000)
        logger.stop_recording()
        return read_card(robot), passed_us


def gyro_deg_s(log: DropLog) -> NDArray[np.float64]:
    return np.asarray(log.imu_counts[:, :, 4:7] / log.header.gyro_lsb_per_deg_s)


def die_c(log: DropLog) -> NDArray[np.float64]:
    return np.asarray(log.imu_counts[:, :, 3] / 340.0 + 36.53)


def test_five_minutes_warm_the_dies_as_five_minutes_do() -> None:
    log, passed_us = record_wait(WARM, 300.0)
    assert passed_us == 0
    rows = log.imu_valid.all(axis=1)
    t_s = log.t_us * 1e-6
    late = rows & (t_s > t_s[-1] - 0.5)
    # Powered for about 2 s of virtual time, and then 300 s more.
    expected_c = 8.0 * (1.0 - np.exp(-(300.0 + t_s[late]) / 180.0))
    assert np.abs(die_c(log)[late] - 25.0 - expected_c[:, None]).max() < 0.1
    assert np.abs(gyro_deg_s(log)[late] - 0.4 * expected_c[:, None, None]).max() < 0.05
    assert np.abs(die_c(log)[rows & (t_s < t_s[0] + 0.5)] - 25.0).max() < 0.2
    assert log.verdict == "complete" and log.samples_lost == 0


def test_waits_add_up_and_end_with_the_power() -> None:
    twice, _ = record_wait(WARM, 100.0, 200.0)
    once, _ = record_wait(WARM, 300.0)
    assert np.array_equal(twice.imu_counts, once.imu_counts)
    cold, _ = record_wait(WARM, 300.0, powered=False)
    assert np.abs(die_c(cold)[cold.imu_valid.all(axis=1)] - 25.0).max() < 0.2


@pytest.mark.parametrize(("wait_s", "like_before"), [(1.0, True), (1000.0, False)])
def test_biases_wander_on_by_the_time_that_passed(wait_s: float, like_before: bool) -> None:
    means = []
    with releaser(seed=SEED, imperfections=replace(ideal(), gyro_wander_rad_s=np.deg2rad(0.5))) as (
        robot,
        _,
        logger,
    ):
        robot.wait(1000.0)
        logger.start_recording()
        starts_us = []
        for _ in range(8):
            starts_us.append(robot.now_us)
            robot.advance(300_000)
            robot.wait(wait_s)
        logger.stop_recording()
        log = read_card(robot)
    rates = gyro_deg_s(log).reshape(-1, 12)
    for start_us in starts_us:
        settled = (log.t_us > start_us + 100_000) & (log.t_us < start_us + 290_000)
        means.append(rates[settled & log.imu_valid.all(axis=1)].mean(axis=0))
    changes = np.diff(means, axis=0)
    # Gauss-Markov over 100 s: 0.5 sqrt(2 (1 - exp(-t / T))).
    expected = 0.5 * np.sqrt(2.0 * (1.0 - np.exp(-wait_s / 100.0)))
    assert np.std(changes) == pytest.approx(expected, rel=0.35)
    assert bool(np.abs(changes).max() < 0.4) == like_before


def test_the_same_seed_waits_the_same_way_and_a_robot_without_slow_errors_not_at_all() -> None:
    slow = replace(WARM, gyro_wander_rad_s=np.deg2rad(0.5), gyro_noise_rad_s_rthz=np.deg2rad(0.005))
    first, _ = record_wait(slow, 300.0)
    again, _ = record_wait(slow, 300.0)
    assert np.array_equal(first.imu_counts, again.imu_counts)
    noisy = replace(ideal(), gyro_noise_rad_s_rthz=np.deg2rad(0.005))
    with_wait, _ = record_wait(noisy, 300.0)
    without, _ = record_wait(noisy)
    assert np.array_equal(with_wait.imu_counts, without.imu_counts)


def test_no_time_passes_backwards() -> None:
    with (
        releaser(seed=SEED, imperfections=ideal()) as (robot, _, _),
        pytest.raises(ValueError, match="cannot be waited"),
    ):
        robot.wait(-1.0)
