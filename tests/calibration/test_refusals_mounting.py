"""Sensors that sit otherwise than the robot file says: recognised and named; those that only sit badly are not."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.calibration.bench_day import (
    MODEL,
    REST,
    SWEEPS,
    SWINGS,
    TRUTH,
    TURN,
    ZERO,
    accept,
    change_counts,
    expect_refusal,
    prepend_rest_zero,
    record_good_step,
    slip_sensor,
    turn_sensor,
)
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.acceptance import check_step
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.solution import solve
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.robot import RobotModel

RIGHT_ANGLES = [np.rint(turn) for turn in Rotation.create_group("O").as_matrix()]
TURNED = [turn for turn in RIGHT_ANGLES if not np.array_equal(turn, np.eye(3))]
FEW = ("+x-z+y", "+y-x+z", "-x-y+z", "+y+z+x")
"""About each kind of axis; the others under `make prove`."""
NAMES = ["".join(f"{'+-'[int(c.sum() < 0)]}{'xyz'[int(abs(c).argmax())]}" for c in t.T) for t in TURNED]


def with_design(body: int, sensor_to_body: FloatArray) -> RobotModel:
    """Return the robot whose file has this mounting of a body's IMU."""
    imus = list(MODEL.imus)
    imus[body - 1] = replace(imus[body - 1], sensor_to_body=sensor_to_body)
    return replace(MODEL, imus=tuple(imus))


def lies_along(rotation: FloatArray) -> str:
    """Format the intended axes along which the sensor's axes lie."""
    return ", ".join(f"{'-' if c.sum() < 0 else ''}{'xyz'[int(abs(c).argmax())]}" for c in rotation.T)


def letters(rotation: FloatArray) -> list[str]:
    """Axes that lie along another."""
    return [
        axis for axis, along in zip("xyz", abs(rotation).argmax(axis=0), strict=True) if axis != "xyz"[along]
    ]


SOME = [
    pytest.param(turn, id=name, marks=() if name in FEW else pytest.mark.prove)
    for turn, name in zip(TURNED, NAMES, strict=True)
]


@pytest.mark.parametrize("rotation", SOME)
@pytest.mark.parametrize("body", [2, pytest.param(4, marks=pytest.mark.prove)])
def test_a_sensor_that_is_mounted_otherwise_is_named(body: int, rotation: FloatArray) -> None:
    """Name a wrongly mounted sensor completely by rotations about two axes.

    A robot file with the suggested mounting accepts the same recordings.
    """
    swings = [
        change_counts(record_good_step(step), turn_sensor(body, rotation))
        for step in SWINGS
        if body in step.moved
    ]
    with pytest.raises(CalibrationError) as caught:
        solve(prepend_rest_zero(*swings), MODEL)
    assert f"The sensor on body {body} looks " in caught.value.what
    assert f"its x, y, z lie along {lies_along(rotation)}" in caught.value.what
    moved = letters(rotation)
    assert ("exchanged" in caught.value.what) == (len(moved) == 2)
    if len(moved) == 2:
        assert f"looks mounted with {moved[0]} and {moved[1]} exchanged" in caught.value.what
    assert f"sensor_to_body = {rotation.astype(int).tolist()}" in caught.value.next_step
    accept(swings[-1], prepend_rest_zero(*swings[:-1]), with_design(body, rotation))


@pytest.mark.parametrize("rotation", SOME)
def test_one_joint_tells_as_much_as_one_axis_can(rotation: FloatArray) -> None:
    swing = change_counts(record_good_step(SWINGS[0]), turn_sensor(1, rotation))
    sensor_axis = rotation.T @ [1.0, 0.0, 0.0]
    main = int(np.abs(sensor_axis).argmax())
    if sensor_axis[0] == 1.0:  # turned about the joint's axis: the next joint tells
        accept(swing, prepend_rest_zero())
        return
    error = expect_refusal(swing, prepend_rest_zero())
    how = "the other way round" if main == 0 else f"with x and {'xyz'[main]} exchanged"
    assert error.what.startswith(f"The sensor on body 1 looks mounted {how}")
    axis_label = f"{'-' if sensor_axis.sum() < 0 else ''}{'xyz'[main]}"
    assert f"about the body's x axis on its {axis_label} axis" in error.what
    assert ("correct their direction" in error.next_step) == (main == 0)


@pytest.mark.parametrize("design", SOME)
def test_every_design_of_right_angles_is_taken(design: FloatArray) -> None:
    """Sensors up to 5 deg off it, on all four bodies."""
    turns = [turn_sensor(body, design) for body in (1, 2, 3, 4)]
    model = replace(MODEL, imus=tuple(replace(imu, sensor_to_body=design) for imu in MODEL.imus))
    steps = [change_counts(record_good_step(step), *turns) for step in (REST, ZERO, *SWINGS)]
    solution = solve(steps, model)
    for gyro, mounting in zip(solution.gyros, TRUTH.mounting, strict=True):
        off = Rotation.from_matrix(gyro.rotation.T @ mounting @ design).as_rotvec()
        stated = np.sqrt(np.diag(gyro.covariance)[3:6])
        assert np.all(np.abs(off) < 4.0 * stated + np.deg2rad(0.05))
        assert set(gyro.axes) == {"x", "y"} or gyro.body == 3


def test_a_mirrored_reading_is_refused() -> None:
    """Refuse a mirrored reading.

    No mounting exchanges two axes and leaves the third; a driver that mixes up registers does.
    """

    def mirror(counts: Counts) -> Counts:
        values = counts.imu_counts.copy()
        values[:, 1, [4, 5]] = values[:, 1, [5, 4]]
        return replace(counts, imu_counts=values)

    steps = [change_counts(record_good_step(step), mirror) for step in (REST, SWINGS[1], SWINGS[2])]
    with pytest.raises(CalibrationError, match="sensor on body 2 looks mounted with x and y exchanged"):
        solve([*steps, record_good_step(ZERO)], MODEL)


@pytest.mark.parametrize("joint", [1, 2, 3])
def test_both_directions_of_a_joint_wrong_in_the_file(joint: int) -> None:
    sensors = tuple(
        replace(sensor, direction=-sensor.direction) if sensor.joint == joint - 1 else sensor
        for sensor in MODEL.angle_sensors
    )
    model = replace(MODEL, angle_sensors=sensors)
    step = next(swing for swing in SWINGS if swing.joint == joint and (len(swing.moved) > 1 or joint == 3))
    error = expect_refusal(record_good_step(step), prepend_rest_zero(), model)
    if joint == 3:  # one gyro alone may be mounted so
        assert "body 4 looks mounted the other way round" in error.what
        assert "angle sensors count the other way: correct their direction" in error.next_step
    else:
        assert f"both sensors of joint {joint} count the other way than the robot file says" in error.what
        assert f"both [[angle_sensor]] of joint {joint}" in error.next_step


# Slipped in between


def test_a_sensor_that_slipped_between_two_joints() -> None:
    earlier = prepend_rest_zero(record_good_step(SWINGS[0]), record_good_step(SWINGS[1]))
    slipped = change_counts(record_good_step(SWINGS[2]), slip_sensor(2, (0.0, 0.0, 5.0)))
    error = expect_refusal(slipped, earlier)
    assert re.match(
        r"The gyro on body 2 measured two axes (8[45]|9[456])\.\d deg apart that are (90\.0|89\.9) deg",
        error.what,
    )
    assert "--joint 1 --anew, then --joint 2" in error.next_step
    accept(change_counts(record_good_step(SWINGS[2]), slip_sensor(2, (0.0, 0.0, 0.5))), earlier)


def test_a_sensor_on_body_4_that_slipped_is_told_its_own_joints() -> None:
    slipped = change_counts(record_good_step(SWINGS[4]), slip_sensor(4, (0.0, 0.0, -6.0)))
    error = expect_refusal(slipped, prepend_rest_zero(record_good_step(SWINGS[3])))
    assert "The gyro on body 4 measured two axes" in error.what
    assert "--joint 2 --anew, then --joint 3" in error.next_step


@pytest.mark.parametrize("about", [(0.0, 4.0, 0.0), (0.0, 0.0, 4.0)])
def test_a_sensor_that_slipped_between_swing_and_sweep(about: tuple[float, ...]) -> None:
    """Refuse a sensor that slipped between swing and sweep: the same axis has two directions."""
    error = expect_refusal(
        change_counts(record_good_step(SWEEPS[0]), slip_sensor(1, about)),
        prepend_rest_zero(record_good_step(SWINGS[0])),
    )
    assert "apart that are 0.0 deg" in error.what


def test_a_slip_that_swings_cannot_tell_shows_in_the_turn() -> None:
    slip = slip_sensor(1, (0.0, 6.0, 0.0))
    earlier = prepend_rest_zero(record_good_step(SWINGS[0]), change_counts(record_good_step(SWINGS[2]), slip))
    error = expect_refusal(change_counts(record_good_step(TURN), slip), earlier)
    assert re.match(
        r"The gyro on body 1 measured two axes (8[456]|9[3456])\.\d deg apart that are (90\.0|89\.9) deg",
        error.what,
    )


def test_a_step_is_judged_whatever_earlier_motions_say() -> None:
    """Check a step even if earlier motions contradict each other.

    The step that replaces the wrong one must not be refused for that.
    """
    earlier = prepend_rest_zero(
        record_good_step(SWINGS[1]),
        change_counts(record_good_step(SWINGS[2]), slip_sensor(2, (0.0, 0.0, 5.0))),
    )
    with pytest.raises(CalibrationError, match="measured two axes"):
        solve(earlier, MODEL)
    check_step(record_good_step(SWINGS[2]), earlier, MODEL)
