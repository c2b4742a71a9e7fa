"""`tfsat-host flash`: new firmware for a board, and the proof that it runs."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tfsat_host.cli.usage import add_actions, add_options, device
from tfsat_host.devices.board_identity import DEVICE
from tfsat_host.errors import RefusedError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import Narration
from tfsat_host.quantity import Column, Columns, fields, record

if TYPE_CHECKING:
    from tfsat_host.flashing.flasher import FlashedBoard, Target
    from tfsat_host.flashing.image import Image

_BOARDS = """
sequencer  flash the Arduino Micro through its bootloader with avrdude, and ask it what it runs afterwards
    Flash the Arduino Micro through its bootloader with avrdude, and ask it what it runs afterwards. Refuses while the
    board is not safe, and where it runs the image already.

    --hex FILE  image to flash (default: build/sequencer/arduino_sequencer.hex of this checkout, by make firmware)
logger     flash the Teensy 4.1 with teensy_loader_cli, and ask it what it runs afterwards
    Flash the Teensy 4.1 with teensy_loader_cli, and ask it what it runs afterwards. Refuses while it records or its RAM
    holds a drop, and where it runs the image already.

    * --hex FILE  image to flash (what arduino-cli or the Arduino IDE exports; make firmware's is none)
"""
_HOW = """\
--dry-run   check everything, say what would be done
--force     flash although the image runs already, or although the board does not answer"""
_NOT_FLASHED = "Nothing was flashed."


@dataclass(frozen=True, slots=True)
class Flashing:
    """An image for a board: what was there, the loader's command line, and the board since; None: a dry run."""

    image: Image
    target: Target
    command: list[str]
    flashed: FlashedBoard | None = None


_PLANNED: Columns = (
    *fields("hex=image.path image_crc=image.crc"),
    Column("image_bytes", of=lambda flashing: len(flashing.image.data)),
    Column("before", of="target.device", columns=DEVICE),
    Column("dry_run", of=lambda flashing: flashing.flashed is None),
    Column("flashed", of=lambda flashing: flashing.flashed is not None),
    *fields("command"),
)
_FLASHED_LOGGER: Columns = (*_PLANNED, Column("device", of="flashed.device", columns=DEVICE))
_FLASHED = {
    "sequencer": (*_FLASHED_LOGGER, *fields("bootloader_port=flashed.bootloader_port")),
    "logger": _FLASHED_LOGGER,
}


def configure(parser: argparse.ArgumentParser) -> None:
    """Add one subcommand for each board."""
    boards = add_actions(parser, _BOARDS, after=_HOW, title="boards", dest="board")
    add_options(boards["sequencer"], device("sequencer"))
    add_options(boards["logger"], device("logger"))


def run(args: argparse.Namespace, out: Output) -> int:
    """Checks image, program and board, then writes."""
    from tfsat_host.flashing.board_flashers import FLASHERS
    from tfsat_host.flashing.flasher import BOOTLOADER
    from tfsat_host.flashing.loader import MARKS, Computer

    if args.emulated:
        raise RefusedError(
            what=f"flash --emulated is refused: the emulated {args.board} has no bootloader.",
            meaning=_NOT_FLASHED,
            next_step=f"To run the sequencer's very image instead: {NextStep('emulate', ('--sequencer', 'avr'))}",
        )
    flasher = FLASHERS[args.board](Computer())
    image = flasher.load_image(args.hex)
    loader = flasher.find_loader()
    target = flasher.look(flasher.find_port(args.port, force=args.force))
    flasher.refuse_needless(target, image, force=args.force)
    if args.dry_run:
        command = flasher.command(loader, image, str(target.port) if target.waits else BOOTLOADER)
        planned = Flashing(image, target, command)
        out.result(record(_PLANNED, planned), "\n".join(flasher.plan(loader, image, target)))
        return 0
    if question := flasher.question(target):
        out.confirm(question, meaning=_NOT_FLASHED)
        flasher.make_safe(target)
    with Narration(out, "avrdude", MARKS) as narrator:
        flashed = flasher.write(loader, image, target, narrator)
    identity = flashed.device.identity
    result = Flashing(image, target, flashed.command, flashed)
    out.result(
        record(_FLASHED[args.board], result),
        Advice(
            f"Flashed: the board at {flashed.device.port} runs image {image.crc} ({identity.describe()}).\n",
            _afterwards(args.board, image.crc),
        ),
    )
    if not identity.speaks_this_protocol:
        out.warn(
            "The flashed firmware speaks another protocol than this program: every command but disarm will refuse. "
            "Flash the image of this program's version, or install the host package of the image's."
        )
    return 0


def _afterwards(board: str, image_crc: str) -> Advice:
    """Return what a flashed board still needs."""
    if board == "sequencer":
        return Advice("What was uploaded before is in its EEPROM still: ", NextStep("status"))
    return Advice(
        "See that its settings are as they were: ",
        NextStep("logger-settings"),
        "\nThe certificate names the image before: calibrate again, or ",
        NextStep("preflight", ("--logger-image", image_crc)),
    )
