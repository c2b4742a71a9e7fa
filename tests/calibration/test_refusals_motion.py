"""Swings and sweeps that are not what was asked: each is refused with the reason, and careful people are not."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from tests.calibration.bench_day import (
    HANDS,
    MODEL,
    REST,
    STEPS,
    SWEEPS,
    SWINGS,
    TRUTH,
    TURN,
    ZERO,
    Change,
    accept,
    add_angle,
    before,
    change_counts,
    exchange_angles,
    exchange_gyros,
    expect_refusal,
    freeze_angle,
    freeze_gyro,
    hands_turn,
    prepend_rest_zero,
    record,
    record_good_step,
    silence_angle,
)
from tests.calibration.cases import Make, case, check_refused, record_move
from tfsat_host.calibration.acceptance import check_step
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.solution import solve
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.calibration.steps.step import Step
from tfsat_host.emulated.manual_motion import Operator

PAIRS = [(1, 2), (1, 3), (1, 4), (2, 3), (2, 4), (3, 4)]
PROVE = pytest.mark.prove
SWEEP = SWEEPS[0]
UP_AND_DOWN = [15.0, 30.0, 45.0, 60.0, 75.0, 90.0, 60.0, 30.0, 0.0]
STAIRS = [30.0, 60.0, 90.0, 60.0, 30.0, 0.0]
SWEPT = partial(partial, record_move, SWEEP)


def by(step: Step, *changes: Change) -> Make:
    """Return a maker of the step performed well, with these faults."""
    return lambda: change_counts(record_good_step(step), *changes)


def instead(step: Step, requested_step: Step) -> Make:
    """Return a maker of a step recorded where another one was asked for."""
    return lambda: replace(record_good_step(step), step=requested_step)


def bent(sensor: int) -> Evidence:
    """Record a sweep with joint 1's angle sensor 1 or 2 having its magnet off by a degree."""
    nonlinearity = TRUTH.angle_nonlinearity_rad.copy()
    nonlinearity[sensor - 1, :2] += np.deg2rad([0.7, 0.7])
    return record(SWEEP, truth=replace(TRUTH, angle_nonlinearity_rad=nonlinearity))


def without_answers() -> Evidence:
    valid = record_good_step(SWINGS[1]).counts.imu_valid.copy()
    valid[100:, 2] = False
    return change_counts(record_good_step(SWINGS[1]), lambda counts: replace(counts, imu_valid=valid))


def carry_robot(step: Step) -> Make:
    """Return a maker of the step recorded with the whole robot turned about x."""
    motion, last_s = hands_turn([60.0, 0.0] * 3, 1.0, 0.0, about=(1.0, 0.0, 0.0))
    return lambda: record(step, motion=motion, last_s=last_s)


def gives_way(fraction: float) -> Make:
    return lambda: record(SWINGS[0], hands=replace(HANDS, reaction=fraction))


@pytest.mark.parametrize("step", STEPS, ids=[step.key for step in STEPS])
def test_each_step_of_a_good_day_is_accepted(step: Step) -> None:
    """Accept each step of a good day by itself; test_solution.py proves that they fit each other."""
    check_step(record_good_step(step), before(step), MODEL)


@pytest.mark.parametrize("seed", [20, *(pytest.param(seed, marks=PROVE) for seed in (21, 22, 23))])
@pytest.mark.parametrize("step", [SWINGS[1], pytest.param(SWINGS[3], marks=PROVE)])
def test_people_who_take_care_are_not_refused(seed: int, step: Step) -> None:
    accept(record(step, hands=Operator.human(seed)), prepend_rest_zero())


@pytest.mark.parametrize("pace", [pytest.param(0.8, marks=PROVE), 1.5])
def test_shaky_hands_that_sway_quick_or_slow_are_not_refused(pace: float) -> None:
    shaky = replace(Operator.human(1), tremor_deg_s=5.0, sway_deg_s=1.0, reaction=0.01, pace=pace)
    for step in (SWINGS[2], SWEEPS[4]):
        accept(record(step, hands=shaky), prepend_rest_zero())


@pytest.mark.parametrize(
    "make",
    [
        pytest.param(lambda: record_move(SWINGS[0], [23.0, 0.0] * 5), id="just enough"),
        pytest.param(gives_way(0.05), id="a held body that gives way a little"),
        pytest.param(by(SWINGS[0], silence_angle(6, 0.5)), id="a sensor that does not matter is silent"),
        pytest.param(SWEPT(STAIRS, rest_s=0.7), id="short rests"),
        pytest.param(SWEPT(UP_AND_DOWN, rest_s=1.0), id="there and back in other steps"),
    ],
)
def test_what_does_no_harm_is_accepted(make: Make) -> None:
    accept(make(), prepend_rest_zero())


def test_a_hurried_leg_does_no_harm() -> None:
    quick = record_move(SWEEP, UP_AND_DOWN, 0.4, 1.0)
    accept(quick, prepend_rest_zero())
    gyro = solve(prepend_rest_zero(quick), MODEL).gyros[0]
    stated = np.sqrt(gyro.covariance[6, 6])
    assert abs(gyro.scale[0] - TRUTH.gyro_scale[0, 0]) < 3.5 * stated < 0.02


def record_rest() -> list[Evidence]:
    return [record_good_step(REST)]


def swung() -> list[Evidence]:
    return prepend_rest_zero(record_good_step(SWINGS[0]))


LITTLE = "Joint 1 moved by {} deg; at least {} are needed."
WRONG = "The wrong side moved: "
CARRIED = "All bodies turned as one, and joint {} did not move."
TO_AND_FRO = [60.0, 0.0] * 3


@pytest.mark.parametrize(
    "row",
    [
        case("15 deg", lambda: record_move(SWINGS[0], [15.0, 0.0] * 4), LITTLE.format(15, 20), "farther"),
        case("40 deg", SWEPT([40.0, 0.0] * 4, rest_s=0.7), LITTLE.format(40, 45), "farther"),
        case("nothing moved", instead(REST, SWINGS[0]), LITTLE.format(0, 20), "farther"),
        case("slow", lambda: record_move(SWINGS[0], [25.0], 12.0), "Body 1 turned at 2.", "wider and faster"),
        *(
            case(
                f"{sides} held",
                partial(record_move, SWINGS[index], TO_AND_FRO, held_bodies=held_bodies),
                f"{WRONG}{sides} was held.",
                "Hold bod",
                quick=index in (0, 2),
            )
            for index, held_bodies, sides in (
                (0, (1,), "bodies 2, 3 and 4 turned, and body 1"),
                (1, (2, 3, 4), "body 1 turned, and bodies 2 and 3"),
                (2, (1, 2), "bodies 3 and 4 turned, and bodies 1 and 2"),
                (3, (3, 4), "bodies 1 and 2 turned, and bodies 3 and 4"),
                (4, (4,), "bodies 1, 2 and 3 turned, and body 4"),
            )
        ),
        *(
            case(
                f"{of[other].key} for {of[requested_index].key}",
                instead(of[other], of[requested_index]),
                f" deg, not joint {of[requested_index].joint}.",
                f"Move joint {of[requested_index].joint}, or put the angle sensors' cables right",
            )
            for of in (SWINGS, SWEEPS)
            for requested_index, other in ((0, 2), (0, 4), (2, 0), (4, 3))
        ),
        case("held at 0.2", gives_way(0.2), "should have been held", "Hold bodies 2, 3 and 4 firmly"),
        case("held at 0.6", gives_way(0.6), "should have been held", "firmly", quick=False),
        *(
            case(
                f"carried in {step.key}",
                carry_robot(step),
                CARRIED.format(step.joint),
                f"move joint {step.joint} alone",
                quick=step is SWINGS[1],
            )
            for step in (SWINGS[0], SWINGS[1], SWINGS[2], SWINGS[4], SWEEPS[1])
        ),
        *(
            case(f"gyro {body} dead in {step.key}", by(step, freeze_gyro(body)), f"{body}", "monitor")
            for step, body in ((SWINGS[0], 1), (SWINGS[1], 3), (SWINGS[2], 2), (SWEEPS[4], 4))
        ),
        case("frozen", without_answers, "samples of the gyro on body 3 are invalid", "status"),
        *(
            case(
                f"no bias: {step.key}",
                by(step),
                "The gyros' biases are not known yet.",
                "tfsat-host calibrate bias",
                earlier=lambda: [record_good_step(ZERO)],
            )
            for step in (SWINGS[0], SWEEP, TURN)
        ),
        *(
            case(
                f"angle sensor {sensor} dead in {step.key}",
                by(step, freeze_angle(sensor)),
                f"Angle sensor {sensor - 2} of joint 2 shows no motion while the other one moves.",
                "cable and its magnet",
            )
            for step in (SWINGS[2], SWEEPS[2])
            for sensor in (3, 4)
        ),
        case(
            "both angle sensors dead",
            by(SWINGS[0], freeze_angle(1), freeze_angle(2)),
            "Neither angle sensor of joint 1 shows a motion while gyros turn.",
        ),
        case("the joint's sensor silent", by(SWINGS[0], silence_angle(2, 0.0)), "gave no value"),
        case("one in between silent", by(SWINGS[1], silence_angle(3, 0.0)), "gave no value"),
        case(
            "another joint's sensors",
            by(SWINGS[0], exchange_angles(1, 3), exchange_angles(2, 4)),
            "Joint 2 was moved by",
            "the angle sensors of the two are exchanged",
            earlier=record_rest,
        ),
        *(
            case(
                f"angle sensors {own} and {other} exchanged",
                by(SWINGS[0], exchange_angles(own, other)),
                f"Angle sensor {mine} of joint 1 and angle sensor {stray} of joint {joint} look exchanged",
                "Exchange their cables",
                earlier=record_rest,
            )
            for own, other, mine, stray, joint in ((1, 3, 1, 1, 2), (2, 5, 2, 1, 3), (1, 6, 1, 2, 3))
        ),
        *(
            case(
                f"slips in {step.key}",
                by(step, add_angle(2 * step.moving_joint - 1, lambda share: 6.0 * (share > 0.5))),
                "disagree by up to",
                f"calibrate zero --joint {step.joint} --anew",
            )
            for step in (SWINGS[0], SWEEPS[4])
        ),
        case("slipped since the zero", by(SWINGS[0], add_angle(1, 6.0)), "disagree by up to", "--anew"),
        case(
            "no rests", SWEPT(STAIRS * 2), "at least 6 are needed", "resting a second at each", earlier=swung
        ),
        case("rests too short", SWEPT(STAIRS, rest_s=0.2), "at least 6 are needed", "resting a second"),
        case("a swing", instead(SWINGS[0], SWEEP), "The sweep of joint 1 has ", "resting a second"),
        case(
            "one way only",
            SWEPT(UP_AND_DOWN[:6], rest_s=1.0),
            "The sweep of joint 1 went one way only.",
            "and back in the same steps",
        ),
        case("too fast", SWEPT([90.0, 0.0] * 4, 0.25, 1.0), "at its full scale", "slower than 500 deg/s"),
        *(
            case(
                f"angle sensor {sensor} bends",
                partial(bent, sensor),
                f"Nonlinearity of angle sensor {sensor} of joint 1: at least ",
                "tfsat-host calibrate scale --turn x 360",
                quick=sensor == 1,
            )
            for sensor in (1, 2)
        ),
    ],
)
def test_what_is_not_what_was_asked_is_refused(row: Any) -> None:
    check_refused(row)


def test_without_a_zero_a_sensor_that_slipped_since_is_taken() -> None:
    accept(change_counts(record_good_step(SWINGS[0]), add_angle(1, 6.0)), [record_good_step(REST)])


def test_a_robot_file_that_says_so_takes_a_bent_sensor() -> None:
    evidence = bent(1)
    sensors = [replace(sensor, nonlinearity_rad=np.deg2rad(0.7)) for sensor in MODEL.angle_sensors]
    model = replace(MODEL, angle_sensors=tuple(sensors))
    accept(evidence, prepend_rest_zero(), model)
    gyro = solve(prepend_rest_zero(evidence), model).gyros[0]
    off, stated = gyro.scale[0] - TRUTH.gyro_scale[0, 0], np.sqrt(gyro.covariance[6, 6])
    assert abs(off) < 3.5 * stated
    assert not gyro.scaled  # too doubtful


def _follows(share: float) -> CalibrationError | None:
    """Joint 2 follows joint 1 by a share while bodies 2 and 3 are moved as if they were one."""
    swing = record_good_step(SWINGS[1])
    turns = np.unwrap(swing.counts.angle_counts[:, 0] / 4096 * 2 * np.pi)
    deg = np.rad2deg(share * (turns - turns[0]))
    follows = change_counts(swing, add_angle(3, lambda _: deg), add_angle(4, lambda _: -deg))
    try:
        accept(follows, prepend_rest_zero())
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
    """Name both exchanged gyros at the first swing that can tell."""
    exchange = exchange_gyros(*pair)
    earlier = [change_counts(record_good_step(REST), exchange), record_good_step(ZERO)]
    for step in SWINGS:
        evidence = change_counts(record_good_step(step), exchange)
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
    earlier = [change_counts(record_good_step(REST), *swap), record_good_step(ZERO)]
    assert (
        "body 1 and body 3 look exchanged"
        in expect_refusal(change_counts(record_good_step(SWINGS[0]), *swap), earlier).what
    )
    error = expect_refusal(change_counts(record_good_step(SWINGS[2]), *swap), earlier)
    assert "wrong side moved" in error.what
    assert "buses are exchanged" in error.next_step


@pytest.mark.parametrize("zero_known", [True, False])
def test_one_direction_wrong_in_the_file(zero_known: bool) -> None:
    sensors = tuple(
        replace(sensor, direction=1) if sensor.joint == 0 else sensor for sensor in MODEL.angle_sensors
    )
    error = expect_refusal(
        record_good_step(SWINGS[0]),
        prepend_rest_zero() if zero_known else [record_good_step(REST)],
        replace(MODEL, angle_sensors=sensors),
    )
    assert error.what.startswith("The two angle sensors of joint 1 go opposite ways")
    assert "direction" in error.next_step


def test_a_motion_of_no_joint_is_a_mistake_of_the_caller() -> None:
    with pytest.raises(ValueError, match="moves no joint"):
        accept(replace(record_good_step(SWINGS[0]), step=replace(SWINGS[0], joint=None)), prepend_rest_zero())
