"""The flashed image on the desk, as campaigns need it: powered, seated, armed; its pins in cycles; its stack."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Self

from tests.fixtures.sequencer.board import CYCLES_PER_US, AvrBoard, Board, load_library
from tests.fixtures.sequencer.cable import eeprom_after_upload
from tests.validation.campaign import Broken
from tests.validation.sequencer_proof.signals import PinEdge
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.maneuver import Schedule
from tfsat_host.protocol.enums import SequencerState

POWER_UP_US = 200_000
SETTLE_US = 12_000
"""Longer than the debounce."""
RAM_START = 0x0100
PAINT = 0xC5
"""What free RAM is filled with at start-up (drivers/ram_paint.cpp)."""


def power_up(board: Board) -> None:
    """Switch it on and wait until it runs."""
    board.power(True)
    board.run(POWER_UP_US)


def seat(board: Board) -> None:
    """Hang the robot on the crane: both switches closed, for longer than they bounce."""
    for index in (0, 1):
        board.switch(index, closed=True)
    board.run(SETTLE_US)


def arm(board: Board, client: SequencerClient) -> None:
    """Bring the board from any state to armed: make it safe, seat it and arm it.

    Pin edges recorded before are discarded.
    """
    # From any state, a run included, to safe.
    client.disarm()
    seat(board)
    board.edges()
    if client.arm() != SequencerState.ARMED:
        raise Broken("the board did not arm")


def pin_edges(board: Board) -> list[PinEdge]:
    """Take the output edges since the last call, in cycles: nanoseconds were cut to whole ones, a cycle is 62.5."""
    # Edges are in nanoseconds of 62.5 ns cycles: rounded up to whole cycles.
    return [PinEdge(-(-edge.t_ns * CYCLES_PER_US // 1000), edge.pin, edge.high) for edge in board.edges()]


def stack_never_used(board: AvrBoard, client: SequencerClient, bench: Bench) -> int:
    """Bytes of stack that nothing has touched since the board started; its own word, and a debugger's.

    Raises Broken where the two differ.
    """
    reported_bytes = client.status().ram_never_used_bytes
    # Free RAM lies between the static variables and the stack: painted at start-up.
    address = RAM_START + _static_ram_bytes(bench.image)
    first = address
    while board.peek(address) == PAINT:
        address += 1
    if address - first != reported_bytes:
        raise Broken(f"STATUS tells of {reported_bytes} bytes never used, the RAM shows {address - first}")
    return reported_bytes


@cache
def _static_ram_bytes(image: Path) -> int:
    """Read the bytes of static RAM from the build's report next to the image."""
    return int(image_report(image)["ram_bytes"])


def image_report(image: Path) -> dict[str, str | int | float]:
    """Read the build's report on its image."""
    report: dict[str, str | int | float] = json.loads(image.with_suffix(".json").read_text())
    return report


@dataclass(frozen=True, slots=True)
class Bench:
    """What emulated boards are made of; paths, so that it can go to another process."""

    image: Path
    """The HEX, with the build's .json next to it."""
    library: Path
    """For `AvrBoard`."""
    eeprom: bytes
    """After an upload of what is flown, 59/70 if nothing else is said."""

    @classmethod
    def of(cls, image: Path, library: Path) -> Self:
        return cls(image, library, eeprom_after_upload(load_library(library), image))

    def flying(self, schedule: Schedule) -> Self:
        """Return the bench with boards to which this was uploaded."""
        return replace(self, eeprom=eeprom_after_upload(load_library(self.library), self.image, schedule))

    def board(self) -> AvrBoard:
        """Return a powered board, with the upload, both switches closed, no cable."""
        return self._power_board(self.eeprom)

    def new_board(self) -> AvrBoard:
        """Return a powered board with an erased EEPROM: nothing was uploaded to it."""
        return self._power_board(None)

    def _power_board(self, eeprom: bytes | None) -> AvrBoard:
        board = AvrBoard(load_library(self.library), self.image)
        if eeprom is not None:
            board.set_eeprom(eeprom)
        # Closed switches before the power: the board starts as if it hung on the crane.
        for index in (0, 1):
            board.switch(index, closed=True)
        power_up(board)
        return board
