"""What drives the IMUs' readings off besides their noise: forces, warmth, wander and blows; and IMUs as data files."""

from __future__ import annotations

import re
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.emulator.fault_bench import SEED, do_nothing, record
from tests.fixtures.emulated_drop import read_card, releaser
from tests.paths import HOST
from tfsat_host.emulated.emulated_robot import BoardIndex
from tfsat_host.emulated.imperfections import Imperfections, draw, draw_as_built, ideal
from tfsat_host.emulated.imu_part import imperfections_with, load_imu
from tfsat_host.emulated.library import EmulationError
from tfsat_host.sdlog import DropLog

PARTS = pytest.mark.parametrize("name", ["mpu6050", "adis16465_2"])


def gyro_deg_s(log: DropLog) -> NDArray[np.float64]:
    return np.asarray(log.imu_counts[:, :, 4:7] / log.header.gyro_lsb_per_deg_s)


def record_drop(wrong: Imperfections) -> DropLog:
    """Record one second in the releaser, one second of fall without rotation or stroke, and the landing."""
    with releaser(seed=SEED, imperfections=wrong) as (robot, _, logger):
        logger.start_recording()
        robot.advance(1_000_000)
        robot.drop(fall_s=1.0)
        robot.advance(1_500_000)
        logger.stop_recording()
        return read_card(robot)


def test_a_gyro_that_feels_forces_shows_another_bias_in_free_fall() -> None:
    sensitivity = np.zeros((4, 3, 3))
    sensitivity[:, :, 2] = np.deg2rad([[0.5, -1.0, 2.0]])  # to the force along z, which is up
    for feels in (True, False):
        wrong = replace(ideal(), gyro_g_sensitivity_rad_s_g=sensitivity) if feels else ideal()
        log = record_drop(wrong)
        assert log.release_us is not None
        held_mask = (log.t_us < log.release_us) & log.imu_valid.all(axis=1)
        falls = (log.t_us > log.release_us + 500_000) & (log.t_us < log.release_us + 900_000)
        change = gyro_deg_s(log)[held_mask].mean(axis=0) - gyro_deg_s(log)[falls].mean(axis=0)
        assert change == pytest.approx(np.tile([0.5, -1.0, 2.0], (4, 1)) * feels, abs=0.03)


def test_dies_that_get_warm_take_their_bias_along() -> None:
    slope = np.deg2rad([[0.4, -0.2, 0.1]]) * np.array([[1.0], [2.0], [-1.0], [0.0]])
    warm = replace(ideal(), gyro_bias_slope_rad_s_c=slope, warming_c=8.0, warming_s=20.0)
    with releaser(seed=SEED, imperfections=warm) as (robot, _, logger):
        logger.start_recording()
        robot.advance(60_000_000)
        logger.stop_recording()
        log = read_card(robot)
    t_s = log.t_us * 1e-6
    warmer_c = 8.0 * (1.0 - np.exp(-t_s / 20.0))
    rows = np.flatnonzero(log.imu_valid.all(axis=1))
    shown_c = log.imu_counts[rows, :, 3] / 340.0 + 36.53
    assert np.abs(shown_c - 25.0 - warmer_c[rows, None]).max() < 0.1
    expected = np.rad2deg(slope)[None] * warmer_c[rows, None, None]
    assert np.abs(gyro_deg_s(log)[rows] - expected).max() < 0.03


def test_a_power_cycle_lets_the_dies_cool_in_no_time_and_warm_anew() -> None:
    warm = replace(ideal(), warming_c=8.0, warming_s=5.0)
    with releaser(seed=SEED, imperfections=warm) as (robot, _, logger):
        robot.advance(20_000_000)
        robot.set_power(BoardIndex.LOGGER, False)
        robot.set_power(BoardIndex.LOGGER, True)
        robot.advance(300_000)
        logger.start_recording()
        robot.advance(300_000)
        logger.stop_recording()
        log = read_card(robot)
    shown_c = log.imu_counts[log.imu_valid.all(axis=1), 0, 3] / 340.0 + 36.53
    assert 25.0 < shown_c.mean() < 26.5


def test_a_bias_wanders_by_what_it_is_told_and_each_axis_its_own_way() -> None:
    wander = replace(ideal(), gyro_wander_rad_s=np.deg2rad(0.5))
    log, _, _ = record(do_nothing, then_us=300_000_000, imperfections=wander)
    rates = gyro_deg_s(log)[log.imu_valid.all(axis=1)].reshape(-1, 12)
    steady, _, _ = record(do_nothing, then_us=1_000_000, imperfections=ideal())
    assert np.ptp(gyro_deg_s(steady)[50:].reshape(-1, 12), axis=0).max() == 0.0
    # Three correlation times of twelve axes.
    assert rates.std() == pytest.approx(0.5, rel=0.35)
    assert np.ptp(np.diff(rates[::280], axis=0)) < 0.8
    assert np.abs(np.corrcoef(rates.T) - np.eye(12)).mean() < 0.6


@pytest.mark.parametrize("limit_g", [0.0, 20.0])
def test_a_landing_drives_gyros_to_their_ends_as_it_does_accelerometers(limit_g: float) -> None:
    log = record_drop(replace(ideal(), gyro_shock_limit_g=limit_g))
    assert log.release_us is not None
    landing = (log.t_us > log.release_us + 1_000_000) & (log.t_us < log.release_us + 1_150_000)
    at_end = np.isin(log.imu_counts, [32767, -32768])
    assert at_end[landing][:, :, 4:7].any() == (limit_g > 0.0)
    assert not at_end[log.t_us < log.release_us + 990_000].any()
    assert log.clipped[landing].any(axis=0).all()
    after = log.t_us > log.release_us + 1_400_000
    assert np.abs(gyro_deg_s(log)[after]).max() < 0.1


@PARTS
def test_each_figure_of_a_shipped_imu_says_where_it_is_from(name: str) -> None:
    part = load_imu(name)
    assert set(part.sources) == {field.name for field in fields(part)} - {"name", "sources"}
    assert all(len(source) > 5 for source in part.sources.values())


def test_an_imu_that_saturates_before_the_emulated_chip_is_refused(tmp_path: Path) -> None:
    shipped = (HOST / "emulated/imus/adis16465_2.toml").read_text(encoding="utf-8")
    (tmp_path / "small.toml").write_text(shipped.replace("value = 500.0", "value = 125.0"), encoding="utf-8")
    with pytest.raises(EmulationError, match="shows 125 deg/s at most"):
        load_imu(tmp_path / "small.toml")


def test_the_papers_comparison_of_the_two_imus() -> None:
    """Tab. adis."""
    mpu, adis = load_imu("mpu6050"), load_imu("adis16465_2")
    assert (mpu.gyro_range_deg_s, adis.gyro_range_deg_s) == (500.0, 500.0)
    assert (mpu.gyro_g_sensitivity_std_deg_s_g, adis.gyro_g_sensitivity_std_deg_s_g) == (0.1, 0.009)
    assert adis.gyro_bias_stability_deg_h == 2.5


def test_two_imus_with_one_seed_differ_by_the_part_alone() -> None:
    mpu, adis = load_imu("mpu6050"), load_imu("adis16465_2")
    a, b, c = imperfections_with(mpu, 4), imperfections_with(adis, 4), imperfections_with(mpu, 5)
    assert a.gyro_bias_rad_s / mpu.gyro_bias_std_deg_s == pytest.approx(
        b.gyro_bias_rad_s / adis.gyro_bias_std_deg_s
    )
    assert (a.gyro_scale - 1) / mpu.gyro_scale_std == pytest.approx((b.gyro_scale - 1) / adis.gyro_scale_std)
    assert np.array_equal(a.angle_zero_rad, b.angle_zero_rad)
    assert np.array_equal(a.angle_zero_rad, draw(4).angle_zero_rad)
    assert not np.array_equal(a.gyro_bias_rad_s, c.gyro_bias_rad_s)
    turned = np.rad2deg(
        np.arccos((np.trace(b.mounting @ draw(4).mounting.transpose(0, 2, 1), axis1=1, axis2=2) - 1) / 2)
    )
    assert 0.0 < turned.max() < 4 * adis.gyro_misalignment_std_deg


def test_the_better_imu_is_quieter_in_the_log() -> None:
    spread = []
    for name in ("mpu6050", "adis16465_2"):
        log, _, after = record(
            do_nothing, then_us=2_000_000, imperfections=imperfections_with(load_imu(name), 2)
        )
        rates = gyro_deg_s(log)[after]
        spread.append((rates.std(axis=0).mean(), np.abs(rates.mean(axis=0)).mean()))
    assert spread[0][0] > 1.2 * spread[1][0]
    assert spread[0][1] > 10 * spread[1][1]


def test_what_is_drawn_otherwise_has_none_of_it() -> None:
    for wrong in (ideal(), draw(1), draw_as_built(1)):
        assert not wrong.gyro_g_sensitivity_rad_s_g.any() and not wrong.gyro_bias_slope_rad_s_c.any()
        assert wrong.warming_c == wrong.gyro_wander_rad_s == wrong.gyro_shock_limit_g == 0.0


GOOD = (HOST / "emulated/imus/mpu6050.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("pattern", "text", "reason"),
    [
        (r"^name.*$", "", "name: is missing"),
        (r"^noise_deg.*$", "", r"gyro\.noise_deg_s_rthz: is missing"),
        (
            r"value = 0\.005,",
            "value = -0.005,",
            r":9: gyro\.noise_deg_s_rthz\.value: -0\.005 is not a num",
        ),
        (r"value = 500\.0,", "value = 0,", "range_deg_s.value: 0 is not a number above 0"),
        (r"value = 0\.005, source = .*\}", "value = 0.005 }", "source: is missing"),
        (r"^noise_deg_s_rthz = .*$", "noise_deg_s_rthz = 0.005", "0.005 is not { value"),
        (r"^\[die\]$", '[die]\ncolour = { value = 1, source = "me" }', r"die\.colour: is not known"),
        (r"^\[die\]$", "[dye]", "dye: is not known"),
        (r"^\[gyro\]$", "kind = 1\n[gyro]", "kind: is not known"),
    ],
)
def test_a_file_that_is_no_imu_says_where(tmp_path: Path, pattern: str, text: str, reason: str) -> None:
    file = tmp_path / "mine.toml"
    broken, replacement_count = re.subn(pattern, text, GOOD, count=1, flags=re.MULTILINE)
    assert replacement_count == 1
    file.write_text(broken, encoding="utf-8")
    with pytest.raises(EmulationError, match=reason):
        load_imu(file)
    file.write_text(GOOD, encoding="utf-8")
    assert load_imu(file) == load_imu("mpu6050")


def test_an_imu_that_is_not_there_names_those_that_are(tmp_path: Path) -> None:
    with pytest.raises(EmulationError, match=r"adis16465_2, mpu6050"):
        load_imu(tmp_path / "none.toml")
    with pytest.raises(EmulationError, match=r"adis16465_2, mpu6050"):
        load_imu("icm20948")
