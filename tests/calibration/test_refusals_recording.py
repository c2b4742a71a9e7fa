"""Recordings that are not whole, and rests that are none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.calibration.bench_day import (
    ACCEL,
    HANDS,
    REST,
    SWEEPS,
    SWINGS,
    TURN,
    ZERO,
    Change,
    accept,
    add_rate,
    change_counts,
    expect_refusal,
    freeze_gyro,
    prepend_rest_zero,
    record,
    record_good_step,
)
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.steps.counts import COLUMNS, Counts
from tfsat_host.calibration.steps.step import Step

MOTIONS = [SWINGS[0], SWEEPS[0], TURN]
ALL = [REST, ZERO, *MOTIONS]


def ids(steps: list[Step]) -> list[str]:
    return [step.key for step in steps]


def clip(body: int, samples: int) -> Change:
    """Some samples of a body's IMU at full scale, as the logger marks them."""

    def change(counts: Counts) -> Counts:
        values, clipped = counts.imu_counts.copy(), counts.clipped.copy()
        values[50 : 50 + samples, body - 1, 4] = 32767
        clipped[50 : 50 + samples, body - 1] = True
        return replace(counts, imu_counts=values, clipped=clipped)

    return change


def lose(share: float) -> Change:
    """So many samples that the logger took did not arrive."""

    def change(counts: Counts) -> Counts:
        keep = np.random.default_rng(1).random(len(counts.t_us)) >= share
        remaining_columns = {name: getattr(counts, name)[keep] for name in COLUMNS}
        return replace(counts, **remaining_columns, samples_lost=int((~keep).sum()))

    return change


def restart(counts: Counts) -> Counts:
    """Restart the logger's clock in the middle."""
    t_us = counts.t_us.copy()
    t_us[len(t_us) // 2 :] -= t_us[len(t_us) // 2] - 300_000
    return replace(counts, t_us=t_us)


@pytest.mark.parametrize("step", [REST, SWEEPS[0]], ids=ids([REST, SWEEPS[0]]))
def test_a_clipped_sensor(step: Step) -> None:
    error = expect_refusal(change_counts(record_good_step(step), clip(4, 3)), prepend_rest_zero())
    assert error.what.startswith("The sensor on body 4 was at its full scale in 3 of ")
    assert "slower than 500 deg/s" in error.next_step


@pytest.mark.parametrize("step", [REST, TURN], ids=ids([REST, TURN]))
def test_lost_samples(step: Step) -> None:
    error = expect_refusal(change_counts(record_good_step(step), lose(0.02)), prepend_rest_zero())
    assert "samples never reached this computer" in error.what
    assert "without a hub" in error.next_step


@pytest.mark.parametrize("step", ALL, ids=ids(ALL))
def test_a_few_lost_samples_are_no_reason(step: Step) -> None:
    accept(change_counts(record_good_step(step), lose(0.005)), prepend_rest_zero())


@pytest.mark.parametrize("step", ALL, ids=ids(ALL))
def test_a_logger_that_restarted(step: Step) -> None:
    error = expect_refusal(change_counts(record_good_step(step), restart), prepend_rest_zero())
    assert "the logger restarted" in error.what
    assert "tfsat-host status" in error.next_step


@pytest.mark.parametrize("step", [REST, TURN], ids=ids([REST, TURN]))
def test_a_gyro_that_did_not_answer(step: Step) -> None:
    valid = record_good_step(step).counts.imu_valid.copy()
    valid[7, 1] = False
    error = expect_refusal(
        change_counts(record_good_step(step), lambda counts: replace(counts, imu_valid=valid)),
        prepend_rest_zero(),
    )
    assert error.what.startswith("1 of ")
    assert "samples of the gyro on body 2 are invalid" in error.what


# Rests


def rates(of: Callable[[FloatArray], FloatArray]) -> Callable[[FloatArray], FloatArray]:
    """Return a rate about x, in deg/s over time, as a function giving all three axes."""
    return lambda t_s: np.column_stack([of(t_s), np.zeros((len(t_s), 2))])


def tilt(body: int, rate_deg_s: float) -> Change:
    """Return a change by which a body turns about x at a steady rate, in both gyro and accelerometer."""

    def change(counts: Counts) -> Counts:
        counts = add_rate(body, rates(lambda t_s: np.full(len(t_s), rate_deg_s)))(counts)
        t_s = (counts.t_us - counts.t_us[0]) * 1e-6
        turned = Rotation.from_rotvec(np.deg2rad(-rate_deg_s) * t_s[:, None] * [1.0, 0.0, 0.0])
        values = counts.imu_counts.copy()
        values[:, body - 1, ACCEL] = np.rint(turned.apply(values[:, body - 1, ACCEL]))
        return replace(counts, imu_counts=values)

    return change


def add_force(offset_g: float) -> Change:
    """Return a change that adds a force to every axis of every accelerometer."""

    def change(counts: Counts) -> Counts:
        values = counts.imu_counts.copy()
        values[..., ACCEL] += round(offset_g * counts.scales.accel_lsb_per_g)
        return replace(counts, imu_counts=values)

    return change


@pytest.mark.parametrize(
    ("fault", "words", "cure"),
    [
        (
            add_rate(2, rates(lambda t_s: 3.0 * np.sin(20.0 * t_s))),
            "Body 2 was not still",
            "without touching",
        ),
        (add_rate(3, rates(lambda t_s: 0.015 * t_s)), "gyro on body 3 drifted by 0.15", "Wait some minutes"),
        (tilt(1, 0.3), "Body 1 was tilted by", "without touching"),
        (tilt(4, -0.05), "Body 4 was tilted by", "without touching"),
        (freeze_gyro(2), "gyro on body 2 gave the very same value in all", "Switch the logger off"),
    ],
    ids=["shaken", "warming up", "tilted slowly", "tilted very slowly", "frozen"],
)
def test_no_rest(fault: Change, words: str, cure: str) -> None:
    error = expect_refusal(change_counts(record_good_step(REST), fault), [])
    assert words in error.what
    assert cure in error.next_step


@pytest.mark.parametrize("size", [0.0, 0.5, 1.3])
def test_an_accelerometer_that_does_not_read_one_g(size: float) -> None:
    def scale(counts: Counts) -> Counts:
        values = counts.imu_counts.copy()
        values[:, 2, ACCEL] = np.rint(size * values[:, 2, ACCEL])
        return replace(counts, imu_counts=values)

    error = expect_refusal(change_counts(record_good_step(REST), scale), [])
    assert error.what == f"The accelerometer on body 3 reads {size:.2f} g at rest, not 1 g."


def test_a_table_that_is_knocked() -> None:
    def knock(counts: Counts) -> Counts:
        values = counts.imu_counts.copy()
        t_s = (counts.t_us - counts.t_us[0]) * 1e-6
        values[:, 0, 2] += np.rint(2000.0 * np.sin(40.0 * t_s)).astype(np.int16)
        return replace(counts, imu_counts=values)

    assert "Body 1 was shaken" in expect_refusal(change_counts(record_good_step(REST), knock), []).what


@pytest.mark.parametrize(
    "fault",
    [
        add_rate(2, rates(lambda t_s: 0.5 * np.sin(20.0 * t_s))),
        add_rate(3, rates(lambda t_s: 0.005 * t_s)),
        tilt(1, 0.005),
        add_force(0.06),
    ],
    ids=["a passing lorry", "nearly warm", "as good as still", "the offset of a real accelerometer"],
)
def test_a_rest_that_is_quiet_enough(fault: Change) -> None:
    accept(change_counts(record_good_step(REST), fault), [])


def test_hands_on_the_robot_are_no_rest() -> None:
    evidence = record(SWINGS[0], hands=HANDS)
    assert "was not still" in expect_refusal(replace(evidence, step=REST), []).what
