"""Commands that an error or a result names, completed by this command's certificate, robot and devices."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from tfsat_host.calibration.errors import NotKeptError
from tfsat_host.cli.advice import device_option
from tfsat_host.errors import Interrupted, TfsatError
from tfsat_host.present.output import NotConfirmed, Output

if TYPE_CHECKING:
    from tfsat_host.calibration.session import Session

_REPEATED = ("joint", "turn", "all", "anew", "jog", "no_upload", "out", "robot")
_COMMAND = re.compile(r"tfsat-host calibrate (?P<quantity>[a-z]+)(?: --[a-z]+| [0-9xyz]+)*")
_OF_BOTH_BOARDS = ("scale", "servo")


def resuming(args: argparse.Namespace) -> str:
    """The command that goes on behind the steps that are kept."""
    # That sensors were moved is in the certificate with the first step: once more, it would end what followed.
    repeated = [name for name in _REPEATED if name != "anew" or args.quantity == "zero"]
    words = ["tfsat-host calibrate", args.quantity, *_options(args, repeated), "--resume"]
    return " ".join(words) + _devices(args, args.quantity)


def as_typed_here(text: str, args: argparse.Namespace) -> str:
    """Gives the `calibrate` commands in an error's words this command's certificate, robot and device."""
    here = "".join(f" {word}" for word in _options(args, ("out", "robot")))
    return _COMMAND.sub(lambda found: found[0] + here + _devices(args, found["quantity"]), text)


def _options(args: argparse.Namespace, names: Iterable[str]) -> list[str]:
    words = []
    for name in names:
        value = getattr(args, name, None)
        if value is None or value is False:
            continue
        values = () if value is True else value if isinstance(value, list) else (value,)
        words += [f"--{name.replace('_', '-')}", *(shlex.quote(str(one)) for one in values)]
    return words


def _devices(args: argparse.Namespace, quantity: str) -> str:
    """As far as the command of that quantity takes them: `show` asks no board."""
    if quantity == "show":
        return " --emulated" if args.emulated else ""
    port = getattr(args, "sequencer_port", None) if quantity in _OF_BOTH_BOARDS else None
    return device_option(args) + ("" if port is None else f" --sequencer-port {shlex.quote(port)}")


@contextmanager
def commands_as_typed(
    args: argparse.Namespace, out: Output, session: Session | None = None
) -> Iterator[None]:
    """Errors name complete commands; what ends a session says how much is kept, and what goes on behind that.

    Raises:
        KeyboardInterrupt, NotConfirmed: as they are, without a session.
        Interrupted: a session was ended by Ctrl-C.
        TfsatError: what ended it; an operator who did not go on ends it with exit code 1.
    """
    try:
        yield
    except KeyboardInterrupt:
        if not out.json_mode:
            out.note("")  # behind the prompt, and the terminal's ^C
        if session is None:
            raise
        what, kept = "Interrupted.", session.kept_words
        raise Interrupted(what=what, meaning=kept, next_step=resuming(args)) from None
    except NotConfirmed:  # what it names is complete
        if session is None:
            raise
        what, kept = "Ended before all steps were done.", session.kept_words
        raise TfsatError(what=what, meaning=kept, next_step=resuming(args)) from None
    except TfsatError as error:
        error.next_step = as_typed_here(error.next_step, args)
        if isinstance(error, NotKeptError):
            error.next_step = f"Make room, or see that it may be written; then: {resuming(args)}"
        elif session is not None and session.kept:
            error.next_step += f"\nTo go on behind the steps that are kept: {resuming(args)}"
        if session is not None and session.kept:
            error.meaning = f"{error.meaning}\n{session.kept_words}"
        raise
