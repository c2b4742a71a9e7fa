"""`tfsat-host emulate`: the emulated robot, served to other commands as two serial ports."""

from __future__ import annotations

import argparse
import contextlib
import shlex
import signal
import sys
from collections.abc import Iterator
from functools import partial
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

SEQUENCER = "the firmware's core on this computer, or the HEX that is flashed in an emulated ATmega32U4"


def configure(parser: argparse.ArgumentParser) -> None:
    """Where, which sequencer, which robot, how long."""
    add = parser.add_argument
    files = "ports, control socket, the boards' memories, card and SD.bin"
    add("--dir", metavar="D", type=Path, default=Path("robot"), help=f"folder of {files} (default: robot)")
    add("--sequencer", choices=("native", "avr"), default="native", help=SEQUENCER)
    add("--seed", metavar="N", type=seed, help="of sensor errors and session ids (default: errors of 1)")
    add("--as-built", action="store_true", help="a robot before calibration: scale factors, servos off, too")
    add("--robot", metavar="FILE", type=Path, help="robot file (default: the drop tower robot)")
    times = "end after that much of the robot's time (default: Ctrl-C, or the control line quit)"
    add("--for", metavar="SECONDS", type=duration_s, dest="for_s", help=times)
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
        typed = TypedLines(server, partial(_reply, out), standard_input())
        serve(server, control, typed, partial(_lag, out))
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
    from tfsat_host.emulated.build import sequencer_hex
    from tfsat_host.emulated.imperfections import draw, draw_as_built
    from tfsat_host.emulated.robot import DEFAULT_SEED, EmulatedRobot

    drawn = draw_as_built if args.as_built else draw
    return EmulatedRobot(
        model,
        imperfections=drawn(DEFAULT_SEED if args.seed is None else args.seed),
        seed=args.seed,
        hex_path=sequencer_hex(out.note) if args.sequencer == "avr" else None,
        eeprom=before.eeprom,
        logger_memory=before.logger_memory,
        progress=out.note,
    )


def _announce(args: argparse.Namespace, folder: ServedFolder, out: Output) -> None:
    kind = "its real image, ATmega32U4 emulated" if args.sequencer == "avr" else "its core, native"
    places = {
        "sequencer": folder.sequencer,
        "logger": folder.logger,
        "control": folder.control,
        "eeprom": folder.kept.eeprom,
        "card": folder.card,
    }
    data = {name: place.absolute() for name, place in places.items()}
    text = f"""The emulated robot is running.
  sequencer  {folder.sequencer} ({kind})
  logger     {folder.logger}
  control    {folder.control}; or type here: help
In another terminal, name a port:
  tfsat-host upload-sequence 59 70 --port {shlex.quote(str(folder.sequencer))}
or both for all commands:
  export TFSAT_SEQUENCER_PORT={shlex.quote(str(data["sequencer"]))}
  export TFSAT_LOGGER_PORT={shlex.quote(str(data["logger"]))}
Ctrl-C ends it."""
    out.result({**data, "image": args.sequencer, "seed": args.seed, "as_built": args.as_built}, text)
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


def _reply(out: Output, reply: str) -> None:
    if out.json_mode:
        out.note(reply)
    else:
        out.line(reply)
        sys.stdout.flush()


def _lag(out: Output, lag_s: float) -> None:
    out.warn(
        f"This computer does not keep up: the robot's clock is {lag_s:.1f} s behind. "
        "Commands work, but answers take longer than a real board's."
    )
