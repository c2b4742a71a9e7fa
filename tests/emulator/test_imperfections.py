"""What is not ideal about an emulated robot, at the boundary where a calibration meets it."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.emulator.performance import perform
from tfsat_host.calibration.steps.step import sweeps, turn
from tfsat_host.devices.jog_path import Jog
from tfsat_host.devices.jogging import JogClient
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.emulated.imperfections import Imperfections, draw, draw_as_built, ideal

SEEDS = range(40)


def jogged_deg(wrong: Imperfections, *targets_deg: float) -> list[float]:
    """Return the true angle of joint 1 after each jog."""
    reached = []
    with EmulatedRobot(imperfections=wrong, seed=1) as robot:
        robot.advance(SETTLE_US)
        robot.hold((2, 3, 4))
        sequencer = JogClient.connect(EmulatedTransport(robot, BoardIndex.SEQUENCER))
        at_cdeg = 0
        for target_deg in targets_deg:
            target_cdeg = round(100 * target_deg)
            sequencer.run(Jog(1, at_cdeg, target_cdeg), 0.5, lambda: False, lambda _: None)
            reached.append(robot.joint_angles_deg()[0])
            at_cdeg = target_cdeg
    return reached


def test_a_wrong_servo_stands_at_offset_plus_gain_times_the_command_less_half_the_backlash() -> None:
    wrong = replace(
        ideal(),
        servo_gain=np.array([0.95, 1.0, 1.0]),
        servo_offset_rad=np.deg2rad([1.2, 0.0, 0.0]),
        servo_backlash_rad=np.deg2rad([0.8, 0.0, 0.0]),
    )
    # Pulses are whole ticks of 0.5 us, 0.045 deg each.
    pulse_step_deg = 0.09 / 2
    assert jogged_deg(wrong, 60, 30) == pytest.approx(
        [1.2 + 0.95 * 60 - 0.4, 1.2 + 0.95 * 30 + 0.4], abs=pulse_step_deg + 0.01
    )
    # The same jogs with a servo that is exact: the errors are the servo's.
    assert jogged_deg(ideal(), 60, 30) == pytest.approx([60, 30], abs=pulse_step_deg + 0.01)


def test_servos_that_do_not_repeat_are_repeated_by_the_seed() -> None:
    wrong = replace(ideal(), servo_repeat_rad=np.deg2rad([0.3, 0.0, 0.0]))
    first = jogged_deg(wrong, 60, 30, 60, 30, 60)
    assert jogged_deg(wrong, 60, 30, 60, 30, 60) == first
    # The same target is reached differently each time.
    assert np.ptp([first[0], first[2], first[4]]) > 0.02
    assert np.abs(np.array(first) - [60, 30, 60, 30, 60]).max() < 1.5


def test_angle_sensors_show_a_bent_angle() -> None:
    bend = np.deg2rad(
        # One term of the nonlinearity a sensor, all of 2 deg.
        np.array([[2.0, 0, 0, 0], [0, 2.0, 0, 0], [0, 0, 2.0, 0], [0, 0, 0, 2.0]] + [[0, 0, 0, 0]] * 2)
    )
    wrong = replace(
        ideal(), angle_nonlinearity_rad=bend, angle_zero_rad=np.deg2rad([10.0, 20, 30, 40, 50, 60])
    )
    for joint in (1, 2):
        performance = perform(sweeps(joint)[0], imperfections=wrong)
        t_s = (performance.counts.t_us - performance.counts.t_us[0]) * 1e-6
        for stop_s, stop_deg in ((0.5, 0.0), (3.0, 30.0), (5.5, 60.0), (8.0, 90.0)):
            angle_counts = performance.counts.angle_counts[int(np.searchsorted(t_s, stop_s))] + 0.5
            # The second sensor of a pair counts the other way.
            for sensor, direction in ((2 * joint - 2, 1), (2 * joint - 1, -1)):
                phi = np.deg2rad(180 + wrong.angle_zero_rad[sensor] * 180 / np.pi + direction * stop_deg)
                # Sine and cosine of one and of two turns.
                terms = np.array([np.sin(phi), np.cos(phi), np.sin(2 * phi), np.cos(2 * phi)])
                expected = (phi + bend[sensor] @ terms) / (2 * np.pi) * 4096
                assert angle_counts[sensor] == pytest.approx(expected, abs=0.51)


def test_a_gyros_reading_is_scale_times_the_turned_rate_plus_bias() -> None:
    wrong = replace(draw_as_built(7), gyro_noise_rad_s_rthz=0.0)
    performance = perform(turn("x", 180.0), imperfections=wrong)
    # Over the first leg, from rest to rest; a reading lags, a sum does not.
    t_s = (performance.counts.t_us - performance.counts.t_us[0]) * 1e-6
    # The leg of the turn, without the rests before and after it.
    leg = (t_s > 0.5) & (t_s < 3.8)
    passed = (np.diff(t_s[leg])[:, None, None] * performance.gyros_deg_s()[leg][:-1]).sum(axis=0)
    for body in range(4):
        sensor_rate_deg_s = wrong.mounting[body].T @ [180.0, 0.0, 0.0]
        bias = np.rad2deg(wrong.gyro_bias_rad_s[body]) * np.ptp(t_s[leg])
        # Scale, mounting and bias together make the reading.
        assert passed[body] == pytest.approx(wrong.gyro_response[body] @ sensor_rate_deg_s + bias, abs=0.15)


def test_a_robot_as_built_is_off_in_everything_and_within_its_ranges() -> None:
    robots = [draw_as_built(seed) for seed in SEEDS]
    tilt = np.rad2deg([Rotation.from_matrix(robot.mounting).magnitude() for robot in robots])
    assert tilt.max() < 5.0 and tilt.mean() == pytest.approx(2.5, abs=0.5)
    bias = np.rad2deg([robot.gyro_bias_rad_s for robot in robots])
    # Uniform within 5 deg/s either way: the standard deviation is 5 over the root of 3.
    assert np.abs(bias).max() <= 5.0 and bias.std() == pytest.approx(5 / np.sqrt(3), rel=0.1)
    scale = np.array([robot.gyro_scale for robot in robots])
    across = np.array([robot.gyro_cross_axis for robot in robots])
    assert np.array_equal(across, across.swapaxes(2, 3)) and not np.einsum("...ii", across).any()
    # Half the sum of two that are uniform within 2 %.
    assert np.abs(across).max() <= 0.02
    assert across[..., [1, 2, 0], [2, 0, 1]].std() == pytest.approx(0.02 / np.sqrt(6), rel=0.1)
    assert np.abs(scale - 1).max() <= 0.03 and scale.std() == pytest.approx(0.03 / np.sqrt(3), rel=0.1)
    zero = np.rad2deg([robot.angle_zero_rad for robot in robots])
    assert zero.min() < 20 and zero.max() > 340
    bend = np.rad2deg([robot.angle_nonlinearity_rad for robot in robots])
    assert bend.shape == (len(SEEDS), 6, 4) and bend.std() == pytest.approx(0.05, rel=0.1)
    gain = np.array([robot.servo_gain for robot in robots])
    assert gain.mean() == pytest.approx(0.95, abs=0.01) and gain.std() == pytest.approx(0.02, rel=0.25)
    assert np.rad2deg([robot.servo_offset_rad for robot in robots]).std() == pytest.approx(1.0, rel=0.25)
    backlash = np.rad2deg([robot.servo_backlash_rad for robot in robots])
    repeat = np.rad2deg([robot.servo_repeat_rad for robot in robots])
    assert 0 <= backlash.min() < 0.1 and 0.9 < backlash.max() <= 1
    assert repeat.min() >= 0.1 and repeat.max() <= 0.3


def test_a_seed_draws_one_robot_and_another_seed_another() -> None:
    first, again, other = draw_as_built(1), draw_as_built(1), draw_as_built(2)
    for field in fields(Imperfections):
        # Every field, not just those that are easy to see.
        assert np.array_equal(getattr(first, field.name), getattr(again, field.name))
    assert not np.array_equal(first.mounting, other.mounting)


def test_robots_of_other_errors_have_other_loggers() -> None:
    serials = [draw_as_built(seed).logger_serial for seed in SEEDS]
    assert len(set(serials)) == len(SEEDS) and {len(serial) for serial in serials} == {8}
    assert not any(serial.isascii() for serial in serials)
    assert draw(1).logger_serial == draw(2).logger_serial == ideal().logger_serial == b"emuLATED"
    assert draw_as_built(1).logger_serial == bytes.fromhex("656d75e891c91e00")
    for wrong in (draw(1), draw_as_built(1)):
        with EmulatedRobot(imperfections=wrong) as robot:
            robot.advance(SETTLE_US)
            logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
            assert logger.identity.serial == wrong.logger_serial.hex()


def test_a_robot_as_it_comes_has_exact_servos_scales_and_straight_angle_sensors() -> None:
    exact = ideal()
    for imperfections in (draw(1), draw(2)):
        for name in ("gyro_scale", "angle_nonlinearity_rad", "servo_gain", "servo_offset_rad", "servo_backlash_rad",
                     "servo_repeat_rad"):  # fmt: skip
            assert np.array_equal(getattr(imperfections, name), getattr(exact, name))
    # The draw itself is fixed: rehearsals with a seed must not change from one version to the next.
    assert np.rad2deg(draw(1).gyro_bias_rad_s[0]) == pytest.approx(
        [-0.736454, -0.162910, -0.482119],
        abs=1e-6,
        # The draw is fixed: an emulated robot of a seed stays the same robot.
    )
