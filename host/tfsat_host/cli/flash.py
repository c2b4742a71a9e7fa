"""`tfsat-host flash`: new firmware for a board, and the proof that it runs."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Iterator
from contextlib import contextmanager

from tfsat_host.cli.boards import device_option
from tfsat_host.cli.usage import add_actions, add_options, device
from tfsat_host.errors import RefusedError, TfsatError
from tfsat_host.present.output import Output

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
_AFTERWARDS = {
    "sequencer": "What was uploaded before is in its EEPROM still: tfsat-host status",
    "logger": "See that its settings are as they were: tfsat-host logger-settings\n"
    "The certificate names the image before: calibrate again, or tfsat-host preflight --logger-image {crc}",
}
_TYPED = re.compile(r"tfsat-host (?:flash (?:sequencer|logger)|status|disarm)")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add one subcommand for each board."""
    boards = add_actions(parser, _BOARDS, after=_HOW, title="boards", dest="board")
    add_options(boards["sequencer"], device("sequencer"))
    add_options(boards["logger"], device("logger"))


def run(args: argparse.Namespace, out: Output) -> int:
    """Checks image, program and board, then writes."""
    from tfsat_host.flashing.flash import BOOTLOADER, FLASHERS
    from tfsat_host.flashing.loader import MARKS, Computer
    from tfsat_host.present.terminal import Narration

    if args.emulated:
        raise RefusedError(
            what=f"flash --emulated is refused: the emulated {args.board} has no bootloader.",
            meaning=_NOT_FLASHED,
            next_step="To run the sequencer's very image instead: tfsat-host emulate --sequencer avr",
        )
    flasher = FLASHERS[args.board](Computer())
    with _typed_as_given(args):
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
        f"Flashed: the board at {flashed.port} runs image {image.crc} ({identity.describe()}).\n"
        + _AFTERWARDS[args.board].format(crc=image.crc),
    )
    if not identity.speaks_this_protocol:
        out.warn(
            "The flashed firmware speaks another protocol than this program: every command but disarm will refuse. "
            "Flash the image of this program's version, or install the host package of the image's."
        )
    return 0


@contextmanager
def _typed_as_given(args: argparse.Namespace) -> Iterator[None]:
    """Commands that an error recommends name the port and image that this one named."""
    image = f" --hex {shlex.quote(str(args.hex))}" if args.hex is not None else ""

    def typed(match: re.Match[str]) -> str:
        return match[0] + (image if " flash " in match[0] else "") + device_option(args)

    try:
        yield
    except TfsatError as error:
        error.next_step = _TYPED.sub(typed, error.next_step)
        raise
