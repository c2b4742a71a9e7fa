"""`tfsat-host`: finds the command, runs it, and turns whatever happens into words and an exit code.

The first thing that a person types must not wait: `--help` imports nothing, a command what it uses.
"""

from __future__ import annotations

import os
import signal
import sys
from functools import partial
from io import TextIOWrapper

from tfsat_host.cli.commands import HELPS, overview
from tfsat_host.errors import TfsatError
from tfsat_host.exit_code import ExitCode
from tfsat_host.present.output import Output

TYPE_CHECKING = False
if TYPE_CHECKING:
    from argparse import Namespace
    from collections.abc import Sequence
    from typing import TextIO

_DEBUG = "--debug"
"""Anywhere on the line: it is no option of a command, and nobody should have to remember where it goes."""


def main(argv: Sequence[str] | None = None, *, heed_interrupts: bool = False) -> int:
    """Runs one command.

    Args:
        argv: What was typed; None: this process's.
        heed_interrupts: Ctrl-C ends the process as yet: a command shall say what it means.

    Returns:
        The exit code: 0 done, 1 failed, 2 usage, 3 done but data was lost or is doubtful,
        4 refused by an interlock, 130 interrupted.
    """
    typed = sys.argv[1:] if argv is None else argv
    argv = [word for word in typed if word != _DEBUG]
    _replace_closed_streams()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without "°" must not end a command
    if argv and argv[0] not in ("-h", "--help"):
        from tfsat_host import debug_log

        debug_log.start(shown=_DEBUG in typed or os.environ.get("TFSAT_DEBUG", "") not in ("", "0"))
    out = Output(json_mode="--json" in argv)
    try:
        code = _dispatch(argv, out, heed_interrupts=heed_interrupts)
        return _flush(code, out)
    except BrokenPipeError:
        _discard(sys.stdout)
        return ExitCode.FAILED


def _flush(code: int, out: Output) -> int:
    """Flush the output and return the exit code, reporting output that could not be printed.

    Raises:
        BrokenPipeError: the reader of a pipe has gone.
    """
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        out.stdout_error = out.stdout_error or error
    if out.stdout_error is not None:
        _discard(sys.stdout)
        code = out.error(
            TfsatError(
                what=f"The result could not be printed: {out.stdout_error.strerror or out.stdout_error}.",
                meaning="Files that the command writes are written; only what it prints is lost.",
                next_step="Make room where its output goes, then run the same command again.",
            )
        )
    if out.stderr_error is not None:
        _discard(sys.stderr)
        code = code or ExitCode.FAILED
    return code


def _discard(stream: TextIO) -> None:
    """Nothing can be printed there any more, not even by the interpreter at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _replace_closed_streams() -> None:
    """Replace each standard stream that the caller had closed (`>&-`) by the null device.

    Python gives None for it, and the system would give its number to the next file that is opened.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is None:
            null = os.open(os.devnull, os.O_RDWR)
            if null != number:
                os.dup2(null, number)
                os.close(null)
            setattr(sys, name, os.fdopen(number, "r" if name == "stdin" else "w"))


def _dispatch(argv: Sequence[str], out: Output, *, heed_interrupts: bool) -> int:
    args: Namespace | None = None
    try:
        if heed_interrupts:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        if not argv or argv[0] in ("-h", "--help"):
            out.line(overview().rstrip())
            return 0
        # The overview does without argparse, which takes as long as all the rest of its start.
        from argparse import Namespace

        args = Namespace()
        return _run(argv, args, out)
    except TfsatError as error:
        return out.error(error)
    except KeyboardInterrupt:
        out.error(_interrupt_error(talks_to_boards=args is not None and "emulated" in args))
        return ExitCode.INTERRUPTED
    except BrokenPipeError:
        raise
    except OSError as error:
        return out.error(_system_error(error))
    except Exception as error:  # noqa: BLE001  the last line of defence: a bug never shows a traceback
        from tfsat_host.crash import bug_error

        return out.error(bug_error(error, argv))


def _run(argv: Sequence[str], args: Namespace, out: Output) -> int:
    """Fills `args` and does the command, which is the first word that is no option."""
    from tfsat_host.cli.next_steps import complete_command
    from tfsat_host.cli.parser import parser_with, refuse_command, refuse_unknown_options

    chosen = next((word for word in argv if not word.startswith("-")), None)
    if chosen is not None and chosen not in HELPS:
        refuse_command(chosen, argv, HELPS)
    parser, modules = parser_with(() if chosen is None else (chosen,))
    refuse_unknown_options(parser, argv)
    parser.parse_args(argv, args)
    if chosen is None:
        out.line(overview().rstrip())
        return 0
    out.json_mode, out.yes = getattr(args, "json", False), getattr(args, "yes", False)
    out.complete_command = partial(complete_command, args=args)
    return int(modules[chosen].run(args, out))


def _interrupt_error(*, talks_to_boards: bool) -> TfsatError:
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
