"""What was typed for `calibrate`: the certificate, a turn; and commands that are completed by it."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, cast

from tfsat_host.calibration.calibration_errors import CalibrationError, NotKeptError
from tfsat_host.calibration.steps.step import AXES, Axis
from tfsat_host.cli.usage import number
from tfsat_host.errors import Interrupted, TfsatError, UsageError
from tfsat_host.next_step import Advice, NextStep
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
    begin = NextStep("calibrate bias")
    next_step = Advice("Begin with: ", begin)
    other = certificate_path(args, emulated=not args.emulated)
    if other != file and other.exists():
        kind, option = ("a real", ()) if args.emulated else ("an emulated", ("--emulated",))
        meaning = f"{other} is here, but it is that of {kind} robot. {meaning}"
        # That command is of the other robot: it is complete.
        next_step = Advice(f"To see that one: {NextStep('calibrate show', option)}. To begin: ", begin)
    what = f"No calibration: file {file} does not exist."
    return CalibrationError(what=what, meaning=meaning, next_step=next_step)


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
        next_step=Advice(NextStep("calibrate scale", ("--help",))),
    )


_REPEATED = ("joint", "turn", "all", "anew", "jog", "no_upload")
"""What is typed again to go on; the certificate, the robot file and the ports are added where it is shown."""


def resume_command(args: argparse.Namespace) -> NextStep:
    """Return the command that resumes after the steps already kept."""
    words: list[str] = []
    for name in _REPEATED:
        value = getattr(args, name, None)
        # That sensors were moved is in the certificate with the first step: once more, it would end what followed.
        if value in (None, False) or (name == "anew" and args.quantity != "zero"):
            continue
        values = () if value is True else value if isinstance(value, list) else (value,)
        words += [f"--{name.replace('_', '-')}", *map(str, values)]
    return NextStep(f"calibrate {args.quantity}", (*words, "--resume"))


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
    except (KeyboardInterrupt, NotConfirmed) as error:
        interrupted = isinstance(error, KeyboardInterrupt)
        if interrupted and not out.json_mode:
            out.note("")  # behind the prompt, and the terminal's ^C
        if session is None:
            raise
        kind = Interrupted if interrupted else TfsatError
        what = "Interrupted." if interrupted else "Stopped before the last step."
        raise kind(what=what, meaning=session.kept_words, next_step=Advice(resume_command(args))) from None
    except TfsatError as error:
        is_kept = session is not None and bool(session.kept)
        next_step = error.next_step
        if isinstance(error, NotKeptError):
            next_step = Advice("Free disk space, or make the file writable; then: ", resume_command(args))
        elif is_kept:
            next_step = Advice(next_step, "\nTo resume after the kept steps: ", resume_command(args))
        meaning = (
            f"{error.meaning}\n{session.kept_words}" if session is not None and is_kept else error.meaning
        )
        raise error.with_words(meaning=meaning, next_step=next_step) from None
