"""Rehearsals with another IMU: the part's errors and nothing else, the command, and the page that compares two."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pytest

from tests.cli.process import RunCli
from tests.paths import HOST
from tests.rehearsal.days import Rehearsing
from tests.rehearsal.imus_page import IMUS, ORBIT_S, PAGE, fly, orbit_rows, robots_table, wander_deg
from tfsat_host.emulated.imperfections import GYRO_WANDER_S
from tfsat_host.emulated.imu_part import load_imu, wander_std_deg_s
from tfsat_host.rehearsal import series
from tfsat_host.rehearsal.series import RehearsedDrop
from tfsat_host.rehearsal.truth import drawn_truth, truth_as_filed
from tfsat_host.robot import load_robot

SHIPPED = HOST / "emulated/imus"


def test_a_robot_of_another_imu_differs_by_that_alone() -> None:
    filed = load_robot()
    own, other = (drawn_truth(filed, 4, load_imu(imu)) for imu in IMUS)
    assert np.array_equal(own.model.com_m, other.model.com_m)
    assert np.array_equal(own.rate_rad_s, other.rate_rad_s)
    for name in ("servo_gain", "servo_offset_rad", "angle_zero_rad", "logger_clock_ppm", "logger_serial"):
        assert np.array_equal(getattr(own.imperfections, name), getattr(other.imperfections, name))
    # The same draws, scaled by each part's figure: 0.1 and 0.009 deg/s/g.
    ratio = own.imperfections.gyro_g_sensitivity_rad_s_g / other.imperfections.gyro_g_sensitivity_rad_s_g
    assert ratio == pytest.approx(0.1 / 0.009)
    assert drawn_truth(filed, 4).imu == own.imu == "InvenSense MPU-6050"
    assert own.imperfections.gyro_shock_limit_g > 0.0
    assert not truth_as_filed(filed, 4).imperfections.gyro_g_sensitivity_rad_s_g.any()


def test_the_command_takes_an_imu_from_a_file(tfsat_host: RunCli) -> None:
    shutil.copy(SHIPPED / "adis16465_2.toml", tfsat_host.folder / "mine.toml")
    tfsat_host("rehearse", "59", "70", "--imu", "mine.toml", expect=None)
    truth = json.loads((tfsat_host.folder / "run" / "truth.json").read_text())
    shipped = drawn_truth(load_robot(), 1, load_imu("adis16465_2")).imperfections
    assert truth["imu"] == "Analog Devices ADIS16465-2"
    assert truth["imperfections"]["gyro_shock_limit_g"] == 30.0
    assert truth["imperfections"]["gyro_bias_rad_s"] == shipped.gyro_bias_rad_s.tolist()


def test_an_unknown_imu_is_refused(tfsat_host: RunCli) -> None:
    for options in ((), ("--runs", "2")):
        refused = tfsat_host("rehearse", "59", "70", "--imu", "best", *options, expect=1)
        assert "adis16465_2, mpu6050" in refused.stderr
        assert "Traceback" not in refused.stderr
        refused = tfsat_host("rehearse", "59", "70", "--imu", "mpu6050", "--as-filed", *options, expect=2)
        assert "contradict" in refused.stderr
    assert not (tfsat_host.folder / "run").exists()


@pytest.fixture(scope="module")
def first_robot() -> dict[str, tuple[RehearsedDrop, ...]]:
    """Fly the page's first robot with each IMU."""
    return fly(
        1, lambda imu_series, runs: tuple(series.fly(imu_series, number) for number in range(1, runs + 1))
    )


def test_the_page_is_of_these_robots(first_robot: dict[str, tuple[RehearsedDrop, ...]]) -> None:
    text = PAGE.read_text(encoding="utf-8")
    for line in robots_table(first_robot):
        assert line in text, "python -m tests.rehearsal.imus_page"
    assert "".join(orbit_rows([load_imu(imu) for imu in IMUS])) in text


def test_the_pages_robots_are_those_of_the_command(
    first_robot: dict[str, tuple[RehearsedDrop, ...]], shared_rehearsal: Rehearsing
) -> None:
    estimates = {
        estimate["name"]: estimate["found"] for estimate in shared_rehearsal("59", "70").result["compared"]
    }
    assert {
        estimate.name: estimate.estimate for estimate in first_robot["mpu6050"][0].compared
    } == pytest.approx(estimates, abs=1e-6)


def test_what_the_page_says_of_orbit_is_what_a_wandering_bias_integrates_to() -> None:
    # By Monte Carlo against the closed form: 1 s is a hundredth of the correlation time.
    part, step_s = load_imu("mpu6050"), 1.0
    random = np.random.default_rng(1)
    std, decay = wander_std_deg_s(part), np.exp(-step_s / GYRO_WANDER_S)
    bias = std * random.standard_normal(20_000)
    angle = np.zeros_like(bias)
    for _ in range(int(ORBIT_S / step_s)):
        before = bias
        # A first-order Gauss-Markov process keeps its variance from step to step.
        bias = decay * bias + std * np.sqrt(1.0 - decay**2) * random.standard_normal(len(bias))
        angle += 0.5 * (before + bias) * step_s
    # 20,000 draws give a standard deviation to 0.5 %.
    assert angle.std() == pytest.approx(wander_deg(part, ORBIT_S), rel=0.03)
