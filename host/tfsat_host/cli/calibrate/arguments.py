"""What was typed for `calibrate`: the certificate, a turn; and commands that are completed by it."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, cast

from tfsat_host.calibration.errors import CalibrationError, NotKeptError
from tfsat_host.calibration.steps.step import AXES, Axis
from tfsat_host.cli.boards import device_option
from tfsat_host.cli.usage import number
from tfsat_host.errors import Interrupted, TfsatError, UsageError
from tfsat_host.present.output import NotConfirmed, Output
from tfsat_host.run.files import CERTIFICATE, EMULATED_CERTIFICATE

if TYPE_CHECKING:
    from tfsat_host.calibration.session import Session


MIN_TURN_DEG, MAX_TURN_DEG = 90.0, 720.0


def certificate_path(args: argparse.Namespace, *, emulated: bool) -> Path:
    """Return the certificate's path.

    An emulated robot's default path is never that of a real robot.
    """
    return args.out or Path(EMULATED_CERTIFICATE if emulated else CERTIFICATE)


def none_yet(args: argparse.Namespace, file: Path) -> CalibrationError:
    """Names the certificate of a real or an emulated robot where the other one was asked for."""
    meaning = "Without one a drop cannot be evaluated: a bias of 1 deg/s alone is 2.5 deg over a fall."
    begin = f"tfsat-host calibrate bias{same_certificate(args)}"
    next_step = f"Begin with: {begin}"
    other = certificate_path(args, emulated=not args.emulated)
    if other != file and other.exists():
        kind, option = ("a real", "") if args.emulated else ("an emulated", " --emulated")
        meaning = f"{other} is here, but it is that of {kind} robot. {meaning}"
        next_step = f"To see that one: tfsat-host calibrate show{option}. To begin: {begin}"
    what = f"There is no calibration yet: no file {file}."
    return CalibrationError(what=what, meaning=meaning, next_step=next_step)


def same_certificate(args: argparse.Namespace) -> str:
    """Return the options that make the next command work on the same certificate."""
    out = f" --out {shlex.quote(str(args.out))}" if args.out else ""
    return out + (" --emulated" if args.emulated else "")


def read_turn(args: argparse.Namespace) -> tuple[Axis, float] | None:
    """Axis and angle in deg of a turn by hand. Raises UsageError."""
    words = getattr(args, "turn", None)
    if words is None:
        return None
    problem = ""
    if args.jog:
        problem = "with --jog a servo moves a joint; a turn is done by hand: leave one of them out"
    elif words[0] not in AXES:
        problem = f"{words[0]!r} is no axis of a body: write x, y or z"
    else:
        try:
            angle_deg = number(words[1])
        except argparse.ArgumentTypeError as error:
            problem = str(error)
        else:
            if MIN_TURN_DEG <= abs(angle_deg) <= MAX_TURN_DEG:
                return cast("Axis", words[0]), angle_deg
            problem = f"a turn is {MIN_TURN_DEG:g} to {MAX_TURN_DEG:g} deg either way, not {words[1]}"
    raise UsageError(
        what=f"Argument --turn: {problem}.",
        meaning="Nothing was measured.",
        next_step="tfsat-host calibrate scale --help",
    )


_REPEATED = ("joint", "turn", "all", "anew", "jog", "no_upload", "out", "robot")
_COMMAND = re.compile(r"tfsat-host calibrate (?P<quantity>[a-z]+)(?: --[a-z]+| [0-9xyz]+)*")
_OF_BOTH_BOARDS = ("scale", "servo")


def resume_command(args: argparse.Namespace) -> str:
    """Return the command that resumes after the steps already kept."""
    # That sensors were moved is in the certificate with the first step: once more, it would end what followed.
    repeated = [name for name in _REPEATED if name != "anew" or args.quantity == "zero"]
    words = ["tfsat-host calibrate", args.quantity, *_options(args, repeated), "--resume"]
    return " ".join(words) + _devices(args, args.quantity)


def as_typed_here(text: str, args: argparse.Namespace) -> str:
    """Gives the `calibrate` commands in an error's words this command's certificate, robot and device."""
    here = "".join(f" {word}" for word in _options(args, ("out", "robot")))
    return _COMMAND.sub(lambda match: match[0] + here + _devices(args, match["quantity"]), text)


def _options(args: argparse.Namespace, names: Iterable[str]) -> list[str]:
    words = []
    for name in names:
        value = getattr(args, name, None)
        if value is None or value is False:
            continue
        values = () if value is True else value if isinstance(value, list) else (value,)
        words += [f"--{name.replace('_', '-')}", *(shlex.quote(str(argument)) for argument in values)]
    return words


def _devices(args: argparse.Namespace, quantity: str) -> str:
    """Return the device options that the command of that quantity takes.

    `show` queries no board.
    """
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
        what, kept_words = "Interrupted.", session.kept_words
        raise Interrupted(what=what, meaning=kept_words, next_step=resume_command(args)) from None
    except NotConfirmed:  # what it names is complete
        if session is None:
            raise
        what, kept_words = "Ended before all steps were done.", session.kept_words
        raise TfsatError(what=what, meaning=kept_words, next_step=resume_command(args)) from None
    except TfsatError as error:
        error.next_step = as_typed_here(error.next_step, args)
        if isinstance(error, NotKeptError):
            error.next_step = f"Make room, or see that it may be written; then: {resume_command(args)}"
        elif session is not None and session.kept:
            error.next_step += f"\nTo go on behind the steps that are kept: {resume_command(args)}"
        if session is not None and session.kept:
            error.meaning = f"{error.meaning}\n{session.kept_words}"
        raise
