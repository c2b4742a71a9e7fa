"""`tfsat-host emulate`: the emulated robot, served to other commands as two serial ports."""

from __future__ import annotations

import argparse
import contextlib
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.cli.stopping import SIGNALS, handle_signals
from tfsat_host.cli.usage import OUTPUT, add_options, seed
from tfsat_host.emulated.build import sequencer_hex
from tfsat_host.errors import TfsatError
from tfsat_host.next_step import NextStep
from tfsat_host.present.output import Output
from tfsat_host.served_robots import announce_served

if TYPE_CHECKING:
    from tfsat_host.emulated.emulated_robot import EmulatedRobot
    from tfsat_host.emulated.state import Kept, ServedFolder
    from tfsat_host.robot import RobotModel

_LATE = (
    "This computer does not keep up: the robot's clock is {:.1f} s behind. "
    "Commands work, but answers take longer than a real board's."
)
SEQUENCER = "the firmware's core on this computer, or the HEX that is flashed in an emulated ATmega32U4"


_USAGE = f"""
--dir D                   folder of ports, control socket, the boards' memories, card and SD.bin (default: robot)
--sequencer {{native,avr}}  {SEQUENCER}
--seed N                  of sensor errors and session ids (default: errors of 1)
--exact                   scale factors, angle sensors and servos without errors; else it is the robot as built, that of
                          calibrate --emulated
--robot FILE              robot file (default: the drop tower robot)
--for SECONDS             end after that much of the robot's time (default: Ctrl-C, or the control line quit)
{OUTPUT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options for folder, sequencer, robot and duration."""
    add_options(parser, _USAGE, seed=seed, **{"for": {"dest": "for_s"}})
    parser.set_defaults(dir=Path("robot"), sequencer="native")


def run(args: argparse.Namespace, out: Output) -> int:
    """Serves until it is interrupted, which is its normal end."""
    require_pseudo_terminals(sys.platform)
    from tfsat_host.emulated.real_time import ControlSocket, TypedLines, serve, standard_input
    from tfsat_host.emulated.server import RobotServer
    from tfsat_host.emulated.state import ServedFolder
    from tfsat_host.robot.absent_parts import describe_absent, load_robot_of_boards

    model = load_robot_of_boards(args.robot)
    if absent := describe_absent(model):
        out.note(absent)
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
        stack.enter_context(announce_served(folder.path))
        # In order, even if the shell had them ignored.
        stack.enter_context(handle_signals(SIGNALS, lambda *_: server.stop()))
        _announce(args, folder, out)
        if args.for_s is not None:
            server.stop_after(args.for_s)
        typed_lines = TypedLines(server, partial(_reply, out), standard_input())
        serve(server, control, typed_lines, lambda lag_s: out.warn(_LATE.format(lag_s)))
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
    from tfsat_host.emulated.emulated_robot import DEFAULT_SEED, EmulatedRobot
    from tfsat_host.emulated.imperfections import draw, draw_as_built

    draw_imperfections = draw if args.exact else draw_as_built
    return EmulatedRobot(
        model,
        imperfections=draw_imperfections(DEFAULT_SEED if args.seed is None else args.seed),
        seed=args.seed,
        hex_path=sequencer_hex(out.note) if args.sequencer == "avr" else None,
        eeprom=before.eeprom,
        logger_memory=before.logger_memory,
        progress=out.note,
    )


def _announce(args: argparse.Namespace, folder: ServedFolder, out: Output) -> None:
    kind = "its real image, ATmega32U4 emulated" if args.sequencer == "avr" else "its core, native"
    ports = {"sequencer": folder.sequencer, "logger": folder.logger, "control": folder.control}
    places = {**ports, "eeprom": folder.kept.eeprom, "card": folder.card}
    data = {name: place.absolute() for name, place in places.items()}
    text = f"""The emulated robot is running.
  sequencer  {folder.sequencer} ({kind})
  logger     {folder.logger}
  control    {folder.control}; or type here: help
In another terminal, while no board is plugged in:
  {NextStep("upload-sequence", ("59", "70"))}
Ctrl-C ends it."""
    out.result({**data, "image": args.sequencer, "seed": args.seed, "as_built": not args.exact}, text)
    sys.stdout.flush()


def _reply(out: Output, reply: str) -> None:
    if out.json_mode:
        out.note(reply)
    else:
        # Commands one a line; no other reply has any.
        out.line(reply.replace(" | ", "\n"))
        sys.stdout.flush()
