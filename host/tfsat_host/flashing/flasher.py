"""New firmware for any board: what runs there and whether it may be taken away, and the proof that the new one runs."""

from __future__ import annotations

import shlex
from abc import ABC, abstractmethod
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from tfsat_host.devices.board_errors import NoAnswer, WrongBoard
from tfsat_host.devices.board_identity import BoardIdentity, Device
from tfsat_host.devices.client import Client
from tfsat_host.devices.serial_ports import (
    BoardName,
    Identity,
    PortError,
    PortInfo,
    PortProblem,
    find_port,
    identify,
)
from tfsat_host.errors import Interrupted, RefusedError
from tfsat_host.flashing.image import Image
from tfsat_host.flashing.loader import AGAIN, MISSING_PROGRAMS, Computer, FlashError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.enums import Board

POLL_S = 0.1
SKETCH_TIMEOUT_S = 15.0
"""The sketch's port is back in 2 s; Windows takes longer the first time."""

BOOTLOADER = "BOOTLOADER_PORT"
"""In a plan: the port's name is not known before the bootloader is awake."""
NOT_FLASHED = "Nothing was flashed."


class Narrator(Protocol):
    """Who follows how far it has got."""

    def step(self, text: str) -> None:
        """Something begins, or the user should do something."""

    def advance(self, bar: str, marks: int) -> None:
        """avrdude's bar of this name has got so many of its MARKS more."""


@dataclass(frozen=True, slots=True)
class Target:
    """The board that will be flashed.

    Attributes:
        port: Where it is; None where it has none, as a Teensy in its bootloader.
        waits: It is in its bootloader already, at that port.
        identity: What its sketch says of itself; None where it does not answer.
    """

    port: str | None
    waits: bool = False
    identity: BoardIdentity | None = None

    @property
    def device(self) -> Device | None:
        """Port and identity; None where the board's sketch does not answer."""
        return None if self.identity is None else Device(str(self.port), self.identity)


@dataclass(frozen=True, slots=True)
class FlashedBoard:
    """A board that runs the image.

    Attributes:
        device: Where it is now, and what HELLO says.
        command: The loader's command line.
        bootloader_port: Where its bootloader was; None: it has no port.
    """

    device: Device
    command: list[str]
    bootloader_port: str | None = None


class Flasher(ABC):
    """One board's way to new firmware, a step after the other: image, loader, `look`, `refuse_needless`, `write`."""

    name: BoardName
    board: Board
    program: str
    unknown: str
    sure: str
    ask: str
    unsafe: str
    after: str

    def __init__(self, computer: Computer) -> None:
        self._computer = computer

    @abstractmethod
    def load_image(self, path: Path | None) -> Image:
        """Reads the HEX; None: the one that this checkout has built. Raises ImageError."""

    @abstractmethod
    def command(self, loader: str, image: Image, port: str) -> list[str]:
        """Return the loader's command line."""

    @abstractmethod
    def _insist_on_idle(self, client: Client) -> None:
        """Raises RefusedError while the board does what must not be cut off."""

    @abstractmethod
    def _write(self, loader: str, image: Image, target: Target, narrator: Narrator) -> FlashedBoard:
        """Wakes the bootloader, has the loader write, and asks the board what it runs; see `write`."""

    def write(self, loader: str, image: Image, target: Target, narrator: Narrator) -> FlashedBoard:
        """Wakes the bootloader, has the loader write, and asks the board what it runs.

        Raises:
            FlashError: a step failed; says which and what to do.
            PortError: the port could not be opened.
            Interrupted: Ctrl-C.
        """
        try:
            return self._write(loader, image, target, narrator)
        except KeyboardInterrupt:
            raise Interrupted(
                what="Interrupted.",
                meaning="The board's image may be incomplete. Its bootloader is intact.",
                next_step=Advice(AGAIN[self.name], "; no drop with this board before that has succeeded."),
            ) from None

    def find_loader(self) -> str:
        """Return the path of the loader program. Raises FlashError with how to install it."""
        path = self._computer.find_program(self.program)
        if path is None:
            code, use, install = MISSING_PROGRAMS[self.program]
            raise FlashError(
                what=f"{self.program} is not installed, or not on the PATH.",
                meaning=f"Nothing was flashed: {use}. The board was not touched.",
                next_step=install,
                code=code,
            )
        return path

    def find_port(self, explicit: str | None, *, force: bool) -> str | None:
        """Return the board's port, or one at which its bootloader waits.

        What may be done there is decided by `refuse_needless`.

        Returns:
            None with `force` where there is none: a Teensy in its bootloader has no port.

        Raises:
            PortError: none, or several.
        """
        try:
            return find_port(self.name, explicit, list_ports=self._computer.ports)
        except PortError as error:
            waiting = sorted(in_bootloader(self._computer))
            # A board that waits in its bootloader can be written to as it is, if there is only one.
            if error.code == PortProblem.BOOTLOADER and len(waiting) == 1:
                return waiting[0]
            # A Teensy's bootloader is a HID device without a port: its loader finds it.
            if self.board == Board.LOGGER and force and explicit is None:
                return None
            raise

    def look(self, port: str | None) -> Target:
        """Asks who is at `port`.

        Raises:
            PortError: the port could not be opened.
            WrongBoard: it is the other board.
            RefusedError: it must not be interrupted; `code` says why.
        """
        if port is None or port in in_bootloader(self._computer):
            # A bootloader runs no sketch that could be asked.
            return Target(port, waits=port is not None)
        with closing(self._computer.connect(port)) as transport:
            client = Client(transport)
            try:
                identity = client.identify(self.board)
            except NoAnswer:
                # Silence is no error yet: a person, or --force, decides about a silent board.
                return Target(port)
            if identity.speaks_this_protocol:
                # Only HELLO and DISARM are frozen: a status in another protocol cannot be read.
                self._insist_on_idle(client)
        return Target(port, identity=identity)

    def refuse_needless(self, target: Target, image: Image, *, force: bool) -> None:
        """Raises RefusedError for an emulated core; unless `force`, where the image runs already or nothing answers."""
        identity = target.identity
        # Not even --force flashes an emulated core.
        if self.board == Board.SEQUENCER and identity is not None and identity.runs_natively:
            raise refusal(
                "emulated",
                f"The sequencer at {target.port} is the firmware's core on a computer: it has no flash.",
                NOT_FLASHED,
                Advice(
                    "Name a real board's port. To run the image itself: ",
                    NextStep("emulate", ("--sequencer", "avr")),
                ),
            )
        if force:
            return
        if identity is None:
            cure = f"If you are sure {self.sure}: add --force."
            raise refusal("silent", f"{self._silence(target)}: {self.unknown}.", NOT_FLASHED, cure)
        if identity.image_crc == image.crc:
            raise refusal(
                "already-running",
                f"The {self.name} at {target.port} runs this image already ({image.crc}).",
                "Nothing was flashed, and nothing needs to be.",
                "Add --force to flash it anyway.",
            )

    def question(self, target: Target) -> str:
        """Return the question that a person must answer for a silent board; empty if there is none."""
        return "" if target.identity else f"{self._silence(target)}; {self.unknown}. {self.ask}"

    def make_safe(self, target: Target) -> None:  # noqa: B027  the logger has nothing to make safe
        """Make the board safe after a yes to the question. Raises RefusedError unless it is safe then."""

    def plan(self, loader: str, image: Image, target: Target) -> list[str]:
        """Return the planned steps, one line each."""
        runs = target.identity.describe() if target.identity else "a board that does not answer"
        steps = [f"At {target.port}: {runs}.", f"Image {image.crc}, {len(image.data)} bytes: {image.path}"]
        steps.append("Would be done:")
        if question := self.question(target):
            steps.append(f"  ask: {question}")
        if target.port is not None and not target.waits:
            steps.append(f"  open {target.port} to wake the bootloader, and wait for that")
        command = shlex.join(self.command(loader, image, str(target.port) if target.waits else BOOTLOADER))
        return [*steps, f"  {command}", f"  ask the board for its image: {image.crc}"]

    def _silence(self, target: Target) -> str:
        if target.port is None:
            return f"There is no {self.name}'s port"
        return (
            f"The board at {target.port} {'waits in its bootloader' if target.waits else 'does not answer'}"
        )

    def sketches(self) -> set[str]:
        """Return the ports that look like this board running its sketch."""
        ports = self._computer.ports()
        return {port.device for port in ports if identify(port) == Identity(self.name, "sketch")}

    def ask_again(self, before: str | None, others: set[str]) -> Device:
        """Waits for the flashed sketch and asks who it is: its port, and what HELLO says.

        Args:
            before: The sketch's port before, if it was known; the board may come back at another. It need not be
                listed (a link, a clone's ids).
            others: Ports of other such boards: those that were there while the board was in its bootloader.

        Raises:
            FlashError: no port came back, or no board answered there.
        """
        deadline_s = self._computer.now_s() + SKETCH_TIMEOUT_S
        reason = f"No port that looks like the {self.name} came back."
        # A new port needs a moment until it can be opened: try on until the deadline.
        while self._computer.now_s() < deadline_s:
            # The port's old name first, unless a bootloader has it now, then ports that are new.
            fresh = sorted(self.sketches() - others - {before})
            for port in (
                fresh if before is None or before in in_bootloader(self._computer) else [before, *fresh]
            ):
                try:
                    with closing(self._computer.connect(port)) as transport:
                        return Device(port, Client(transport).identify(self.board))
                except (PortError, NoAnswer, WrongBoard) as error:
                    reason = error.what
            self._computer.sleep(POLL_S)
        raise FlashError(
            what=f"The image was written, but the board did not say who it is. {reason}",
            meaning=f"It may not be a tfsat image, or it crashes at its start. Do not {self.after} this board yet.",
            next_step=Advice("Unplug the board and plug it in again, then: ", NextStep("status")),
            code="silent",
        )

    def _proof(self, image: Image, before: str | None, others: set[str], cure: str) -> Device:
        """Check that the board reports the written image; return its port and identity. Raises FlashError."""
        device = self.ask_again(before, others)
        # The board computes the CRC over its own flash: this shows what runs, not what was sent.
        runs_crc = device.identity.image_crc
        if runs_crc != image.crc:
            raise FlashError(
                what=f"The {self.name} at {device.port} runs image {runs_crc}; {image.crc} was written.",
                meaning=f"It does not run what was asked for. {self.unsafe}",
                next_step=cure,
                code="other-image",
            )
        return device


def in_bootloader(computer: Computer) -> dict[str, PortInfo]:
    """Find the ports at which a sequencer's bootloader waits, by name."""
    waits = Identity("sequencer", "bootloader")
    return {port.device: port for port in computer.ports() if identify(port) == waits}


def refusal(code: str, what: str, meaning: str, next_step: str) -> RefusedError:
    """Build the error of a board that is not flashed; `code` says why."""
    return RefusedError(what=what, meaning=meaning, next_step=next_step, code=code)
