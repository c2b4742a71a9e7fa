"""How a step that is being read is followed: who moves how much, and which rest is next."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tfsat_host.calibration.progress import MAX_DURATION_S, progress_of, stops_deg
from tfsat_host.calibration.solution import solve
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.sensor_samples import SensorSamples, find_rests
from tfsat_host.calibration.steps.step import Step, rest, sweeps, swings, turn, zero
from tfsat_host.cli.calibrate.person import Picture, line_of
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.emulated.emulated_operator import EmulatedOperator
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.emulated.imperfections import ideal
from tfsat_host.emulated.manual_motion import Operator
from tfsat_host.robot import load_robot

MODEL = load_robot()
_NOTHING = solve((), MODEL)
SWEEP, TURN = sweeps(1)[1], turn("z", -360.0)


@cache
def record_counts(step: Step, duration_s: float, hands: Operator) -> Counts:
    """Record an ideal robot's sensors while a person performs the step."""
    with EmulatedRobot(MODEL, imperfections=ideal(), seed=1) as robot:
        robot.advance(SETTLE_US)
        logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
        EmulatedOperator(robot, hands).begin(step)
        parts: list[Counts] = []
        with logger.live() as scales:
            while not parts or parts[-1].t_us[-1] - parts[0].t_us[0] < duration_s * 1e6:
                parts.append(Counts.from_live(logger.live_samples(), scales))
        return Counts.join(parts)


def until(counts: Counts, elapsed_s: float) -> Counts:
    """Return the part of the counts received by `elapsed_s`."""
    n = int(np.searchsorted(counts.t_us, counts.t_us[0] + elapsed_s * 1e6))
    return replace(
        counts,
        t_us=counts.t_us[:n],
        imu_counts=counts.imu_counts[:n],
        angle_counts=counts.angle_counts[:n],
        imu_valid=counts.imu_valid[:n],
        angle_valid=counts.angle_valid[:n],
        clipped=counts.clipped[:n],
    )


def test_a_sweep_rests_where_the_screen_says_and_ends_with_the_last_rest() -> None:
    stops = stops_deg(SWEEP)
    assert list(stops) == [0, 30, 60, 90, 60, 30, 0, 30, 60, 90, 60, 30, 0]
    counts = record_counts(SWEEP, 34.0, Operator.steady())
    snapshots = [
        progress_of(SWEEP, until(counts, elapsed_s), _NOTHING, MODEL)
        for elapsed_s in np.arange(1.0, 34.0, 1.5)
    ]
    rests = [snapshot.rests for snapshot in snapshots]
    assert rests == sorted(rests) and rests[-1] == len(stops)
    for snapshot in snapshots:
        assert snapshot.next_stop_deg == (stops[snapshot.rests] if snapshot.rests < 13 else None)
        assert snapshot.done is (snapshot.rests == 13)
    arrived = next(snapshot for snapshot in snapshots if snapshot.rests == 4)
    assert arrived.joint_deg[0] == pytest.approx(90.0, abs=3.0)
    final_snapshot = next(snapshot for snapshot in snapshots if snapshot.done)
    assert final_snapshot.elapsed_s > 1.0 + 12 * 2.5 - 1.0, "the last rest was read, not only reached"


def test_a_turn_rests_at_both_ends() -> None:
    assert list(stops_deg(TURN)) == [0, -360, 0, -360, 0, -360, 0]
    counts = record_counts(TURN, 34.0, Operator.steady())
    assert progress_of(TURN, until(counts, 4.0), _NOTHING, MODEL).next_stop_deg == -360
    assert progress_of(TURN, until(counts, 28.0), _NOTHING, MODEL).rests == 6
    assert progress_of(TURN, counts, _NOTHING, MODEL).done


def test_a_joint_that_twitches_at_a_rest_has_rested_once() -> None:
    still = record_counts(rest(), 4.0, Operator.steady())
    twitching = replace(still, imu_counts=still.imu_counts.copy())
    middle = len(still.t_us) // 2
    twitching.imu_counts[middle : middle + 30, 1:3, 4] += 500  # 8 deg/s for a tenth of a second
    samples = SensorSamples.from_counts(twitching)
    assert len(find_rests(samples.t_s, samples.rate_rad_s[:, 1, 0])) == 2
    assert progress_of(SWEEP, twitching, _NOTHING, MODEL).rests == 1


def test_nobody_who_sweeps_is_waited_for_endlessly() -> None:
    counts = record_counts(rest(), 2.0, Operator.steady())
    late = replace(
        counts, t_us=counts.t_us + np.where(np.arange(len(counts.t_us)) > 5, round(MAX_DURATION_S * 1e6), 0)
    )
    progress = progress_of(SWEEP, late, _NOTHING, MODEL)
    assert (progress.done, progress.left_s, progress.rests) == (True, 0.0, 1)
    assert not progress_of(SWEEP, counts, _NOTHING, MODEL).done


def test_what_moves_and_what_should() -> None:
    counts = record_counts(SWEEP, 34.0, Operator.steady())
    right = progress_of(SWEEP, counts, _NOTHING, MODEL).levels
    assert all(level.met for level in right)
    assert right[3].limit_deg_s is None, "body 4 goes along with 2 and 3"
    wrong = progress_of(
        sweeps(1)[0], counts, _NOTHING, MODEL
    ).levels  # asked was body 1, with 2, 3 and 4 held
    assert [level.met for level in wrong] == [False, False, False, False]
    resting = progress_of(rest(), counts, _NOTHING, MODEL).levels
    assert [level.met for level in resting] == [True] * 4, "the last seconds count, and the sweep is over"
    moving = progress_of(zero(None), until(counts, 10.0), _NOTHING, MODEL)
    assert [level.met for level in moving.levels] == [True, False, False, False]
    assert (moving.done, progress_of(zero(None), until(counts, 4.0), _NOTHING, MODEL).done) == (True, False)


@pytest.mark.parametrize("width", [60, 80, 120])
@pytest.mark.parametrize("step", [rest(), swings(1)[0], SWEEP, TURN])
def test_the_picture_fits_the_terminal_and_says_what_is_wrong(step: Step, width: int) -> None:
    progress = progress_of(step, until(record_counts(SWEEP, 34.0, Operator.steady()), 10.0), _NOTHING, MODEL)
    lines = [line for line, _ in Picture(step, progress).lines(width)]
    assert max(map(len, lines)) <= max(width, 60)
    assert sum("|" in line for line in lines) == sum(
        level.limit_deg_s is not None for level in progress.levels
    )
    assert ("rest at" in lines[-1]) is (step in (SWEEP, TURN))
    wrong = [level for level in progress.levels if not level.met]
    assert all(
        f"body {level.body} {level.rate_deg_s:.1f} deg/s" in line_of(step, progress) for level in wrong
    )
