"""New firmware for a board: what runs there and whether it may be taken away, the writing, and the proof that it runs.

A port goes when a board is sent into its bootloader, another comes, and back.
"""

from __future__ import annotations

import shlex
from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from tfsat_host.devices.client import BoardIdentity, Client, NoAnswer, WrongBoard
from tfsat_host.devices.sequencer import SequencerClient
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
from tfsat_host.flashing.image import Image, default_hex, load_image, load_teensy_image
from tfsat_host.flashing.loader import (
    AGAIN,
    AVRDUDE,
    MISSING_PROGRAMS,
    TEENSY_LOADER,
    Computer,
    FlashError,
    run_avrdude,
    run_teensy_loader,
)
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol import messages as msg
from tfsat_host.protocol.enums import Board, LoggerState, SequencerState

POLL_S = 0.1
BOOTLOADER_TIMEOUT_S = 8.0
"""The Micro's bootloader itself goes back to the sketch after 8 s."""
HINT_S = 4.0
PERMISSIONS_S = 0.3
"""A new port's permissions are set by udev a moment after it has appeared."""
SKETCH_TIMEOUT_S = 15.0
"""The sketch's port is back in 2 s; Windows takes longer the first time."""
TEENSY_REBOOT_BAUDRATE = 134
"""A Teensy whose USB serial port is set to this starts its bootloader (Teensyduino, teensy4/usb.c)."""

BOOTLOADER = "BOOTLOADER_PORT"
"""In a plan: the port's name is not known before the bootloader is awake."""
_NOT_FLASHED = "Nothing was flashed."


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


@dataclass(frozen=True, slots=True)
class FlashedBoard:
    """A board that runs the image.

    Attributes:
        port: Where it is now.
        command: The loader's command line.
        identity: What HELLO says.
        details: What else is known, for `--json`.
    """

    port: str
    command: list[str]
    identity: BoardIdentity
    details: dict[str, str] = field(default_factory=dict)


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
            raise _refusal(
                "emulated",
                f"The sequencer at {target.port} is the firmware's core on a computer: it has no flash.",
                _NOT_FLASHED,
                Advice(
                    "Name a real board's port. To run the image itself: ",
                    NextStep("emulate", ("--sequencer", "avr")),
                ),
            )
        if force:
            return
        if identity is None:
            cure = f"If you are sure {self.sure}: add --force."
            raise _refusal("silent", f"{self._silence(target)}: {self.unknown}.", _NOT_FLASHED, cure)
        if identity.image_crc == image.crc:
            raise _refusal(
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

    def ask_again(self, before: str | None, others: set[str]) -> tuple[str, BoardIdentity]:
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
                        return port, Client(transport).identify(self.board)
                except (PortError, NoAnswer, WrongBoard) as error:
                    reason = error.what
            self._computer.sleep(POLL_S)
        raise FlashError(
            what=f"The image was written, but the board did not say who it is. {reason}",
            meaning=f"It may not be a tfsat image, or it crashes at its start. Do not {self.after} this board yet.",
            next_step=Advice("Unplug the board and plug it in again, then: ", NextStep("status")),
            code="silent",
        )

    def _proof(
        self, image: Image, before: str | None, others: set[str], cure: str
    ) -> tuple[str, BoardIdentity]:
        """Check that the board reports the written image; return its port and identity. Raises FlashError."""
        port, identity = self.ask_again(before, others)
        # The board computes the CRC over its own flash: this shows what runs, not what was sent.
        if identity.image_crc != image.crc:
            raise FlashError(
                what=f"The {self.name} at {port} runs image {identity.image_crc}; {image.crc} was written.",
                meaning=f"It does not run what was asked for. {self.unsafe}",
                next_step=cure,
                code="other-image",
            )
        return port, identity


class SequencerFlasher(Flasher):
    """The Arduino Micro, through its bootloader with avrdude, which verifies."""

    name, board, program = "sequencer", Board.SEQUENCER, AVRDUDE
    unknown, sure = "its state is not known", "that it is the sequencer and that nothing is armed"
    ask = "Is it the sequencer's Arduino Micro, and may it be flashed?"
    unsafe, after = "Do not fly it.", "fly"

    def load_image(self, path: Path | None) -> Image:
        return load_image(path or default_hex())

    def command(self, loader: str, image: Image, port: str) -> list[str]:
        # Write the image and read it back, as the Arduino IDE does (boards.txt, micro: avr109 at 57600).
        options = ["-p", "atmega32u4", "-c", "avr109", "-P", port, "-b", "57600", "-D"]
        return [loader, *options, "-U", f"flash:w:{image.path}:i"]

    def _insist_on_idle(self, client: Client) -> None:
        state = client.request(msg.SequencerStatusRequest(), msg.SequencerStatusReply).state
        _insist_on_safe(client.transport.name, state)

    def question(self, target: Target) -> str:
        if target.identity is None or target.identity.speaks_this_protocol:
            return super().question(target)
        return (
            f"The sequencer at {target.port} speaks another protocol, so its state cannot be read. "
            "Disarm it and flash?"
        )

    def make_safe(self, target: Target) -> None:
        """Disarms a board of another protocol, whose state cannot be read. Raises RefusedError unless it is safe."""
        if target.port is None or target.identity is None or target.identity.speaks_this_protocol:
            return
        # DISARM is frozen in every revision, so even a board of another protocol is made safe.
        with closing(self._computer.connect(target.port)) as transport:
            state = SequencerClient.connect_any_protocol(transport).disarm()
        _insist_on_safe(target.port, state)

    def _write(self, loader: str, image: Image, target: Target, narrator: Narrator) -> FlashedBoard:
        at = str(target.port)
        if not target.waits:
            narrator.step(f"Waking the bootloader of the board at {at}")
            at = wake(self._computer, at, narrator.step)
        # Such boards that are there while this one is in its bootloader are other ones.
        others = self.sketches()
        narrator.step(f"Writing {len(image.data)} bytes to the bootloader at {at}")
        command = self.command(loader, image, at)
        run_avrdude(self._computer, command, narrator.advance)
        narrator.step("Waiting for the new sketch")
        cure = Advice(AGAIN["sequencer"], "; if it recurs, replace the Arduino Micro.")
        port, identity = self._proof(image, None if target.waits else target.port, others, cure)
        return FlashedBoard(port, command, identity, {"bootloader_port": at})


class LoggerFlasher(Flasher):
    """The Teensy 4.1, with PJRC's teensy_loader_cli."""

    name, board, program = "logger", Board.LOGGER, TEENSY_LOADER
    unknown = "what its RAM holds is not known"
    sure = "that this is the logger and that nothing in it is needed"
    ask = "Flash the Teensy that is plugged in?"
    unsafe, after = "Another Teensy was flashed, or the writing failed.", "record a drop with"

    def load_image(self, path: Path | None) -> Image:
        assert path is not None, "make firmware's image is none for the Teensy"
        return load_teensy_image(path)

    def command(self, loader: str, image: Image, port: str) -> list[str]:  # noqa: ARG002  the loader finds the board
        # Wait for a Teensy 4.1 in its bootloader, write the image, and start it.
        return [loader, "--mcu=TEENSY41", "-w", "-v", str(image.path)]

    def _insist_on_idle(self, client: Client) -> None:
        status, port = client.request(msg.LoggerStatusRequest(), msg.LoggerStatusReply), client.transport.name
        if status.ram_holds_drop:
            raise _refusal(
                "ram-holds-drop",
                f"The RAM of the logger at {port} holds a drop that no card has.",
                f"Flashing would erase it. {_NOT_FLASHED}",
                Advice(
                    NextStep("log fetch", ("ram",)),
                    ", then ",
                    NextStep("log erase", ("ram",)),
                    ", then the same command again.",
                ),
            )
        if status.state in (LoggerState.RECORDING, LoggerState.STOPPING):
            raise _refusal(
                "recording",
                f"The logger at {port} is {status.state.name.lower()}.",
                f"Flashing would cut the recording off. {_NOT_FLASHED}",
                Advice(NextStep("record stop"), ", then the same command again."),
            )

    def _write(self, loader: str, image: Image, target: Target, narrator: Narrator) -> FlashedBoard:
        others = self.sketches() - {target.port}
        if target.port is not None:
            narrator.step(f"Waking the bootloader of the Teensy at {target.port}")
            self._computer.touch(target.port, TEENSY_REBOOT_BAUDRATE)
        narrator.step(f"Writing {len(image.data)} bytes; if nothing happens, press the button on the Teensy")
        command = self.command(loader, image, "")
        run_teensy_loader(self._computer, command)
        narrator.step("Waiting for the new sketch")
        cure = Advice("Unplug every other Teensy, then: ", AGAIN["logger"])
        port, identity = self._proof(image, target.port, others, cure)
        return FlashedBoard(port, command, identity)


FLASHERS: dict[str, type[Flasher]] = {"sequencer": SequencerFlasher, "logger": LoggerFlasher}


def in_bootloader(computer: Computer) -> dict[str, PortInfo]:
    """Find the ports at which a sequencer's bootloader waits, by name."""
    waits = Identity("sequencer", "bootloader")
    return {port.device: port for port in computer.ports() if identify(port) == waits}


def wake(computer: Computer, port: str, hint: Callable[[str], None]) -> str:
    """Sends the Arduino Micro at `port` into its bootloader; the bootloader's port.

    Raises:
        PortError: the port could not be opened.
        FlashError: no bootloader, or more than one, appeared in time.
    """
    not_flashed = f"{_NOT_FLASHED[:-1]}; the board goes on with the sketch that it has."
    # Bootloaders that wait already are other boards': only a new one can be this board's.
    others = in_bootloader(computer)
    computer.touch(port)
    deadline_s = computer.now_s() + BOOTLOADER_TIMEOUT_S
    hint_s = computer.now_s() + HINT_S
    while True:
        new_ports = sorted(in_bootloader(computer).keys() - others.keys())
        # Never guess between boards: the image might go onto the wrong one.
        if len(new_ports) > 1:
            raise FlashError(
                what=f"{len(new_ports)} bootloaders appeared at once: {', '.join(new_ports)}.",
                meaning=f"One of them is another board's. {not_flashed}",
                next_step="Unplug the other boards, wait 10 s, then the same command again.",
                code="ambiguous",
            )
        if new_ports:
            computer.sleep(PERMISSIONS_S)
            return new_ports[0]
        if computer.now_s() > deadline_s:
            raise FlashError(
                what=f"No bootloader appeared within {BOOTLOADER_TIMEOUT_S:g} s after the 1200-baud touch of {port}.",
                meaning=not_flashed,
                next_step=Advice(
                    "Press the board's reset button twice; its LED pulses for 8 s. Within that time type:\n",
                    AGAIN["sequencer"],
                ),
                code="bootloader-not-seen",
            )
        if computer.now_s() > hint_s:
            hint("The bootloader has not shown up yet: press the board's reset button twice.")
            # Not again: the next time lies beyond the deadline.
            hint_s = deadline_s + POLL_S
        computer.sleep(POLL_S)


def _insist_on_safe(port: str, state: SequencerState) -> None:
    if state != SequencerState.SAFE:
        raise _refusal(
            "not-safe",
            f"The sequencer at {port} is {state.name.lower()}; it is flashed only while it is safe.",
            f"Flashing would end that and let the servos go. {_NOT_FLASHED}",
            Advice(NextStep("disarm"), ", then the same command again."),
        )


def _refusal(code: str, what: str, meaning: str, next_step: str) -> RefusedError:
    return RefusedError(what=what, meaning=meaning, next_step=next_step, code=code)
