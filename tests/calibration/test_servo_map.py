"""A servo's map against servos of known faults: values, intervals, settings, strokes, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.arduino_sequencer.servo_model import TICK_NS, pulse_centi_ns
from tests.calibration.simulated_servo import FACTORY_SERVO, SimulatedServo
from tests.calibration.some_calibration import MEASURED
from tests.servo_settings.values import valid_settings
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.servos.fit import fit_servo_map
from tfsat_host.calibration.servos.servo_map import (
    ServoMap,
    ServoPoint,
    arrivals,
    board_pulse_us,
    expected_stroke_errors,
    matching_setting,
    servo_plan,
    setting_error_rad,
    settings_from_map,
)
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.servo_settings import FACTORY, ServoSettings, find_defect

SEEDS = range(150)
STROKES_CDEG = (5900, -5900)
MOVES = [(1, angle_cdeg) for angle_cdeg in STROKES_CDEG]
TRUE = SimulatedServo(gain=0.95, offset_deg=2.0, backlash_deg=1.2, repeatability_deg=0.5, noise_deg=0.05)


def _measure_servo_map(servo: SimulatedServo) -> ServoMap:
    return fit_servo_map(servo.visit_plan(), 1, FACTORY_SERVO, MEASURED)


def _with(setting: ServoSetting) -> ServoSettings:
    return replace(FACTORY, servos=(setting, *FACTORY.servos[1:]))


# The plan


@given(valid_settings())
def test_the_plan_goes_up_and_down_twice_within_the_limits(settings: ServoSettings) -> None:
    for servo in settings.servos:
        plan = servo_plan(servo)
        assert all(servo.min_cdeg <= angle_cdeg <= servo.max_cdeg for angle_cdeg in plan)
        assert (plan[0], plan[-1]) == (servo.min_cdeg, servo.min_cdeg)
        assert plan.count(servo.max_cdeg) >= 2
        assert max(abs(np.diff(plan))) <= 1501


def test_the_plan_of_the_factory_settings() -> None:
    up_and_down = (1500, 3000, 4500, 6000, 7500, 9000, 7500, 6000, 4500, 3000, 1500, 0)
    assert servo_plan(FACTORY_SERVO) == (0, *up_and_down, *up_and_down)
    assert arrivals(servo_plan(FACTORY_SERVO)) == (0, *([1] * 6 + [-1] * 6) * 2)


def test_a_joint_that_is_sent_where_it_is_came_from_where_it_came() -> None:
    assert arrivals([5, 5, 7, 7, 6, 6]) == (0, 0, 1, 1, -1, -1)
    assert arrivals([]) == ()


# Values


@given(
    gain=st.floats(0.5, 1.5),
    offset_deg=st.floats(-10, 10),
    backlash_deg=st.floats(-1, 5),
    order=st.randoms(use_true_random=False),
)
def test_a_servo_without_scatter_is_found_exactly(
    gain: float, offset_deg: float, backlash_deg: float, order: np.random.Generator
) -> None:
    servo = SimulatedServo(gain, offset_deg, backlash_deg)
    points = servo.visit_plan()
    order.shuffle(points)
    servo_map = fit_servo_map(points, 1, FACTORY_SERVO, MEASURED)
    assert np.rad2deg(servo_map.backlash_rad) == pytest.approx(backlash_deg, abs=1e-6)
    for pulse_us in (1000.0, 1500.0, 2000.0):
        for direction in (-1, 1):
            reached_deg = np.rad2deg(servo_map.reached_rad(pulse_us, direction))
            assert reached_deg == pytest.approx(servo.mean_deg(pulse_us, direction), abs=1e-6)
    assert np.rad2deg(servo_map.repeatability_rad) == pytest.approx(0.0, abs=1e-6)
    assert np.rad2deg(servo_map.nonlinearity_rad) == pytest.approx(0.0, abs=1e-6)
    assert servo_map.pulse_range_us == (1000.0, 2000.0)
    assert (servo_map.places, servo_map.repeats, servo_map.setting) == (7, 12, FACTORY_SERVO)


def test_scatter_and_bend_are_told_apart_and_from_the_sensors_noise() -> None:
    noisy = SimulatedServo(repeatability_deg=0.5, bend_deg=1.5, noise_deg=0.5)
    servo_maps = [_measure_servo_map(replace(noisy, seed=seed)) for seed in SEEDS]
    scatter_deg = np.rad2deg([each.repeatability_rad for each in servo_maps])
    assert np.sqrt(np.mean(scatter_deg**2)) == pytest.approx(0.5, rel=0.05)
    # Of a half wave 1.5 deg high at 0, 15 … 90 deg, what the best line leaves.
    places_deg = np.arange(0, 91, 15)
    wave_deg = 1.5 * np.sin(np.pi * places_deg / 90)
    left_deg = wave_deg - np.polyval(np.polyfit(places_deg, wave_deg, 1), places_deg)
    bend_deg = np.rad2deg([each.nonlinearity_rad for each in servo_maps])
    assert np.sqrt(np.mean(bend_deg**2)) == pytest.approx(np.sqrt(left_deg @ left_deg / 5), rel=0.05)


# Intervals


@pytest.mark.parametrize(
    "servo",
    [
        TRUE,
        replace(TRUE, repeatability_deg=1.5, noise_deg=0.3),
        replace(TRUE, repeatability_deg=0.02, noise_deg=0.3),
        replace(TRUE, backlash_deg=0.0, repeatability_deg=0.1, noise_deg=0.0),
    ],
    ids=["usual", "bad repeatability", "noisy sensors", "sensors without noise"],
)
def test_intervals_of_the_map_hold_the_truth(servo: SimulatedServo) -> None:
    inside = []
    for seed in SEEDS:
        servo_map = _measure_servo_map(replace(servo, seed=seed))
        truth = np.deg2rad(
            [
                servo.mean_deg(servo_map.middle_us, 0),
                servo.gain / FACTORY_SERVO.ns_per_deg * 1000,
                servo.backlash_deg,
            ]
        )
        estimate = [servo_map.middle_rad, servo_map.slope_rad_per_us, servo_map.backlash_rad]
        inside.append(np.abs(estimate - truth) < 1.96 * np.sqrt(np.diag(servo_map.covariance)))
        assert servo_map.backlash_std_rad == np.sqrt(servo_map.covariance[2, 2])
    for share in np.mean(inside, axis=0):
        assert 0.90 <= share <= 0.99


def test_intervals_of_a_crooked_servo_hold_the_line_that_it_strays_from() -> None:
    inside = []
    for seed in SEEDS:
        random = np.random.default_rng([seed, 1])
        points = replace(TRUE, repeatability_deg=0.2, seed=seed).visit_plan()
        stray_rad = {
            pulse: np.deg2rad(0.5) * random.standard_normal()
            for pulse in sorted({p.pulse_us for p in points})
        }
        strayed = [replace(p, reached_rad=p.reached_rad + stray_rad[p.pulse_us]) for p in points]
        servo_map = fit_servo_map(strayed, 1, FACTORY_SERVO, MEASURED)
        truth = [
            np.deg2rad(TRUE.mean_deg(servo_map.middle_us, 0)),
            np.deg2rad(TRUE.gain / FACTORY_SERVO.ns_per_deg * 1000),
        ]
        off = np.abs(np.array([servo_map.middle_rad, servo_map.slope_rad_per_us]) - truth)
        inside.append(off < 1.96 * np.sqrt(np.diag(servo_map.covariance)[:2]))
    for share in np.mean(inside, axis=0):
        assert 0.90 <= share <= 0.99


@pytest.mark.parametrize(
    "servo",
    [
        TRUE,
        replace(TRUE, repeatability_deg=1.5),
        replace(TRUE, repeatability_deg=0.2, backlash_deg=0.0, noise_deg=0.2),
    ],
    ids=["usual", "bad repeatability", "good"],
)
@pytest.mark.parametrize("corrected", [False, True], ids=["factory settings", "corrected"])
def test_strokes_miss_as_expected(servo: SimulatedServo, corrected: bool) -> None:
    inside, missed_by = [], []
    for seed in SEEDS:
        seeded_servo = replace(servo, seed=seed)
        servo_map = _measure_servo_map(seeded_servo)
        settings = settings_from_map(servo_map, FACTORY) if corrected else FACTORY
        reached_deg = np.array(seeded_servo.fly_deg(STROKES_CDEG, settings.of(1)))
        expected = expected_stroke_errors(MOVES, [servo_map], settings)
        missed_rad = np.deg2rad(reached_deg - np.array(STROKES_CDEG) / 100)
        off_rad = missed_rad - [each.error_rad for each in expected]
        inside.append(np.abs(off_rad) < 1.96 * np.array([each.std_rad for each in expected]))
        missed_by.append(np.rad2deg(missed_rad))
    for share in np.mean(inside, axis=0):
        assert 0.90 <= share <= 0.99
    # Opening falls short by half the backlash from wherever it hung; closing, by all of it, as does the gain.
    short_deg = 0.0 if corrected else 59.0 * (1.0 - servo.gain)
    expected_deg = [-short_deg - servo.backlash_deg / 2, short_deg + servo.backlash_deg]
    slack_deg = 4.0 * np.std(missed_by, axis=0) / np.sqrt(len(SEEDS)) + 0.05
    assert np.all(np.abs(np.mean(missed_by, axis=0) - expected_deg) < slack_deg)


def test_much_backlash_leaves_the_first_stroke_in_doubt_and_no_other() -> None:
    loose = replace(TRUE, backlash_deg=4.0)
    inside, stds_deg = [], []
    for seed in SEEDS:
        seeded_servo = replace(loose, seed=seed)
        expected = expected_stroke_errors(MOVES, [_measure_servo_map(seeded_servo)], FACTORY)
        missed_rad = np.deg2rad(
            np.array(seeded_servo.fly_deg(STROKES_CDEG, FACTORY_SERVO)) - np.array(STROKES_CDEG) / 100
        )
        off_rad = missed_rad - [each.error_rad for each in expected]
        inside.append(np.abs(off_rad) < 1.96 * np.array([each.std_rad for each in expected]))
        stds_deg.append(np.rad2deg([each.std_rad for each in expected]))
    # The play is bounded, not normal: two standard deviations hold more than 95 % of it.
    first, second = np.mean(inside, axis=0)
    assert first >= 0.95
    assert 0.90 <= second <= 0.99
    assert np.mean(stds_deg, axis=0) == pytest.approx([np.sqrt(2.0**2 + 0.8**2), 0.8], abs=0.1)


def test_a_bent_servo_is_given_wider_intervals_that_hold() -> None:
    bent = replace(TRUE, bend_deg=1.5, repeatability_deg=0.3)
    inside = []
    for number, seed in enumerate(SEEDS):
        seeded_servo = replace(bent, seed=seed)
        servo_map = _measure_servo_map(seeded_servo)
        top_cdeg = 1000 + 7500 * number // len(SEEDS)  # over the whole bend
        (reached_deg,) = seeded_servo.fly_deg([top_cdeg], FACTORY_SERVO)
        (expected,) = expected_stroke_errors([(1, top_cdeg)], [servo_map], FACTORY)
        off_rad = np.deg2rad(reached_deg - top_cdeg / 100) - expected.error_rad
        inside.append(abs(off_rad) < 1.96 * expected.std_rad)
        straight = replace(servo_map, nonlinearity_rad=0.0)
        assert expected_stroke_errors([(1, top_cdeg)], [straight], FACTORY)[0].std_rad < expected.std_rad
    assert 0.90 <= np.mean(inside) <= 0.99


# Settings


@given(gain=st.floats(0.6, 1.3), offset_deg=st.floats(-5, 5), backlash_deg=st.floats(0, 3))
def test_with_the_new_settings_the_joint_reaches_what_is_commanded(
    gain: float, offset_deg: float, backlash_deg: float
) -> None:
    servo = SimulatedServo(gain, offset_deg, backlash_deg)
    narrow = replace(FACTORY_SERVO, max_cdeg=7000)
    settings = settings_from_map(_measure_servo_map(servo), _with(narrow))
    assert find_defect(settings) is None
    assert (settings.of(1).min_cdeg, settings.of(1).max_cdeg) == (0, 7000)
    assert (settings.frame_us, settings.servos[1:]) == (FACTORY.frame_us, FACTORY.servos[1:])
    # Half a microsecond of zero_us, half a nanosecond each degree, a quarter of a microsecond of the tick.
    allowed_deg = gain / FACTORY_SERVO.ns_per_deg * 1000 * (0.5 + 70 * 0.0005 + 0.25) + 1e-6
    for angle_cdeg in range(0, 7001, 500):
        pulse_us = board_pulse_us(settings.of(1), angle_cdeg)
        assert abs(servo.mean_deg(pulse_us, 0) - angle_cdeg / 100) <= allowed_deg


def test_a_servo_that_opens_by_shorter_pulses() -> None:
    turned = replace(FACTORY_SERVO, zero_us=2000, reversed=1)
    servo = SimulatedServo(gain=-0.95, offset_deg=92.0, backlash_deg=1.0)
    servo_map = fit_servo_map(servo.visit_plan(turned), 1, turned, MEASURED)
    setting = settings_from_map(servo_map, _with(turned)).of(1)
    assert setting.reversed == 1
    assert servo.mean_deg(board_pulse_us(setting, 4500), 0) == pytest.approx(45.0, abs=0.1)


def test_a_servo_that_does_not_reach_its_range_says_how_far_it_goes() -> None:
    far = SimulatedServo(gain=0.55)
    with pytest.raises(CalibrationError) as caught:
        settings_from_map(_measure_servo_map(far), FACTORY)
    assert "Joint 1" in caught.value.what
    assert "90 deg would need a pulse of" in caught.value.what
    assert "[0, 74]" in caught.value.next_step
    narrow = _with(replace(FACTORY_SERVO, max_cdeg=7400))
    assert settings_from_map(_measure_servo_map(far), narrow).of(1).max_cdeg == 7400
    wide_settings = _with(replace(FACTORY_SERVO, max_cdeg=7500))
    with pytest.raises(CalibrationError):
        settings_from_map(_measure_servo_map(far), wide_settings)


@pytest.mark.parametrize(
    ("servo", "words"),
    [
        (SimulatedServo(offset_deg=60.0), "0 deg lies well within"),
        (SimulatedServo(gain=0.2), "horn of servo 1 slips"),
    ],
)
def test_settings_that_no_limit_saves(servo: SimulatedServo, words: str) -> None:
    with pytest.raises(CalibrationError) as caught:
        settings_from_map(_measure_servo_map(servo), FACTORY)
    assert words in caught.value.next_step


def test_another_joints_defect_is_not_this_joints() -> None:
    broken = replace(FACTORY, servos=(*FACTORY.servos[:2], replace(FACTORY_SERVO, zero_us=0)))
    with pytest.raises(CalibrationError) as caught:
        settings_from_map(_measure_servo_map(SimulatedServo()), broken)
    assert "present settings are not valid" in caught.value.what


# Strokes


def test_each_stroke_goes_on_from_where_its_joint_came_to_rest() -> None:
    servo = SimulatedServo(gain=0.95, backlash_deg=1.0)
    second = replace(_measure_servo_map(servo), joint=2)
    expected = expected_stroke_errors(
        [(1, 5900), (2, 2000), (2, 1000), (2, -3000), (3, 100)], [second], FACTORY
    )
    assert [(each.stroke, each.joint, each.commanded_cdeg) for each in expected] == [
        (2, 2, 2000),
        (3, 2, 1000),
        (4, 2, -3000),
    ]
    errors_deg = np.rad2deg([each.error_rad for each in expected])
    # The gain's 5 %; half the backlash, none, all of it.
    assert errors_deg == pytest.approx([-1.0 - 0.5, -0.5, 1.5 + 1.0], abs=0.05)
    stds_deg = np.rad2deg([each.std_rad for each in expected])
    assert stds_deg == pytest.approx([0.5, 0.0, 0.0], abs=0.001)


def test_a_setting_that_misses_is_told_from_one_that_is_only_rounded() -> None:
    servo_map = _measure_servo_map(TRUE)
    # 2 deg of offset at 0, and 5 % of 90 deg less it at the other end.
    worst_deg = np.rad2deg(setting_error_rad(servo_map, FACTORY_SERVO) or 0.0)
    assert worst_deg == pytest.approx(-2.5, abs=0.5)
    assert setting_error_rad(servo_map, settings_from_map(servo_map, FACTORY).of(1)) is None
    again = _measure_servo_map(replace(TRUE, seed=1))
    assert setting_error_rad(servo_map, settings_from_map(again, FACTORY).of(1)) is None


@given(valid_settings(), st.floats(0, 1))
def test_pulses_are_those_that_the_board_sends(settings: ServoSettings, share: float) -> None:
    for servo in settings.servos:
        angle_cdeg = round(share * servo.max_cdeg)
        sent_ns, exact_ns = board_pulse_us(servo, angle_cdeg) * 1000, pulse_centi_ns(servo, angle_cdeg) / 100
        # The board cuts the fraction of a nanosecond off before it rounds to a tick.
        assert sent_ns % TICK_NS == 0 and abs(sent_ns - exact_ns) < TICK_NS / 2 + 1


def test_a_matching_setting_is_found_where_the_board_would_refuse_it() -> None:
    far = _measure_servo_map(SimulatedServo(gain=0.55))
    assert matching_setting(far, FACTORY_SERVO) == replace(FACTORY_SERVO, ns_per_deg=20202)


# Refusals


def _expect_refusal(points: list[ServoPoint], setting: ServoSetting = FACTORY_SERVO) -> CalibrationError:
    with pytest.raises(CalibrationError) as caught:
        fit_servo_map(points, 3, setting, MEASURED)
    assert "oint 3" in caught.value.what
    assert "The board keeps its servo settings." in caught.value.meaning
    assert "tfsat-host calibrate servo --joint 3" in caught.value.next_step
    return caught.value


@pytest.mark.parametrize("gain", [0.0, 0.05, -0.05])
def test_a_dead_servo(gain: float) -> None:
    error = _expect_refusal(SimulatedServo(gain, repeatability_deg=0.1, noise_deg=0.05).visit_plan())
    assert "did not follow: 90 deg were commanded" in error.what
    assert "battery" in error.next_step


def test_a_reversed_servo() -> None:
    error = _expect_refusal(SimulatedServo(gain=-1.0, offset_deg=90.0).visit_plan())
    assert "moves the wrong way" in error.what
    assert "reversed = true and zero_us = 2000" in error.next_step
    turned = replace(FACTORY_SERVO, zero_us=2000, reversed=1)
    error = _expect_refusal(SimulatedServo().visit_plan(turned), turned)
    assert "reversed = false and zero_us = 1000" in error.next_step


def test_too_few_visits() -> None:
    points = SimulatedServo().visit_plan()
    for few_points in ([], points[:1], points[:13], [point for point in points if point.direction > 0]):
        assert "at least 5 and 4 are needed, opening and closing" in _expect_refusal(few_points).what
    assert fit_servo_map(points[:17], 3, FACTORY_SERVO, MEASURED).repeats == 4


def test_too_small_a_range() -> None:
    narrow = replace(FACTORY_SERVO, max_cdeg=1900)
    assert "over 19.0 deg only" in _expect_refusal(SimulatedServo().visit_plan(narrow), narrow).what


def test_a_gear_that_slips_once() -> None:
    points = SimulatedServo(noise_deg=0.05).visit_plan()
    slipped = [replace(point, reached_rad=point.reached_rad + np.deg2rad(10.0)) for point in points[13:]]
    error = _expect_refusal([*points[:13], *slipped])
    assert "scattered by 7.1 deg" in error.what
    assert "horn" in error.next_step


def test_a_servo_that_scatters_much_is_not_called_bent() -> None:
    for seed in range(200):
        _measure_servo_map(replace(TRUE, repeatability_deg=2.5, seed=seed))


def test_a_joint_that_meets_a_stop() -> None:
    points = SimulatedServo(noise_deg=0.05).visit_plan()
    stopped = [replace(point, reached_rad=min(point.reached_rad, np.deg2rad(70.0))) for point in points]
    error = _expect_refusal(stopped)
    assert "not a straight line" in error.what
    assert "narrow limits_deg" in error.next_step
