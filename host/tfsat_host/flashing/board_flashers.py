"""New firmware for each board: when it may be interrupted, how its bootloader is woken, and its loader's command.

A port goes when a board is sent into its bootloader, another comes, and back.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from tfsat_host.devices.client import Client
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.flashing.flasher import (
    NOT_FLASHED,
    POLL_S,
    FlashedBoard,
    Flasher,
    Narrator,
    Target,
    in_bootloader,
    refusal,
)
from tfsat_host.flashing.image import Image, default_hex, load_image, load_teensy_image
from tfsat_host.flashing.loader import (
    AGAIN,
    AVRDUDE,
    TEENSY_LOADER,
    Computer,
    FlashError,
    run_avrdude,
    run_teensy_loader,
)
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol import messages as msg
from tfsat_host.protocol.enums import Board, LoggerState, SequencerState

BOOTLOADER_TIMEOUT_S = 8.0
"""The Micro's bootloader itself goes back to the sketch after 8 s."""
HINT_S = 4.0
PERMISSIONS_S = 0.3
"""A new port's permissions are set by udev a moment after it has appeared."""
TEENSY_REBOOT_BAUDRATE = 134
"""A Teensy whose USB serial port is set to this starts its bootloader (Teensyduino, teensy4/usb.c)."""


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
        device = self._proof(image, None if target.waits else target.port, others, cure)
        return FlashedBoard(device, command, at)


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
            raise refusal(
                "ram-holds-drop",
                f"The RAM of the logger at {port} holds a drop that no card has.",
                f"Flashing would erase it. {NOT_FLASHED}",
                Advice(
                    NextStep("log fetch", ("ram",)),
                    ", then ",
                    NextStep("log erase", ("ram",)),
                    ", then the same command again.",
                ),
            )
        if status.state in (LoggerState.RECORDING, LoggerState.STOPPING):
            raise refusal(
                "recording",
                f"The logger at {port} is {status.state.name.lower()}.",
                f"Flashing would cut the recording off. {NOT_FLASHED}",
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
        return FlashedBoard(self._proof(image, target.port, others, cure), command)


FLASHERS: dict[str, type[Flasher]] = {"sequencer": SequencerFlasher, "logger": LoggerFlasher}


def wake(computer: Computer, port: str, hint: Callable[[str], None]) -> str:
    """Sends the Arduino Micro at `port` into its bootloader; the bootloader's port.

    Raises:
        PortError: the port could not be opened.
        FlashError: no bootloader, or more than one, appeared in time.
    """
    not_flashed = f"{NOT_FLASHED[:-1]}; the board goes on with the sketch that it has."
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
        raise refusal(
            "not-safe",
            f"The sequencer at {port} is {state.name.lower()}; it is flashed only while it is safe.",
            f"Flashing would end that and let the servos go. {NOT_FLASHED}",
            Advice(NextStep("disarm"), ", then the same command again."),
        )
