"""Zero points: right anywhere in 360 deg, and what is no zero."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from tests.calibration.bench_day import (
    MODEL,
    REST,
    TRUTH,
    ZERO,
    Change,
    accept,
    add_angle,
    change_counts,
    expect_refusal,
    record,
    record_good_step,
    silence_angle,
)
from tfsat_host.angles import wrap_angle
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.solution import solve
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.step import zero


def swing_angle(most_deg: float, share: FloatArray) -> FloatArray:
    return np.asarray(most_deg * np.sin(30.0 * share))


def loose(joint: int, most_deg: float) -> Change:
    """Return a change by which the joint swings to and fro within its attachment.

    Both sensors see it, each in its direction.
    """

    def change(counts: Counts) -> Counts:
        for sensor in (2 * joint - 1, 2 * joint):
            most = MODEL.angle_sensors[sensor - 1].direction * most_deg
            counts = add_angle(sensor, partial(swing_angle, most))(counts)
        return counts

    return change


@pytest.mark.parametrize(
    "shown_deg",
    [
        0.0,
        180.0,
        359.95,
        *(pytest.param(deg, marks=pytest.mark.prove) for deg in (0.04, 89.9, 359.9, 359.99)),
    ],
)
def test_zero_points_anywhere_and_at_the_wrap(shown_deg: float) -> None:
    """Find zero points anywhere, also at the wrap.

    There the sensors' noise crosses the wrap from one sample to the next.
    """
    design = np.array([sensor.zero_offset_rad for sensor in MODEL.angle_sensors])
    truth = replace(
        TRUTH, angle_zero_rad=np.deg2rad(shown_deg) - design, angle_nonlinearity_rad=np.zeros((6, 4))
    )
    solution = solve([record(zero(None), truth=truth)], MODEL)
    for sensors in solution.joints:
        off = np.rad2deg(wrap_angle(sensors.zero_rad - np.deg2rad(shown_deg)))
        assert np.all(np.abs(off) < 0.03)
        stated = np.rad2deg(np.sqrt(np.diag(sensors.zero_covariance)))
        assert np.all(stated < 0.03)
        assert np.all(np.abs(off) < 4.0 * stated)


def test_zero_of_one_joint_leaves_the_others() -> None:
    solution = solve([record_good_step(ZERO), record(zero(2))], MODEL)
    zero_times = [sensors.zero_recorded_at for sensors in solution.joints]
    assert zero_times[0] == zero_times[2] == record_good_step(ZERO).recorded_at
    assert zero_times[1] != zero_times[0]


@pytest.mark.parametrize("joint", [1, 2, 3])
def test_the_attachment_is_loose(joint: int) -> None:
    error = expect_refusal(change_counts(record_good_step(ZERO), loose(joint, 1.0)), [record_good_step(REST)])
    assert error.what.startswith(f"Joint {joint} moved by ")
    assert "screw it down" in error.next_step
    accept(change_counts(record_good_step(ZERO), loose(joint, 0.3)), [record_good_step(REST)])


def test_a_joint_that_creeps_while_its_zero_is_read() -> None:
    creeps = change_counts(record_good_step(ZERO), add_angle(3, lambda share: 1.2 * share))
    assert "Joint 2 moved by 0.8" in expect_refusal(creeps, [record_good_step(REST)]).what
    accept(
        change_counts(record_good_step(ZERO), add_angle(3, lambda share: 0.3 * share)),
        [record_good_step(REST)],
    )


@pytest.mark.parametrize(("sensor", "by_deg"), [(1, 5.0), (4, -5.0), (6, 175.0)])
def test_a_sensor_that_slipped_since_the_last_zero(sensor: int, by_deg: float) -> None:
    slipped = change_counts(record_good_step(ZERO), add_angle(sensor, by_deg))
    error = expect_refusal(slipped, [record_good_step(REST), record_good_step(ZERO)])
    joint = (sensor + 1) // 2
    assert error.what.startswith(f"The two sensors of joint {joint} disagree by ")
    assert abs(float(error.what.split(" disagree by ")[1].split()[0]) - abs(by_deg)) < 0.15
    assert error.next_step.endswith(f"tfsat-host calibrate zero --joint {joint} --anew")
    accept(slipped, [record_good_step(REST)])  # nothing to compare it with, or --anew


def test_both_sensors_turned_together_are_no_slip() -> None:
    """Accept both sensors turned together: the joint itself lies elsewhere, with another attachment."""
    turned = change_counts(record_good_step(ZERO), add_angle(1, 1.5), add_angle(2, -1.5))
    accept(turned, [record_good_step(REST), record_good_step(ZERO)])


@pytest.mark.parametrize("sensor", [2, 5])
def test_a_silent_sensor(sensor: int) -> None:
    error = expect_refusal(
        change_counts(record_good_step(ZERO), silence_angle(sensor, 0.5)), [record_good_step(REST)]
    )
    index, joint = (sensor - 1) % 2 + 1, (sensor + 1) // 2
    assert error.what == f"Angle sensor {index} of joint {joint} gave no value in 50 % of the samples."
    assert "monitor" in error.next_step
    accept(change_counts(record_good_step(ZERO), silence_angle(sensor, 0.005)), [record_good_step(REST)])


def test_another_joints_silent_sensor_does_not_matter() -> None:
    evidence = replace(change_counts(record_good_step(ZERO), silence_angle(1, 1.0)), step=zero(3))
    accept(evidence, [record_good_step(REST)])


def test_a_logger_that_restarted_while_a_zero_was_read() -> None:
    t_us = record_good_step(ZERO).counts.t_us.copy()
    t_us[len(t_us) // 2 :] -= t_us[len(t_us) // 2]
    restarted = change_counts(record_good_step(ZERO), lambda counts: replace(counts, t_us=t_us))
    assert "the logger restarted" in expect_refusal(restarted, [record_good_step(REST)]).what
