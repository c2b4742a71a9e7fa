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
from typing import NoReturn, Protocol, cast

from tfsat_host import __version__
from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.present.output import Output

EXIT_INTERRUPTED = 130


HELPS = {
    "upload-sequence": "put a maneuver on the sequencer, checked whole",
    "upload-servos": "tell the sequencer how its servos turn pulses into angles",
    "design": "design the maneuver that turns the robot farthest in its time",
    "simulate": "where a maneuver leaves the robot, and what happens on the way",
    "sensitivity": "how sure a maneuver's rotation is, and what it depends on",
    "plan": "chain loops of the joints to a target attitude, with feedback",
    "envelope": "check a maneuver against the drop tower",
    "rehearse": "fly a maneuver with the real firmware and the emulated robot",
    "calibrate": "measure biases, zero points, mountings, scale factors and servos",
    "decode": "turn a card's recording into engineering units, with a verdict",
    "evaluate": "what the robot did in a drop, whether the model knew, and how sure that is",
    "report": "an evaluated drop as one offline page with plots and a replay",
    "bundle": "all of one drop in one archive, to be kept and computed anew",
    "reproduce": "compute a bundle anew from raw, and say what differs",
    "campaign": "a folder of numbered drops: notes, comparison, one report",
    "record": "start or stop the recording of a drop on the logger's card",
    "log": "list, fetch or erase the logger's recordings over the cable",
    "logger-settings": "show or change the logger's rate, ranges and times",
    "status": "what both boards are doing, and what stands against a drop",
    "preflight": "GO or NO-GO before a drop, with evidence for every check",
    "arm": "let the next release start the maneuver",
    "disarm": "back to safe: nothing moves, faults are cleared",
    "jog": "move one joint slowly, for calibration, then let it go",
    "monitor": "live states, switches, rates and angles in the terminal",
    "flash": "put firmware on the sequencer, and check that it runs",
    "robot": "check a robot file and show what it says",
    "ports": "list serial ports and which board each looks like",
    "emulate": "serve both boards of the emulated robot for other commands",
    "completion": "print what teaches a shell to complete commands",
}
"""What each command does, as `tfsat-host --help` has it."""
_MODULES = {
    "calibrate": "calibrate.command",
    "arm": "arming",
    "disarm": "arming",
}
"""Where a command is done, if not in the module of its name."""


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
        # The reader of a pipe has gone: nothing can be printed any more, not even by the interpreter at exit.
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


def module_of(command: str) -> str:
    """The name of the module that does a command."""
    return f"tfsat_host.cli.{_MODULES.get(command, command.replace('-', '_'))}"


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
    for name, text in HELPS.items():
        if name not in names:
            # Listed and known by name alone: to make all parsers takes half of the time of `--help`.
            subparsers._choices_actions.append(subparsers._ChoicesPseudoAction(name, (), text))
            subparsers._name_parser_map[name] = parser
            continue
        from tfsat_host.cli.options import accept_negative_numbers

        subparser = subparsers.add_parser(
            name,
            help=text,
            description=f"{text[:1].upper()}{text[1:]}.",
            formatter_class=_command_formatter,
            allow_abbrev=False,
        )
        modules[name] = module = cast(CommandModule, importlib.import_module(module_of(name)))
        accept_negative_numbers(subparser)
        module.configure(subparser)
    return parser, modules


def _overview_formatter(prog: str) -> argparse.HelpFormatter:
    """Plain: the first thing that a person types must not wait for Rich."""
    formatter = argparse.HelpFormatter(prog, max_help_position=28)
    # argparse forgets the indentation of subcommands when it measures names: the longest would wrap.
    formatter._action_max_length = max(map(len, HELPS)) + 4
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
