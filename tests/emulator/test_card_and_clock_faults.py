"""A slow card, clocks that go wrong while the robot runs, and a supply that goes in the middle of a block."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.emulator.fault_bench import SEED, do_nothing, fly
from tests.fixtures.emulated_drop import read_card, releaser
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.emulated.imperfections import ideal
from tfsat_host.protocol.enums import SequencerState

BOTH = pytest.mark.parametrize("sequencer", ["native", "avr"])


@pytest.mark.parametrize("stall_us", [None, 60_000, 400_000, 900_000])
def test_the_ring_bridges_a_card_that_stalls_now_and_then(stall_us: int | None) -> None:
    with releaser(seed=SEED) as (robot, _, logger):
        logger.start_recording()
        robot.faults.card_stalls(stall_us)
        robot.advance(6_000_000)
        logger.stop_recording()
        log = read_card(robot)
    assert log.verdict == "complete" and log.samples_lost == 0
    stalls = [event for event in log.events if event.name == "card_stall"]
    assert bool(stalls) == (stall_us is not None)
    # The stall is timed by the logger as long as it was.
    for stall in stalls:
        assert stall.value * 1000 == pytest.approx(stall_us, abs=3_000)


def test_stalls_come_about_as_often_as_they_are_told() -> None:
    with releaser(seed=SEED) as (robot, _, logger):
        logger.start_recording()
        robot.faults.card_stalls(200_000, 1_000_000)
        robot.advance(24_000_000)
        logger.stop_recording()
        log = read_card(robot)
    ended_us = np.array([event.t_us for event in log.events if event.name == "card_stall"])
    # 24 s with a stall about every second.
    assert 16 <= ended_us.size <= 25
    apart_s = np.diff(ended_us) * 1e-6
    # Not evenly: the distances are drawn, but never far from their mean.
    assert apart_s.min() >= 0.7 and apart_s.max() <= 1.75 and np.ptp(apart_s) > 0.3


def test_a_card_that_stalls_at_each_block_is_more_than_the_ring_bridges() -> None:
    with releaser(seed=SEED) as (robot, _, logger):
        logger.start_recording()
        # 400 ms for every block: the card is far too slow for any ring.
        robot.faults.card_stalls(400_000, 0)
        robot.advance(40_000_000)
        dropped = logger.status().samples_dropped
    assert dropped > 1000


@BOTH
def test_a_sequencers_clock_may_go_wrong_in_the_middle_of_a_run(sequencer: str) -> None:
    """1.2 s after the release it gets 2 % slow: the strokes at 1.47 and 1.82 s come 2 % of what was left later."""
    with releaser(seed=SEED, imperfections=ideal(), sequencer=sequencer) as (robot, board, logger):
        logger.start_recording()
        fly(robot, board, do_nothing, until_us=1_200_000)
        turned_us = robot.now_us - robot.released_us
        # 2 % slow from here on.
        robot.faults.clock("sequencer", -20_000.0)
        robot.advance(1_300_000)
        assert board.status().state == SequencerState.DONE
        logger.stop_recording()
        log = read_card(robot)
        noted_us = [event.t_us - robot.released_us for event in log.events if event.name == "stroke"]
    expected = [700_000.0, 1_050_000.0]
    # What was left of the time goes 2 % slower.
    expected += [turned_us + (at_us - turned_us) / 0.98 for at_us in (1_470_000, 1_820_000)]
    assert noted_us == pytest.approx(expected, abs=25)


def test_a_loggers_clock_may_go_wrong_while_it_records_and_its_time_has_no_jump() -> None:
    with releaser(seed=SEED, imperfections=ideal()) as (robot, _, logger):
        logger.start_recording()
        robot.advance(1_000_000)
        before_us = robot.now_us
        robot.faults.clock("logger", 10_000.0)
        robot.advance(1_000_000)
        robot.knock(1, 100_000)
        knocked_us = robot.now_us
        robot.advance(500_000)
        logger.stop_recording()
        log = read_card(robot)
    # The samples' own times stay even: no jump in the log.
    assert np.diff(log.t_us).max() <= 1e6 / log.header.rate_hz + 1
    assert np.diff(log.t_us).min() >= 1e6 / log.header.rate_hz - 1
    (opened, closed) = [event.t_us for event in log.events if event.name == "switch_edge"]
    # The logger notes the switch by its own clock, which is 1 % fast by then.
    assert opened == pytest.approx(before_us + (knocked_us - before_us) * 1.01, abs=2)
    assert closed - opened == pytest.approx(101_000, abs=2)


@pytest.mark.parametrize("ppm", [10_000.0, -10_000.0])
def test_a_clock_set_at_once_is_one_that_was_drawn(ppm: float) -> None:
    """Setting a clock's error by a fault at time zero gives the same card as drawing it."""
    cards = []
    for is_drawn in (True, False):
        wrong = replace(ideal(), logger_clock_ppm=ppm if is_drawn else 0.0)
        with EmulatedRobot(imperfections=wrong, seed=1, session_seed=1) as robot:
            if not is_drawn:
                # As soon as it runs: a clock error drawn at the start must give the same card.
                robot.faults.clock("logger", ppm)
            robot.advance(SETTLE_US)
            logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
            logger.start_recording()
            robot.advance(700_000)
            logger.stop_recording()
            cards.append(robot.card())
    assert cards[0] == cards[1]


@pytest.mark.parametrize("every", [4, pytest.param(1, marks=pytest.mark.prove)])
def test_a_supply_that_goes_at_any_moment_takes_no_block_that_was_synced_and_no_half_block(
    every: int,
) -> None:
    """Whatever the card was doing: the log ends within a quarter of a second of the cut, and all of it is whole."""
    # Over a sync interval, in steps that share no factor with it.
    for cut_us in range(1_000_000, 1_260_000, 20_111)[::every]:
        with releaser(seed=SEED) as (robot, _, logger):
            logger.start_recording()
            robot.advance(cut_us)
            at_us = robot.now_us
            robot.set_power(BoardIndex.LOGGER, False)
            robot.advance(100_000)
            log = read_card(robot)
        assert log.verdict == "truncated"
        # A quarter of a second to the last sync, and a block under way.
        assert 0 <= at_us - int(log.t_us[-1]) < 350_000
        assert np.diff(log.t_us).max() < 5_000
