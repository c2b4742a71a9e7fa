"""The rest before a release: found in a long recording, between knocks, and as long as it really is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.calibration.quiet_drop import quiet_drop
from tests.sdlog.encoder import drop_with_release
from tests.sdlog.test_values import write
from tfsat_host.calibration.bias import estimate_biases, quiet_before_release
from tfsat_host.calibration.steps.sensor_samples import SensorSamples
from tfsat_host.sdlog import DropLog, load

RATE_HZ = 280
STEP_US = 3571
BIAS_COUNTS = np.array([120, -75, 33])
FALL_S = 5


@pytest.fixture
def drop(tmp_path: Path) -> DropLog:
    """Return a recording with a release; its columns are replaced by `resting`."""
    return load(write(tmp_path / "SD.bin", drop_with_release()[0].image()))


def make_rest_log(drop: DropLog, rest_s: int, seed: int = 1) -> DropLog:
    """`rest_s` on the bench with an MPU-6050's noise, then 1 s in the hook, the release and a fall with turning."""
    rng = np.random.default_rng(seed)
    # Rest, one second in the hook, the release, and five seconds of fall.
    n = (rest_s + 1 + FALL_S) * RATE_HZ
    released = (rest_s + 1) * RATE_HZ
    t_us = 1_000_000 + STEP_US * np.arange(n, dtype=np.int64)
    counts = np.zeros((n, 4, 7))
    # One g on every accelerometer's z: the robot lies still.
    counts[:, :, 2] = 16384
    counts[:, :, 3] = -4000
    counts[:, :, 4:7] = BIAS_COUNTS
    counts[:, :, :3] += 60 * rng.normal(size=(n, 4, 3))
    # 4 counts of gyro noise: the MPU-6050's own.
    counts[:, :, 4:7] += 4 * rng.normal(size=(n, 4, 3))
    # 45 deg/s from the release on: not part of the rest.
    counts[released:, :, 4:7] += 3000
    assert drop.release is not None
    at = int(t_us[released])
    return replace(
        drop,
        sample_index=np.arange(n, dtype=np.int64),
        t_us=t_us,
        release=replace(drop.release, t_us=at, earliest_us=at, latest_us=at, left_us=(at, at)),
        imu_counts=counts.round().astype(np.int16),
        angle_counts=np.zeros((n, 6), np.uint16),
        imu_valid=np.ones((n, 4), dtype=bool),
        angle_valid=np.ones((n, 6), dtype=bool),
        switch_open=np.zeros((n, 2), dtype=bool),
        clipped=np.zeros((n, 4), dtype=bool),
        late_rows=np.zeros(0, np.int64),
    )


def stretch_s(log: DropLog) -> tuple[float, float] | None:
    """Return the begin and the end of the quiet interval, in seconds after the first sample."""
    quiet = quiet_before_release(log)
    if quiet is None:
        return None
    return tuple((quiet.t_us[[0, -1]] - log.t_us[0]) * 1e-6)


def second(at_s: float) -> slice:
    return slice(round(at_s * RATE_HZ), round((at_s + 0.2) * RATE_HZ))


def test_all_of_a_long_rest_is_taken(drop: DropLog) -> None:
    log = make_rest_log(drop, 143)
    quiet = quiet_before_release(log)
    assert quiet is not None
    # Every sample of the rest, to the last one.
    assert len(quiet.t_us) == 143 * RATE_HZ
    assert quiet.t_us[-1] < log.origin_us - 1_000_000
    for estimate in estimate_biases(SensorSamples.from_counts(quiet)):
        assert np.degrees(estimate.bias_rad_s) == pytest.approx(BIAS_COUNTS / 65.5, abs=0.003)


def shift(rows: slice, column: int, counts: int) -> Callable[[DropLog], None]:
    def change(log: DropLog) -> None:
        log.imu_counts[rows, 2, column] += counts

    return change


def shake(column: int, counts: int) -> Callable[[DropLog], None]:
    def change(log: DropLog) -> None:
        at = second(40.0)
        # Alternating sign: a shake whose mean is the bias itself.
        log.imu_counts[at, 1, column] += (counts * (-1.0) ** np.arange(at.stop - at.start)).astype(np.int16)

    return change


def invalidate_sample(log: DropLog) -> None:
    log.imu_valid[40 * RATE_HZ, 3] = False


def at_full_scale(log: DropLog) -> None:
    log.clipped[40 * RATE_HZ, 3] = True


def lost(log: DropLog) -> None:
    # Seven samples are missing from here on.
    log.sample_index[round(40.5 * RATE_HZ) :] += 7


@pytest.mark.parametrize(
    "knock",
    [
        shake(4, 300),
        shake(2, 2500),
        shift(second(40.3), 5, 2000),
        shift(second(40.3), 0, 9000),
        invalidate_sample,
        at_full_scale,
        lost,
    ],
    ids=["gyro shakes", "accelerometer shakes", "a turn", "a push", "no answer", "clipped", "lost samples"],
)
def test_a_knock_divides_the_rest(drop: DropLog, knock: Callable[[DropLog], None]) -> None:
    log = make_rest_log(drop, 120)
    knock(log)
    # A knock at 40 s: the longer part behind it counts.
    first, last = stretch_s(log) or (0.0, 0.0)
    assert 40.0 < first < 42.5
    assert last == pytest.approx(120.0, abs=0.1)


def test_late_samples_divide_it_too(drop: DropLog) -> None:
    log = replace(make_rest_log(drop, 120), late_rows=np.array([40 * RATE_HZ]))
    first, _ = stretch_s(log) or (0.0, 0.0)
    assert 40.0 < first < 42.5


def test_the_longest_is_taken_and_of_equals_the_newest(drop: DropLog) -> None:
    log = make_rest_log(drop, 100)
    shift(second(60.0), 4, 2000)(log)
    # 60 s before the knock, 40 s behind it: the longer part.
    assert stretch_s(log) == pytest.approx((0.0, 60.0), abs=2.1)
    log = make_rest_log(drop, 100)
    shift(second(51.0), 4, 2000)(log)  # 50 s before, 48 s after: within 10 %
    assert stretch_s(log) == pytest.approx((52.0, 100.0), abs=2.1)


def test_a_bias_that_moves_is_taken_where_it_came_to_rest(drop: DropLog) -> None:
    """Take a drifting bias from where it became steady.

    A board warms up: its bias changes by 0.5 deg/s in the first minute, then it is steady.
    """
    log = make_rest_log(drop, 180)
    ramp = np.clip(np.arange(len(log)) / (60 * RATE_HZ), 0, 1)
    # 33 counts are 0.5 deg/s: the drift of the first minute.
    log.imu_counts[:, 1, 6] += np.round(-33 * (1 - ramp)).astype(np.int16)
    first, last = stretch_s(log) or (0.0, 0.0)
    assert 45.0 < first < 61.0
    assert last == pytest.approx(180.0, abs=0.1)


def test_a_bias_that_never_rests_is_taken_just_before_the_release(drop: DropLog) -> None:
    """It moves by the drift that is allowed in 35 s: the last 35 s count, wherever the first ones began."""
    log = make_rest_log(drop, 80)
    # 6.55 counts are 0.1 deg/s, the drift that is allowed.
    ramp = np.arange(len(log)) / (35 * RATE_HZ)
    log.imu_counts[:, 1, 6] += np.round(6.55 * ramp).astype(np.int16)
    first, last = stretch_s(log) or (0.0, 0.0)
    assert last == pytest.approx(80.0, abs=0.1)
    assert 25.0 < last - first < 37.0


def test_a_gyro_that_turns_steadily_rests_by_itself_but_its_weight_does_not(drop: DropLog) -> None:
    log = make_rest_log(drop, 60)
    # Half a g is no robot at rest.
    log.imu_counts[:, 0, 2] = 8000
    assert quiet_before_release(log) is None


def test_too_short_a_rest_is_none(drop: DropLog) -> None:
    assert quiet_before_release(make_rest_log(drop, 9)) is None
    log = make_rest_log(drop, 60)
    # Nine seconds between knocks: every rest is too short.
    for at_s in np.arange(0.5, 60, 9.0):
        shift(second(at_s), 4, 2000)(log)
    assert quiet_before_release(log) is None
    assert quiet_before_release(drop) is None


def test_without_a_release_all_of_it_counts(drop: DropLog) -> None:
    log = make_rest_log(drop, 30)
    log.imu_counts[:, :, 4:7] = BIAS_COUNTS
    interval_s = stretch_s(replace(log, release=None))
    # Without a release the whole recording is one rest.
    assert interval_s == pytest.approx((0.0, 36.0), abs=0.1)


def test_the_wait_in_the_emulated_releaser(tmp_path: Path) -> None:
    """Estimate biases from the wait in the emulated releaser, against the truth.

    The logger's own firmware recorded it.
    """
    data, truth = quiet_drop(4)
    card = tmp_path / "SD.bin"
    card.write_bytes(data)
    quiet = quiet_before_release(load(card))
    assert quiet is not None
    # The wait of 14 s, less its end before the release.
    assert 12.0 <= len(quiet.t_us) / RATE_HZ <= 13.5
    for estimate in estimate_biases(SensorSamples.from_counts(quiet)):
        assert np.degrees(estimate.bias_rad_s) == pytest.approx(
            np.degrees(truth[estimate.body - 1]), abs=0.02
        )
