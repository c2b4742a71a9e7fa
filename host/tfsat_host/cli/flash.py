"""`tfsat-host flash`: new firmware for a board, and the proof that it runs; here for the Arduino Micro."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.cli import flash_logger
from tfsat_host.cli.advice import Interrupted, device_option
from tfsat_host.cli.options import add_device_options, file_name
from tfsat_host.cli.subcommands import add_subcommands
from tfsat_host.errors import RefusedError, TfsatError
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.flashing.image import Image
    from tfsat_host.flashing.ports import Computer
    from tfsat_host.flashing.running import Target
    from tfsat_host.flashing.writing import Flashed

_BOARDS = {
    "sequencer": "flash the Arduino Micro through its bootloader with avrdude, and ask it what it runs afterwards",
    "logger": "flash the Teensy 4.1 with teensy_loader_cli, and ask it what it runs afterwards",
}
_NOT_FLASHED = "Nothing was flashed."
_THIS_COMMAND = re.compile(r"tfsat-host (?:flash sequencer|status|disarm)")


def configure(parser: argparse.ArgumentParser) -> None:
    """One subcommand a board."""
    boards = add_subcommands(parser, _BOARDS, title="boards", dest="board")
    flash_logger.configure(boards["logger"])
    sequencer = boards["sequencer"]
    sequencer.description = (
        f"{sequencer.description} Refuses while the board is not safe, and where it runs the image already."
    )
    sequencer.add_argument(
        "--hex",
        metavar="FILE",
        type=file_name,
        help="image to flash (default: build/sequencer/arduino_sequencer.hex of this checkout, by make firmware)",
    )
    sequencer.add_argument("--dry-run", action="store_true", help="check everything, say what would be done")
    sequencer.add_argument(
        "--force",
        action="store_true",
        help="flash although the image runs already, or although the board does not answer",
    )
    add_device_options(sequencer, "sequencer")


def run(args: argparse.Namespace, out: Output) -> int:
    """Checks image, program and board, then writes."""
    from tfsat_host.flashing.avrdude import find_avrdude
    from tfsat_host.flashing.image import default_hex, load_image
    from tfsat_host.flashing.running import look, refuse_needless
    from tfsat_host.flashing.system import ThisComputer

    _refuse_emulated(args)
    if args.board == "logger":
        return flash_logger.run(args, out)
    computer = ThisComputer()
    with _typed_as_given(args):
        image = load_image(args.hex or default_hex())
        avrdude = find_avrdude(computer)
        target = look(computer, _find_port(args, computer))
        refuse_needless(target, image, force=args.force)
        if args.dry_run:
            _show_plan(avrdude, image, target, out)
            return 0
        _ask(computer, target, out)
        flashed = _write(computer, avrdude, image, target, out)
    _show(image, target, flashed, out)
    return 0


def _refuse_emulated(args: argparse.Namespace) -> None:
    if args.emulated:
        raise RefusedError(
            what=f"flash --emulated is refused: the emulated {args.board} has no bootloader.",
            meaning=_NOT_FLASHED,
            next_step="To run the sequencer's very image instead: tfsat-host emulate --sequencer avr",
        )


@contextmanager
def _typed_as_given(args: argparse.Namespace) -> Iterator[None]:
    """Commands that an error recommends name the port and image that this one named."""
    options = device_option(args)
    image = f" --hex {shlex.quote(str(args.hex))}" if args.hex is not None else ""

    def typed(found: re.Match[str]) -> str:
        return found[0] + (image if found[0].endswith("sequencer") else "") + options

    try:
        yield
    except TfsatError as error:
        error.next_step = _THIS_COMMAND.sub(typed, error.next_step)
        raise


def _find_port(args: argparse.Namespace, computer: Computer) -> str:
    """The sequencer's port; with `--force` also one at which a bootloader waits. Raises PortError."""
    from tfsat_host.devices.discovery import PortError, PortProblem, find_port
    from tfsat_host.flashing.bootloader import in_bootloader

    try:
        return find_port("sequencer", args.port, list_ports=computer.ports)
    except PortError as error:
        waiting = sorted(in_bootloader(computer))
        if error.code == PortProblem.BOOTLOADER and len(waiting) == 1:
            return waiting[0]
        raise


def _ask(computer: Computer, target: Target, out: Output) -> None:
    """What a board cannot say, a person must. Raises RefusedError, UsageError."""
    from tfsat_host.flashing.running import make_safe

    if target.identity is None:
        what = "waits in its bootloader" if target.waits else "does not answer"
        out.confirm(
            f"The board at {target.port} {what}; its state is not known. Is it the sequencer's Arduino Micro, "
            "and may it be flashed?",
            meaning=_NOT_FLASHED,
        )
    elif target.state_unknown:
        out.confirm(
            f"The sequencer at {target.port} speaks another protocol, so its state cannot be read. "
            "Disarm it and flash?",
            meaning=_NOT_FLASHED,
        )
        make_safe(computer, target.port)


def _write(computer: Computer, avrdude: str, image: Image, target: Target, out: Output) -> Flashed:
    from tfsat_host.flashing.writing import write

    with _narrated(out) as narrator:
        try:
            return write(computer, avrdude, image, target, narrator)
        except KeyboardInterrupt:
            raise Interrupted(
                what="Interrupted.",
                meaning="The board's image may be incomplete. Its bootloader is intact.",
                next_step="tfsat-host flash sequencer --force; do not arm this board before that has succeeded.",
            ) from None


class _Narration:
    """Steps as lines, avrdude's bars as progress."""

    def __init__(self, out: Output) -> None:
        self._out = out
        self._bar: str | None = None
        self._advance: Callable[[float], None] = lambda _marks: None
        self._stack = ExitStack()

    def step(self, text: str) -> None:
        self.end()
        self._out.note(f"{text} …")

    def advance(self, bar: str, marks: int) -> None:
        from tfsat_host.flashing.avrdude import MARKS

        if bar != self._bar:
            self.end()
            progress = self._out.progress(f"avrdude: {bar}", total=MARKS)
            self._bar, self._advance = bar, self._stack.enter_context(progress)
        self._advance(marks)

    def end(self) -> None:
        self._stack.close()
        self._bar = None


@contextmanager
def _narrated(out: Output) -> Iterator[_Narration]:
    narration = _Narration(out)
    try:
        yield narration
    finally:
        narration.end()


def _show_plan(avrdude: str, image: Image, target: Target, out: Output) -> None:
    from tfsat_host.flashing.avrdude import command_line

    command = command_line(avrdude, target.port if target.waits else "BOOTLOADER_PORT", image.path)
    runs = target.identity.describe() if target.identity else "a board that does not answer"
    steps = [
        f"At {target.port}: {runs}.",
        f"Image {image.crc}, {len(image.data)} bytes: {image.path}",
        "Would be done:",
    ]
    if target.identity is None:
        steps.append("  ask whether this is the sequencer")
    elif target.state_unknown:
        steps.append("  ask, and disarm it: it speaks another protocol")
    if not target.waits:
        steps.append(f"  open {target.port} at 1200 baud and close it; wait for the bootloader's port")
    steps += [f"  {shlex.join(command)}", f"  ask the board for its image: {image.crc}"]
    out.result(
        {**_about(image, target), "dry_run": True, "flashed": False, "command": command},
        "\n".join(steps),
    )


def _show(image: Image, target: Target, flashed: Flashed, out: Output) -> None:
    out.result(
        {
            **_about(image, target),
            "dry_run": False,
            "flashed": True,
            "command": flashed.command,
            "bootloader_port": flashed.bootloader_port,
            "device": {"port": flashed.port, **flashed.identity.as_dict()},
        },
        f"Flashed: the board at {flashed.port} runs image {image.crc} ({flashed.identity.describe()}).\n"
        "What was uploaded before is in its EEPROM still: tfsat-host status",
    )
    if not flashed.identity.speaks_this_protocol:
        out.warn(
            "The flashed firmware speaks another protocol than this program: every command but disarm will refuse. "
            "Flash the image of this program's version, or install the host package of the image's."
        )


def _about(image: Image, target: Target) -> dict[str, object]:
    return {
        "hex": Path(image.path),
        "image_crc": image.crc,
        "image_bytes": len(image.data),
        "before": None if target.identity is None else {"port": target.port, **target.identity.as_dict()},
    }
