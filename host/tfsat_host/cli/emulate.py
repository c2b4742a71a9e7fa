"""`tfsat-host emulate`: the emulated robot, served to other commands as two serial ports."""

from __future__ import annotations

import argparse
import contextlib
import shlex
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.cli.options import add_output_options, duration_s, seed
from tfsat_host.errors import TfsatError
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.emulated.robot import EmulatedRobot
    from tfsat_host.emulated.served_folder import ServedFolder
    from tfsat_host.emulated.server import RobotServer
    from tfsat_host.emulated.state import Kept
    from tfsat_host.robot import RobotModel


def configure(parser: argparse.ArgumentParser) -> None:
    """Where, which sequencer, which robot, how long."""
    parser.add_argument(
        "--dir",
        metavar="D",
        type=Path,
        default=Path("robot"),
        help="folder for the ports D/sequencer and D/logger, the control socket D/control, "
        "what the boards store, the card's files D/card and its newest recording D/SD.bin (default: robot)",
    )
    parser.add_argument(
        "--sequencer",
        choices=("native", "avr"),
        default="native",
        help="native: the firmware's core compiled for this computer; avr: the very image that is flashed, "
        "in an emulated ATmega32U4 (needs the toolchain)",
    )
    parser.add_argument(
        "--seed",
        metavar="N",
        type=seed,
        help="draws the sensors' hidden errors and the recordings' session ids "
        "(default: errors as with 1, other ids at each start)",
    )
    parser.add_argument(
        "--as-built",
        action="store_true",
        help="a robot that nobody has calibrated: also scale factors, bends of the angle sensors and servos are off",
    )
    parser.add_argument(
        "--robot", metavar="FILE", type=Path, help="robot file (default: the drop tower robot)"
    )
    parser.add_argument(
        "--for",
        metavar="SECONDS",
        type=duration_s,
        dest="for_s",
        help="end after that much of the robot's time (default: Ctrl-C, or the control line quit)",
    )
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Serves until it is interrupted, which is its normal end."""
    require_pseudo_terminals(sys.platform)
    from tfsat_host.emulated.real_time import ControlSocket, TypedLines, serve, standard_input
    from tfsat_host.emulated.served_folder import ServedFolder
    from tfsat_host.emulated.server import RobotServer
    from tfsat_host.robot import load_robot

    model = load_robot(args.robot)
    folder = ServedFolder(args.dir)
    with contextlib.ExitStack() as stack:
        stack.callback(folder.release)
        # Built while the folder is held: a command that is after its ports sees that they will come.
        before = folder.kept.load()
        robot = stack.enter_context(_robot(args, model, before, out))
        server = RobotServer(robot, folder, before)
        stack.callback(server.close)
        control = ControlSocket(folder.control, server)
        stack.callback(control.close)
        stack.enter_context(_ended_by_signals(server))
        _announce(args, folder, out)
        if args.for_s is not None:
            server.stop_after(args.for_s)

        def say(reply: str) -> None:
            if out.json_mode:
                out.note(reply)
            else:
                out.line(reply)
                sys.stdout.flush()

        serve(server, control, TypedLines(server, say, standard_input()), lambda lag_s: _lag(out, lag_s))
    return 0


def require_pseudo_terminals(platform: str) -> None:
    """Raises TfsatError on Windows, which has none."""
    if platform == "win32":
        raise TfsatError(
            what="Windows has no pseudo-terminals, so the emulated robot's ports cannot be served here.",
            meaning="Nothing was started.",
            next_step="Add --emulated to the command you want to try, or run emulate inside WSL.",
        )


def _robot(args: argparse.Namespace, model: RobotModel, before: Kept, out: Output) -> EmulatedRobot:
    from tfsat_host.emulated.build import Variant, ensure_built, sequencer_hex
    from tfsat_host.emulated.imperfections import draw, draw_as_built
    from tfsat_host.emulated.robot import DEFAULT_SEED, EmulatedRobot

    avr = args.sequencer == "avr"
    hex_path = sequencer_hex(out.note) if avr else None
    ensure_built(Variant(avr=avr), out.note)
    drawn = draw_as_built if args.as_built else draw
    return EmulatedRobot(
        model,
        imperfections=drawn(DEFAULT_SEED if args.seed is None else args.seed),
        seed=args.seed,
        hex_path=hex_path,
        eeprom=before.eeprom,
        logger_memory=before.logger_memory,
    )


def _announce(args: argparse.Namespace, folder: ServedFolder, out: Output) -> None:
    kind = "its real image, ATmega32U4 emulated" if args.sequencer == "avr" else "its core, native"
    data = {
        "sequencer": folder.sequencer.absolute(),
        "logger": folder.logger.absolute(),
        "control": folder.control.absolute(),
        "eeprom": folder.kept.eeprom.absolute(),
        "card": folder.card.absolute(),
        "image": args.sequencer,
        "seed": args.seed,
        "as_built": args.as_built,
    }
    text = "\n".join(
        (
            "The emulated robot is running.",
            f"  sequencer  {folder.sequencer} ({kind})",
            f"  logger     {folder.logger}",
            f"  control    {folder.control}; or type here: help",
            "In another terminal, name a port:",
            f"  tfsat-host upload-sequence 59 70 --port {shlex.quote(str(folder.sequencer))}",
            "or both for all commands:",
            f"  export TFSAT_SEQUENCER_PORT={shlex.quote(str(data['sequencer']))}",
            f"  export TFSAT_LOGGER_PORT={shlex.quote(str(data['logger']))}",
            "Ctrl-C ends it.",
        )
    )
    out.result(data, text)
    sys.stdout.flush()


@contextlib.contextmanager
def _ended_by_signals(server: RobotServer) -> Iterator[None]:
    """Ctrl-C, kill and a closed terminal end the server in order, even if the shell had them ignored."""
    caught = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = {number: signal.signal(number, lambda *_: server.stop()) for number in caught}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _lag(out: Output, lag_s: float) -> None:
    out.warn(
        f"This computer does not keep up: the robot's clock is {lag_s:.1f} s behind. "
        "Commands work, but answers take longer than a real board's."
    )
