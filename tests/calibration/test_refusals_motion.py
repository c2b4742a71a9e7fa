"""Swings and sweeps that are not what was asked: each is refused with the reason, and careful people are not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.calibration.bench_day import (
    HANDS,
    MODEL,
    REST,
    STEPS,
    SWEEPS,
    SWINGS,
    TURN,
    ZERO,
    accept,
    add_angle,
    before,
    changed,
    done,
    exchange_angles,
    exchange_gyros,
    freeze_angle,
    freeze_gyro,
    hands_move,
    hands_turn,
    known,
    record,
    refused,
    silence_angle,
)
from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.calibration.steps.step import Step
from tfsat_host.emulated.hands import Hands

PAIRS = [(1, 2), (1, 3), (1, 4), (2, 3), (2, 4), (3, 4)]


@pytest.mark.parametrize("step", STEPS, ids=[step.key for step in STEPS])
def test_each_step_of_a_good_day_is_accepted(step: Step) -> None:
    accept(done(step), before(step))


@pytest.mark.parametrize("seed", range(20, 24))
@pytest.mark.parametrize("step", [SWINGS[1], SWINGS[3]], ids=["joint 1", "joint 2"])
def test_people_who_take_care_are_not_refused(seed: int, step: Step) -> None:
    accept(record(step, hands=Hands.human(seed)), known())


@pytest.mark.parametrize("pace", [0.8, 1.5])
def test_shaky_hands_that_sway_quick_or_slow_are_not_refused(pace: float) -> None:
    shaky = replace(Hands.human(1), tremor_deg_s=5.0, sway_deg_s=1.0, reaction=0.01, pace=pace)
    for step in (SWINGS[1], SWINGS[2], SWEEPS[4]):
        accept(record(step, hands=shaky), known())


@pytest.mark.parametrize(("kind", "reach_deg", "least"), [(0, 15.0, 20), (1, 40.0, 45)])
def test_too_little_motion(kind: int, reach_deg: float, least: int) -> None:
    step = (SWINGS, SWEEPS)[kind][0]
    move, last_s = hands_move(step.joint or 0, step.held, [reach_deg, 0.0] * 4, 1.0, 0.7 * kind)
    error = refused(record(step, motion=move, last_s=last_s), known())
    assert error.what == f"Joint 1 moved by {reach_deg:.0f} deg; at least {least} are needed."
    assert "farther" in error.next_step


def test_motion_that_is_just_enough() -> None:
    move, last_s = hands_move(1, (2, 3, 4), [23.0, 0.0] * 5, 1.0, 0.0)
    accept(record(SWINGS[0], motion=move, last_s=last_s), known())


def test_motion_that_is_wide_and_too_slow() -> None:
    move, last_s = hands_move(1, (2, 3, 4), [25.0], 12.0, 0.0)
    error = refused(record(SWINGS[0], motion=move, last_s=last_s), known())
    assert error.what.startswith("Body 1 turned at 2.")
    assert "at least 5 are needed" in error.what
    assert "wider and faster" in error.next_step


@pytest.mark.parametrize(
    ("asked", "held", "sides"),
    [
        (0, (1,), "bodies 2, 3 and 4 turned, and body 1 was held"),
        (1, (2, 3, 4), "body 1 turned, and bodies 2 and 3 was held"),
        (2, (1, 2), "bodies 3 and 4 turned, and bodies 1 and 2 was held"),
        (3, (3, 4), "bodies 1 and 2 turned, and bodies 3 and 4 was held"),
        (4, (4,), "bodies 1, 2 and 3 turned, and body 4 was held"),
    ],
)
def test_the_wrong_side_moved(asked: int, held: tuple[int, ...], sides: str) -> None:
    step = SWINGS[asked]
    move, last_s = hands_move(step.joint or 0, held, [60.0, 0.0] * 3, 1.0, 0.0)
    error = refused(record(step, motion=move, last_s=last_s), known())
    assert error.what == f"The wrong side moved: {sides}."
    assert error.next_step.startswith(f"Hold {'body' if len(step.held) == 1 else 'bodies'}")


@pytest.mark.parametrize(("asked", "done_instead"), [(0, 2), (0, 4), (2, 0), (4, 3)])
@pytest.mark.parametrize("of", [SWINGS, SWEEPS], ids=["swing", "sweep"])
def test_the_wrong_joint_moved(of: tuple[Step, ...], asked: int, done_instead: int) -> None:
    error = refused(replace(done(of[done_instead]), step=of[asked]), known())
    other, joint = of[done_instead].joint, of[asked].joint
    assert error.what.startswith(f"Joint {other} was moved by ")
    assert error.what.endswith(f" deg, not joint {joint}.")
    assert error.next_step.startswith(f"Move joint {joint}, or put the angle sensors' cables right")


@pytest.mark.parametrize("fraction", [0.2, 0.6])
def test_a_held_body_that_moves(fraction: float) -> None:
    gives_way = replace(HANDS, reaction=fraction)
    error = refused(record(SWINGS[0], hands=gives_way), known())
    assert "should have been held" in error.what
    assert error.next_step.startswith("Hold bodies 2, 3 and 4 firmly")


def test_a_held_body_that_gives_way_a_little_is_taken_off() -> None:
    accept(record(SWINGS[0], hands=replace(HANDS, reaction=0.05)), known())


@pytest.mark.parametrize("step", [SWINGS[0], SWINGS[1], SWINGS[2], SWINGS[4], SWEEPS[1]])
def test_the_whole_robot_carried_about(step: Step) -> None:
    move, last_s = hands_turn([60.0, 0.0] * 3, 1.0, 0.0, about=(1.0, 0.0, 0.0))
    error = refused(record(step, motion=move, last_s=last_s), known())
    assert error.what == f"All bodies turned as one, and joint {step.joint} did not move."
    assert f"move joint {step.joint} alone" in error.next_step


def test_nothing_moved_at_all() -> None:
    error = refused(replace(done(REST), step=SWINGS[0]), known())
    assert error.what == "Joint 1 moved by 0 deg; at least 20 are needed."


def _follows(share: float) -> CalibrationError | None:
    """Joint 2 follows joint 1 by a share while bodies 2 and 3 are moved as if they were one."""
    swing = done(SWINGS[1])
    turns = np.unwrap(swing.counts.angle_counts[:, 0] / 4096 * 2 * np.pi)
    deg = np.rad2deg(share * (turns - turns[0]))
    follows = changed(swing, add_angle(3, lambda _: deg), add_angle(4, lambda _: -deg))
    try:
        accept(follows, known())
    except CalibrationError as error:
        return error
    return None


def test_another_joint_that_moves_along() -> None:
    error = _follows(0.03)
    assert error is not None
    assert error.what.startswith("Joint 2 moved by ")
    assert "while joint 1 was moved; it should stay closed" in error.what
    assert "grip bodies 2 and 3 as one" in error.next_step
    assert _follows(0.005) is None


@pytest.mark.parametrize("pair", PAIRS, ids=[f"{a} and {b}" for a, b in PAIRS])
def test_gyros_of_two_bodies_exchanged(pair: tuple[int, int]) -> None:
    """The first swing that can tell names both."""
    exchange = exchange_gyros(*pair)
    earlier = [changed(done(REST), exchange), done(ZERO)]
    for step in SWINGS:
        evidence = changed(done(step), exchange)
        try:
            accept(evidence, earlier)
        except CalibrationError as error:
            named = {f"The gyros of body {a} and body {b} look exchanged" for a, b in (pair, pair[::-1])}
            assert error.what.split(":")[0] in named
            assert "Exchange their cables" in error.next_step
            assert "tfsat-host calibrate bias" in error.next_step
            return
        earlier.append(evidence)
    pytest.fail("nobody noticed")


def test_both_buses_exchanged() -> None:
    swap = (exchange_gyros(1, 3), exchange_gyros(2, 4))
    earlier = [changed(done(REST), *swap), done(ZERO)]
    assert "body 1 and body 3 look exchanged" in refused(changed(done(SWINGS[0]), *swap), earlier).what
    error = refused(changed(done(SWINGS[2]), *swap), earlier)
    assert "wrong side moved" in error.what
    assert "buses are exchanged" in error.next_step


@pytest.mark.parametrize(("step", "body"), [(SWINGS[0], 1), (SWINGS[1], 3), (SWINGS[2], 2), (SWEEPS[4], 4)])
def test_a_gyro_that_is_dead(step: Step, body: int) -> None:
    error = refused(changed(done(step), freeze_gyro(body)), known())
    assert f"{body}" in error.what
    assert "monitor" in error.next_step


def test_a_gyro_that_the_logger_found_frozen() -> None:
    valid = done(SWINGS[1]).counts.imu_valid.copy()
    valid[100:, 2] = False
    error = refused(changed(done(SWINGS[1]), lambda counts: replace(counts, imu_valid=valid)), known())
    assert "samples of the gyro on body 3 are invalid" in error.what


def test_biases_that_nobody_took() -> None:
    for step in (SWINGS[0], SWEEPS[0], TURN):
        error = refused(done(step), [done(ZERO)])
        assert error.what == "The gyros' biases are not known yet."
        assert error.next_step.endswith("tfsat-host calibrate bias")


# Angle sensors


@pytest.mark.parametrize("step", [SWINGS[2], SWEEPS[2]], ids=["swing", "sweep"])
@pytest.mark.parametrize("sensor", [3, 4])
def test_an_angle_sensor_that_is_dead(step: Step, sensor: int) -> None:
    error = refused(changed(done(step), freeze_angle(sensor)), known())
    assert error.what == f"Angle sensor {sensor - 2} of joint 2 shows no motion while the other one moves."
    assert "cable and its magnet" in error.next_step


def test_both_angle_sensors_dead() -> None:
    error = refused(changed(done(SWINGS[0]), freeze_angle(1), freeze_angle(2)), known())
    assert error.what == "Neither angle sensor of joint 1 shows a motion while gyros turn."


@pytest.mark.parametrize(
    ("step", "sensor"), [(SWINGS[0], 2), (SWINGS[1], 3)], ids=["of the joint", "of one in between"]
)
def test_an_angle_sensor_without_a_value(step: Step, sensor: int) -> None:
    error = refused(changed(done(step), silence_angle(sensor, 0.0)), known())
    assert "gave no value" in error.what
    accept(changed(done(step), silence_angle(6, 0.5)), known())  # of a joint that does not matter


def test_angle_sensors_exchanged_with_another_joints() -> None:
    pairs = exchange_angles(1, 3), exchange_angles(2, 4)
    error = refused(changed(done(SWINGS[0]), *pairs), [done(REST)])
    assert error.what.startswith("Joint 2 was moved by")
    assert "the angle sensors of the two are exchanged" in error.meaning


@pytest.mark.parametrize(("own", "other", "named"), [(1, 3, (1, 1, 2)), (2, 5, (2, 1, 3)), (1, 6, (1, 2, 3))])
def test_one_angle_sensor_exchanged_with_another_joints(
    own: int, other: int, named: tuple[int, int, int]
) -> None:
    error = refused(changed(done(SWINGS[0]), exchange_angles(own, other)), [done(REST)])
    mine, stray, joint = named
    assert error.what.startswith(
        f"Angle sensor {mine} of joint 1 and angle sensor {stray} of joint {joint} look exchanged"
    )
    assert "Exchange their cables" in error.next_step


@pytest.mark.parametrize("step", [SWINGS[0], SWEEPS[4]], ids=["swing", "sweep"])
def test_an_angle_sensor_that_slips(step: Step) -> None:
    sensor = 2 * (step.joint or 0) - 1
    slips = add_angle(sensor, lambda share: 6.0 * (share > 0.5))
    error = refused(changed(done(step), slips), known())
    assert "disagree by up to" in error.what
    assert f"calibrate zero --joint {step.joint} --anew" in error.next_step


def test_an_angle_sensor_that_slipped_since_the_zero() -> None:
    slipped = changed(done(SWINGS[0]), add_angle(1, 6.0))
    assert "disagree by up to" in refused(slipped, known()).what
    accept(slipped, [done(REST)])  # without a zero nobody can know


@pytest.mark.parametrize("zero_known", [True, False])
def test_one_direction_wrong_in_the_file(zero_known: bool) -> None:
    sensors = tuple(
        replace(sensor, direction=1) if sensor.joint == 0 else sensor for sensor in MODEL.angle_sensors
    )
    error = refused(
        done(SWINGS[0]), known() if zero_known else [done(REST)], replace(MODEL, angle_sensors=sensors)
    )
    assert error.what.startswith("The two angle sensors of joint 1 go opposite ways")
    assert "direction" in error.next_step


def test_a_motion_of_no_joint_is_a_mistake_of_the_caller() -> None:
    with pytest.raises(ValueError, match="moves no joint"):
        accept(replace(done(SWINGS[0]), step=replace(SWINGS[0], joint=None)), known())
