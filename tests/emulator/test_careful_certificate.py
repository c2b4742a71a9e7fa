"""The certificate of a careful day that nobody spent: whole, and off by what it states."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from tfsat_host.emulated.emulated_certificate import careful_certificate
from tfsat_host.emulated.imperfections import draw_as_built
from tfsat_host.emulated.imu_part import imperfections_with, load_imu
from tfsat_host.robot import load_robot

MODEL = load_robot()
MEASURED = datetime(2026, 1, 5, 8, 0, tzinfo=UTC)


def test_nothing_is_missing_for_a_drop() -> None:
    certificate = careful_certificate(MODEL, draw_as_built(3), 3, MEASURED)
    assert certificate.shortcomings() == ()
    assert [servo_map.joint for servo_map in certificate.servo_maps] == [1, 2, 3]


def test_servo_maps_are_off_by_what_they_state() -> None:
    off = []
    for seed in range(1, 31):
        truth = draw_as_built(seed)
        truth = replace(truth, servo_gain=1.0 + 0.02 * np.random.default_rng(seed).standard_normal(3))
        for joint, servo_map in enumerate(careful_certificate(MODEL, truth, seed, MEASURED).servo_maps):
            pulses = MODEL.servos[joint].pulses
            assert pulses is not None
            nominal = (
                pulses.reference_angle_rad
                + (servo_map.middle_us - pulses.reference_pulse_us) / pulses.pulse_us_per_rad
            )
            true = np.array(
                [
                    truth.servo_offset_rad[joint] + truth.servo_gain[joint] * nominal,
                    truth.servo_gain[joint] / pulses.pulse_us_per_rad,
                    truth.servo_backlash_rad[joint],
                ]
            )
            estimate = np.array([servo_map.middle_rad, servo_map.slope_rad_per_us, servo_map.backlash_rad])
            std = np.sqrt(np.diag(servo_map.covariance))
            assert (np.rad2deg(std[[0, 2]]) < 0.4).all()
            off.append((estimate - true) / std)
    # 30 robots, three servos, three numbers each: 270 errors in their own std.
    assert np.abs(off).max() < 4.5
    assert np.std(off, axis=0) == pytest.approx(1.0, abs=0.35)


def test_a_bench_takes_what_gravity_does_to_a_gyro_for_its_bias() -> None:
    truth = imperfections_with(load_imu("mpu6050"), 5, draw_as_built(5))
    certificate = careful_certificate(MODEL, truth, 5, MEASURED)
    for body, gyro in enumerate(certificate.gyros):
        # Gravity along the sensor's own axes, by its true mounting.
        up = (truth.mounting[body] @ MODEL.imus[body].sensor_to_body).T @ [0.0, 0.0, 1.0]
        felt = truth.gyro_g_sensitivity_rad_s_g[body] @ up
        # What the chip feels of gravity is in its bias, as a bench cannot tell them apart.
        assert np.rad2deg(gyro.bias_rad_s - truth.gyro_bias_rad_s[body] - felt) == pytest.approx(
            0.0, abs=0.005
        )
        assert np.rad2deg(np.linalg.norm(felt)) > 0.02


def test_a_quieter_part_is_certified_as_quieter() -> None:
    noise = [
        careful_certificate(MODEL, imperfections_with(load_imu(name), 1, draw_as_built(1)), 1, MEASURED)
        .gyros[0]
        .noise_rad_s[0]
        for name in ("mpu6050", "adis16465_2")
    ]
    assert np.rad2deg(noise[0]) == pytest.approx(0.04)
    assert noise[1] == pytest.approx(0.7 * noise[0])
