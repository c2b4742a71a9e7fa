"""One emulated robot that records while something breaks: the decoded log is what a user sees of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.fixtures.emulated_drop import OF_THE_PAPER, Act, read_card, releaser
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.emulated.emulated_robot import EmulatedRobot
from tfsat_host.emulated.imperfections import Imperfections, draw
from tfsat_host.maneuver import Schedule
from tfsat_host.sdlog import DropLog
from tfsat_host.servo_settings import FACTORY

BROKEN_AT_US = 500_000
"""After the start of a recording."""
SEED = 3


def record(
    *acts: Act, then_us: int = 1_000_000, imperfections: Imperfections | None = None
) -> tuple[DropLog, slice, slice]:
    """Record half a second, do the acts at once, and record the rest.

    Returns:
        The log, its rows before the acts and those after them (from 20 ms on).
    """
    with releaser(imperfections=imperfections or draw(SEED), seed=SEED) as (robot, _, logger):
        logger.start_recording()
        # Half a second before the act, so that both states are in one log.
        robot.advance(BROKEN_AT_US)
        broken_us = robot.now_us
        for act in acts:
            act(robot)
        robot.advance(then_us)
        logger.stop_recording()
        log = read_card(robot)
    # Within 20 ms of the act the low-pass filters show a mixture of before and after: leave it out.
    row = int(np.searchsorted(log.t_us, broken_us))
    after = int(np.searchsorted(log.t_us, broken_us + 20_000))
    return log, slice(0, row), slice(after, log.t_us.size)


def fly(
    robot: EmulatedRobot,
    board: SequencerClient,
    before_drop: Act,
    *,
    until_us: int = 2_450_000,
    schedule: Schedule = OF_THE_PAPER,
) -> None:
    """Upload the schedule, arm, let the act happen, drop, and stop in the fall."""
    if schedule.moving_at_once > FACTORY.moving_at_once:
        board.write_settings(replace(FACTORY, moving_at_once=schedule.moving_at_once))
    board.upload(schedule)
    board.arm()
    # Half a second of resting on the crane.
    robot.advance(500_000)
    robot.record_truth(1000)
    before_drop(robot)
    robot.drop()
    robot.advance(until_us)


def do_nothing(robot: EmulatedRobot) -> None:
    """Break nothing: what a test must be red without."""
