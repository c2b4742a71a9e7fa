"""At 100 kHz IMUs 2 and 4 are read 1.56 ms after IMUs 1 and 3: the log says so, and the evaluation heeds it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.evaluation.drops import Drop, certificate, flown, moved


@pytest.fixture(scope="module")
def one() -> Drop:
    return flown(1, bus_khz=100)


def off_deg(one: Drop, offsets_us: tuple[int, ...]) -> tuple[float, float]:
    """By a log that tells these offsets: rms error of the bodies' attitudes in the fall, and the measured delay, ms."""
    header = replace(one.log.header, imu_offset_us=offsets_us)
    found = moved(replace(one.log, header=header), certificate(one, 1), one.model)
    errors_rad = [
        (track.attitude[row] * one.true_turn(body, track.t_s[0], track.t_s[row]).inv()).magnitude()
        for body, track in enumerate(found.bodies, 1)
        for row in np.flatnonzero(track.t_s > 0.0)[::10]
    ]
    return float(np.rad2deg(np.sqrt(np.mean(np.square(errors_rad))))), 1e3 * found.lag.delay_s


def test_the_offsets_are_told_and_taken_off(one: Drop) -> None:
    """The low-pass and half the age of a reading make 5.3 ms, whenever an IMU is read."""
    told = one.log.header.imu_offset_us
    assert told == (0, 1560, 0, 1560)
    (right, delay_ms), (none, without_ms) = off_deg(one, told), off_deg(one, (0, 0, 0, 0))
    assert right < 0.06 and abs(delay_ms - 5.3) < 0.1
    assert none > 2.0 * right and abs(without_ms - 5.3) > 0.4


def test_a_reading_does_not_depend_on_the_steps_of_the_emulators_caller(
    one: Drop, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 1 ms, shorter than a reading of both IMUs of a bus, and of 100 ms."""
    monkeypatch.setattr("tests.evaluation.drops.TRUTH_PERIOD_US", 100_000)
    coarse = flown.__wrapped__(1, bus_khz=100)
    rows = min(len(one.log), len(coarse.log))
    np.testing.assert_array_equal(one.log.t_us[:rows], coarse.log.t_us[:rows])
    falling = (one.log.t_s[:rows] > 0.0) & (one.log.t_s[:rows] < 2.3)
    apart = (one.log.rate_rad_s[:rows] - coarse.log.rate_rad_s[:rows])[falling]
    assert np.rad2deg(np.sqrt((apart**2).mean())) < 0.03 and np.rad2deg(np.abs(apart).max()) < 0.5
