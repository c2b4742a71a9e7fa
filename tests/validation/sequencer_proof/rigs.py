"""The board under test, native or the flashed image, as campaigns see it: in cycles of its clock."""

from __future__ import annotations

import ctypes
import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Protocol, Self

from tests.arduino_sequencer import board as native
from tests.arduino_sequencer.avr.avr_board import AvrBoard, load_library
from tests.arduino_sequencer.avr.board_link import BoardTransport, eeprom_after_upload
from tests.validation.campaign import Broken
from tests.validation.sequencer_proof.signals import CYCLES_PER_US, PinEdge
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.protocol.enums import SequencerState

POWER_UP_US = 200_000
SETTLE_US = 12_000
"""Longer than the debounce."""
RAM_START = 0x0100
PAINT = 0xC5
"""What free RAM is filled with at start-up (drivers/ram_paint.cpp)."""


class Rig(Protocol):
    """A powered board with both switches closed, and a host."""

    resolution: int
    """Cycles; inputs can change at multiples of it."""

    @property
    def now(self) -> int: ...
    def run_to(self, cycle: int) -> None: ...
    def set_switch(self, index: int, *, closed: bool) -> None: ...
    def edges(self) -> list[PinEdge]: ...
    def connect(self) -> SequencerClient: ...


def run_us(rig: Rig, duration_us: int) -> None:
    """Lets time pass, up to a whole microsecond."""
    rig.run_to((rig.now // CYCLES_PER_US + duration_us) * CYCLES_PER_US)


def seat(rig: Rig) -> None:
    """Hangs the robot on the crane: both switches closed, for longer than they bounce."""
    for index in (0, 1):
        rig.set_switch(index, closed=True)
    run_us(rig, SETTLE_US)


def arm(rig: Rig, client: SequencerClient) -> None:
    """From whatever there was: safe, seated, armed. Forgets the pins' past."""
    client.disarm()
    seat(rig)
    rig.edges()
    if client.arm() != SequencerState.ARMED:
        raise Broken("the board did not arm")


class AvrRig:
    """The image in libsimavr."""

    resolution = 1

    def __init__(self, library: ctypes.CDLL, image: Path, eeprom: bytes | None = None) -> None:
        self.board = AvrBoard(library, image)
        if eeprom is not None:
            self.board.set_eeprom(eeprom)
        for index in (0, 1):
            self.board.switch(index, closed=True)
        self._cycle = 0
        self.power_up()

    @property
    def now(self) -> int:
        return max(self._cycle, self.board.now_us * CYCLES_PER_US)

    def power_up(self) -> None:
        self.board.power(True)
        run_us(self, POWER_UP_US)

    def run_to(self, cycle: int) -> None:
        if cycle < self.now:
            raise ValueError(f"cycle {cycle} is past")
        self.board.run_to_cycle(cycle)
        self._cycle = cycle

    def set_switch(self, index: int, *, closed: bool) -> None:
        self.board.switch(index, closed=closed)

    def edges(self) -> list[PinEdge]:
        # Nanoseconds were cut to whole ones; a cycle is 62.5 of them.
        return [
            PinEdge(-(-edge.t_ns * CYCLES_PER_US // 1000), edge.pin, edge.high) for edge in self.board.edges()
        ]

    def connect(self) -> SequencerClient:
        self.board.connect()
        return SequencerClient.connect(BoardTransport(self.board))

    def close(self) -> None:
        self.board.close()


class NativeRig:
    """The core, compiled for this computer. Its loop runs every 50 us, its edges are exact to the tick."""

    resolution = CYCLES_PER_US

    def __init__(self, library: ctypes.CDLL) -> None:
        self.board = native.Board(library)

    @property
    def now(self) -> int:
        return self.board.now_us * CYCLES_PER_US

    def run_to(self, cycle: int) -> None:
        self.board.advance_to(cycle // CYCLES_PER_US)

    def set_switch(self, index: int, *, closed: bool) -> None:
        self.board.switch(index, opened=not closed)

    def edges(self) -> list[PinEdge]:
        return [PinEdge(t_ns * CYCLES_PER_US // 1000, pin, high) for t_ns, pin, high in self.board.edges()]

    def connect(self) -> SequencerClient:
        return native.connect(self.board)


def stack_never_used(rig: AvrRig, client: SequencerClient, bench: Bench) -> int:
    """Bytes of stack that nothing has touched since the board started; its own word, and a debugger's.

    Raises Broken where the two differ.
    """
    told = client.status().ram_never_used_bytes
    address = RAM_START + _static_ram_bytes(bench.image)
    first = address
    while rig.board.peek(address) == PAINT:
        address += 1
    if address - first != told:
        raise Broken(f"STATUS tells of {told} bytes never used, the RAM shows {address - first}")
    return told


@cache
def _static_ram_bytes(image: Path) -> int:
    """From the build's report next to the image."""
    return int(image_report(image)["ram_bytes"])


def image_report(image: Path) -> dict[str, str | int | float]:
    """What the build says of its image."""
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
    """After an upload of 59/70."""

    @classmethod
    def of(cls, image: Path, library: Path) -> Self:
        return cls(image, library, eeprom_after_upload(_avr_library(library), image))

    def rig(self) -> AvrRig:
        """A board that 59/70 was uploaded to."""
        return AvrRig(_avr_library(self.library), self.image, self.eeprom)

    def new_rig(self) -> AvrRig:
        """A board that nothing was uploaded to: its EEPROM is erased."""
        return AvrRig(_avr_library(self.library), self.image)


def native_rig(library: Path) -> NativeRig:
    """The core in a library that tests.arduino_sequencer.board built."""
    return NativeRig(native_library(library))


@cache
def _avr_library(path: Path) -> ctypes.CDLL:
    return load_library(path)


@cache
def native_library(path: Path) -> ctypes.CDLL:
    return native.load_board(path)
