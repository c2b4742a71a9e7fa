"""Readings that a drop lacks: what that costs, and that nothing else is blamed for it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.evaluation.corrupted import Flown, failures_by_name, healthy_drop, silence_imu, without_samples
from tests.evaluation.drops import few_of
from tfsat_host.sdlog import DropLog

HOLES, ANSWERS = "holes in the fall", "answers in the fall"


@pytest.fixture(scope="module")
def healthy() -> Flown:
    return healthy_drop()


def all_silent(log: DropLog, from_s: float, until_s: float) -> DropLog:
    for body in range(1, 5):
        log = silence_imu(log, body, from_s, until_s)
    return log


def sensors_silent(log: DropLog, columns: list[int], from_s: float, until_s: float) -> DropLog:
    valid = log.angle_valid.copy()
    for column in columns:
        valid[(log.t_s >= from_s) & (log.t_s < until_s), column] = False
    return replace(log, angle_valid=valid)


def test_a_hole_in_all_gyros_in_a_stroke_fails_and_says_what_it_costs(healthy: Flown) -> None:
    # 30 ms without any gyro, in the middle of stroke 2.
    failures = failures_by_name(healthy.run_checks(lambda log: all_silent(log, 1.10, 1.13)))
    # 30 ms and the sample interval on either side.
    assert failures[HOLES].value == pytest.approx(32.0, abs=3.0)
    assert "Joint 2 moved at its ends" in failures[HOLES].sentence
    assert "off by up to 0." in failures[HOLES].sentence
    assert (failures[HOLES].cause or "").startswith("no IMU answered although the logger sampled")


def test_the_same_while_nothing_moves(healthy: Flown) -> None:
    failures = failures_by_name(healthy.run_checks(lambda log: all_silent(log, 0.30, 0.33)))
    assert "No joint moved at its ends" in failures[HOLES].sentence


def test_gyros_that_are_silent_one_after_the_other_leave_no_hole(healthy: Flown) -> None:
    # Staggered by 0.1 s: at every moment three gyros still measure.
    def wrong(log: DropLog) -> DropLog:
        for body in range(1, 5):
            log = silence_imu(log, body, 0.20 + 0.1 * body, 0.23 + 0.1 * body)
        return log

    assert HOLES not in failures_by_name(healthy.run_checks(wrong))


def test_lost_samples_are_a_hole_of_the_recording(healthy: Flown) -> None:
    failures = failures_by_name(healthy.run_checks(lambda log: without_samples(log, 1.10, 1.13)))
    assert "blocks" in (failures[HOLES].cause or "") or "late" in (failures[HOLES].cause or "")
    assert "Joint 2 moved at its ends" in failures[HOLES].sentence


@pytest.mark.parametrize("from_s", few_of(1.045, 1.155, 1.355))
def test_an_angle_sensor_that_misses_part_of_a_stroke_contradicts_nobody(
    healthy: Flown, from_s: float
) -> None:
    """Less than half of each block of 0.1 s: its mean counts."""
    failures = failures_by_name(
        healthy.run_checks(lambda log: sensors_silent(log, [2], from_s, from_s + 0.045))
    )
    assert failures.keys() <= {ANSWERS}


@pytest.mark.parametrize(("body", "from_s"), few_of((2, 1.045), (1, 1.045), (2, 1.355), (3, 1.355)))
def test_a_gyro_that_misses_part_of_a_stroke_contradicts_nobody(
    healthy: Flown, body: int, from_s: float
) -> None:
    failures = failures_by_name(
        healthy.run_checks(lambda log: silence_imu(log, body, from_s, from_s + 0.045))
    )
    assert failures.keys() <= {ANSWERS}


def test_the_words_are_those_of_the_sensor_that_is_silent(healthy: Flown) -> None:
    def sentence(wrong: DropLog) -> str:
        return failures_by_name(healthy.run_checks(lambda _: wrong))[ANSWERS].sentence

    log = healthy.drop.log
    imu = sentence(silence_imu(log, 3, 0.5, 1.0))
    assert imu.startswith("The IMU of body 3 did not answer in ")
    assert "its neighbours and the angle sensors bridge it." in imu
    sensor_text = sentence(sensors_silent(log, [2], 0.5, 1.0))
    assert sensor_text.startswith("The angle sensor 1 of joint 2 did not answer in ")
    assert "the joint's other sensor and the gyros go on without it." in sensor_text
    both = sentence(sensors_silent(log, [2, 3], 0.5, 1.0))
    assert "neither of the joint's did, and its gyros alone tell its angle. 1 more did not answer" in both
