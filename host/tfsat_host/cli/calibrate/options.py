"""Options of the quantities of `calibrate`: the certificate, the joint, a turn, the second board."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path
from typing import Any, cast

from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.calibration.steps.step import AXES, Axis
from tfsat_host.cli.options import add_device_options, file_name, number, port_name
from tfsat_host.errors import UsageError
from tfsat_host.protocol.limits import JOINT_COUNT
from tfsat_host.run.files import CERTIFICATE, EMULATED_CERTIFICATE

LEAST_TURN_DEG, MOST_TURN_DEG = 90.0, 720.0


def add_certificate_options(parser: argparse.ArgumentParser, certificate: str) -> argparse._ArgumentGroup:
    """`--out` and `--robot`; `certificate` says what the first one names."""
    group = parser.add_argument_group("certificate")
    group.add_argument("--out", metavar="FILE", type=file_name, help=certificate)
    robot = "robot file (default: the drop tower robot)"
    group.add_argument("--robot", metavar="FILE", type=file_name, help=robot)
    return group


def add_campaign_options(parser: argparse.ArgumentParser) -> None:
    """Where the certificate is, of which robot, and how to begin or to go on; device and output options."""
    group = add_certificate_options(
        parser,
        f"the certificate that the steps go into (default {CERTIFICATE}; of an emulated robot "
        f"{EMULATED_CERTIFICATE}); recordings are kept in a folder of its name",
    )
    group.add_argument(
        "--force", action="store_true", help="begin the certificate again where it is of other sensors"
    )
    group.add_argument(
        "--resume",
        action="store_true",
        help="leave out steps of this command that were accepted within the last hour and since the last landing",
    )
    add_device_options(parser, "logger")


def add_sequencer_port(parser: argparse.ArgumentParser) -> None:
    """`--sequencer-port`, besides the logger's `--port`."""
    parser.add_argument(
        "--sequencer-port",
        metavar="PORT",
        type=port_name,
        help="serial port of the sequencer, which moves the joint; without it the environment's "
        "TFSAT_SEQUENCER_PORT, else the one port that looks like this board",
    )


def add_joint_option(parser: argparse._ActionsContainer, *, required: bool) -> None:
    """`--joint N`; not required where a group of options asks for one of them."""
    needed: dict[str, Any] = (
        {"required": True} if required else {}
    )  # an option of a group must not have the word
    parser.add_argument("--joint", type=int, choices=range(1, JOINT_COUNT + 1), help="which joint", **needed)


def certificate_path(args: argparse.Namespace, *, emulated: bool) -> Path:
    """Where the certificate is; an emulated robot's never lies where a real one's would."""
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
    """What makes the next command work on the same certificate."""
    out = f" --out {shlex.quote(str(args.out))}" if args.out else ""
    return out + (" --emulated" if args.emulated else "")


def turned(args: argparse.Namespace) -> tuple[Axis, float] | None:
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
            if LEAST_TURN_DEG <= abs(angle_deg) <= MOST_TURN_DEG:
                return cast("Axis", words[0]), angle_deg
            problem = f"a turn is {LEAST_TURN_DEG:g} to {MOST_TURN_DEG:g} deg either way, not {words[1]}"
    raise UsageError(
        what=f"Argument --turn: {problem}.",
        meaning="Nothing was measured.",
        next_step="tfsat-host calibrate scale --help",
    )
