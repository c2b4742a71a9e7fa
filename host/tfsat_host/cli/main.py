"""`tfsat-host`: finds the command, runs it, and turns whatever happens into words and an exit code.

Only the module of the command that was chosen is imported; the table below gives `--help` the rest.
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from collections.abc import Container, Sequence
from io import TextIOWrapper
from typing import NamedTuple, NoReturn, Protocol, cast

from tfsat_host import __version__
from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.present.output import Output

EXIT_INTERRUPTED = 130


class Command(NamedTuple):
    """One line of `tfsat-host --help`, and the module that does it."""

    name: str
    module: str
    help: str


COMMANDS = (
    Command(
        "upload-sequence", "tfsat_host.cli.upload_sequence", "put a maneuver on the sequencer, checked whole"
    ),
    Command(
        "upload-servos",
        "tfsat_host.cli.upload_servos",
        "tell the sequencer how its servos turn pulses into angles",
    ),
    Command(
        "design", "tfsat_host.cli.design", "design the maneuver that turns the robot farthest in its time"
    ),
    Command(
        "simulate",
        "tfsat_host.cli.simulate",
        "where a maneuver leaves the robot, and what happens on the way",
    ),
    Command(
        "sensitivity",
        "tfsat_host.cli.sensitivity",
        "how sure a maneuver's rotation is, and what it depends on",
    ),
    Command("plan", "tfsat_host.cli.plan", "chain loops of the joints to a target attitude, with feedback"),
    Command("envelope", "tfsat_host.cli.envelope", "check a maneuver against the drop tower"),
    Command(
        "rehearse", "tfsat_host.cli.rehearse", "fly a maneuver with the real firmware and the emulated robot"
    ),
    Command(
        "calibrate",
        "tfsat_host.cli.calibrate.command",
        "measure biases, zero points, mountings, scale factors and servos",
    ),
    Command(
        "decode", "tfsat_host.cli.decode", "turn a card's recording into engineering units, with a verdict"
    ),
    Command(
        "evaluate",
        "tfsat_host.cli.evaluate.command",
        "what the robot did in a drop, whether the model knew, and how sure that is",
    ),
    Command(
        "report", "tfsat_host.cli.report", "an evaluated drop as one offline page with plots and a replay"
    ),
    Command(
        "bundle", "tfsat_host.cli.bundle", "all of one drop in one archive, to be kept and computed anew"
    ),
    Command("reproduce", "tfsat_host.cli.reproduce", "compute a bundle anew from raw, and say what differs"),
    Command(
        "campaign", "tfsat_host.cli.campaign", "a folder of numbered drops: notes, comparison, one report"
    ),
    Command("record", "tfsat_host.cli.record", "start or stop the recording of a drop on the logger's card"),
    Command("log", "tfsat_host.cli.log", "list, fetch or erase the logger's recordings over the cable"),
    Command(
        "logger-settings",
        "tfsat_host.cli.logger_settings",
        "show or change the logger's rate, ranges and times",
    ),
    Command("status", "tfsat_host.cli.status", "what both boards are doing, and what stands against a drop"),
    Command(
        "preflight", "tfsat_host.cli.preflight", "GO or NO-GO before a drop, with evidence for every check"
    ),
    Command("arm", "tfsat_host.cli.arming", "let the next release start the maneuver"),
    Command("disarm", "tfsat_host.cli.arming", "back to safe: nothing moves, faults are cleared"),
    Command("jog", "tfsat_host.cli.jog", "move one joint slowly, for calibration, then let it go"),
    Command("monitor", "tfsat_host.cli.monitor", "live states, switches, rates and angles in the terminal"),
    Command("flash", "tfsat_host.cli.flash", "put firmware on the sequencer, and check that it runs"),
    Command("robot", "tfsat_host.cli.robot", "check a robot file and show what it says"),
    Command("ports", "tfsat_host.cli.ports", "list serial ports and which board each looks like"),
    Command(
        "emulate", "tfsat_host.cli.emulate", "serve both boards of the emulated robot for other commands"
    ),
    Command("completion", "tfsat_host.cli.completion", "print what teaches a shell to complete commands"),
)


class CommandModule(Protocol):
    """What every command's module offers."""

    def configure(self, parser: argparse.ArgumentParser) -> None:
        """Adds the command's arguments."""

    def run(self, args: argparse.Namespace, out: Output) -> int:
        """Does it; gives the exit code."""


class Parser(argparse.ArgumentParser):
    """An argument parser whose errors are tfsat's."""

    def error(self, message: str) -> NoReturn:
        raise UsageError(
            what=f"{message[:1].upper()}{message[1:].rstrip('.')}.",
            meaning="Nothing was done.",
            next_step=f"{self.prog} --help",
        )


def main(argv: Sequence[str] | None = None) -> int:
    """Runs one command.

    Returns:
        The exit code: 0 done, 1 failed, 2 usage, 3 done but data was lost or is doubtful,
        4 refused by an interlock, 130 interrupted.
    """
    argv = sys.argv[1:] if argv is None else argv
    _replace_closed_streams()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without "°" must not end a command
    out = Output(json_mode="--json" in argv)
    try:
        code = _dispatch(argv, out)
        sys.stdout.flush()
    except BrokenPipeError:
        # The reader of a pipe has gone: nothing can be said any more, not even by the interpreter at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return TfsatError.exit_code
    return code


def _replace_closed_streams() -> None:
    """A standard stream that the caller had closed (`>&-`) becomes the null device.

    Python gives None for it, and the system would give its number to the next file that is opened.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is None:
            null = os.open(os.devnull, os.O_RDWR)
            if null != number:
                os.dup2(null, number)
                os.close(null)
            setattr(sys, name, os.fdopen(number, "r" if name == "stdin" else "w"))


def _dispatch(argv: Sequence[str], out: Output) -> int:
    args = argparse.Namespace()
    try:
        parser, module = _parser_for(argv)
        parser.parse_args(argv, args)
        if module is None:
            parser.print_help()
            return 0
        out.json_mode = getattr(args, "json", False)
        out.yes = getattr(args, "yes", False)
        return module.run(args, out)
    except TfsatError as error:
        return out.error(error)
    except KeyboardInterrupt:
        out.error(_interrupted(talks_to_boards="emulated" in args))
        return EXIT_INTERRUPTED
    except BrokenPipeError:
        raise
    except OSError as error:
        return out.error(_system_error(error))
    except Exception as error:  # noqa: BLE001  the last line of defence: a bug never shows a traceback
        from tfsat_host.crash import bug_error

        return out.error(bug_error(error, argv))


def _parser_for(argv: Sequence[str]) -> tuple[Parser, CommandModule | None]:
    """A parser that knows all names, and the arguments of the one command that was chosen."""
    chosen = next((word for word in argv if not word.startswith("-")), "")
    parser, modules = parser_with((chosen,))
    return parser, modules.get(chosen)


def parser_with(names: Container[str]) -> tuple[Parser, dict[str, CommandModule]]:
    """A parser that knows all commands' names and the arguments of these, and the modules of these."""
    parser = Parser(
        prog="tfsat-host",
        description="Ground tools of a transformable CubeSat robot: from a typed maneuver to a decoded card.",
        epilog="Exit codes: 0 done, 1 failed, 2 usage, 3 done but data was lost or is doubtful, "
        "4 refused by an interlock, 130 interrupted.",
        formatter_class=_overview_formatter,
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"tfsat-host {__version__}")
    subparsers = parser.add_subparsers(title="commands", metavar="COMMAND", dest="command")
    modules: dict[str, CommandModule] = {}
    for command in COMMANDS:
        description = command.help[:1].upper() + command.help[1:] + "."
        subparser = subparsers.add_parser(
            command.name,
            help=command.help,
            description=description,
            formatter_class=_command_formatter,
            allow_abbrev=False,
        )
        if command.name in names:
            from tfsat_host.cli.options import accept_negative_numbers

            module = cast(CommandModule, importlib.import_module(command.module))
            accept_negative_numbers(subparser)
            module.configure(subparser)
            modules[command.name] = module
    return parser, modules


def _overview_formatter(prog: str) -> argparse.HelpFormatter:
    """Plain: the first thing that a person types must not wait for Rich."""
    formatter = argparse.HelpFormatter(prog, max_help_position=28)
    # argparse forgets the indentation of subcommands when it measures names: the longest would wrap.
    formatter._action_max_length = max(len(command.name) for command in COMMANDS) + 4
    return formatter


def _command_formatter(prog: str) -> argparse.HelpFormatter:
    """Rich's formatter on a terminal, plain text elsewhere."""
    if not sys.stdout.isatty():
        return argparse.HelpFormatter(prog, max_help_position=28)
    from rich_argparse import RichHelpFormatter

    return RichHelpFormatter(prog, max_help_position=28)


def _interrupted(*, talks_to_boards: bool) -> TfsatError:
    """Ctrl-C where no command made more of it: no board was connected yet, or there is none."""
    again = "run the same command again when ready."
    return TfsatError(
        what="Interrupted.",
        meaning="The command stopped before it was done.",
        next_step=f"No board was connected: {again}" if talks_to_boards else again.capitalize(),
    )


def _system_error(error: OSError) -> TfsatError:
    place = f"{error.filename}: " if error.filename is not None else ""
    return TfsatError(
        what=f"{place}{error.strerror or error}.",
        meaning="The command stopped before it was done.",
        next_step="Check that the path exists, may be written and has room; then run the same command again.",
    )


if __name__ == "__main__":
    sys.exit(main())
