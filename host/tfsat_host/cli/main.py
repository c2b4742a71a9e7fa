"""`tfsat-host`: finds the command, runs it, and turns whatever happens into words and an exit code.

The first thing that a person types must not wait: `--help` imports nothing, a command what it uses.
"""

from __future__ import annotations

import os
import sys
from io import TextIOWrapper

from tfsat_host.errors import TfsatError, UsageError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from argparse import Namespace
    from collections.abc import Sequence

    from tfsat_host.present.output import Output

EXIT_INTERRUPTED = 130
HELPS = {
    "upload-sequence": "put a maneuver on the sequencer, checked whole",
    "upload-servos": "how its servos turn pulses into angles, to the sequencer",
    "design": "the maneuver that turns the robot farthest in its time",
    "simulate": "where a maneuver leaves the robot, and what happens then",
    "sensitivity": "how sure a maneuver's rotation is, and what it depends on",
    "plan": "chain loops of the joints to a target attitude",
    "envelope": "check a maneuver against the drop tower",
    "rehearse": "fly a maneuver with the real firmware, robot emulated",
    "calibrate": "measure biases, zero points, mountings, scales, servos",
    "decode": "turn a card's recording into engineering units",
    "evaluate": "what the robot did, whether the model knew, and ± of both",
    "report": "an evaluated drop as one offline page with plots, replay",
    "bundle": "all of one drop in one archive, to keep and recompute",
    "reproduce": "recompute a bundle from raw, and say what differs",
    "campaign": "a folder of numbered drops: notes, comparison, one report",
    "record": "start or stop the recording of a drop on the logger's card",
    "log": "list, fetch or erase the logger's recordings by cable",
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
    "completion": "print what lets a shell complete commands",
}
"""What each command does."""
_OVERVIEW = """\
usage: tfsat-host [-h] [--version] COMMAND ...

Ground tools of a transformable CubeSat robot: from a typed maneuver to a
decoded card.

options:
  -h, --help            show this help message and exit
  --version             show program's version number and exit

commands:
  COMMAND
{commands}

Exit codes: 0 done, 1 failed, 2 usage, 3 done but data was lost or is doubtful,
4 refused by an interlock, 130 interrupted.
"""


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
    try:
        if not argv or argv[0] in ("-h", "--help"):
            sys.stdout.write(overview())
            code = 0
        else:
            code = _dispatch(argv)
        sys.stdout.flush()
    except BrokenPipeError:
        # The reader of a pipe has gone: nothing can be printed any more, not even by the interpreter at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return TfsatError.exit_code
    return code


def overview() -> str:
    """All commands, a line each."""
    commands = "\n".join(f"    {name:<18}{text}" for name, text in HELPS.items())
    return _OVERVIEW.format(commands=commands)


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


def _dispatch(argv: Sequence[str]) -> int:
    from argparse import Namespace

    from tfsat_host.present.output import Output

    out, args = Output(json_mode="--json" in argv), Namespace()
    try:
        return _run(argv, args, out)
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


def _run(argv: Sequence[str], args: Namespace, out: Output) -> int:
    """Fills `args` and does the command, which is the first word that is no option."""
    from tfsat_host.cli.parser import parser_with

    chosen = next((word for word in argv if not word.startswith("-")), None)
    if chosen is not None and chosen not in HELPS:
        raise UsageError(
            what=f"There is no command {chosen!r}.",
            meaning="Nothing was done.",
            next_step="tfsat-host --help lists all commands.",
        )
    parser, modules = parser_with(() if chosen is None else (chosen,))
    parser.parse_args(argv, args)
    if chosen is None:
        sys.stdout.write(overview())
        return 0
    out.json_mode, out.yes = getattr(args, "json", False), getattr(args, "yes", False)
    return int(modules[chosen].run(args, out))


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
