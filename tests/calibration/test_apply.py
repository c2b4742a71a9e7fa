"""From counts to body axes: against the emulated robot's truth, and what is said of the errors against their effect."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tests.calibration.some_calibration import drawn_calibration, whole_calibration
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.apply import CalibratedSamples, apply_calibration
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.sensors.gyro import GyroCalibration, by_design, skews_of
from tfsat_host.calibration.sensors.joint_sensors import sensor_columns, sensors_by_design
from tfsat_host.calibration.steps.counts import Counts, Scales
from tfsat_host.calibration.steps.sensor_samples import SensorSamples
from tfsat_host.calibration.steps.step import swings
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.emulated.imperfections import draw_as_built
from tfsat_host.protocol.live_sample import LiveSample
from tfsat_host.robot import load_robot

SCALES = Scales(280.0, 65.5, 16384.0, 4096)
MODEL = load_robot()
TAKEN = datetime(2026, 7, 1, tzinfo=UTC)


def calibration_by_truth(robot: EmulatedRobot) -> Calibration:
    """Return the perfect calibration: the true parameters with zero covariance."""
    truth, model = robot.imperfections, robot.model
    gyros = tuple(
        replace(
            # The file's orientation with the true misalignment on top.
            by_design(body, truth.mounting[body - 1] @ model.imus[body - 1].sensor_to_body),
            bias_rad_s=truth.gyro_bias_rad_s[body - 1],
            scale=truth.gyro_scale[body - 1],
            skew=skews_of(truth.gyro_cross_axis[body - 1]),
            covariance=np.zeros((12, 12)),
        )
        for body in range(1, 5)
    )
    joints = []
    for joint in (1, 2, 3):
        design = sensors_by_design(model, joint)
        columns = sensor_columns(model, joint)
        zero = np.mod(design.zero_rad + truth.angle_zero_rad[columns], 2 * np.pi)
        a, b, c, d = truth.angle_nonlinearity_rad[columns].T  # at zero the sensor is off by this
        at_zero = a * np.sin(zero) + b * np.cos(zero) + c * np.sin(2 * zero) + d * np.cos(2 * zero)
        joints.append(
            replace(
                design,
                zero_rad=zero + at_zero,
                bend=truth.angle_nonlinearity_rad[columns],
                zero_covariance=np.zeros((2, 2)),
                bend_covariance=np.zeros((8, 8)),
                noise_rad=np.full(2, truth.angle_noise_rad),
            )
        )
    return replace(whole_calibration(), gyros=gyros, joints=tuple(joints))


@pytest.fixture(scope="module")
def swung() -> Iterator[tuple[EmulatedRobot, CalibratedSamples]]:
    """Yield an as-built robot and the samples of a swing of its joint 2, perfectly calibrated.

    Its angle sensors have poor magnets.
    """
    built = draw_as_built(11)
    # Ten times the drawn nonlinearity: what is corrected must show.
    bent = replace(built, angle_nonlinearity_rad=10 * built.angle_nonlinearity_rad)
    with EmulatedRobot(seed=11, imperfections=bent) as robot:
        robot.advance(SETTLE_US)
        logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
        robot.record_truth(1000)
        robot.hold(swings(2)[0].held)
        # Joint 2 swings 60 deg every 2 s, five times.
        robot.swing(2, 60.0, 2.0, 5)
        samples: list[LiveSample] = []
        with logger.live() as reply:
            while not samples or samples[-1].time_us - samples[0].time_us < 6e6:
                # 6 s of samples: three swings.
                samples += logger.live_samples()
        counts = Counts.from_live(samples, reply)
        yield robot, apply_calibration(counts, calibration_by_truth(robot), robot.model)


def at_samples(robot: EmulatedRobot, t_s: FloatArray, columns: slice) -> FloatArray:
    truth = robot.truth()
    return np.stack([np.interp(t_s, truth[:, 0], column) for column in truth[:, columns].T], axis=1)


def test_body_rates_are_the_truth(swung: tuple[EmulatedRobot, CalibratedSamples]) -> None:
    robot, calibrated_samples = swung
    # Compared at the delay that suits best.
    delays_s = np.arange(0.0, 0.02, 0.0005)  # of the low-pass, and when in its period a sensor is read
    errors = []
    for delay_s in delays_s:
        true = at_samples(robot, calibrated_samples.t_s - delay_s, slice(20, 32)).reshape(-1, 4, 3)
        errors.append(np.degrees(np.sqrt(np.mean((calibrated_samples.rate_rad_s - true) ** 2, axis=0))))
    best = np.min(errors, axis=0)
    assert np.degrees(np.abs(calibrated_samples.rate_rad_s).max()) > 60.0, "something moved"
    # A moving body is off by the low-pass's amplitude, too.
    assert best.max() < 0.35
    still = [2, 3]  # bodies 3 and 4 were held
    assert best[still].max() < 0.08
    # A held body reads zero on average: its bias is taken off.
    assert np.degrees(np.abs(calibrated_samples.rate_rad_s[:, still].mean(axis=0)).max()) < 0.01


def test_joint_angles_are_the_truth(swung: tuple[EmulatedRobot, CalibratedSamples]) -> None:
    robot, calibrated_samples = swung
    delays_s = np.arange(-0.004, 0.004, 0.0005)  # when in its period a sensor is read
    errors = [
        np.degrees(
            calibrated_samples.joint_angle_rad
            - at_samples(robot, calibrated_samples.t_s + delay_s, slice(1, 4))
        )
        for delay_s in delays_s
    ]
    assert np.degrees(np.ptp(calibrated_samples.joint_angle_rad[:, 1])) > 50.0, "something moved"
    best = np.min([np.sqrt(np.mean(error**2, axis=0)) for error in errors], axis=0)
    assert best.max() < 0.08
    assert np.abs(errors[0][:, [0, 2]].mean(axis=0)).max() < 0.01  # joints that stand
    # Two sensors of 0.05 deg each, averaged.
    assert np.degrees(calibrated_samples.joint_angle_std_rad) == pytest.approx(0.05 / np.sqrt(2), rel=1e-6)


def test_specific_forces_are_the_weight_where_nothing_moves(
    swung: tuple[EmulatedRobot, CalibratedSamples],
) -> None:
    robot, calibrated_samples = swung
    up = (
        Rotation.from_quat(at_samples(robot, calibrated_samples.t_s[:1], slice(12, 16))[0])
        .inv()
        .apply([0, 0, 9.80665])
    )
    # Specific force at rest points up and is one g.
    assert calibrated_samples.specific_force_m_s2[:, 2].mean(axis=0) == pytest.approx(up, abs=0.05)
    assert (calibrated_samples.specific_force_std_m_s2[:, 2] > 0.28).all()


def counts_of(rng: np.random.Generator, n: int) -> Counts:
    return Counts(
        t_us=np.arange(n, dtype=np.int64) * 3571,
        imu_counts=rng.integers(-20000, 20000, (n, 4, 7)).astype(np.int16),
        angle_counts=rng.integers(0, 4096, (n, 6)).astype(np.uint16),
        imu_valid=np.ones((n, 4), dtype=bool),
        angle_valid=np.ones((n, 6), dtype=bool),
        clipped=np.zeros((n, 4), dtype=bool),
        samples_lost=0,
        scales=SCALES,
    )


def change_gyro(gyro: GyroCalibration, step: FloatArray) -> GyroCalibration:
    """Return the gyro with its nine parameters changed: the rotation vector is in sensor axes."""
    turned = gyro.rotation @ Rotation.from_rotvec(step[3:6]).as_matrix()
    return replace(
        gyro,
        bias_rad_s=gyro.bias_rad_s + step[:3],
        rotation=turned,
        scale=gyro.scale + step[6:9],
        skew=gyro.skew + step[9:],
    )


@settings(max_examples=4)
@given(st.integers(0, 2**32))
def test_the_jacobian_is_how_rates_change_with_the_parameters(seed: int) -> None:
    calibration = drawn_calibration(seed)
    counts = counts_of(np.random.default_rng(seed), 3)
    applied = apply_calibration(counts, calibration, MODEL)
    size = 1e-6
    for parameter in range(12):
        # Central differences of 1e-6 in each of the nine parameters.
        step = size * np.eye(12)[parameter]
        ends = [
            apply_calibration(
                counts,
                replace(
                    calibration, gyros=tuple(change_gyro(gyro, sign * step) for gyro in calibration.gyros)
                ),
                MODEL,
            ).rate_rad_s
            for sign in (1, -1)
        ]
        slope = (ends[0] - ends[1]) / (2 * size)
        # The Jacobian is what the covariance of the rates is computed with.
        np.testing.assert_allclose(applied.rate_jacobian[..., parameter], slope, rtol=1e-5, atol=1e-5)


def test_the_covariance_is_how_rates_scatter() -> None:
    """Monte Carlo over all nine parameters, correlated, and over a sample's noise."""
    rng = np.random.default_rng(5)
    counts = counts_of(rng, 2)
    # A random covariance of all nine errors together, correlated.
    root = np.radians(0.2) * rng.normal(size=(12, 12))
    calibration = drawn_calibration(8)
    gyros = tuple(
        replace(gyro, covariance=root @ root.T, noise_rad_s=np.full(3, 0.02), temperature_c=np.nan)
        for gyro in calibration.gyros
    )
    applied = apply_calibration(counts, replace(calibration, gyros=gyros), MODEL)
    assert applied.parameter_covariance == pytest.approx(np.tile(root @ root.T, (4, 1, 1)))
    readings = np.radians(counts.imu_counts[:, 1, 4:7] / SCALES.gyro_lsb_per_deg_s)
    sampled_rates = np.array(
        [
            change_gyro(gyros[1], root @ rng.normal(size=12)).body_rates(
                readings + 0.02 * rng.normal(size=(2, 3))
            )
            for _ in range(4000)
        ]
    )
    for n in range(2):
        scatter = np.cov(sampled_rates[:, n], rowvar=False)
        size = np.sqrt(np.outer(np.diag(scatter), np.diag(scatter)))
        # Relative to the scatter, which 4000 samples tell to some percent.
        assert applied.rate_covariance[n, 1] / size == pytest.approx(scatter / size, abs=0.08)


def test_a_die_that_is_warmer_than_when_it_rested_makes_its_bias_doubtful() -> None:
    """Increase the bias's uncertainty for a die that is warmer than at rest.

    By the data sheet it drifts within 20 deg/s over 62.5 deg C, uniformly distributed.
    """
    counts = counts_of(np.random.default_rng(6), 50)
    temperature_c = SensorSamples.from_counts(counts).temperature_c
    calibration = whole_calibration()
    cold = tuple(
        replace(gyro, temperature_c=float(temperature_c[:, gyro.body - 1].min()) - 3.0)
        # Its rest was 3 deg C colder than its coldest sample.
        for gyro in calibration.gyros
    )
    applied = apply_calibration(counts, replace(calibration, gyros=cold), MODEL)
    for gyro, covariance in zip(cold, applied.parameter_covariance, strict=True):
        warmer_c = float(temperature_c[:, gyro.body - 1].mean()) - gyro.temperature_c
        added_variance = np.diag(covariance - gyro.covariance)
        # 20 deg/s over 62.5 deg C, uniform: divided by the square root of three.
        assert np.degrees(np.sqrt(added_variance[:3])) == pytest.approx([20.0 / 62.5 / 3**0.5 * warmer_c] * 3)
        # Only the bias grows: scale and misalignment do not know the temperature.
        assert not added_variance[3:].any()


def test_a_sensor_that_did_not_answer_gives_no_number() -> None:
    counts = counts_of(np.random.default_rng(2), 4)
    counts.imu_valid[1, 2] = False
    counts.angle_valid[3, sensor_columns(MODEL, 2)[1]] = False
    counts.clipped[2, 0] = True
    calibrated_samples = apply_calibration(counts, whole_calibration(), MODEL)
    # The IMU of body 3 in the second sample, angle sensor of joint 2 in the fourth.
    gone = ~counts.imu_valid
    for values in (
        calibrated_samples.rate_rad_s,
        calibrated_samples.rate_covariance,
        calibrated_samples.rate_jacobian,
        calibrated_samples.specific_force_m_s2,
        calibrated_samples.specific_force_std_m_s2,
    ):
        missing = np.isnan(values.reshape(4, 4, -1))
        assert missing[gone].any(axis=1).all()
        assert not missing[~gone].any()
    for values in (calibrated_samples.joint_angle_rad, calibrated_samples.joint_angle_std_rad):
        assert np.argwhere(np.isnan(values)).tolist() == [[3, 1]]
    # Clipped samples keep their numbers: only the flag tells.
    assert np.argwhere(calibrated_samples.clipped).tolist() == [[2, 0]]
    assert np.isnan(calibrated_samples.rate_rad_s[1, 2]).all()
    assert np.isnan(calibrated_samples.rate_covariance[1, 2]).all()


def test_what_was_never_measured_keeps_its_design() -> None:
    bare = tuple(by_design(body, imu.sensor_to_body) for body, imu in enumerate(MODEL.imus, 1))
    counts = counts_of(np.random.default_rng(2), 1)
    calibrated_samples = apply_calibration(counts, replace(whole_calibration(), gyros=bare), MODEL)
    for body, imu in enumerate(MODEL.imus):
        reading = np.radians(counts.imu_counts[0, body, 4:7] / 65.5)
        assert calibrated_samples.rate_rad_s[0, body] == pytest.approx(imu.sensor_to_body @ reading)
    assert (
        # 12 deg/s: the data sheet's bias tolerance is the design.
        np.degrees(np.sqrt(np.diagonal(calibrated_samples.rate_covariance[0], axis1=1, axis2=2))) > 11.5
    ).all()
