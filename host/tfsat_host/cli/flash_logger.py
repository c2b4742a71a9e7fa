"""`tfsat-host flash logger`: a sketch for the Teensy 4.1, and the proof that it runs."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.cli.advice import device_option
from tfsat_host.cli.options import add_device_options, file_name
from tfsat_host.errors import TfsatError
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.flashing.image import Image
    from tfsat_host.flashing.logger import LoggerTarget
    from tfsat_host.flashing.ports import Computer


def configure(parser: argparse.ArgumentParser) -> None:
    """The image, how sure one is, the device."""
    refusals = "Refuses while it records or its RAM holds a drop, and where it runs the image already."
    parser.description = f"{parser.description} {refusals}"
    parser.add_argument(
        "--hex",
        metavar="FILE",
        type=file_name,
        required=True,
        help="image to flash: what arduino-cli or the Arduino IDE exports (make firmware's is none)",
    )
    parser.add_argument("--dry-run", action="store_true", help="check everything, say what would be done")
    parser.add_argument(
        "--force",
        action="store_true",
        help="flash although the image runs already, or although no logger answers",
    )
    add_device_options(parser, "logger")


def run(args: argparse.Namespace, out: Output) -> int:
    """Checks image, program and board, then writes."""
    from tfsat_host.flashing import logger, teensy
    from tfsat_host.flashing.system import ThisComputer

    computer = ThisComputer()
    try:
        image = teensy.load_image(args.hex)
        loader = teensy.find_loader(computer)
        target = logger.look(computer, _find_port(args, computer))
        logger.refuse_needless(target, image, force=args.force)
        command = teensy.command_line(loader, image.path)
        about = _about(image, target, command)
        if args.dry_run:
            text = f"Image {image.crc}, {len(image.data)} bytes: {image.path}\nWould be done:\n  {shlex.join(command)}"
            out.result({**about, "dry_run": True, "flashed": False}, text)
            return 0
        if target.identity is None:
            out.confirm(
                "No logger answers, so nobody knows what its RAM holds. Flash the Teensy that is plugged in?",
                meaning="Nothing was flashed.",
            )
        port, identity = logger.write(computer, loader, image, target, lambda text: out.note(f"{text} …"))
    except TfsatError as error:
        typed = f"{teensy.AGAIN} --hex {shlex.quote(str(args.hex))}{device_option(args)}"
        error.next_step = error.next_step.replace(teensy.AGAIN, typed)
        raise
    out.result(
        {**about, "dry_run": False, "flashed": True, "device": {"port": port, **identity.as_dict()}},
        f"Flashed: the board at {port} runs image {image.crc} ({identity.describe()}).\n"
        "See that its settings are as they were: tfsat-host logger-settings\n"
        f"The certificate names the image before: calibrate again, or tfsat-host preflight --logger-image {image.crc}",
    )
    return 0


def _find_port(args: argparse.Namespace, computer: Computer) -> str | None:
    """The logger's port; with `--force` none is needed, since a Teensy in its bootloader has none."""
    from tfsat_host.devices.discovery import find_port
    from tfsat_host.devices.port_errors import PortError

    try:
        return find_port("logger", args.port, list_ports=computer.ports)
    except PortError:
        if args.force and args.port is None:
            return None
        raise


def _about(image: Image, target: LoggerTarget, command: list[str]) -> dict[str, object]:
    return {
        "hex": Path(image.path),
        "image_crc": image.crc,
        "image_bytes": len(image.data),
        "before": None if target.identity is None else {"port": target.port, **target.identity.as_dict()},
        "command": command,
    }
