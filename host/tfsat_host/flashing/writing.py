"""From a board that may be flashed to one that says that it runs the image."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from tfsat_host.devices.identity import BoardIdentity
from tfsat_host.flashing.avrdude import FlashError, command_line, run_avrdude
from tfsat_host.flashing.bootloader import ask_again, sketches, wake
from tfsat_host.flashing.image import Image
from tfsat_host.flashing.ports import Computer
from tfsat_host.flashing.running import Target


class Narrator(Protocol):
    """Who is told how far it has got."""

    def step(self, text: str) -> None:
        """Something begins, or the user should do something."""

    def advance(self, bar: str, marks: int) -> None:
        """avrdude's bar of this name has got so many of its MARKS more."""


@dataclass(frozen=True, slots=True)
class Flashed:
    """A board that runs the image.

    Attributes:
        port: Where it is now.
        bootloader_port: Where it was written.
        command: avrdude's command line.
        identity: What HELLO says.
    """

    port: str
    bootloader_port: str
    command: list[str]
    identity: BoardIdentity


def write(computer: Computer, avrdude: str, image: Image, target: Target, narrator: Narrator) -> Flashed:
    """Wakes the bootloader, has avrdude write and verify, and asks the board what it runs.

    Raises:
        FlashError: a step failed; says which and what to do.
        PortError: the port could not be opened.
    """
    bootloader_port = target.port
    if not target.waits:
        narrator.step(f"waking the bootloader of the board at {target.port}")
        bootloader_port = wake(computer, target.port, narrator.step)
    others = sketches(computer)
    narrator.step(f"writing {len(image.data)} bytes to the bootloader at {bootloader_port}")
    command = command_line(avrdude, bootloader_port, image.path)
    run_avrdude(computer, command, narrator.advance)
    narrator.step("waiting for the new sketch")
    port, identity = ask_again(computer, None if target.waits else target.port, others)
    if identity.image_crc != image.crc:
        raise FlashError(
            "other-image",
            what=f"The sequencer at {port} runs image {identity.image_crc}; {image.crc} was written.",
            meaning="It does not run what was asked for. Do not fly it.",
            next_step="tfsat-host flash sequencer --force; if it recurs, replace the Arduino Micro.",
        )
    return Flashed(port, bootloader_port, command, identity)
