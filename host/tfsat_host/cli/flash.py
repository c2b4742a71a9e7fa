"""`tfsat-host flash`: new firmware for a board, and the proof that it runs."""

from __future__ import annotations

import argparse

from tfsat_host.cli.usage import add_actions, add_options, device
from tfsat_host.errors import RefusedError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import Narration

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


def configure(parser: argparse.ArgumentParser) -> None:
    """Add one subcommand for each board."""
    boards = add_actions(parser, _BOARDS, after=_HOW, title="boards", dest="board")
    add_options(boards["sequencer"], device("sequencer"))
    add_options(boards["logger"], device("logger"))


def run(args: argparse.Namespace, out: Output) -> int:
    """Checks image, program and board, then writes."""
    from tfsat_host.flashing.flasher import BOOTLOADER, FLASHERS
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
    before = None if target.identity is None else {"port": target.port, **target.identity.as_dict()}
    about = {"hex": image.path, "image_crc": image.crc, "image_bytes": len(image.data), "before": before}
    if args.dry_run:
        port = target.port if target.waits else BOOTLOADER
        result = {"dry_run": True, "flashed": False, "command": flasher.command(loader, image, str(port))}
        out.result({**about, **result}, "\n".join(flasher.plan(loader, image, target)))
        return 0
    if question := flasher.question(target):
        out.confirm(question, meaning=_NOT_FLASHED)
        flasher.make_safe(target)
    with Narration(out, "avrdude", MARKS) as narrator:
        flashed = flasher.write(loader, image, target, narrator)
    identity = flashed.identity
    device = {"port": flashed.port, **identity.as_dict()}
    result = {**about, "dry_run": False, "flashed": True, "command": flashed.command, **flashed.details}
    out.result(
        {**result, "device": device},
        Advice(
            f"Flashed: the board at {flashed.port} runs image {image.crc} ({identity.describe()}).\n",
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
