"""One emulated robot that records while something breaks: the decoded log is what a user sees of it."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.emulated.build import sequencer_hex
from tfsat_host.emulated.imperfections import Imperfections, draw
from tfsat_host.emulated.robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.transport import EmulatedTransport
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.sdlog import DropLog, load

Act = Callable[[EmulatedRobot], None]
BROKEN_AT_US = 500_000
"""After the start of a recording."""
SEED = 3


@contextmanager
def bench(
    sequencer: str = "native", imperfections: Imperfections | None = None
) -> Iterator[tuple[EmulatedRobot, SequencerClient, LoggerClient]]:
    """A robot in the releaser and both boards' clients, settled."""
    hex_path = sequencer_hex() if sequencer == "avr" else None
    with EmulatedRobot(imperfections=imperfections or draw(SEED), seed=SEED, hex_path=hex_path) as robot:
        robot.advance(SETTLE_US)
        yield (
            robot,
            SequencerClient.connect(EmulatedTransport(robot, BoardIndex.SEQUENCER)),
            LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER)),
        )


def read_card(robot: EmulatedRobot) -> DropLog:
    """The newest recording, decoded."""
    with tempfile.TemporaryDirectory() as folder:
        card = Path(folder) / "SD.bin"
        card.write_bytes(robot.card())
        return load(card)


def record(
    *acts: Act, then_us: int = 1_000_000, imperfections: Imperfections | None = None
) -> tuple[DropLog, slice, slice]:
    """Half a second of recording, the acts at once, and the rest of it.

    Returns:
        The log, its rows before the acts and those after them (from 20 ms on).
    """
    with bench(imperfections=imperfections) as (robot, _, logger):
        logger.start_recording()
        robot.advance(BROKEN_AT_US)
        broken_us = robot.now_us
        for act in acts:
            act(robot)
        robot.advance(then_us)
        logger.stop_recording()
        log = read_card(robot)
    row = int(np.searchsorted(log.t_us, broken_us))
    after = int(np.searchsorted(log.t_us, broken_us + 20_000))
    return log, slice(0, row), slice(after, log.t_us.size)


def fly(robot: EmulatedRobot, board: SequencerClient, before_drop: Act, *, until_us: int = 2_450_000) -> None:
    """Uploads 59/70, arms, lets the act happen, drops, and stops in the fall."""
    board.upload(schedule_maneuver(four_stroke(59, 70)))
    board.arm()
    robot.advance(500_000)
    robot.record_truth(1000)
    before_drop(robot)
    robot.drop()
    robot.advance(until_us)


def nothing(robot: EmulatedRobot) -> None:
    """Does not break it: what a test must be red without."""
