"""From `--port` or `--emulated` to a board that has said who it is."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from tfsat_host.devices.discovery import find_port

if TYPE_CHECKING:
    from tfsat_host.cli.output import Output
    from tfsat_host.devices.logger import LoggerClient
    from tfsat_host.devices.sequencer import SequencerClient
    from tfsat_host.emulated.robot import EmulatedRobot


@contextmanager
def open_sequencer(args: argparse.Namespace, out: Output) -> Iterator[SequencerClient]:
    """The sequencer that the options name. Raises PortError, NoAnswer, WrongBoard, BuildError."""
    from tfsat_host.devices.sequencer import SequencerClient

    if args.emulated:
        from tfsat_host.emulated.robot import BoardIndex
        from tfsat_host.emulated.transport import EmulatedTransport

        with emulated_robot(out) as robot:
            yield SequencerClient.connect(EmulatedTransport(robot, BoardIndex.SEQUENCER))
        return
    from tfsat_host.devices.transport import SerialTransport

    transport = SerialTransport(find_port("sequencer", args.port))
    try:
        yield SequencerClient.connect(transport)
    finally:
        transport.close()


@contextmanager
def open_logger(args: argparse.Namespace) -> Iterator[LoggerClient]:
    """The logger at the port that the options name. Raises PortError, NoAnswer, WrongBoard."""
    from tfsat_host.devices.logger import LoggerClient
    from tfsat_host.devices.transport import SerialTransport

    transport = SerialTransport(find_port("logger", args.port))
    try:
        yield LoggerClient.connect(transport)
    finally:
        transport.close()


@contextmanager
def emulated_robot(out: Output) -> Iterator[EmulatedRobot]:
    """The robot of `--emulated`: its EEPROM is kept from one command to the next. Raises BuildError."""
    from tfsat_host.emulated.build import ensure_built
    from tfsat_host.emulated.robot import SETTLE_US, EmulatedRobot
    from tfsat_host.emulated.state import eeprom_path, load_eeprom, save_eeprom

    ensure_built(progress=out.note)
    path = eeprom_path()
    before = load_eeprom(path)
    with EmulatedRobot(eeprom=before) as robot:
        robot.advance(SETTLE_US)
        yield robot
        after = robot.eeprom()
        if after != before:
            save_eeprom(path, after)
