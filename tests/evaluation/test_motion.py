"""What the robot did, by its sensors, next to the emulated robot's truth; with other parts, and on a slow bus."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.evaluation import drops
from tests.evaluation.corrupted import without_samples
from tests.evaluation.drops import certificate, estimate_motion, few_of, fly_drop
from tests.fixtures.emulated_drop import DLPF_5_HZ, DLPF_42_HZ, Drop
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.sensor_samples import SensorSamples
from tfsat_host.evaluation.motion.attitude import BodyMotion
from tfsat_host.evaluation.motion.motion import Motion
from tfsat_host.evaluation.motion.samples import EvaluationError, samples_of
from tfsat_host.sdlog import DropLog

FILTERS = pytest.mark.parametrize("dlpf_cfg", [DLPF_42_HZ, DLPF_5_HZ])


def motion(seed: int, dlpf_cfg: int = DLPF_42_HZ) -> tuple[Drop, Motion]:
    return fly_drop(seed, dlpf_cfg), drops.motion(seed, dlpf_cfg)


def off_deg(drop: Drop, body: int, track: BodyMotion) -> tuple[float, float]:
    """Return a body's last attitude error and the largest standard deviation of it, in deg."""
    true = drop.true_turn(body, track.t_s[0], track.t_s[-1])
    error = np.rad2deg((track.attitude[-1] * true.inv()).magnitude())
    return float(error), float(np.rad2deg(np.sqrt(np.linalg.eigvalsh(track.covariance()).max())))


@FILTERS
@pytest.mark.parametrize("seed", few_of(1, 2, 3))
def test_every_body_ends_where_it_was_seen_to_end(seed: int, dlpf_cfg: int) -> None:
    drop, estimate = motion(seed, dlpf_cfg)
    for body, track in enumerate(estimate.bodies, 1):
        error, std = off_deg(drop, body, track)
        assert error < 0.06
        assert error < 4.0 * std
        assert 0.005 < std < 0.06


@FILTERS
def test_the_delay_of_the_low_pass_is_measured_against_the_angle_sensors(dlpf_cfg: int) -> None:
    """Measure the low-pass delay against the angle sensors.

    The data sheet says 4.8 and 18.6 ms; on average a reading is also half a millisecond old.
    """
    for seed in (1, 2, 3):
        _, estimate = motion(seed, dlpf_cfg)
        expected_s = {DLPF_42_HZ: 5.3e-3, DLPF_5_HZ: 19.1e-3}[dlpf_cfg]
        assert estimate.lag.measured
        assert estimate.lag.delay_s == pytest.approx(expected_s, abs=1e-4)
        assert estimate.lag.delay_std_s < 1e-4


def test_a_delay_that_no_chip_has_is_not_taken_off() -> None:
    """Reject a measured delay that no chip has.

    With body 4's gyro and both sensors of joint 1 dead, joint 2 alone would give one of minus 7 ms.
    """
    drop = fly_drop(1)
    angle_valid, imu_valid = drop.log.angle_valid.copy(), drop.log.imu_valid.copy()
    angle_valid[:, :2], imu_valid[:, 3] = False, False
    log = replace(drop.log, angle_valid=angle_valid, imu_valid=imu_valid)
    motion = estimate_motion(log, certificate(drop, 1), drop.model)
    assert motion.lag.delay_s == pytest.approx(5.3e-3, abs=3e-3)
    error, std = off_deg(drop, 3, motion.bodies[2])
    assert error < 4.0 * std


@FILTERS
def test_joint_angles_follow_the_truth_through_every_stroke(dlpf_cfg: int) -> None:
    for seed in (1, 2, 3):
        drop, estimate = motion(seed, dlpf_cfg)
        fall = estimate.t_s >= 0.0
        error = (estimate.angles_rad - drop.true_angles_rad(estimate.t_s))[fall]
        std = np.column_stack([joint.std_rad() for joint in estimate.joints])[fall]
        assert np.rad2deg(np.sqrt((error**2).mean(axis=0))).max() < 0.05
        assert (np.abs(error) < 4.0 * std + np.deg2rad(0.03)).all(), "0.03 deg: the ramps of a servo"


def without(log: DropLog, body: int, from_s: float, until_s: float) -> DropLog:
    valid = log.imu_valid.copy()
    valid[(log.t_s >= from_s) & (log.t_s < until_s), body - 1] = False
    return replace(log, imu_valid=valid)


@FILTERS
@pytest.mark.parametrize(
    ("body", "from_s", "until_s"), [(1, -100.0, 100.0), (2, -100.0, 100.0), (3, 0.9, 1.2), (4, 0.9, 1.2)]
)
def test_a_gyro_that_does_not_answer_is_bridged_and_said_to_be_less_sure(
    body: int, from_s: float, until_s: float, dlpf_cfg: int
) -> None:
    drop, reference = motion(1, dlpf_cfg)
    estimate = estimate_motion(without(drop.log, body, from_s, until_s), certificate(drop, 1), drop.model)
    track = estimate.bodies[body - 1]
    error, std = off_deg(drop, body, track)
    assert error < 0.15
    assert error < 4.0 * std
    assert track.bridged.any()
    assert not reference.bodies[body - 1].bridged.any()
    if body in (1, 4):  # the middle ones have two neighbours, whose gyros are as good as their own
        assert std > 1.1 * off_deg(drop, body, reference.bodies[body - 1])[1]


def test_a_single_lost_sample_costs_next_to_nothing() -> None:
    drop, _ = motion(1)
    row = int(np.searchsorted(drop.log.t_s, 1.2))
    log = without(drop.log, 1, float(drop.log.t_s[row]), float(drop.log.t_s[row]) + 1e-3)
    estimate = estimate_motion(log, certificate(drop, 1), drop.model)
    assert estimate.bodies[0].bridged.sum() <= 5
    assert off_deg(drop, 1, estimate.bodies[0])[0] < 0.05


def test_a_hole_in_all_gyros_is_counted_in_and_a_long_one_refused() -> None:
    drop, reference = motion(1)
    short, long = drop.log, drop.log
    for body in range(1, 5):
        short, long = without(short, body, 1.10, 1.13), without(long, body, 1.10, 1.25)
    estimate = estimate_motion(short, certificate(drop, 1), drop.model)
    error, std = off_deg(drop, 1, estimate.bodies[0])
    assert error < 4.0 * std
    assert std > 2.0 * off_deg(drop, 1, reference.bodies[0])[1]
    with pytest.raises(EvaluationError, match=r"No gyro has a sample between 1\.09\d s"):
        estimate_motion(long, certificate(drop, 1), drop.model)


def test_a_log_without_a_release_is_refused() -> None:
    drop, _ = motion(1)
    with pytest.raises(EvaluationError, match="no release"):
        estimate_motion(replace(drop.log, release=None), certificate(drop, 1), drop.model)


@pytest.mark.parametrize(("from_s", "until_s"), [(-0.25, -0.02), (-0.4, 0.0)])
def test_a_hole_before_the_release_is_none_in_the_fall(from_s: float, until_s: float) -> None:
    drop = fly_drop(1)
    samples = samples_of(without_samples(drop.log, from_s, until_s), certificate(drop, 1), drop.model)
    full_samples = samples_of(drop.log, certificate(drop, 1), drop.model)
    assert samples.t_s[samples.fall].tolist() == full_samples.t_s[full_samples.fall].tolist()


@pytest.mark.parametrize(("from_s", "until_s"), [(-0.05, 0.12), (2.2, 2.6)])
def test_the_fall_s_own_ends_may_not_be_lost(from_s: float, until_s: float) -> None:
    drop = fly_drop(1)
    with pytest.raises(EvaluationError, match="No gyro has a sample between"):
        samples_of(without_samples(drop.log, from_s, until_s), certificate(drop, 1), drop.model)


ALL_ICM_20689 = bytes([0x98] * 4)
MIXED = bytes([0x68, 0x70, 0x68, 0x98])
PARTS = pytest.mark.parametrize("parts", [ALL_ICM_20689, MIXED], ids=bytes.hex)


@cache
def flown_with(parts: bytes) -> tuple[Drop, Motion]:
    drop = drops.fly_drop(1, parts=parts)
    return drop, estimate_motion(drop.log, certificate(drop, 1))


@PARTS
def test_the_log_names_them_and_their_temperatures_are_right(parts: bytes) -> None:
    drop, _ = flown_with(parts)
    assert drop.log.header.who_am_i == parts
    assert drop.log.imu_valid[drop.log.t_s > -1.0].all()
    for temperature_c in (
        drop.log.temperature_c,
        SensorSamples.from_counts(Counts.from_log(drop.log)).temperature_c,
    ):
        assert np.abs(np.nanmean(temperature_c, axis=0) - 25.0).max() < 0.1


@PARTS
def test_their_low_pass_is_taken_off(parts: bytes) -> None:
    """Compensate the low-pass delay of each part.

    By the data sheets it is 5.9 ms for the ICM-20689 and 4.8 ms for the MPU-6050, plus half a millisecond of
    age.
    """
    _, motion = flown_with(parts)
    expected_s = 6.4e-3 if parts == ALL_ICM_20689 else 5.3e-3
    assert motion.lag.measured and motion.lag.expected_s == pytest.approx(expected_s)
    assert motion.lag.delay_s == pytest.approx(expected_s, abs=1e-4)


@PARTS
def test_angles_and_attitudes_are_as_right_as_with_the_papers_part(parts: bytes) -> None:
    drop, motion = flown_with(parts)
    fall = motion.t_s >= 0.0
    error = np.rad2deg(motion.angles_rad - drop.true_angles_rad(motion.t_s))[fall]
    assert np.sqrt((error**2).mean(axis=0)).max() < 0.05
    for body, track in enumerate(motion.bodies, 1):
        true = drop.true_turn(body, track.t_s[0], track.t_s[-1])
        off_rad = (track.attitude[-1] * true.inv()).magnitude()
        assert np.rad2deg(off_rad) < 0.06
        assert off_rad < 4.0 * np.sqrt(np.linalg.eigvalsh(track.covariance()).max())


@pytest.fixture(scope="module")
def slow() -> Drop:
    return fly_drop(1, bus_khz=100)


def off_all_deg(slow: Drop, offsets_us: tuple[int, ...]) -> tuple[float, float]:
    """Evaluate the drop with these IMU time offsets in the log's header.

    Return the rms error of the bodies' attitudes in the fall, in deg, and the measured delay, in ms.
    """
    header = replace(slow.log.header, imu_offset_us=offsets_us)
    motion = estimate_motion(replace(slow.log, header=header), certificate(slow, 1), slow.model)
    errors_rad = [
        (track.attitude[row] * slow.true_turn(body, track.t_s[0], track.t_s[row]).inv()).magnitude()
        for body, track in enumerate(motion.bodies, 1)
        for row in np.flatnonzero(track.t_s > 0.0)[::10]
    ]
    return float(np.rad2deg(np.sqrt(np.mean(np.square(errors_rad))))), 1e3 * motion.lag.delay_s


def test_the_offsets_are_told_and_taken_off_or_else_found(slow: Drop) -> None:
    """Compensate the IMU time offsets stated in the header, or else estimate them.

    The low-pass and half the age of a reading make 5.3 ms, whenever an IMU is read.
    """
    offsets_us = slow.log.header.imu_offset_us
    assert offsets_us == (0, 1560, 0, 1560)
    (right, delay_ms), (none, without_ms) = off_all_deg(slow, offsets_us), off_all_deg(slow, (0, 0, 0, 0))
    assert right < 0.06 and abs(delay_ms - 5.3) < 0.1
    # Untold they are in the mean delay, and in how much later than the others each gyro is.
    assert none < 0.06 and abs(without_ms - 5.3) > 0.4


def test_a_reading_does_not_depend_on_the_steps_of_the_emulators_caller(
    slow: Drop, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Readings do not depend on the step with which the emulator is advanced.

    Steps are 1 ms, shorter than a reading of both IMUs of a bus, and 100 ms.
    """
    monkeypatch.setattr("tests.fixtures.emulated_drop.TRUTH_PERIOD_US", 100_000)
    coarse = fly_drop.__wrapped__(1, bus_khz=100)
    rows = min(len(slow.log), len(coarse.log))
    np.testing.assert_array_equal(slow.log.t_us[:rows], coarse.log.t_us[:rows])
    falling = (slow.log.t_s[:rows] > 0.0) & (slow.log.t_s[:rows] < 2.3)
    apart = (slow.log.rate_rad_s[:rows] - coarse.log.rate_rad_s[:rows])[falling]
    assert np.rad2deg(np.sqrt((apart**2).mean())) < 0.03 and np.rad2deg(np.abs(apart).max()) < 0.5
