"""Which robot a recording is of, by the logger's own words in it: drops of different robots are never combined."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.cli.calibration_notice import origin_of_log
from tfsat_host.cli.evaluate.run_files import run_files
from tfsat_host.errors import TfsatError, UsageError

if TYPE_CHECKING:
    from tfsat_host.sdlog import DropLog


@dataclass(frozen=True, slots=True)
class DroppedRobot:
    """A robot, as far as a recording tells it from others.

    Attributes:
        kind: Whether it fell, or was emulated: one of `campaign.entries.ROBOTS`.
        logger_serial: Of the board that the sensors hang on, hexadecimal; empty: it gave none.
    """

    kind: str
    logger_serial: str

    def __str__(self) -> str:
        logger = f"logger {self.logger_serial}" if self.logger_serial else "a logger without a serial number"
        return f"{self.kind} robot with {logger}"


def dropped_robot(log: DropLog) -> DroppedRobot:
    """The robot that recorded it."""
    from tfsat_host.campaign.entries import EMULATED, REAL

    origin = origin_of_log(log.header)
    return DroppedRobot(EMULATED if origin.emulated else REAL, origin.logger_serial)


def require_one_robot(places: Sequence[Path]) -> None:
    """Refuses drops of different robots, before anything is evaluated.

    Args:
        places: RUN, as typed; one that cannot be read is refused for that reason when its turn comes.

    Raises:
        UsageError: two of them were recorded by different loggers, or one by an emulated one.
    """
    from tfsat_host.sdlog.load import load

    first: dict[DroppedRobot, Path] = {}
    for place in places:
        try:
            robot = dropped_robot(load(run_files(place, None).recording))
        except (TfsatError, OSError):
            continue
        first.setdefault(robot, place)
    if len(first) > 1:
        named = "; ".join(f"{place}: {robot}" for robot, place in first.items())
        raise UsageError(
            what=f"These drops are not of one robot. {named}.",
            meaning="What one robot's drops say of its model says nothing of another's. Nothing was evaluated.",
            next_step="Evaluate each robot's drops by themselves; tfsat-host campaign report keeps them apart.",
        )
